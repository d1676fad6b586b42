//! Which trains are wanted: the options that making trains and driving them share.

use railgrip_truth_plant::train::{FaultWish, OrderError, TrainOrder, TrainSpec, deck, faults::FaultKind};

use crate::CliError;

/// Which trains are wanted.
#[derive(Debug, clap::Args)]
pub(super) struct Order {
    /// Number of trains
    #[arg(long, default_value_t = 20)]
    pub(super) trains: usize,
    /// Length of each train's day, h
    #[arg(long, default_value_t = 1.0)]
    pub(super) hours: f64,
    /// Trains and faults follow from this; the salt of a seal does not
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Coupled trains only, of 4 to 64 wagons (default: four in five)
    #[arg(long, conflicts_with = "free")]
    coupled: bool,
    /// Single free wagons only
    #[arg(long)]
    free: bool,
    /// Samples a second: 20, 25, 50, 100 or 200. On disk a bogie wagon takes about 18 MB an hour at 50
    #[arg(long, default_value_t = 50.0)]
    rate: f64,
    /// Faults of these kinds only, beside the trains without one (default: every kind equally often)
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = kind)]
    fault: Vec<&'static FaultKind>,
    /// Trains at the same time (default: one a core)
    #[arg(long)]
    pub(super) threads: Option<usize>,
}

/// The kind of fault of a name.
fn kind(name: &str) -> Result<&'static FaultKind, String> {
    FaultKind::of(name).ok_or_else(|| OrderError::Fault(name.to_owned()).to_string())
}

/// Most trains of one order.
const MOST_TRAINS: usize = 1_000_000;

/// A train of a deck: its seed, and its fault.
pub(super) type Card = (u64, FaultWish<'static>);

impl Order {
    fn kind(&self) -> Option<bool> {
        match (self.coupled, self.free) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }

    /// The trains, one card each.
    ///
    /// # Errors
    /// An order of no train.
    pub(super) fn deck(&self) -> Result<Vec<Card>, CliError> {
        if !(1..=MOST_TRAINS).contains(&self.trains) {
            let given = self.trains;
            return Err(CliError::bad_input(format!("--trains {given}: allowed is 1 to {MOST_TRAINS}")));
        }
        Ok(deck(self.trains, self.seed, self.kind(), &self.fault))
    }

    /// The train of a card.
    ///
    /// # Errors
    /// An order that no train meets.
    pub(super) fn draw(&self, (seed, fault): Card) -> Result<TrainSpec, CliError> {
        let order = TrainOrder {
            coupled: self.kind(),
            hours: self.hours,
            rate_hz: self.rate,
            fault,
            ..TrainOrder::default()
        };
        TrainSpec::draw_to(seed, &order).map_err(CliError::bad_input)
    }

    /// The options as somebody would write them.
    pub(super) fn words(&self) -> String {
        let Self { trains, hours, seed, rate, .. } = self;
        let kind = match self.kind() {
            Some(true) => " --coupled",
            Some(false) => " --free",
            None => "",
        };
        let fault = match self.fault.is_empty() {
            true => String::new(),
            false => {
                format!(" --fault {}", self.fault.iter().map(|kind| kind.id).collect::<Vec<_>>().join(","))
            }
        };
        format!("--trains {trains} --hours {hours} --seed {seed} --rate {rate}{kind}{fault}")
    }
}
