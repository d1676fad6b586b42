//! A train of rigid wagons that follow a timetable, with one fault or none: does the watch name it, and nothing else?

use railgrip_causes::{Alert, Cause, Reading, TrainWatch, WagonFile};

const WAGONS: usize = 5;
const DT_S: f64 = 0.02;
const RADIUS_M: f64 = 0.45;
const COMPLIANCE_PER_N: f64 = 1.7e-7;
const FULL_N: f64 = 30e3;

/// What is wrong with wheelset 2 (index 1) of wagon 3 (index 2), or with that wagon, from the third stop on.
#[derive(Clone, Copy, PartialEq)]
enum Wrong {
    Nothing,
    Pads(f64),
    Drags(f64),
    NoForce,
    Wagon,
    Late(f64),
    Clock(f64),
    Wobbles(f64),
    Missing,
    /// Its cylinders take so many times as long.
    Slow(f64),
    /// Its distributor hears the order so late, s.
    LateDistributor(f64),
    /// The wheelset's cylinder loses this share a second while it is held.
    Leaks(f64),
}

/// Even noise that repeats with the seed.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 3.46
    }
}

fn file() -> WagonFile {
    WagonFile {
        wheelsets: 4,
        mass_kg: 40e3,
        mass_sigma: 0.015,
        radius_m: RADIUS_M,
        inertia_kg_m2: 100.0,
        pad_radius_m: 0.25,
        pad_friction: 0.35,
        compliance_per_n: COMPLIANCE_PER_N,
        resistance: [500.0, 5.0, 2.0],
        speed_sigma_m_s: 0.03,
        wheel_speed_sigma_rad_s: 0.03,
    }
}

/// Acceleration and order of a timetable of 150 s a stop.
fn timetable(t: f64) -> (f64, f64) {
    match t % 150.0 {
        t if t < 40.0 => (0.5, 0.0),
        t if t < 105.0 => (0.0, 0.0),
        t if t < 135.0 => (-0.64, 0.6),
        _ => (0.0, 0.0),
    }
}

fn day(wrong: Wrong) -> Vec<Alert> {
    day_with(wrong, &[]).alerts().to_vec()
}

/// What a successor of `watch` goes on with, from what was written down.
fn successor(watch: &TrainWatch, files: &[WagonFile]) -> Option<TrainWatch> {
    let bytes = postcard::to_stdvec(watch).expect("bytes");
    postcard::from_bytes::<TrainWatch>(&bytes).expect("a watch").go_on(files)
}

/// A day on which the watch has a successor at each of these times, s.
fn day_with(wrong: Wrong, successions_s: &[f64]) -> TrainWatch {
    day_that_says(wrong, successions_s, |_, _| {})
}

/// The same with what `spoils` makes of the readings of each instant, by its number.
fn day_that_says(
    wrong: Wrong,
    successions_s: &[f64],
    spoils: impl FnMut(usize, &mut [Reading]),
) -> TrainWatch {
    day_of(vec![file(); WAGONS], wrong, successions_s, spoils)
}

