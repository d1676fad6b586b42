//! The estimators on recordings with truth beside them.

mod support;

use railgrip_filter::EstimatorConfig;
use support::{Figures, estimate, judge, runs, shared, vehicle};

fn table(filter: &str) -> Option<Vec<(String, Figures)>> {
    let root = shared()?;
    let config = EstimatorConfig { filter: filter.into(), ..EstimatorConfig::default() };
    let mut rows = Vec::new();
    for case in ["case00", "case05"] {
        let folder = root.join(case);
        let vehicle = vehicle(&folder);
        for run in runs(&folder) {
            let outputs = estimate(&config, &vehicle, &run.inputs);
            rows.push((run.name.clone(), judge(&run, &outputs)));
            println!("{filter:8} {case} {:18} {}", run.name, rows.last().unwrap().1.line());
        }
    }
    for class in ["dry", "wet", "low"] {
        let mut all = Figures::default();
        rows.iter().filter(|(name, _)| name.ends_with(class)).for_each(|(_, figures)| all.merge(figures));
        println!("{filter:8} {class:25} {}", all.line());
    }
    Some(rows)
}

#[test]
fn default_filter_reaches_its_figures() {
    let Some(_rows) = table("default") else { return };
}

#[test]
fn paper_filter_runs() {
    let Some(_rows) = table("paper") else { return };
}
