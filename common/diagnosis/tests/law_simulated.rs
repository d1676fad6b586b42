//! The diagnosis of simulated benches: does it name the effect, stay silent without one, and know its own errors?

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod law_cases;

use law_cases::{CreepTruth, LAYOUTS, PLAIN, Simulated, brake, creep};
use railgrip_diagnosis::answer::schema::Verdict;
use railgrip_diagnosis::law_bench::{Options, Outcome, diagnose};

fn run(case: &Simulated, without: &[&str]) -> Outcome {
    let folder = tempfile::tempdir().unwrap();
    case.write(folder.path());
    let without = without.iter().map(|id| (*id).to_owned()).collect();
    diagnose(folder.path(), &Options { without, seed: 1, ..Options::default() }).unwrap()
}

/// Name, id and truth of an effect of a brake bench.
type BrakeLaw = (&'static str, &'static str, fn(f64, f64, f64) -> f64);

const BRAKE_LAWS: [BrakeLaw; 11] = [
    ("Stribeck", "brake_friction_speed", |v, _, _| 1.0 + 0.3 * (-v / 5.0).exp()),
    ("Karwatzki", "brake_friction_speed", |v, _, _| (3.6 * v + 100.0) / (5.0 * 3.6 * v + 100.0) * 1.5),
    ("log of speed", "brake_friction_speed", |v, _, _| 1.1 - 0.06 * (1.0 + v).ln()),
    ("arctangent of speed", "brake_friction_speed", |v, _, _| 1.1 - 0.15 * (v / 8.0).atan()),
    ("linear fade", "brake_fade", |_, t, _| 1.0 - 8e-4 * (t - 100.0)),
    ("sigmoid fade", "brake_fade", |_, t, _| 1.0 - 0.35 / (1.0 + (-(t - 260.0) / 25.0).exp())),
    ("quadratic fade", "brake_fade", |_, t, _| 1.0 - 3e-6 * (t - 20.0).powi(2)),
    ("exponential fade", "brake_fade", |_, t, _| 0.6 + 0.5 * (-t / 150.0).exp()),
    ("power of force", "brake_friction_pressure", |_, _, f| (f / 12e3).powf(-0.15)),
    ("Karwatzki's force", "brake_friction_pressure", |_, _, f| {
        let p = f / 1e3;
        2.4 * (1.6 * p + 10.0) / (8.0 * p + 10.0)
    }),
    ("log of force", "brake_friction_pressure", |_, _, f| 1.0 - 0.12 * (f / 12e3).ln()),
];