/// The same of a train of these wagons.
fn day_of(
    files: Vec<WagonFile>,
    wrong: Wrong,
    successions_s: &[f64],
    mut spoils: impl FnMut(usize, &mut [Reading]),
) -> TrainWatch {
    let wagons = files.len();
    let mut watch = TrainWatch::new(files.clone());
    let mut noise = Noise(7);
    let (mut v_m_s, mut angle_rad) = (4.0_f64, 0.0_f64);
    let mut force_n = vec![[0.0_f64; 4]; wagons];
    for step in 0..(1900.0 / DT_S) as usize {
        let t = step as f64 * DT_S;
        let (a_m_s2, order) = timetable(t);
        v_m_s = (v_m_s + a_m_s2 * DT_S).max(4.0);
        angle_rad += v_m_s / RADIUS_M * DT_S;
        let faulty = t > 450.0;
        let mut readings = vec![Reading::default(); wagons];
        for (index, reading) in readings.iter_mut().enumerate() {
            let here = index == 2 && faulty;
            let behind_s = match wrong {
                Wrong::Clock(lag_s) if here => lag_s,
                _ => 0.0,
            };
            reading.v_m_s = v_m_s - behind_s * a_m_s2 + 0.03 * noise.next();
            reading.brake_demand = order;
            reading.grade_rad = 0.0;
            for k in 0..4 {
                let one = here && k == 1;
                let cut = (one && wrong == Wrong::NoForce) || (here && wrong == Wrong::Wagon);
                let (slow, late_s) = match wrong {
                    Wrong::Slow(times) if here => (times, 0.0),
                    Wrong::LateDistributor(late_s) if here => (1.0, late_s),
                    _ => (1.0, 0.0),
                };
                let heard = if late_s > 0.0 { timetable(t - late_s).1 } else { order };
                let leaked = match wrong {
                    Wrong::Leaks(share) if one => (-share * (t % 150.0 - 106.0).max(0.0)).exp(),
                    _ => 1.0,
                };
                let wanted_n = if cut { 0.0 } else { heard * leaked * FULL_N };
                let pressed_n = &mut force_n[index][k];
                *pressed_n += DT_S / (0.8 * slow) * (wanted_n - *pressed_n);
                let (pads, drags_n) = match wrong {
                    Wrong::Pads(lost) if one => (1.0 - lost, 0.0),
                    Wrong::Drags(force_n) if one => (1.0, force_n),
                    _ => (1.0, 0.0),
                };
                let pads_n = 0.35 * pads * *pressed_n * 0.25 / RADIUS_M;
                let inertia_n = 100.0 * a_m_s2 / (RADIUS_M * RADIUS_M);
                let creepage = -(pads_n + drags_n + inertia_n) * COMPLIANCE_PER_N;
                let seen_m_s = match wrong {
                    Wrong::Late(lag_s) if one => v_m_s - lag_s * a_m_s2,
                    _ => v_m_s - behind_s * a_m_s2,
                };
                let wobble = match wrong {
                    Wrong::Wobbles(share) if one => share * angle_rad.sin(),
                    _ => 0.0,
                };
                // Every wheel has a radius of its own.
                let radius = 1e-3 * ((index * 4 + k) as f64 * 1.7).sin();
                let omega = seen_m_s / RADIUS_M * (1.0 + radius + creepage + wobble);
                let lost = one && wrong == Wrong::Missing && step % 500 < 60;
                reading.wheel_speed_rad_s[k] = if lost { f64::NAN } else { omega + 0.03 * noise.next() };
                reading.pressing_force_n[k] = (*pressed_n + 150.0 * noise.next()).max(0.0);
            }
        }
        if successions_s.iter().any(|at_s| (t - at_s).abs() < 0.5 * DT_S) {
            watch = successor(&watch, &files).expect("of the same wagons");
        }
        spoils(step, &mut readings);
        watch.take(t, &readings);
    }
    watch
}

fn named(alerts: &[Alert]) -> Vec<(Cause, Vec<usize>, Vec<usize>)> {
    alerts.iter().map(|alert| (alert.cause, alert.wagons.clone(), alert.wheelsets.clone())).collect()
}

/// The wagons of each alert of a cause.
fn wagons_of(watch: &TrainWatch, cause: Cause) -> Vec<Vec<usize>> {
    let alerts = watch.alerts().iter().filter(|alert| alert.cause == cause);
    alerts.map(|alert| alert.wagons.clone()).collect()
}

/// Makes each wagon press with a share of its force.
fn press(readings: &mut [Reading], shares: &[f64]) {
    for (reading, share) in readings.iter_mut().zip(shares) {
        reading.pressing_force_n.iter_mut().for_each(|force_n| *force_n *= share);
    }
}

#[test]
fn a_healthy_train_raises_nothing() {
    assert_eq!(day(Wrong::Nothing), vec![]);
}

