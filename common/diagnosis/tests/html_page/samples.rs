//! A report of a wagon and what its page shows beside, made by hand.

use railgrip_diagnosis::answer::schema::*;
use railgrip_diagnosis::answer::supplement::{
    Alarm, Axis, CandidateDetail, Curve, CurvePoint, Detail, Event, FreedPlace, HeatGroup, HeatMap,
    ParameterRow, RunRow, Settings, Tie, Trace, TraceWindow,
};
use std::collections::BTreeMap;

pub fn wagon_report() -> Report {
    let signal = |name: &str, gap, share| SignalShare { name: name.to_owned(), gap, share };
    let candidate = |id: &str, fit_gap, cv_gain, p_value, converged| Candidate {
        id: id.to_owned(),
        fit_gap,
        cv_gain,
        p_value,
        converged,
    };
    Report {
        schema: SCHEMA.to_owned(),
        verdict: Verdict::Effects,
        rule: "effects_explain_gap".to_owned(),
        location: Location {
            term: Some("brake_friction".to_owned()),
            signals: vec![
                signal("v_m_s", 6.1, 0.21),
                signal("omega_f_rad_s", 10.2, 0.42),
                signal("omega_r_rad_s", 9.7, 0.37),
            ],
            regime: Some(Regime {
                variable: "temperature".to_owned(),
                range: [140.0, 300.0],
                gap_inside: 12.4,
                gap_outside: 2.9,
            }),
            runs: vec![RunGap { name: "dry_stop.dry".to_owned(), gap: 11.9 }],
        },
        effects: vec![FoundEffect {
            id: "brake_fade".to_owned(),
            term: "brake_friction".to_owned(),
            confidence: 0.94,
            p: None,
            score: None,
            gap_grows_without: None,
            rivals: Vec::new(),
            equivalent: vec!["brake_friction_speed".to_owned()],
            parameters: BTreeMap::from([(
                "alpha_per_k".to_owned(),
                ParameterEstimate::new(8.1e-4, [7.2e-4, 9.0e-4]),
            )]),
        }],
        posterior: Vec::new(),
        verdict_set: Vec::new(),
        carries_over: Some(true),
        candidates: vec![
            candidate("brake_fade", 2.1, 0.83, 0.0017, true),
            candidate("brake_friction_speed", 2.6, 0.74, 0.0017, true),
            candidate("brake_lag", 8.3, 0.06, 0.31, true),
            candidate("wheel_encoder_eccentricity", 9.3, -0.02, 1.0, false),
        ],
        gap: Gap {
            fit: ThreeGaps { nominal: 21.4, calibrated: 9.36, extended: 2.11 },
            holdout: HoldoutGap {
                nominal: 19.0,
                calibrated: 8.34,
                extended: 3.31,
                reduction: 0.603,
                reduction_ci95: [0.55, 0.66],
                by_signal: BTreeMap::from([
                    ("v_m_s".to_owned(), SignalGap { calibrated: 5.3, extended: 2.2 }),
                    ("omega_f_rad_s".to_owned(), SignalGap { calibrated: 9.9, extended: 3.8 }),
                    ("omega_r_rad_s".to_owned(), SignalGap { calibrated: 9.2, extended: 3.6 }),
                ]),
                worst_window: None,
            },
            natural: None,
        },
        unexplained: None,
        evidence: None,
        next_run: Some(
            "To tell brake_fade from brake_friction_speed: two stops from the same speed in quick succession, and one after a long cool-down."
                .to_owned(),
        ),
        seconds: 41.7,
        notes: Vec::new(),
    }
}

