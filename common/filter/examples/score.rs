#[path = "../tests/support/mod.rs"]
mod support;
use support::*;
// usage: score FILTER key=value ... (toml overrides), prints class totals; -v prints runs
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let root = shared().unwrap();
    let verbose = a.iter().any(|x| x == "-v");
    let mut sets: Vec<String> = vec![String::new()];
    for x in a[2..].iter().filter(|x| x.contains('=')) {
        let (k, v) = x.split_once('=').unwrap();
        let mut n = Vec::new();
        for s in &sets {
            for one in v.split(',') {
                n.push(format!("{s}{k} = {one}\n"));
            }
        }
        sets = n;
    }
    for s in sets {
        let config: railgrip_filter::EstimatorConfig =
            toml::from_str(&format!("filter = \"{}\"\n{s}", a[1])).unwrap();
        println!("== {}", s.replace('\n', "; "));
        let mut rows = Vec::new();
        for case in ["case00", "case05"] {
            let folder = root.join(case);
            let vehicle = vehicle(&folder);
            for run in runs(&folder) {
                let outputs = estimate(&config, &vehicle, &run.inputs);
                rows.push((run.name.clone(), judge(&run, &outputs)));
                if verbose {
                    println!("{case} {:18} {}", run.name, rows.last().unwrap().1.line());
                }
            }
        }
        for class in ["dry", "wet", "low"] {
            let mut all = Figures::default();
            rows.iter().filter(|(name, _)| name.ends_with(class)).for_each(|(_, f)| all.merge(f));
            println!("{class:5} {}", all.line());
        }
    }
}
