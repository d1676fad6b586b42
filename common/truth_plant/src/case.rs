//! Cases: which departures, how large, on which vehicle; and the label that a diagnosis has to find.

use serde::{Deserialize, Serialize};

use crate::{
    departure::{Departure, Departures},
    departures::{CATALOGUE, Kind},
    gap,
    label::{Gaps, Label, LabelledEffect},
    plant::{Plant, Run},
    programme,
    random::Stream,
    sheet::Sheet,
    wagon::{Nuisances, TrueWagon},
};

pub use crate::family::family_deck;

/// A case as it is ordered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recipe {
    /// Name of the folder.
    pub name: String,
    /// Everything random follows from this.
    pub seed: u64,
    /// Ids of the departures; empty for a case that holds nuisances and clutter only.
    pub departures: Vec<String>,
}

/// A finished case with its twin.
pub struct Case {
    /// The believed vehicle.
    pub sheet: Sheet,
    /// The tolerances that were drawn.
    pub nuisances: Nuisances,
    /// The runs.
    pub runs: Vec<Run>,
    /// The same runs without the departure.
    pub twin: Vec<Run>,
    /// The answer.
    pub label: Label,
}

/// A recipe names a departure that the catalogue lacks.
#[derive(Debug, thiserror::Error)]
#[error("no departure is called {0:?}")]
pub struct UnknownDeparture(String);

/// A departure drawn at a strength.
struct Chosen {
    kind: Kind,
    strength: f64,
    seed: u64,
}

/// How many times the size of an effect is adjusted, and how many vehicles are tried.
const ADJUSTMENTS: usize = 3;
const VEHICLES: u64 = 3;

impl Case {
    /// Makes a case. The departures are sized so that the calibrated gap is clearly above the twin's, not absurdly so.
    pub fn make(recipe: &Recipe) -> Result<Self, UnknownDeparture> {
        let find = |id: &String| Kind::of(id).ok_or_else(|| UnknownDeparture(id.clone()));
        let kinds = recipe.departures.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        let mut best: Option<(f64, Self)> = None;
        for attempt in 0..VEHICLES {
            let bench = Bench::new(recipe.seed.wrapping_add(attempt.wrapping_mul(0x51_7cc1)), &kinds);
            let case = bench.case(&recipe.name, &kinds);
            let label = &case.label;
            let shows = kinds.iter().any(|kind| kind.shows_in_holdout);
            let clear = clearness(&label.gap_calibrated, &label.gap_without_the_effect, shows);
            if kinds.is_empty() || clear >= 1.0 {
                return Ok(case);
            }
            if best.as_ref().is_none_or(|(clearest, _)| clear > *clearest) {
                best = Some((clear, case));
            }
        }
        best.map(|(_, case)| case).ok_or_else(|| UnknownDeparture(String::new()))
    }
}

/// One or more when the effect stands clearly above the floor, on the holdout runs too if they can show it.
fn clearness(with: &Gaps, without: &Gaps, shows_in_holdout: bool) -> f64 {
    let fit = (with.fit - without.fit) / (1.2 * without.fit).max(3.0);
    let holdout = (with.holdout - without.holdout) / (0.5 * without.holdout);
    if shows_in_holdout { fit.min(holdout) } else { fit }
}

/// A vehicle with its tolerances and ordered runs: where departures are sized.
struct Bench {
    sheet: Sheet,
    nuisances: Nuisances,
    wagon: TrueWagon,
    orders: Vec<programme::Order>,
    seed: u64,
    twin: Vec<Run>,
    floor: Gaps,
}

impl Bench {
    fn new(seed: u64, kinds: &[Kind]) -> Self {
        let motored = kinds.iter().any(|kind| kind.needs_motor);
        let sander = kinds.iter().any(|kind| kind.needs_sander);
        let sheet = Sheet::draw(&mut Stream::new(seed, "sheet", 0), motored, sander);
        let nuisances = Nuisances::draw(&mut Stream::new(seed, "nuisances", 0));
        let wagon = TrueWagon::new(&sheet, &nuisances);
        let orders = programme::orders(&sheet, seed);
        let floor = Gaps { fit: 0.0, holdout: 0.0 };
        let mut bench = Self { sheet, nuisances, wagon, orders, seed, twin: Vec::new(), floor };
        bench.twin = bench.drive(&[]);
        bench.floor = bench.calibrated(&bench.twin);
        bench
    }

    fn drive(&self, chosen: &[&Chosen]) -> Vec<Run> {
        let departures = chosen.iter().map(|chosen| self.draw(chosen).0).collect();
        let mut plant = Plant::new(&self.sheet, &self.wagon, Departures(departures), self.seed);
        let numbered = self.orders.iter().enumerate();
        numbered.map(|(index, order)| plant.drive(order, index as u64)).collect()
    }

