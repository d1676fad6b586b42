//! A coupled train is judged together, by a process of its own: what that says, and what it takes from the wagons.
//!
//! A wagon that is pulled and pushed by couplers does not tell by its motion what its own brake does. Indicators that look at
//! it so (`of_free_wagon` in the table) keep their figures but are not graded here; alerts, grades of wagons and wheelsets,
//! stopping distances and the map follow the verdicts about the whole train.

use railgrip_causes::Cause;
use railgrip_indicators::train::stopping::BrakedWagon;
use railgrip_indicators::{IndicatorSpec, Nominal, Table};
use railgrip_messages::{Grade, Health, Indicator, Stamp, Text, Verdict, Verdicts};

/// Without a message for so long nobody judges, s.
const SILENT_S: f64 = 10.0;
/// Why an indicator is not graded.
const NOT_ALONE: &str =
    "not graded: couplers push and pull this wagon, so that it is judged with the whole train";
/// Pad friction over nominal of a coupled wagon: value, low, high.
const PADS: [f64; 3] = [1.0, 0.7, 1.1];

/// What is judged of the train as a whole.
#[derive(Debug, Clone, Default)]
pub(super) struct Judgement {
    together: bool,
    latest: Option<Box<Verdicts>>,
}

impl Judgement {
    /// Nothing has been judged yet.
    pub fn new(together: bool) -> Self {
        Self { together, latest: None }
    }

    /// Whether the wagons are judged together.
    pub const fn is_together(&self) -> bool {
        self.together
    }

    /// Takes what is wrong now.
    pub fn take(&mut self, verdicts: &Verdicts) {
        self.latest = Some(Box::new(*verdicts));
    }

    /// What was judged last, if it is not old.
    pub fn fresh(&self, now: Stamp) -> Option<&Verdicts> {
        self.latest.as_deref().filter(|latest| latest.stamp.age_s(now.monotonic_ns) < SILENT_S)
    }

    /// Whether somebody judges the train now: what none of the verdicts names is well then.
    pub fn speaks(&self, now_ns: u64) -> bool {
        let latest = self.latest.as_deref().filter(|_| self.together);
        latest.is_some_and(|latest| latest.instants > 0 && latest.stamp.age_s(now_ns) < SILENT_S)
    }

    /// Brake applications that the judge has seen.
    pub fn brakings(&self) -> Option<u32> {
        self.latest.as_deref().map(|latest| latest.brakings)
    }

    /// When something was judged last, and whether that is too long ago; `started` is when this service began.
    pub fn silence(&self, started: Stamp, now: Stamp) -> Option<Stamp> {
        let last = self.latest.as_deref().map_or(started, |latest| latest.stamp);
        (self.together && last.age_s(now.monotonic_ns) >= SILENT_S).then_some(last)
    }

    /// Whether an indicator is graded on each wagon.
    pub fn grades(&self, spec: &IndicatorSpec) -> bool {
        !self.together || spec.alert.is_none_or(|alert| !alert.of_free_wagon)
    }

    /// What a wagon says, without the grades that it can give only where it runs alone.
    pub fn limit(&self, table: Table, health: &Health) -> Health {
        let mut limited = *health;
        if !self.together {
            return limited;
        }
        let ungraded = |indicator: &mut Indicator| {
            indicator.grade = Grade::Unknown.code();
            indicator.reason = Text::new(NOT_ALONE);
        };
        for spec in table.iter().filter(|spec| !self.grades(spec)) {
            table.wagon_mut(&mut limited, spec).map(ungraded);
            for index in 0..health.wheelset_count() {
                table.wheelset_mut(&mut limited, index, spec).map(ungraded);
            }
        }
        // The filter takes the couplers for adhesion: what it says of the rail is not the rail's, and a wheelset slides only
        // where slide protection says so.
        limited.condition = u32::MAX;
        limited.wheelset.iter_mut().for_each(|wheelset| wheelset.sliding &= wheelset.wsp_active);
        limited.grade = table.worst(&limited).code();
        limited
    }