#[test]
fn each_fault_raises_one_alert_with_its_cause_and_place() {
    let wheelset = |cause| vec![(cause, vec![2], vec![1])];
    assert_eq!(named(&day(Wrong::Pads(0.35))), wheelset(Cause::PadUneven));
    assert_eq!(named(&day(Wrong::Drags(1500.0))), wheelset(Cause::Dragging));
    assert_eq!(named(&day(Wrong::NoForce)), wheelset(Cause::Isolated));
    assert_eq!(named(&day(Wrong::Wagon)), vec![(Cause::Isolated, vec![2], vec![])]);
    assert_eq!(named(&day(Wrong::Late(0.3))), wheelset(Cause::TachometerLate));
    assert_eq!(named(&day(Wrong::Clock(0.3))), vec![(Cause::Clock, vec![2], vec![])]);
    assert_eq!(named(&day(Wrong::Wobbles(0.012))), wheelset(Cause::TachometerEccentric));
    assert_eq!(named(&day(Wrong::Missing)), wheelset(Cause::TachometerDropout));
    assert_eq!(named(&day(Wrong::Slow(2.5))), vec![(Cause::SlowCylinder, vec![2], vec![])]);
    assert_eq!(named(&day(Wrong::LateDistributor(3.0))), vec![(Cause::LateDistributor, vec![2], vec![])]);
    assert_eq!(named(&day(Wrong::Leaks(0.03))), wheelset(Cause::SlowCylinder));
}

/// From the third stop on one wheelset turns faster, as if its wheel had become smaller: the others of its wagon do not drag.
#[test]
fn a_wheelset_that_turns_faster_makes_no_drag_of_the_others() {
    let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
        if step as f64 * DT_S > 450.0 {
            readings[2].wheel_speed_rad_s[1] *= 1.01;
        }
    });
    assert_eq!(named(watch.alerts()), [(Cause::WheelDiameter, vec![2], vec![1])]);
}

/// A tachometer that shows nothing but zeros from the fourth stop on is dead, and neither late nor a wheelset that slides.
#[test]
fn a_tachometer_that_shows_zeros_is_dead() {
    let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
        if step as f64 * DT_S > 500.0 {
            readings[2].wheel_speed_rad_s[1] = 0.0;
        }
    });
    let [alert] = watch.alerts() else { panic!("{:?}", watch.alerts()) };
    assert_eq!((alert.cause, &alert.wheelsets[..]), (Cause::TachometerDropout, &[1][..]), "{alert:?}");
    assert!(alert.raised_t_s < 560.0 && alert.reason.contains("stands"), "{alert:?}");
}

/// A wheel that is larger than its file says is so until somebody corrects the file: it hides neither pads nor a brake that drags.
#[test]
fn a_wrong_diameter_hides_neither_pads_nor_drag() {
    let named = |wrong: Wrong| {
        let watch = day_that_says(wrong, &[], |_, readings| readings[2].wheel_speed_rad_s[1] *= 0.988);
        watch.alerts().iter().map(|alert| (alert.cause, alert.wheelsets.clone())).collect::<Vec<_>>()
    };
    let diameter = (Cause::WheelDiameter, vec![1]);
    assert_eq!(named(Wrong::Nothing), vec![diameter.clone()]);
    assert_eq!(named(Wrong::Pads(0.35)), vec![diameter.clone(), (Cause::PadUneven, vec![1])]);
    assert_eq!(named(Wrong::Drags(1500.0)), vec![diameter, (Cause::Dragging, vec![1])]);
}

/// Of two speeds that differ the one is wrong with which all wheels disagree, be it of the first wagon or of the second.
#[test]
fn of_two_speeds_the_one_is_wrong_that_no_wheel_follows() {
    for wrong in [0, 1] {
        let watch = day_of(vec![file(); 2], Wrong::Nothing, &[], |_, readings| readings[wrong].v_m_s *= 1.02);
        let [alert] = watch.alerts() else { panic!("{:?}", watch.alerts()) };
        assert_eq!((alert.cause, &alert.wagons[..]), (Cause::SpeedSensor, &[wrong][..]), "{alert:?}");
    }
    assert_eq!(day_of(vec![file(); 2], Wrong::Nothing, &[], |_, _| {}).alerts(), []);
}