    fn draw(&self, chosen: &Chosen) -> (Box<dyn Departure>, Vec<(&'static str, f64)>) {
        chosen.kind.draw(chosen.strength, &mut Stream::new(chosen.seed, chosen.kind.id, 0), &self.sheet)
    }

    /// The calibrated nominal model on these runs, fitted on their fit part.
    fn calibrated(&self, runs: &[Run]) -> Gaps {
        let fit: Vec<&Run> = runs.iter().filter(|run| !run.order.holdout).collect();
        let nuisances = gap::calibrate(&self.sheet, &fit, &self.nuisances, 5);
        let wagon = TrueWagon::new(&self.sheet, &nuisances);
        let part = |holdout: bool| {
            gap::gap(&self.sheet, &wagon, runs.iter().filter(|run| run.order.holdout == holdout)).total()
        };
        Gaps { fit: part(false), holdout: part(true) }
    }

    /// Finds a size at which the gap is clear: between twice and ten times the floor, roughly.
    fn size(&self, kind: Kind) -> (Chosen, Vec<Run>, Gaps) {
        let seed = self.seed ^ 0x00c0_ffee;
        let aim = Stream::new(seed, "aim", 0).uniform(8.0, 18.0);
        let mut chosen = Chosen { kind, strength: 1.0, seed };
        let mut runs = self.drive(&[&chosen]);
        let mut gaps = self.calibrated(&runs);
        for _ in 0..ADJUSTMENTS {
            let excess = (gaps.fit.powi(2) - self.floor.fit.powi(2)).max(0.25).sqrt();
            let too_large = gaps.fit > 30.0;
            let too_small = clearness(&gaps, &self.floor, kind.shows_in_holdout) < 1.0;
            let change = if too_large { (aim / excess).max(0.3) } else { (aim / excess).clamp(1.25, 3.0) };
            let strength = (chosen.strength * change).clamp(0.1, kind.strongest);
            if !(too_large || too_small) || (strength - chosen.strength).abs() < 0.02 {
                break;
            }
            chosen.strength = strength;
            runs = self.drive(&[&chosen]);
            gaps = self.calibrated(&runs);
        }
        (chosen, runs, gaps)
    }

    fn case(self, name: &str, kinds: &[Kind]) -> Case {
        let mut sized: Vec<(Chosen, Vec<Run>, Gaps)> = kinds.iter().map(|kind| self.size(*kind)).collect();
        let effects = sized.iter().map(|(chosen, _, _)| self.label(chosen)).collect();
        let (runs, gaps) = match sized.len() {
            0 => (self.twin.clone(), self.floor),
            1 => {
                let (_, runs, gaps) = sized.swap_remove(0);
                (runs, gaps)
            }
            _ => {
                let runs = self.drive(&sized.iter().map(|(chosen, _, _)| chosen).collect::<Vec<_>>());
                let gaps = self.calibrated(&runs);
                (runs, gaps)
            }
        };
        let label = Label {
            case: name.to_owned(),
            vehicle: self.sheet.family.to_owned(),
            effects,
            gap_calibrated: gaps,
            gap_without_the_effect: self.floor,
            plant: None,
        };
        Case { sheet: self.sheet, nuisances: self.nuisances, runs, twin: self.twin, label }
    }

    fn label(&self, chosen: &Chosen) -> LabelledEffect {
        let (_, parameters) = self.draw(chosen);
        LabelledEffect {
            gap_without: None,
            id: chosen.kind.id.to_owned(),
            term: chosen.kind.term.to_owned(),
            named: chosen.kind.named,
            form: String::new(),
            set: String::new(),
            strength: chosen.strength,
            parameters: parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
        }
    }
}

/// Shares of the kinds of case in a deck; the rest has one named effect each.
const NONE_SHARE: f64 = 0.17;
const PAIR_SHARE: f64 = 0.10;
const NAMELESS_SHARE: f64 = 0.13;

/// A deck of `count` cases: none, single effects (every id equally often), pairs and effects that no id names.
#[must_use]
pub fn deck(count: usize, seed: u64) -> Vec<Recipe> {
    let mut stream = Stream::new(seed, "deck", 0);
    let share = |share: f64| (share * count as f64).round() as usize;
    let mut named = Supply::new(|kind| kind.named);
    let mut nameless = Supply::new(|kind| !kind.named);
    let mut drawn: Vec<Vec<&'static str>> = vec![Vec::new(); share(NONE_SHARE)];
    drawn.extend((0..share(NAMELESS_SHARE)).map(|_| vec![nameless.next(&mut stream).id]));
    for _ in 0..share(PAIR_SHARE) {
        let first = named.next(&mut stream);
        let mut second = named.next(&mut stream);
        while twins(&first, &second) {
            second = named.next(&mut stream);
        }
        drawn.push(vec![first.id, second.id]);
    }
    while drawn.len() < count {
        drawn.push(vec![named.next(&mut stream).id]);
    }
    drawn.truncate(count);
    stream.shuffle(&mut drawn);
    let recipe = |(index, ids): (usize, Vec<&str>)| Recipe {
        name: format!("case{index:03}"),
        seed: seed.wrapping_mul(0x1_0000_01b3).wrapping_add(index as u64 * 7919),
        departures: ids.into_iter().map(str::to_owned).collect(),
    };
    drawn.into_iter().enumerate().map(recipe).collect()
}

/// Effects of one term, or of the two pairs that look alike across terms, make no fair pair.
fn twins(first: &Kind, second: &Kind) -> bool {
    const ALIKE: [[&str; 2]; 4] = [
        ["wheel_radius", "speed_scale"],
        ["clock_skew", "speed_latency"],
        ["brake_lag", "wheel_encoder_window"],
        ["mass_error", "rotating_inertia"],
    ];
    let alike = |pair: &[&str; 2]| pair.contains(&first.id) && pair.contains(&second.id);
    first.term == second.term || ALIKE.iter().any(alike)
}

/// Hands out kinds in random order, each once before any comes again.
struct Supply {
    all: Vec<Kind>,
    left: Vec<Kind>,
}

impl Supply {
    fn new(wanted: impl Fn(&Kind) -> bool) -> Self {
        Self { all: CATALOGUE.into_iter().filter(wanted).collect(), left: Vec::new() }
    }

    fn next(&mut self, stream: &mut Stream) -> Kind {
        if self.left.is_empty() {
            self.left.clone_from(&self.all);
            stream.shuffle(&mut self.left);
        }
        self.left.pop().unwrap_or(self.all[0])
    }
}
