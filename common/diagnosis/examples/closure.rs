use railgrip_diagnosis::data::{align::Alignments, load};
use railgrip_diagnosis::decide::{criteria::Criteria, selection};
use railgrip_diagnosis::fit::windows;
use railgrip_diagnosis::predict::open_loop::{self, Tally, sigmas};
fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let folder = std::path::Path::new(&args[0]);
    let vehicle = toml::from_str(&std::fs::read_to_string(folder.join("vehicle.toml")).unwrap()).unwrap();
    let case = load::load(folder, vehicle).unwrap();
    let criteria = Criteria::default();
    let alignments = Alignments::default();
    let base = selection::calibrate(&case);
    let places = selection::localise(&base, &criteria);
    let ids = railgrip_vehicle::effects::CATALOGUE.iter().map(|(spec, _)| spec.id.to_owned());
    let without: Vec<String> = ids.filter(|id| !args[1..].contains(id)).collect();
    let s = selection::select((&case, &alignments), base, places, &without, &criteria, &|_| ());
    let shape = s.best.fitted.shape.on_recordings();
    let sigma = sigmas(&case.vehicle.sensors);
    let show = |name: &str, theta: &[f64]| {
        let built = shape.build(theta);
        for (what, runs) in [("fit", &case.fit), ("holdout", &case.holdout)] {
            print!("{name} {what}:");
            let mut all = Vec::new();
            for run in runs.iter() {
                let t = open_loop::tallies(&built, run, &sigma);
                print!(" {}={:.1}[{}]", run.name, Tally::total(&t).gap(), t.iter().map(|t| format!("{:.0}", t.gap())).collect::<Vec<_>>().join(" "));
                all.extend(t);
            }
            println!("  ALL {:.2}", Tally::total(&all).gap());
        }
        println!("{:?}", shape.parameters().iter().zip(theta).map(|(p, t)| format!("{}={:.4}", p.name, t)).collect::<Vec<_>>());
    };
    let white = s.best.fitted.fit.theta.clone();
    show("whitened", &white);
    let polished = windows::fit(&case, &shape, &[white.clone()]);
    show("polished", &polished);
}