    /// Whether what a wagon says of the rail may go onto the map: the train slides, or nothing is wrong with the wagon.
    pub fn charts(&self, wagon: u32, slides: bool) -> bool {
        let Some(latest) = self.latest.as_deref().filter(|_| self.together) else { return !self.together };
        let low = |verdict: &Verdict| verdict.cause == Cause::LowAdhesion.code();
        let accused = |verdict: &Verdict| verdict.wagons().any(|other| other == wagon);
        let all = latest.standing();
        !all.iter().any(accused) && (!slides || all.iter().any(low))
    }

    /// How a wagon brakes by what is judged of the train; `nominal` is what its file says, with good pads on dry rail.
    pub fn braked(&self, wagon: u32, file: &Nominal, nominal: BrakedWagon) -> BrakedWagon {
        let mut now = BrakedWagon { friction_ratio: PADS, ..nominal };
        let standing = self.latest.as_deref().map_or(&[][..], |latest| latest.standing());
        for verdict in standing {
            match Cause::from_code(verdict.cause) {
                Some(Cause::LowAdhesion) => {
                    let [_, wet, low] = file.rail;
                    now.adhesion = [low, 0.5 * low, wet];
                }
                Some(Cause::Isolated) if verdict.wagons().any(|other| other == wagon) => {
                    let without = f64::from(verdict.wheelsets.count_ones()) / file.wheelsets.max(1) as f64;
                    now.braked_share =
                        if verdict.wheelsets == 0 { 0.0 } else { (1.0 - without).clamp(0.0, 1.0) };
                }
                _ => {}
            }
        }
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_indicators::INDICATORS;
    use railgrip_indicators::indicator::{BRAKE_FRICTION, SENSORS};

    fn indicator(grade: Grade) -> Indicator {
        Indicator { value: 0.2, grade: grade.code(), known: 1, ..Indicator::default() }
    }

    #[test]
    fn a_coupled_wagon_keeps_its_figures_and_is_graded_by_its_sensors_alone() {
        let mut health = Health { wheelsets: 2, grade: Grade::Act.code(), ..Health::default() };
        BRAKE_FRICTION.put(&mut health, indicator(Grade::Act));
        BRAKE_FRICTION.put_wheelset(&mut health, 1, indicator(Grade::Act));
        SENSORS.put(&mut health, indicator(Grade::Ok));
        let free = Judgement::new(false).limit(INDICATORS, &health);
        assert_eq!(free, health);
        let coupled = Judgement::new(true).limit(INDICATORS, &health);
        assert_eq!(coupled.grade(), Grade::Ok);
        assert_eq!(BRAKE_FRICTION.of(&coupled).grade(), Grade::Unknown);
        assert_eq!(BRAKE_FRICTION.of_wheelset(&coupled, 1).figure(), Some(0.2));
    }

    #[test]
    fn brakes_and_rail_are_those_of_the_verdicts() {
        let file = Nominal {
            brake_friction: 0.35,
            rail: [0.30, 0.12, 0.06],
            wheelsets: 4,
            mass_kg: 40e3,
            inertia_kg_m2: 120.0,
            wheel_radius_m: 0.44,
            brake_radius_m: 0.25,
            resistance: [400.0, 8.0, 4.0],
            coupled: false,
        };
        let nominal = railgrip_indicators::train::braked::nominally(&file);
        let mut verdicts = Verdicts { count: 2, ..Verdicts::default() };
        verdicts.verdict[0].cause = Cause::Isolated.code();
        verdicts.verdict[0].add_wagon(3);
        verdicts.verdict[0].wheelsets = 0b10;
        verdicts.verdict[1].cause = Cause::LowAdhesion.code();
        let mut judgement = Judgement::new(true);
        judgement.take(&verdicts);
        let braked = |wagon| judgement.braked(wagon, &file, nominal);
        assert_eq!((braked(3).braked_share, braked(2).braked_share), (0.75, 1.0));
        assert_eq!(braked(2).adhesion, [0.06, 0.03, 0.12]);
        assert!(judgement.charts(2, true) && !judgement.charts(3, false));
    }
}
