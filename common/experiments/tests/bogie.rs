//! The bogie rig's experiments.
#![allow(clippy::unwrap_used)]

fn run(name: &str) -> railgrip_experiments::Report {
    let directory = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let start = std::time::Instant::now();
    let report = railgrip_experiments::find(name).unwrap().run_into(&directory).unwrap();
    println!("{}\n{:.1} s", report.markdown(name), start.elapsed().as_secs_f64());
    report
}

#[test]
fn stops_are_the_papers() {
    assert!(run("shrestha-stopping").all_met());
}

#[test]
fn probe() {
    use railgrip_experiments::bogie::{controller::Control, run::*};
    use railgrip_vehicle::bogie_rig::*;
    for (v, control, rail) in [(4.14, Control::Proposed, RailCondition::Dry), (4.14, Control::CONVENTIONAL, RailCondition::Dry), (1.38, Control::Proposed, RailCondition::Dry), (1.38, Control::Proposed, RailCondition::Wet), (4.14, Control::Proposed, RailCondition::Wet)] {
        let setup = Setup { parameters: BogieParameters::default(), v_m_s: v, rail: Rail::Steady(rail), control, preset_torque_nm: 81.0, brake_from_s: 2.0, control_lag_s: 0.25, hold_s: f64::INFINITY, accuracy: 1.0, roughness: 1.0, end_s: 20.0, seed: 5 };
        let start = std::time::Instant::now();
        let run = simulate(&setup);
        let time = start.elapsed().as_secs_f64();
        let late: Vec<_> = run.iter().filter(|i| i.sample.time_s > 8.0).collect();
        let n = late.len() as f64;
        let mean = |f: &dyn Fn(&Instant) -> f64| late.iter().map(|i| f(i)).sum::<f64>() / n;
        println!("{v} {control:?} {rail:?}: {time:.2} s; slip {:.4} sd {:.4}, est err mean {:.4} rms {:.4} sigma {:.4}; mu {:.4} rms err {:.5} sigma {:.5}; opt {:?}; nis/dof {:.3}; v err {:.5} {:.5}; bT {:.3} bF {:.2}",
            mean(&|i| i.slip[0]), mean(&|i| i.slip[0].powi(2)).sqrt(), mean(&|i| -i.estimate.creepage[0] - i.slip[0]), mean(&|i| (-i.estimate.creepage[0] - i.slip[0]).powi(2)).sqrt(), mean(&|i| i.estimate.creepage_sigma[0]),
            mean(&|i| i.adhesion(&setup.parameters)), mean(&|i| (i.adhesion(&setup.parameters) + i.estimate.mu_w).powi(2)).sqrt(), mean(&|i| i.estimate.mu_w_sigma), late[100].decision.optimum,
            late.iter().map(|i| i.estimate.nis).sum::<f64>() / late.iter().map(|i| f64::from(i.estimate.nis_dof)).sum::<f64>(), mean(&|i| (i.estimate.v_m_s - i.v_m_s).powi(2)).sqrt(), mean(&|i| i.estimate.v_sigma_m_s), late[100].estimate.torque_offset_nm, late[100].estimate.load_cell_offset_n);
        for o in 0..5 { let k: Vec<_> = late.iter().filter(|i| i.estimate.innovation_variance[o] > 0.0).collect(); print!(" nis{o} {:.3}", k.iter().map(|i| i.estimate.innovation[o].powi(2) / i.estimate.innovation_variance[o]).sum::<f64>() / k.len() as f64); }
        println!(" states {:?}", late.iter().map(|i| i.estimate.state).collect::<std::collections::HashSet<_>>());
    }
}
