//! The programme of one case: three to twelve runs, some of them to be predicted only, and who drives them.

use super::{line::Line, sheet::FamilySheet};
use crate::{
    random::Stream,
    sheet::{GRAVITY_M_S2, Rail},
};

/// A run as it is ordered, before the wagon runs it.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyOrder {
    /// Name without rail class.
    pub name: String,
    /// Rail class.
    pub rail: Rail,
    /// Whether the run may only be predicted.
    pub holdout: bool,
    /// Speed at the start, m/s.
    pub start_m_s: f64,
    /// From when on (s) which share of full pressing force is demanded.
    pub demand: Vec<(f64, f64)>,
    /// From when to when (s) which share of the largest drive torque acts.
    pub drive: Vec<(f64, f64, f64)>,
    /// Whether the run goes on to standstill and some seconds beyond; else it ends at 2 m/s.
    pub to_standstill: bool,
    /// Longest time, s.
    pub longest_s: f64,
    /// The line.
    pub line: Line,
}

impl FamilyOrder {
    /// Demanded share of full pressing force at a time.
    #[must_use]
    pub fn demand(&self, time_s: f64) -> f64 {
        self.demand.iter().take_while(|(from_s, _)| *from_s <= time_s).last().map_or(0.0, |(_, share)| *share)
    }

    /// Share of the largest drive torque at a time.
    #[must_use]
    pub fn drive(&self, time_s: f64) -> f64 {
        let acting = self.drive.iter().find(|(from_s, to_s, _)| (*from_s..*to_s).contains(&time_s));
        acting.map_or(0.0, |(_, _, share)| *share)
    }
}

/// What a run is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Stop,
    Partial,
    Steps,
    Hold,
    Mixed,
    Coast,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Partial => "partial",
            Self::Steps => "steps",
            Self::Hold => "hold",
            Self::Mixed => "mixed",
            Self::Coast => "coast",
        }
    }
}

/// The runs of a case. `low_rail` asks for low adhesion (most effects of adhesion show nowhere else); `protected` says
/// whether slide protection lets the brake ask for more than the rail may give.
#[must_use]
pub fn orders(sheet: &FamilySheet, seed: u64, low_rail: bool, protected: bool) -> Vec<FamilyOrder> {
    let mut stream = Stream::new(seed, "programme", 0);
    let count = 3 + stream.below(10);
    let holdouts = (count / 4).max(1) + usize::from(count > 6 && stream.chance(0.3));
    let fits = count - holdouts;
    let mut rails = vec![Rail::Dry];
    if stream.chance(0.6) {
        rails.push(Rail::Wet);
    }
    if low_rail || stream.chance(0.5) {
        rails.push(Rail::Low);
    }
    let mut plan: Vec<(Kind, Rail)> = vec![(Kind::Steps, Rail::Dry), (Kind::Stop, Rail::Dry)];
    if sheet.is_motored() {
        plan.push((Kind::Mixed, Rail::Dry));
    }
    plan.extend(rails.iter().skip(1).rev().map(|rail| (Kind::Stop, *rail)));
    plan.truncate(fits);
    let any = [Kind::Stop, Kind::Partial, Kind::Steps, Kind::Hold, Kind::Mixed, Kind::Mixed, Kind::Coast];
    while plan.len() < fits {
        plan.push((any[stream.below(any.len())], rails[stream.below(rails.len())]));
    }
    let met: Vec<Rail> = plan.iter().map(|(_, rail)| *rail).collect();
    plan.extend((0..holdouts).map(|_| (any[stream.below(any.len())], met[stream.below(met.len())])));
    let order = |(index, (kind, rail)): (usize, (Kind, Rail))| {
        let mut stream = Stream::new(seed, "order", index as u64);
        let name = format!("{}_{}", kind.name(), index + 1);
        FamilyOrder { name, holdout: index >= fits, ..order(kind, rail, sheet, protected, &mut stream) }
    };
    plan.into_iter().enumerate().map(order).collect()
}

/// A run after the programme.
#[derive(Debug, Clone, PartialEq)]
pub enum NextRun {
    /// What somebody asks the driver for.
    Asked(AskedRun),
    /// Any other of the programme, of this length, s.
    Any(f64),
}

/// A test that somebody asks the driver for.
#[derive(Debug, Clone, PartialEq)]
pub struct AskedRun {
    /// Rail class.
    pub rail: Rail,
    /// Speed at the start, m/s.
    pub start_m_s: f64,
    /// Until when (s) which share of full braking and of full traction is asked; one after the other.
    pub phases: Vec<(f64, f64, f64)>,
}

/// The order that a driver makes of what is asked: no more than the rail surely holds where nothing protects the wheels.
pub(super) fn asked(asked: &AskedRun, sheet: &FamilySheet, seed: u64, protected: bool) -> FamilyOrder {
    let (brake, traction) = (most_brake(sheet, asked.rail, protected), most_drive(sheet, asked.rail));
    let from_s = |index: usize| if index == 0 { 0.0 } else { asked.phases[index - 1].0 };
    let phases = || asked.phases.iter().enumerate();
    let pulls = phases().filter(|(_, (_, _, share))| *share > 0.0);
    FamilyOrder {
        name: String::new(),
        rail: asked.rail,
        holdout: false,
        start_m_s: asked.start_m_s,
        demand: phases().map(|(index, (_, share, _))| (from_s(index), share * brake)).collect(),
        drive: pulls
            .map(|(index, (until_s, _, share))| (from_s(index), *until_s, share * traction))
            .collect(),
        to_standstill: false,
        longest_s: asked.phases.last().map_or(0.0, |(until_s, ..)| *until_s),
        line: Line::draw(&mut Stream::new(seed, "asked", 0)),
    }
}

