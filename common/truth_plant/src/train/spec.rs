//! A train before it runs: everything about it follows from one seed and an order.

use crate::random::Stream;

use super::{
    contact::CreepLaw,
    coupler::DrawGear,
    driver::DriverStyle,
    family::{BrakeLine, FAMILIES, Family, WagonKind},
    faults::{ActsOn, FAULTS, Fault, FaultKind},
    line::{Line, LinePlan, LowStretch, START_M},
    wagon::{Common, Wagon},
    weather::{self, Weather},
};

/// Share of trains without any fault, where the order leaves it open.
const HEALTHY_SHARE: f64 = 0.35;
/// Heaviest train that one locomotive pulls, kg.
const ONE_LOCOMOTIVE_KG: f64 = 1.3e6;

/// Which fault is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FaultWish<'a> {
    /// Any or none, by chance.
    #[default]
    Any,
    /// None.
    None,
    /// The one of this id.
    Of(&'a str),
}

/// What is wanted of a train; the rest is drawn.
#[derive(Debug, Clone, Copy)]
pub struct TrainOrder<'a> {
    /// Coupled trains only, single free wagons only, or either.
    pub coupled: Option<bool>,
    /// Family by name, or any.
    pub family: Option<&'a str>,
    /// Number of wagons, or as the family has it.
    pub wagons: Option<usize>,
    /// Length of the day, h.
    pub hours: f64,
    /// Sample rate of the recordings, Hz.
    pub rate_hz: f64,
    /// Fault.
    pub fault: FaultWish<'a>,
}

impl Default for TrainOrder<'_> {
    fn default() -> Self {
        Self { coupled: None, family: None, wagons: None, hours: 1.0, rate_hz: 50.0, fault: FaultWish::Any }
    }
}

/// An order that no train meets.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// No such sample rate.
    #[error("sample rate is {0} Hz, allowed are {allowed}", allowed = "20, 25, 50, 100 and 200")]
    Rate(f64),
    /// Hours out of range.
    #[error("{0} hours, allowed is 0.01 to 24")]
    Hours(f64),
    /// No such number of wagons.
    #[error("{0} wagons, allowed is 4 to 64, and 1 for a free wagon")]
    Wagons(usize),
    /// No such family.
    #[error("no family {0} of this kind; there are {known}", known = families())]
    Family(String),
    /// The fault has no place in this train.
    #[error("fault {0} has no place in a {1} of {2} wagons")]
    NoPlace(String, &'static str, usize),
    /// No such fault.
    #[error("no fault {0}; there are {known}", known = faults())]
    Fault(String),
}

fn families() -> String {
    FAMILIES.map(|family| family.name).join(", ")
}

fn faults() -> String {
    FAULTS.map(|kind| kind.id).join(", ")
}

/// A train before it runs.
#[derive(Debug, Clone)]
pub struct TrainSpec {
    /// Everything random follows from this.
    pub seed: u64,
    /// Family.
    pub family: &'static str,
    /// Whether its wagons are coupled.
    pub coupled: bool,
    /// The wagons, front first.
    pub wagons: Vec<Wagon>,
    /// The draw gear behind each wagon but the last.
    pub couplers: Vec<DrawGear>,
    /// How orders reach the distributors.
    pub brake_line: BrakeLine,
    pub(crate) law: CreepLaw,
    /// The line.
    pub line: Line,
    /// The weather.
    pub weather: Weather,
    /// The driver.
    pub driver: DriverStyle,
    /// What is wrong, if anything.
    pub fault: Option<Fault>,
    /// The stretches that a fault of the rail has soiled; they are among those of the line.
    pub(crate) soiled: Vec<LowStretch>,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Length of the day, s.
    pub duration_s: f64,
}

impl TrainSpec {
    /// Any train: an hour at 50 Hz.
    ///
    /// # Errors
    /// None that this order can raise.
    pub fn draw(seed: u64) -> Result<Self, OrderError> {
        Self::draw_to(seed, &TrainOrder::default())
    }