pub fn wagon_detail() -> Detail {
    let time: Vec<f64> = (0..1000).map(|i| 20.0 + 0.01 * f64::from(i)).collect();
    let trace = |name: &str, unit: &str, scale: f64, sigma: f64, lag: f64| {
        let wave = |t: f64, k: f64| scale * (24.0 - 0.93 * (t - 20.0) + k * (t - 20.0).powi(2));
        let noisy = |i: usize, t: &f64| wave(*t, 0.0) + sigma * ((i * 7919 % 97) as f64 / 48.5 - 1.0) * 1.6;
        Trace {
            name: name.to_owned(),
            unit: unit.to_owned(),
            sigma,
            measured: time.iter().enumerate().map(|(i, t)| noisy(i, t)).collect(),
            nominal: time.iter().map(|t| wave(*t, -0.011 * lag)).collect(),
            calibrated: time.iter().map(|t| wave(*t, -0.006 * lag)).collect(),
            extended: time.iter().map(|t| wave(*t, -0.0012 * lag)).collect(),
        }
    };
    let curve = |x: f64| 0.36 * (1.0 - 8.1e-4 * (x - 20.0));
    Detail {
        case: "case00".to_owned(),
        subject: "wagon \"coach\", 52.3 t, 2 wheelsets".to_owned(),
        rule: "The effects explain more than chance, and nothing that they leave asks for another cause.".to_owned(),
        notes: Vec::new(),
        runs: vec![
            RunRow {
                name: "dry_stop.dry".to_owned(),
                holdout: false,
                samples: 4200,
                duration_s: Some(42.0),
                nominal: 30.0,
                calibrated: 11.9,
                extended: 2.3,
            },
            RunRow {
                name: "wet_stop.wet".to_owned(),
                holdout: true,
                samples: 5100,
                duration_s: Some(51.0),
                nominal: 19.0,
                calibrated: 8.3,
                extended: 3.3,
            },
        ],
        heat_map: HeatMap {
            signals: ["v_m_s", "omega_f_rad_s", "omega_r_rad_s"].map(str::to_owned).to_vec(),
            groups: vec![
                HeatGroup {
                    variable: "temperature".to_owned(),
                    unit: "°C".to_owned(),
                    edges: vec![20.0, 40.0, 80.0, 140.0, 220.0, 300.0],
                    samples: vec![4000, 3000, 2500, 1800, 900],
                    calibrated: vec![
                        vec![2.1, 2.4, 3.9, 8.2, 12.3],
                        vec![2.3, 3.1, 6.0, 11.8, 17.4],
                        vec![2.2, 3.0, 5.8, 11.1, f64::NAN],
                    ],
                    extended: vec![vec![1.8; 5], vec![2.0; 5], vec![2.1; 5]],
                },
                HeatGroup {
                    variable: "speed".to_owned(),
                    unit: "m/s".to_owned(),
                    edges: vec![0.0, 5.0, 10.0, 20.0, 33.0],
                    samples: vec![2000, 2400, 3000, 3100],
                    calibrated: vec![
                        vec![9.0, 8.1, 6.2, 2.0],
                        vec![13.0, 11.0, 8.0, 2.6],
                        vec![12.2, 10.3, 7.7, 2.5],
                    ],
                    extended: vec![vec![2.1; 4], vec![2.4; 4], vec![2.3; 4]],
                },
            ],
        },
        freed: vec![FreedPlace {
            place: "share of pad friction".to_owned(),
            terms: vec!["brake_friction".to_owned()],
            before: 812.0,
            after: Some(14.0),
            size: 0.09,
            unit: String::new(),
            time_s: 10.0,
        }],
        events: vec![Event {
            run: "wet_stop.wet".to_owned(),
            holdout: true,
            wheelset: 0,
            from_s: 24.1,
            to_s: 25.6,
            words: "front wheelset locks".to_owned(),
            severity: 1.0,
        }],
        worst_window: Some(TraceWindow {
            run: "wet_stop.wet".to_owned(),
            window: 2,
            holdout: true,
            t_s: time.clone(),
            traces: vec![
                trace("v_m_s", "m/s", 1.0, 0.05, 1.0),
                trace("omega_f_rad_s", "rad/s", 2.17, 0.08, 1.0),
                trace("omega_r_rad_s", "rad/s", 2.18, 0.08, 0.9),
            ],
        }),
        scatters: Vec::new(),
        effect_curves: vec![Curve {
            title: "brake_fade".to_owned(),
            equation: "mu = mu0 (1 - alpha (T - T0)), C dT/dt = P_brake - (T - T0) C / tau".to_owned(),
            x: Axis { label: "disc temperature".to_owned(), unit: "°C".to_owned() },
            y: Axis { label: "pad friction".to_owned(), unit: String::new() },
            points: (0..60)
                .map(|i| 20.0 + 5.0 * f64::from(i))
                .map(|x| CurvePoint {
                    x,
                    y: curve(x),
                    low: curve(x) - 0.004 - 2e-5 * x,
                    high: curve(x) + 0.004 + 2e-5 * x,
                })
                .collect(),
            reference: vec![[20.0, 0.322], [315.0, 0.322]],
            data: (0..14)
                .map(|i| 30.0 + 20.0 * f64::from(i))
                .map(|x| [x, curve(x) + 0.003 * (x / 17.0).sin()])
                .collect(),
            region: None,
        }],
        missing_curve: None,
        parameters: vec![ParameterRow {
            owner: "brake_fade".to_owned(),
            name: "alpha_per_k".to_owned(),
            nominal: None,
            value: 8.1e-4,
            ci95: [7.2e-4, 9.0e-4],
            bounds: [-3e-3, 3e-3],
        }],
        candidates: vec![CandidateDetail {
            id: "brake_fade".to_owned(),
            cv_gain_interval: Some([0.76, 0.9]),
            form: String::new(),
            on_bound: Vec::new(),
        }],
        gap_without_any: Some(9.28),
        ties: vec![Tie {
            ids: vec!["brake_fade".to_owned(), "brake_friction_speed".to_owned()],
            because: "they predict the recordings equally well; separated by two stops from the same speed in quick succession, and one after a long cool-down".to_owned(),
        }],
        alarm: Some(Alarm {
            statistic: "log-likelihood of whitened innovations gained by the best candidate, where it is small without the few stretches that gain most".to_owned(),
            how: "the errors that the final model leaves got random signs, stretch by stretch, and every candidate was fitted to them in linear form".to_owned(),
            level: 0.05,
            threshold: 14.2,
            observed: 412.0,
            replicates: 400,
        }),
        settings: Settings {
            version: "railgrip 0.1.0".to_owned(),
            command: "railgrip gap diagnose case00 --html report.html".to_owned(),
            seed: 7,
            without: Vec::new(),
            more: Vec::new(),
        },
    }
}