/// Name, id and truth of an effect of a creep bench.
type CreepLaw = (&'static str, &'static str, CreepTruth<'static>);

fn creep_laws() -> Vec<CreepLaw> {
    vec![
        (
            "Polach's fall",
            "falling_friction",
            CreepTruth { level: &|w, _, _| 0.4 + 0.6 * (-0.6 * w).exp(), ..PLAIN },
        ),
        (
            "hyperbolic fall",
            "falling_friction",
            CreepTruth { level: &|w, _, _| 1.0 / (1.0 + 0.25 * w), ..PLAIN },
        ),
        (
            "log fall",
            "falling_friction",
            CreepTruth { level: &|w, _, _| 1.0 - 0.15 * (1.0 + 3.0 * w).ln(), ..PLAIN },
        ),
        (
            "Curtius-Kniffler",
            "adhesion_speed",
            CreepTruth { level: &|_, v, _| (7.5 / (3.6 * v + 44.0) + 0.161) / 0.3315, ..PLAIN },
        ),
        ("root of speed", "adhesion_speed", CreepTruth { level: &|_, v, _| 1.05 - 0.06 * v.sqrt(), ..PLAIN }),
        ("linear in speed", "adhesion_speed", CreepTruth { level: &|_, v, _| 1.0 - 0.012 * v, ..PLAIN }),
        (
            "log of load",
            "adhesion_load",
            CreepTruth { level: &|_, _, q| 1.0 - 0.15 * (q / 9e3).ln(), ..PLAIN },
        ),
        (
            "Hertz stiffness",
            "creep_stiffness_load",
            CreepTruth { stiffness: &|q| (q / 9e3).powf(2.0 / 3.0), ..PLAIN },
        ),
        ("wet shape", "creep_shape", CreepTruth { shape: (0.4, 0.12), ..PLAIN }),
    ]
}

fn named(outcome: &Outcome) -> Vec<&str> {
    outcome.report.effects.iter().map(|effect| effect.id.as_str()).collect()
}

/// Every effect in every layout: 33 brake and 27 creep cases.
fn all_cases() -> Vec<(String, &'static str, Simulated)> {
    let mut cases = Vec::new();
    for (index, (name, id, law)) in BRAKE_LAWS.iter().enumerate() {
        for (l, layout) in LAYOUTS.into_iter().enumerate() {
            let seed = 100 + 10 * index as u64 + l as u64;
            cases.push((format!("{name}, {layout:?}"), *id, brake(seed, layout, 0.010, l != 1, law)));
        }
    }
    for (index, (name, id, truth)) in creep_laws().into_iter().enumerate() {
        for (l, layout) in LAYOUTS.into_iter().enumerate() {
            let seed = 500 + 10 * index as u64 + l as u64;
            cases.push((format!("{name}, {layout:?}"), id, creep(seed, layout, 0.02, l != 1, truth)));
        }
    }
    cases
}

#[test]
fn names_the_effect_whatever_its_form() {
    let (mut top, mut within, mut total) = (0, 0, 0);
    let mut closures = Vec::new();
    let (mut sure, mut sure_right) = (0, 0);
    for (name, id, case) in all_cases() {
        let outcome = run(&case, &[]);
        let report = &outcome.report;
        let right = named(&outcome) == [id];
        let near = report.effects.len() == 1
            && (right || report.effects[0].equivalent.iter().any(|other| other == id));
        total += 1;
        top += usize::from(right);
        within += usize::from(near);
        let gap = &report.gap.holdout;
        let closure = (gap.calibrated - gap.extended) / (gap.calibrated - 1.0).max(0.05);
        closures.push(closure);
        for effect in &report.effects {
            if effect.confidence >= 0.9 {
                sure += 1;
                sure_right += usize::from(effect.id == id);
            }
        }
        let confidence = report.effects.first().map_or(0.0, |effect| effect.confidence);
        let equivalent = report.effects.first().map(|e| e.equivalent.clone()).unwrap_or_default();
        println!(
            "{} {name:32} {id:24} -> {:15} {:?} eq {equivalent:?} conf {confidence:.2} gap {:.2} -> {:.2} ({:.2}s) {}",
            if right {
                "  "
            } else if near {
                "~ "
            } else {
                "XX"
            },
            report.verdict.name(),
            named(&outcome),
            gap.calibrated,
            gap.extended,
            report.seconds,
            outcome.detail.candidates.first().map_or("", |c| c.form.as_str()),
        );
    }
    closures.sort_by(f64::total_cmp);
    println!(
        "top-1 {top}/{total}, within equivalents {within}/{total}, closure median {:.2}, lower decile {:.2}, sure {sure_right}/{sure}",
        closures[closures.len() / 2],
        closures[closures.len() / 10]
    );
    assert!(top * 10 >= total * 9, "top-1 {top}/{total}");
    assert!(within * 20 >= total * 19, "within {within}/{total}");
    assert!(sure_right * 10 >= sure * 9);
}

#[test]
fn stays_silent_without_an_effect() {
    let mut alarms = 0;
    let mut total = 0;
    for seed in 0..18 {
        for layout in LAYOUTS {
            let cases = [
                brake(10_000 + seed, layout, 0.01, seed % 3 != 0, &|_, _, _| 1.0),
                creep(20_000 + seed, layout, 0.02, seed % 3 != 0, PLAIN),
            ];
            for case in cases {
                let outcome = run(&case, &[]);
                total += 1;
                if outcome.report.verdict != Verdict::None {
                    alarms += 1;
                    println!(
                        "false alarm, seed {seed} {layout:?}: {} {:?}",
                        outcome.report.verdict.name(),
                        named(&outcome)
                    );
                }
            }
        }
    }
    println!("false alarms {alarms}/{total}");
    assert!(alarms * 100 <= total * 8, "{alarms}/{total}");
}

/// Without the true id in the library, and with effects that no id names.
#[test]
fn calls_the_unknown_unknown() {
    let (mut called, mut total) = (0, 0);
    let mut check = |name: String, case: &Simulated, without: &[&str]| {
        let outcome = run(case, without);
        let report = &outcome.report;
        let unknown = matches!(report.verdict, Verdict::Unknown | Verdict::EffectsAndUnknown);
        total += 1;
        called += usize::from(unknown);
        println!(
            "{} {name:40} {:15} {:?} regime {:?} candidates {:?}",
            if unknown { "  " } else { "XX" },
            report.verdict.name(),
            named(&outcome),
            report.location.regime.as_ref().map(|r| &r.variable),
            report.candidates.iter().take(2).map(|c| (&c.id, c.cv_gain, c.p_value)).collect::<Vec<_>>()
        );
        if unknown {
            assert!(report.location.term.is_some());
            let rest = report.unexplained.as_ref().unwrap();
            assert!(!rest.curve.is_empty());
        }
    };
    for (name, id, case) in all_cases().into_iter().skip(1).step_by(3) {
        check(format!("{name} without {id}"), &case, &[id]);
    }
    for (l, layout) in LAYOUTS.into_iter().enumerate() {
        let seed = 900 + l as u64;
        let joint =
            brake(seed, layout, 0.01, true, &|v, t, _| 1.0 - 0.25 * (v - 20.0) / 20.0 * (t - 180.0) / 150.0);
        check(format!("speed times temperature, {layout:?}"), &joint, &[]);
        let offset =
            CreepTruth { level: &|w, _, _| 1.0 - 0.3 * (-((w - 0.6) / 0.25).powi(2)).exp(), ..PLAIN };
        check(format!("a dip over slip velocity, {layout:?}"), &creep(seed, layout, 0.02, true, offset), &[]);
    }
    println!("unknown called unknown {called}/{total}");
    assert!(called * 100 >= total * 80, "{called}/{total}");
}

#[test]
fn names_both_of_a_pair() {
    let (mut both, mut total) = (0, 0);
    for (l, layout) in LAYOUTS.into_iter().enumerate() {
        for k in 0..2 {
            let seed = 700 + 10 * l as u64 + k;
            let fade = 4e-4 + 2e-4 * k as f64;
            let truth =
                move |v: f64, t: f64, _: f64| (1.0 + 0.3 * (-v / 8.0).exp()) * (1.0 - fade * (t - 100.0));
            let force =
                move |v: f64, _: f64, f: f64| (1.1 - 0.2 * (v / 8.0).atan()) * (1.0 - 0.12 * (f / 12e3).ln());
            let fall = CreepTruth { level: &|w, v, _| (0.5 + 0.5 / (1.0 + w)) * (1.0 - 0.012 * v), ..PLAIN };
            let mut check = |case: &Simulated, ids: [&str; 2]| {
                let outcome = run(case, &[]);
                let found = named(&outcome);
                let good = found.len() == 2 && ids.iter().all(|id| found.contains(id));
                both += usize::from(good);
                total += 1;
                println!(
                    "{} {layout:?} {ids:?} -> {} {found:?} conf {:?} gap {:.2} -> {:.2}",
                    if good { "  " } else { "XX" },
                    outcome.report.verdict.name(),
                    outcome.report.effects.iter().map(|e| (e.confidence, &e.equivalent)).collect::<Vec<_>>(),
                    outcome.report.gap.holdout.calibrated,
                    outcome.report.gap.holdout.extended
                );
            };
            check(&brake(seed, layout, 0.008, true, &truth), ["brake_friction_speed", "brake_fade"]);
            check(
                &brake(seed, layout, 0.008, true, &force),
                ["brake_friction_speed", "brake_friction_pressure"],
            );
            check(&creep(seed, layout, 0.015, true, fall), ["falling_friction", "adhesion_speed"]);
        }
    }
    println!("pairs {both}/{total}");
    assert!(both * 10 >= total * 7, "{both}/{total}");
}

#[test]
fn intervals_hold_the_truth_where_forms_agree() {
    let (mut held, mut total) = (0_u32, 0_u32);
    let mut check = |outcome: &Outcome, id: &str, wanted: &[(&str, f64)]| {
        let Some(effect) = outcome.report.effects.iter().find(|effect| effect.id == id) else { return };
        for (name, truth) in wanted {
            let Some(estimate) = effect.parameters.get(*name) else { continue };
            total += 1;
            held += u32::from((estimate.ci95[0]..=estimate.ci95[1]).contains(truth));
        }
    };
    for seed in 0..7 {
        for layout in LAYOUTS {
            let fade = brake(3000 + seed, layout, 0.01, seed % 2 == 0, &|_, t, _| 1.0 - 9e-4 * (t - 20.0));
            check(&run(&fade, &[]), "brake_fade", &[("alpha_per_k", 9e-4)]);
            let speed = brake(3100 + seed, layout, 0.01, true, &|v, _, _| 0.7 + 0.3 * (-0.2 * v).exp());
            let names = [("rise", 3.0 / 7.0), ("decay_speed_m_s", 5.0)];
            check(&run(&speed, &[]), "brake_friction_speed", &names);
            let force = brake(3200 + seed, layout, 0.01, true, &|_, _, f| (f / 12e3).powf(-0.12));
            check(&run(&force, &[]), "brake_friction_pressure", &[("exponent", 0.12)]);
            let fall = CreepTruth { level: &|w, _, _| 0.4 + 0.6 * (-0.6 * w).exp(), ..PLAIN };
            let names = [("friction_ratio", 0.4), ("friction_decay_s_per_m", 0.6)];
            check(&run(&creep(3300 + seed, layout, 0.02, true, fall), &[]), "falling_friction", &names);
        }
    }
    let share = f64::from(held) / f64::from(total);
    println!("95 % intervals hold the truth in {held}/{total} = {share:.3}");
    assert!((0.88..=0.995).contains(&share), "{share}");
}

/// Slow wander of the level by 0.6 % is a nuisance of every brake, never an effect.
#[test]
fn slow_wander_is_no_effect() {
    let (mut alarms, mut total) = (0, 0);
    for seed in 0..10 {
        for layout in LAYOUTS {
            let mut case = brake(40_000 + seed, layout, 0.01, true, &|_, _, _| 1.0);
            case.wander(seed, 0.006);
            let outcome = run(&case, &[]);
            total += 1;
            alarms += usize::from(outcome.report.verdict != Verdict::None);
        }
    }
    println!("false alarms under wander {alarms}/{total}");
    assert!(alarms * 10 <= total, "{alarms}/{total}");
}

/// Effects at the edge of what the noise lets through: what is said surely must be right.
#[test]
fn confidence_means_what_it_says() {
    let mut said: Vec<(f64, bool)> = Vec::new();
    for seed in 0..10_u64 {
        for layout in LAYOUTS {
            let k = 0.05 + 0.025 * seed as f64;
            let cases = [
                (
                    "brake_friction_speed",
                    brake(50_000 + seed, layout, 0.012, true, &|v, _, _| 1.0 + k * 0.3 * (-v / 8.0).exp()),
                ),
                (
                    "brake_fade",
                    brake(51_000 + seed, layout, 0.012, true, &|_, t, _| 1.0 - k * 8e-4 * (t - 60.0)),
                ),
                (
                    "brake_friction_pressure",
                    brake(52_000 + seed, layout, 0.012, true, &|_, _, f| (f / 12e3).powf(-0.15 * k)),
                ),
            ];
            for (id, case) in cases {
                let effects = run(&case, &[]).report.effects;
                said.extend(effects.iter().map(|effect| (effect.confidence, effect.id == id)));
            }
        }
    }
    for (low, high) in [(0.0, 0.5), (0.5, 0.9), (0.9, 1.0)] {
        let group: Vec<_> = said.iter().filter(|(c, _)| (low..high).contains(c)).collect();
        let right = group.iter().filter(|(_, right)| *right).count();
        println!("confidence {low} to {high}: right {right}/{}", group.len());
        assert!(high < 1.0 || right * 10 >= group.len() * 9);
    }
}