    /// A train to an order.
    ///
    /// # Errors
    /// An order that no train meets.
    pub fn draw_to(seed: u64, order: &TrainOrder<'_>) -> Result<Self, OrderError> {
        let wanted = check(order)?;
        let family = family(seed, order)?;
        let duration_s = order.hours * 3600.0;
        let mut stream = Stream::new(seed, "train", 0);
        let full_m_s2 = stream.uniform(family.full_m_s2.0, family.full_m_s2.1);
        let common = Common {
            stiffness: stream.uniform(0.95, 1.05),
            declared: stream.chance(0.6),
            load_measured: stream.chance(0.4),
            full_m_s2,
            by_bogie: stream.chance(0.3),
        };
        let wagons = wagons(seed, family, order.wagons, &common);
        let gear = (family.gear)(&mut stream);
        let couplers = (1..wagons.len()).map(|_| varied(&mut stream, &gear)).collect();
        let top_m_s = stream.uniform(family.top_m_s.0, family.top_m_s.1);
        let length_m: f64 = wagons.iter().map(|wagon| wagon.real.length_m).sum();
        let plan = LinePlan {
            station_m: family.station_m,
            top_m_s,
            grade_rad: family.grade_rad,
            length_m: START_M + duration_s * 0.95 * top_m_s,
            train_m: length_m,
        };
        let mut line = Line::draw(&mut Stream::new(seed, "line", 0), &plan);
        let mut sky = Stream::new(seed, "weather", 0);
        let weather = Weather::draw(&mut sky, duration_s);
        line.low = weather::leaves(&mut sky, duration_s * 0.5 * top_m_s);
        let driver = driver(&mut stream, family, full_m_s2, length_m);
        let law = CreepLaw {
            fall: stream.uniform(0.25, 0.45),
            clean_share: 0.675 * stream.uniform(0.98, 1.02),
            ..CreepLaw::default()
        };
        let mut spec = Self {
            seed,
            family: family.name,
            coupled: family.coupled,
            wagons,
            couplers,
            brake_line: family.line,
            law,
            line,
            weather,
            driver,
            fault: None,
            soiled: Vec::new(),
            rate_hz: order.rate_hz,
            duration_s,
        };
        spec.place_fault(wanted, order.fault == FaultWish::Any);
        match wanted.filter(|_| spec.fault.is_none()) {
            Some(kind) => Err(OrderError::NoPlace(kind.id.to_owned(), spec.family, spec.wagons.len())),
            None => Ok(spec),
        }
    }

    /// Full-brake retardation of the train, m/s².
    #[must_use]
    pub fn full_brake_m_s2(&self) -> f64 {
        self.driver.full_m_s2
    }

    /// Draws the fault and builds in what the train leaves the depot with.
    fn place_fault(&mut self, wanted: Option<&'static FaultKind>, any: bool) {
        let mut stream = Stream::new(self.seed, "fault", 0);
        let healthy = stream.chance(HEALTHY_SHARE);
        let sanders: Vec<usize> =
            (0..self.wagons.len()).filter(|wagon| self.wagons[*wagon].real.sander).collect();
        let possible = |kind: &&'static FaultKind| match kind.acts_on {
            ActsOn::RearPart => self.wagons.len() > 1,
            ActsOn::Sander => !sanders.is_empty(),
            _ => true,
        };
        let choices: Vec<&'static FaultKind> = FAULTS.iter().filter(possible).collect();
        let drawn = choices[stream.below(choices.len())];
        let Some(kind) = wanted.filter(possible).or_else(|| (any && !healthy).then_some(drawn)) else {
            return;
        };
        let wheelsets: Vec<usize> = self.wagons.iter().map(Wagon::wheelsets).collect();
        let fault = Fault::draw(kind, &mut stream, &wheelsets, &sanders, self.duration_s);
        let wagon = &mut self.wagons[fault.wagon];
        match kind.id {
            "payload_entry" => {
                wagon.file.mass_kg = (wagon.real.mass_kg / (1.0 + fault.size)).round();
                wagon.file.mass_sigma = 0.015;
            }
            "wheel_diameter" => wagon.real.radius_m[fault.wheelset] *= 1.0 + fault.size,
            "low_stretch" => self.soil(&fault, &mut stream),
            _ => {}
        }
        self.fault = Some(fault);
    }

    /// Dirties the approaches of some stations in a row.
    fn soil(&mut self, fault: &Fault, stream: &mut Stream) {
        let stations = &self.line.stations_m;
        // The line is as long as the train could run without a stop; it gets about as far as half of it.
        let likely = (0.25 * stations.len() as f64) as usize;
        let first = 1 + stream.below(likely.max(1));
        let friction = self.weather.dry * (1.0 - fault.size);
        for station in stations.iter().skip(first).take(2 + stream.below(3)) {
            let from_m = station - stream.uniform(300.0, 900.0);
            self.soiled.push(LowStretch { from_m, to_m: station - stream.uniform(0.0, 80.0), friction });
        }
        self.line.low.extend(&self.soiled);
    }
}