/// Another run of the programme, on a rail that it has met, of this length; it ends where its brake stops it.
pub(super) fn another(
    sheet: &FamilySheet,
    met: &[FamilyOrder],
    seed: u64,
    protected: bool,
    longest_s: f64,
) -> FamilyOrder {
    let mut stream = Stream::new(seed, "another", 0);
    let kinds = [Kind::Stop, Kind::Partial, Kind::Steps, Kind::Hold, Kind::Mixed, Kind::Coast];
    let kind = kinds[stream.below(kinds.len())];
    let rail = met[stream.below(met.len())].rail;
    let order = order(kind, rail, sheet, protected, &mut stream);
    FamilyOrder { to_standstill: false, longest_s, ..order }
}

/// Share of full braking that is asked for at most: without slide protection nobody brakes harder than the rail surely holds.
fn most_brake(sheet: &FamilySheet, rail: Rail, protected: bool) -> f64 {
    if protected { 1.0 } else { (0.75 * sheet.rail_friction(rail) / sheet.full_brake_ratio).min(1.0) }
}

/// Share of full traction that is asked for at most.
fn most_drive(sheet: &FamilySheet, rail: Rail) -> f64 {
    let ratio = sheet.drive_nm * sheet.wheelsets as f64 / (sheet.mass_kg * GRAVITY_M_S2 * sheet.radius_m);
    (0.6 * sheet.rail_friction(rail) / ratio).min(1.0)
}

fn order(kind: Kind, rail: Rail, sheet: &FamilySheet, protected: bool, stream: &mut Stream) -> FamilyOrder {
    let top = match rail {
        Rail::Dry => sheet.top_speed_m_s,
        Rail::Wet => sheet.top_speed_m_s.min(32.0),
        Rail::Low => sheet.top_speed_m_s.min(24.0),
    };
    let most = most_brake(sheet, rail, protected);
    let share = |stream: &mut Stream, low: f64, high: f64| most * stream.uniform(low, high);
    let onset_s = stream.uniform(2.0, 6.0);
    let mut demand = match kind {
        Kind::Stop => vec![(onset_s, share(stream, 0.8, 1.0))],
        Kind::Partial => vec![(onset_s, share(stream, 0.35, 0.7))],
        Kind::Hold => {
            vec![(onset_s, share(stream, 0.12, 0.3)), (stream.uniform(30.0, 40.0), share(stream, 0.5, 0.9))]
        }
        Kind::Steps => steps(stream, most),
        Kind::Mixed => vec![(stream.uniform(24.0, 34.0), share(stream, 0.5, 0.95))],
        Kind::Coast => vec![(stream.uniform(18.0, 32.0), share(stream, 0.4, 0.9))],
    };
    let driven = kind == Kind::Mixed && sheet.is_motored();
    let from_standstill = driven && stream.chance(0.5);
    let start_m_s = match kind {
        Kind::Mixed if from_standstill => 0.0,
        Kind::Mixed if driven => stream.uniform(3.0, 9.0),
        _ => top * stream.uniform(0.7, 1.0),
    };
    let mut drive = Vec::new();
    if driven {
        let most = most_drive(sheet, rail);
        let (from_s, until_s) = (stream.uniform(1.5, 4.0), stream.uniform(14.0, 20.0));
        let change_s = stream.uniform(from_s + 3.0, until_s);
        drive.push((from_s, change_s, most * stream.uniform(0.6, 1.0)));
        drive.push((change_s, until_s, most * stream.uniform(0.2, 0.8)));
    }
    if from_standstill {
        // The brake holds until the drive pulls.
        let released_s = drive.first().map_or(1.0, |(from_s, _, _)| from_s - 0.8);
        demand.splice(0..0, [(0.0, 0.3), (released_s, 0.0)]);
    }
    FamilyOrder {
        name: String::new(),
        rail,
        holdout: false,
        start_m_s,
        demand,
        drive,
        to_standstill: stream.chance(0.35),
        longest_s: stream.uniform(35.0, 60.0),
        line: Line::draw(stream),
    }
}

/// On and off at changing levels, then one last level until the end.
fn steps(stream: &mut Stream, most: f64) -> Vec<(f64, f64)> {
    let (mut demand, mut time_s) = (Vec::new(), stream.uniform(3.0, 5.0));
    while time_s < 42.0 {
        demand.push((time_s, most * stream.uniform(0.2, 0.95)));
        time_s += stream.uniform(3.0, 7.0);
        if stream.chance(0.3) {
            demand.push((time_s, most * stream.uniform(0.2, 0.95)));
            time_s += stream.uniform(2.0, 4.0);
        }
        demand.push((time_s, 0.0));
        time_s += stream.uniform(2.5, 5.0);
    }
    demand.push((time_s, most * stream.uniform(0.6, 0.9)));
    demand
}