/// Driven wagons whose electric brake hears the order by another way than the distributor: that it comes in time says nothing
/// against pads that let go late.
#[test]
fn a_late_distributor_is_told_by_pads_though_the_electric_brake_is_in_time() {
    let mut letting_go = std::collections::VecDeque::new();
    let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
        let t = step as f64 * DT_S;
        let electric = (105.0..125.0).contains(&(t % 150.0));
        for reading in &mut *readings {
            for k in (0..4).filter(|_| electric) {
                reading.drive_torque_nm[k] = -0.35 * 0.25 * reading.pressing_force_n[k];
                reading.pressing_force_n[k] = 0.0;
            }
        }
        letting_go.push_back(readings[2].pressing_force_n);
        if letting_go.len() > (3.0 / DT_S) as usize {
            let late_n = letting_go.pop_front().expect("three seconds of them");
            if t > 450.0 {
                readings[2].pressing_force_n = late_n;
            }
        }
    });
    assert_eq!(wagons_of(&watch, Cause::LateDistributor), [[2]]);
}

/// Wheels that are worn by a few thousandths each, as their files do not say: none of them is wrong by more than wear. One that is
/// four percent smaller is.
#[test]
fn worn_wheels_are_no_wrong_diameters() {
    let named = |one: f64| {
        let watch = day_that_says(Wrong::Nothing, &[], |_, readings| {
            for (index, reading) in readings.iter_mut().enumerate() {
                for k in 0..4 {
                    let worn = 0.0055 * ((index * 4 + k) as f64 * 2.3).sin();
                    let wrong = if (index, k) == (2, 1) { one } else { 0.0 };
                    reading.wheel_speed_rad_s[k] *= 1.0 + worn + wrong;
                }
            }
        });
        watch.alerts().iter().map(|alert| (alert.cause, alert.wheelsets.clone())).collect::<Vec<_>>()
    };
    assert_eq!(named(0.0), vec![]);
    assert_eq!(named(0.04), vec![(Cause::WheelDiameter, vec![1])]);
}

/// A locomotive spins while it drives, and then brakes with its pads: what rolls again does not slide.
#[test]
fn a_wheelset_that_spun_does_not_slide_when_it_rolls_again() {
    let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
        let t = (step as f64 * DT_S) % 150.0;
        if (30.0..105.0).contains(&t) {
            readings[0].drive_torque_nm = [6000.0; 4];
            readings[0].wheel_speed_rad_s.iter_mut().for_each(|omega| *omega *= 1.8);
        }
    });
    let slides = |alert: &&Alert| matches!(alert.cause, Cause::WspValve | Cause::LowAdhesion);
    assert_eq!(watch.alerts().iter().find(slides), None);
}

/// A wagon that has no force any more is told after one application.
#[test]
fn a_wagon_without_a_brake_is_told_at_once() {
    let alerts = day(Wrong::Wagon);
    assert!(alerts[0].raised_t_s < 600.0, "{alerts:?}");
}

/// Brakes that weigh press a quarter less: so much less the wagon weighs than was entered. Where brakes do not weigh, wagons lie
/// far from one another, and nothing is said.
#[test]
fn brakes_that_weigh_tell_a_wrong_load() {
    let weighs = |shares: [f64; WAGONS]| {
        let watch = day_that_says(Wrong::Nothing, &[], |_, readings| press(readings, &shares));
        wagons_of(&watch, Cause::Payload)
    };
    assert_eq!(weighs([1.0, 0.99, 0.75, 1.02, 1.0]), vec![vec![2]]);
    assert_eq!(weighs([1.3, 0.8, 0.75, 1.1, 0.6]), Vec::<Vec<usize>>::new());
}

/// Wagons whose loads nobody knows press for what they carry: one empty one among full ones is told, several are how the train is loaded.
#[test]
fn how_a_train_is_loaded_is_no_wrong_entry() {
    let weighs = |shares: [f64; 8]| {
        let files = vec![WagonFile { mass_sigma: 0.3, ..file() }; 8];
        let watch = day_of(files, Wrong::Nothing, &[], |_, readings| press(readings, &shares));
        wagons_of(&watch, Cause::Payload)
    };
    assert_eq!(weighs([1.0, 0.98, 0.21, 1.03, 0.97, 1.0, 0.95, 1.02]), vec![vec![2]]);
    assert_eq!(weighs([1.0, 0.98, 0.21, 1.03, 0.97, 1.0, 0.23, 1.02]), Vec::<Vec<usize>>::new());
}