/// Seeds and faults of `count` trains: healthy ones and every kind of fault, or of `only` those, equally often, in random order.
#[must_use]
pub fn deck(
    count: usize,
    seed: u64,
    coupled: Option<bool>,
    only: &[&'static FaultKind],
) -> Vec<(u64, FaultWish<'static>)> {
    let mut stream = Stream::new(seed, "deck of trains", 0);
    let mut wishes = vec![FaultWish::None; (HEALTHY_SHARE * count as f64).round() as usize];
    let mut kinds: Vec<&'static FaultKind> = Vec::new();
    while wishes.len() < count {
        if kinds.is_empty() {
            // A part of a train to cut off is only sure to exist where all trains are coupled.
            let fits = |kind: &&FaultKind| coupled == Some(true) || kind.acts_on != ActsOn::RearPart;
            kinds = match only.is_empty() {
                true => FAULTS.iter().filter(fits).collect(),
                false => only.to_vec(),
            };
            stream.shuffle(&mut kinds);
        }
        wishes.extend(kinds.pop().map(|kind| FaultWish::Of(kind.id)));
    }
    stream.shuffle(&mut wishes);
    let train = |(index, wish): (usize, FaultWish<'static>)| {
        (seed.wrapping_mul(0x1_0000_01b3).wrapping_add(0x9e37 * (index as u64 + 1)), wish)
    };
    wishes.into_iter().enumerate().map(train).collect()
}

fn check(order: &TrainOrder<'_>) -> Result<Option<&'static FaultKind>, OrderError> {
    if ![20.0, 25.0, 50.0, 100.0, 200.0].contains(&order.rate_hz) {
        return Err(OrderError::Rate(order.rate_hz));
    }
    if !(0.01..=24.0).contains(&order.hours) {
        return Err(OrderError::Hours(order.hours));
    }
    match order.fault {
        FaultWish::Of(id) => FaultKind::of(id).map(Some).ok_or_else(|| OrderError::Fault(id.to_owned())),
        FaultWish::Any | FaultWish::None => Ok(None),
    }
}

/// A family that the order allows, drawn by weight.
fn family(seed: u64, order: &TrainOrder<'_>) -> Result<&'static Family, OrderError> {
    let mut stream = Stream::new(seed, "family", 0);
    let coupled = match (order.coupled, order.wagons) {
        (Some(coupled), _) => coupled,
        (None, Some(count)) => count > 1,
        (None, None) => stream.chance(0.8),
    };
    let fits = |count: usize| if coupled { (4..=64).contains(&count) } else { count == 1 };
    if let Some(count) = order.wagons.filter(|count| !fits(*count)) {
        return Err(OrderError::Wagons(count));
    }
    if let Some(name) = order.family {
        let named = FAMILIES.iter().find(|family| family.name == name);
        let asked = |family: &&Family| order.coupled.is_none_or(|coupled| coupled == family.coupled);
        return named.filter(asked).ok_or_else(|| OrderError::Family(name.to_owned()));
    }
    let choices = || FAMILIES.iter().filter(|family| family.coupled == coupled);
    let total: f64 = choices().map(|family| family.weight).sum();
    let mut left = stream.uniform(0.0, total);
    for family in choices() {
        left -= family.weight;
        if left <= 0.0 {
            return Ok(family);
        }
    }
    Ok(&FAMILIES[0])
}

/// Locomotives first, then the pattern of the family, as long as the train is.
fn wagons(seed: u64, family: &Family, wanted: Option<usize>, common: &Common) -> Vec<Wagon> {
    let mut stream = Stream::new(seed, "wagons", 0);
    let (fewest, most) = family.wagons;
    // Short trains are as frequent as long ones on a logarithmic scale.
    let drawn = fewest as f64 * ((most as f64 + 1.0) / fewest as f64).powf(stream.uniform(0.0, 1.0));
    let count = wanted.unwrap_or((drawn as usize).clamp(fewest, most));
    let draw = |index: usize, kind: &WagonKind, motored: bool| {
        Wagon::draw(&mut Stream::new(seed, "wagon", index as u64), kind, family, common, motored)
    };
    let mut train: Vec<Wagon> = (0..count)
        .map(|index| {
            let kind = match (&family.locomotive, index) {
                (Some(locomotive), 0) => locomotive,
                _ => &family.pattern[index % family.pattern.len()],
            };
            draw(index, kind, kind.traction_n > 0.0)
        })
        .collect();
    let mass_kg: f64 = train.iter().map(|wagon| wagon.real.mass_kg).sum();
    if let Some(locomotive) = family.locomotive.filter(|_| mass_kg > ONE_LOCOMOTIVE_KG) {
        train[1] = draw(1, &locomotive, true);
    }
    train
}

fn varied(stream: &mut Stream, gear: &DrawGear) -> DrawGear {
    DrawGear {
        slack_m: gear.slack_m * stream.uniform(0.6, 1.4),
        stiffness_n_per_m: gear.stiffness_n_per_m * stream.uniform(0.85, 1.15),
        preload_n: gear.preload_n * stream.uniform(0.8, 1.2),
        ..*gear
    }
}

fn driver(stream: &mut Stream, family: &Family, full_m_s2: f64, length_m: f64) -> DriverStyle {
    let by_pipe = family.line == BrakeLine::Pipe;
    let fill_s = family.fill_s.0;
    DriverStyle {
        planned_m_s2: full_m_s2 * stream.uniform(family.planned.0, family.planned.1),
        full_m_s2,
        lag_s: 0.5 * fill_s + if by_pipe { 0.8 + length_m / 500.0 } else { 0.2 },
        patience_s: if by_pipe { 1.5 + 0.1 * fill_s } else { 0.3 },
        notch: if by_pipe { 0.05 } else { [0.0, 1.0 / 7.0, 0.02][stream.below(3)] },
        coast_m_s: stream.uniform(1.5, 5.0),
        dwell_s: family.dwell_s,
        hold: stream.uniform(0.3, 0.5),
        release_s: if by_pipe { 0.9 * family.release_s.1 } else { 0.0 },
    }
}
