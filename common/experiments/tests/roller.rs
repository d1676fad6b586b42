//! The roller rig's experiments meet the paper's criteria.
#![allow(clippy::unwrap_used)] // helpers of tests, too

fn run(name: &str) {
    let directory = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let start = std::time::Instant::now();
    let report = railgrip_experiments::find(name).unwrap().run_into(&directory).unwrap();
    println!("{}\n{:.1} s", report.markdown(name), start.elapsed().as_secs_f64());
    assert!(report.all_met());
}

#[test]
fn adhesion_is_followed_through_slide_protection() {
    run("schwarz-wsp");
}

#[test]
fn adhesion_is_followed_while_sanding() {
    run("schwarz-sanding");
}

#[test]
fn wheel_speed_must_be_trusted_where_the_branch_reverses() {
    run("schwarz-noise");
}