/// Two driven wagons brake nearly twice as hard for their mass as the others, because they brake for them: that says nothing of what
/// they weigh. A wagon that is not driven is still told beside its own kind.
#[test]
fn driven_wagons_that_brake_for_the_others_are_not_heavier() {
    let said = |shares: [f64; WAGONS]| {
        let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
            let driving = timetable(step as f64 * DT_S).0 > 0.0;
            press(readings, &shares);
            for (index, reading) in readings.iter_mut().enumerate() {
                let torque_nm = if driving && index < 2 { 4000.0 } else { 0.0 };
                reading.drive_torque_nm = [torque_nm; 4];
            }
        });
        wagons_of(&watch, Cause::Payload)
    };
    assert_eq!(said([1.9, 1.88, 1.0, 0.99, 1.01]), Vec::<Vec<usize>>::new());
    assert_eq!(said([1.0, 1.01, 1.0, 0.7, 0.99]), vec![vec![3]]);
}

/// On a steep curve the same wheelset of each wagon creeps less than the others for what a pitching body does to its load, of one wagon by
/// most. That says nothing of pads; of one wagon alone it does.
#[test]
fn what_the_same_wheelset_of_each_wagon_does_is_not_its_pads() {
    let uneven = |others: f64| {
        let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
            if step as f64 * DT_S < 450.0 {
                return;
            }
            for (index, reading) in readings.iter_mut().enumerate() {
                let less = if index == 2 { 0.5 } else { others };
                let pads_n = 0.35 * reading.pressing_force_n[1] * 0.25 / RADIUS_M;
                reading.wheel_speed_rad_s[1] += less * pads_n * COMPLIANCE_PER_N * reading.v_m_s / RADIUS_M;
            }
        });
        named(watch.alerts()).into_iter().filter(|it| it.0 == Cause::PadUneven).collect::<Vec<_>>()
    };
    assert_eq!(uneven(0.28), []);
    assert_eq!(uneven(0.0), [(Cause::PadUneven, vec![2], vec![1])]);
}

/// Most wagons brake electrically until shortly before they stand, the others with their pads, and nobody tells the order: pads that
/// press meanwhile do not drag.
#[test]
fn pads_beside_an_electric_brake_do_not_drag_where_no_order_is_known() {
    let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
        let electric = (step as f64 * DT_S) % 150.0 < 128.0;
        for (index, reading) in readings.iter_mut().enumerate() {
            reading.brake_demand = f64::NAN;
            for k in (0..4).filter(|_| index < 3 && electric) {
                reading.drive_torque_nm[k] = -0.35 * 0.25 * reading.pressing_force_n[k];
                reading.pressing_force_n[k] = 0.0;
            }
        }
    });
    assert_eq!(wagons_of(&watch, Cause::Dragging), Vec::<Vec<usize>>::new());
}

/// From the fourth stop on two motor cars brake electrically for the whole train at most stops, until shortly before it stands: the pads
/// of the others owe nothing meanwhile, and one wagon that has no brake then is told when the others press.
#[test]
fn pads_owe_nothing_while_others_brake_electrically_for_them() {
    let isolated = |wrong: Wrong| {
        let watch = day_that_says(wrong, &[], |step, readings| {
            let t = step as f64 * DT_S;
            let (stop, t_s) = ((t / 150.0) as usize, t % 150.0);
            let electric = stop > 1 && stop % 3 != 2 && (105.0..133.0).contains(&t_s);
            for (index, reading) in readings.iter_mut().enumerate().filter(|_| electric) {
                let motor_car = index < 2;
                reading.drive_torque_nm =
                    if motor_car { [-2.5 * 0.35 * 0.25 * 0.6 * FULL_N; 4] } else { [0.0; 4] };
                reading.pressing_force_n = [0.0; 4];
            }
        });
        wagons_of(&watch, Cause::Isolated)
    };
    assert_eq!(isolated(Wrong::Nothing), Vec::<Vec<usize>>::new());
    assert_eq!(isolated(Wrong::Wagon), vec![vec![2]]);
}

/// A transducer without clipping that reads a tenth too little shows less than none when the brake is released: it is named, and not
/// the three that show none.
#[test]
fn a_transducer_that_shows_less_than_none_is_named() {
    let watch = day_that_says(Wrong::Nothing, &[], |step, readings| {
        if step as f64 * DT_S > 450.0 {
            readings[2].pressing_force_n[1] -= 0.1 * FULL_N;
        }
    });
    let [alert] = watch.alerts() else { panic!("{:?}", watch.alerts()) };
    assert_eq!(
        (alert.cause, &alert.wagons[..], &alert.wheelsets[..]),
        (Cause::PressureSensor, &[2][..], &[1][..])
    );
}

/// Successors in a roll, in an application and while the brakes are applied: one application at most goes unseen for each.
#[test]
fn what_was_learnt_outlives_the_watch() {
    let successions_s = [500.0, 561.0, 1020.0, 1330.0];
    for (wrong, cause) in [(Wrong::Pads(0.35), Cause::PadUneven), (Wrong::Drags(1500.0), Cause::Dragging)] {
        let watch = day_with(wrong, &successions_s);
        let [alert] = watch.alerts() else { panic!("{:?}", watch.alerts()) };
        assert_eq!((alert.cause, &alert.wagons[..], &alert.wheelsets[..]), (cause, &[2][..], &[1][..]));
        let without = day_with(wrong, &[]);
        println!(
            "{cause:?}: raised at {:.0} s, {:.0} s without successors; {} applications seen, {} without",
            alert.raised_t_s,
            without.alerts()[0].raised_t_s,
            watch.brakings(),
            without.brakings()
        );
        assert!(watch.brakings() + 4 >= without.brakings());
    }
    assert_eq!(day_with(Wrong::Nothing, &successions_s).alerts(), []);
}

#[test]
fn what_was_learnt_of_other_wagons_is_not_taken() {
    let watch = day_with(Wrong::Nothing, &[]);
    let files = vec![file(); WAGONS];
    assert!(successor(&watch, &files).is_some());
    assert!(successor(&watch, &files[1..]).is_none());
    let mut heavier = files;
    heavier[3].mass_kg *= 1.5;
    assert!(successor(&watch, &heavier).is_none());
}

/// From the first second on, single values that no train shows: they are counted, and what is learnt stays what it was.
#[test]
fn values_that_cannot_be_are_unknown_and_counted() {
    const HOSTILE: [f64; 6] = [f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 4.5e15, -3e9];
    let mut said = 0_u64;
    let watch = day_that_says(Wrong::Drags(1500.0), &[], |step, readings| {
        if step % 37 != 0 {
            return;
        }
        let turn = step / 37;
        let reading = &mut readings[turn % WAGONS];
        let value = HOSTILE[turn % HOSTILE.len()];
        match turn % 7 {
            0 => reading.v_m_s = value,
            1 => reading.wheel_speed_rad_s[turn % 4] = value,
            2 => reading.pressing_force_n[turn % 4] = value,
            3 => reading.drive_torque_nm[turn % 4] = value,
            4 => reading.grade_rad = value,
            5 => reading.load_kg = value,
            _ => reading.brake_demand = value,
        }
        said += 1;
    });
    assert_eq!(watch.doubted(), said);
    assert!(said > 2000, "{said}");
    let [alert] = watch.alerts() else { panic!("{:?}", watch.alerts()) };
    assert_eq!((alert.cause, &alert.wagons[..], &alert.wheelsets[..]), (Cause::Dragging, &[2][..], &[1][..]));
    assert!((0.0..=1.0).contains(&alert.probability) && !alert.reason.contains("NaN"), "{alert:?}");
    assert!(successor(&watch, &vec![file(); WAGONS]).is_some(), "what was learnt are numbers");
}
