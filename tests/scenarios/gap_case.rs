//! `gap diagnose` on a small simulated case, by the contract: files, keys, gaps that follow from the prediction files, the same
//! report on any number of threads, and a vehicle with the effect in it that simulator and estimator load.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use railgrip_tests::{Table, program};
use serde_json::Value;

const OUTPUTS: [&str; 3] = ["v_m_s", "omega_f_rad_s", "omega_r_rad_s"];
/// Larger than any tolerance of the fit, small enough to be no gross misfit.
const RADIUS_ERROR: f64 = 0.008;

fn run(arguments: &[&str]) -> Output {
    Command::new(program!()).args(arguments).output().expect("start")
}

fn must(arguments: &[&str]) {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// A scenario of one wagon that coasts, brakes twice and coasts, on one class of rail.
fn scenario(condition: &str, brake: f64) -> String {
    format!(
        "schema = 1\nname = \"stop\"\nduration_s = 30.0\nstart_speed_m_s = 25.0\ntrain = {{ wagons = 1 }}\n\
         demand = [{{ from_s = 0.0, coast = true }}, {{ from_s = 4.0, brake = {brake:?} }}, {{ from_s = 12.0, coast = true }}, \
         {{ from_s = 18.0, brake = 0.4 }}, {{ from_s = 25.0, coast = true }}]\n\
         rail = [{{ from_m = -1000.0, condition = \"{condition}\" }}]\n"
    )
}

/// A case whose recordings come from a vehicle with a wheel radius that the case's vehicle file does not know.
fn case(folder: &Path) -> PathBuf {
    let effect = format!(
        "\n[[effect]]\nid = \"wheel_radius\"\nparameters = {{ relative_error = {RADIUS_ERROR}, wheelset = 2.0 }}\n"
    );
    case_of(folder, &effect, &[])
}

/// A case whose recordings come from a vehicle with an effect that the case's vehicle file does not know; `more` goes to the
/// simulator.
fn case_of(folder: &Path, effect: &str, more: &[&str]) -> PathBuf {
    let plain = include_str!("../../config/vehicle.toml");
    let case = folder.join("case");
    std::fs::create_dir_all(&case).expect("case");
    std::fs::write(case.join("vehicle.toml"), plain).expect("vehicle");
    std::fs::write(folder.join("true.toml"), format!("{plain}{effect}")).expect("vehicle");
    let runs =
        [("fit/stop.dry", "dry", 0.7), ("fit/stop.wet", "wet", 0.5), ("holdout/other.dry", "dry", 0.5)];
    for (index, (name, condition, brake)) in runs.into_iter().enumerate() {
        let (file, out) = (folder.join("scenario.toml"), folder.join(format!("run{index}")));
        std::fs::write(&file, scenario(condition, brake)).expect("scenario");
        let seed = (index + 1).to_string();
        let vehicle = text(&folder.join("true.toml"));
        let (file, to) = (text(&file), text(&out));
        let simulate =
            ["simulate", "--scenario", &file, "--vehicle", &vehicle, "--out", &to, "--seed", &seed];
        must(&[&simulate, more].concat());
        let to = case.join(format!("{name}.csv"));
        std::fs::create_dir_all(to.parent().expect("folder")).expect("folder");
        std::fs::copy(out.join(format!("wagon01.{condition}.csv")), to).expect("recording");
    }
    case
}

/// What one diagnosis left.
struct Answer {
    report: Value,
    predictions: String,
    page: String,
    vehicle: PathBuf,
}

fn diagnose(case: &Path, out: &Path, threads: &str) -> Answer {
    let at = |name: &str| text(&out.join(name));
    must(&[
        "gap",
        "diagnose",
        &text(case),
        "--json",
        &at("report.json"),
        "--html",
        &at("report.html"),
        "--predictions",
        &at("predictions"),
        "--apply",
        &at("applied.toml"),
        "--seed",
        "3",
        "--threads",
        threads,
    ]);
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    Answer {
        report: serde_json::from_str(&read("report.json")).expect("JSON"),
        predictions: read("predictions/other.dry.csv"),
        page: read("report.html"),
        vehicle: out.join("applied.toml"),
    }
}

/// The holdout gaps that follow from a prediction file: nominal, calibrated, extended.
fn gaps(file: &Path) -> [f64; 3] {
    let table = Table::read(file);
    ["nominal", "calibrated", "extended"].map(|model| {
        let squares = OUTPUTS.map(|output| {
            let sigma = 0.03;
            let pairs = table.column(output).iter().zip(table.column(&format!("{output}_{model}")));
            pairs.map(|(a, b)| ((a - b) / sigma).powi(2)).sum::<f64>() / table.rows() as f64
        });
        (squares.iter().sum::<f64>() / 3.0).sqrt()
    })
}

#[test]
fn a_case_is_answered_by_the_contract_and_alike_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("folder");
    let case = case(folder.path());
    let (one, three) = (folder.path().join("one"), folder.path().join("three"));
    for out in [&one, &three] {
        std::fs::create_dir_all(out).expect("folder");
    }
    let (mut first, mut second) = (diagnose(&case, &one, "1"), diagnose(&case, &three, "3"));

    for key in [
        "schema",
        "verdict",
        "rule",
        "where",
        "effects",
        "candidates",
        "gap",
        "unexplained",
        "next_run",
        "seconds",
    ] {
        assert!(first.report.get(key).is_some(), "no {key}");
    }
    assert_eq!(first.report["schema"], "railgrip.gap.report/1");
    assert_eq!(
        (&first.report["verdict"], &first.report["effects"][0]["id"]),
        (&"effects".into(), &"wheel_radius".into())
    );
    assert_eq!(first.report["where"]["term"], "kinematics");
    let candidates = first.report["candidates"].as_array().expect("candidates");
    assert!(candidates.len() >= 27, "{} candidates", candidates.len());

    let said = &first.report["gap"]["holdout"];
    let followed = gaps(&one.join("predictions/other.dry.csv"));
    for (model, gap) in ["nominal", "calibrated", "extended"].into_iter().zip(followed) {
        let stated = said[model].as_f64().expect("a gap");
        println!("{model}: {stated:.4} stated, {gap:.4} from the file");
        assert!((stated - gap).abs() < 1e-3 * gap, "{model}");
    }
    assert!(said["reduction"].as_f64().expect("reduction") > 0.5, "{said}");

    for answer in [&mut first, &mut second] {
        answer.report["seconds"] = Value::Null;
    }
    assert_eq!(first.report, second.report, "the report depends on the threads");
    assert_eq!(first.predictions, second.predictions, "the predictions depend on the threads");
    let timeless = |page: &str| {
        let (before, after) = page.split_once("<dt>Time taken</dt>").expect("how long it took");
        format!("{before}{}", after.split_once("</dd>").expect("an end").1)
    };
    assert_eq!(timeless(&first.page), timeless(&second.page), "the page depends on the threads");
    assert!(
        !first.page.contains("http://") && !first.page.contains("https://"),
        "the page needs the network"
    );

    let compared = folder.path().join("compared.html");
    let reports = [&one, &three].map(|out| text(&out.join("report.json")));
    let output = run(&["gap", "compare", &reports[0], &reports[1], "--html", &text(&compared)]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    println!("{said}");
    assert!(output.status.success() && said.contains("is as before, within the intervals"), "{said}");
    let page = std::fs::read_to_string(&compared).expect("the comparison as a page");
    assert!(page.contains("one") && page.contains("three") && page.contains("</html>"), "{page}");

    let vehicle = std::fs::read_to_string(&first.vehicle).expect("vehicle");
    println!("{vehicle}");
    assert!(
        vehicle.contains("id = \"wheel_radius\"") && vehicle.contains("friction_by_wheelset"),
        "{vehicle}"
    );
    let (applied, estimates) = (text(&first.vehicle), text(&folder.path().join("estimates.csv")));
    must(&[
        "estimate",
        &text(&case.join("holdout/other.dry.csv")),
        "--vehicle",
        &applied,
        "--out",
        &estimates,
    ]);
    let (scenario, again) = (text(&folder.path().join("scenario.toml")), text(&folder.path().join("again")));
    must(&["simulate", "--scenario", &scenario, "--vehicle", &applied, "--out", &again]);
}

/// A pad that glazes while it presses, on one wheelset: no effect of the catalogue does that.
const GLAZING: &str = r#"schema = 1
[[effect]]
id = "glazing"
term = "brake_friction"
law = "brake_friction"
wheelset = 2
expression = "value * (1 - depth * min(state / 4, 1))"
state.rate = "min(pressing_force_n / 10e3, 1)"
parameters.depth = { upper = 0.8, default = 0.1, neutral = 0.0 }
"#;

#[test]
fn an_effect_from_a_file_is_simulated_found_applied_and_estimated_with() {
    let folder = tempfile::tempdir().expect("folder");
    let file = text(&folder.path().join("effects.toml"));
    std::fs::write(&file, GLAZING).expect("effects");
    let own = ["--effects", file.as_str()];
    let effect = "\n[[effect]]\nid = \"glazing\"\nparameters = { depth = 0.4 }\n";
    let case = case_of(folder.path(), effect, &own);
    let at = |name: &str| text(&folder.path().join(name));
    let (report, applied) = (at("report.json"), at("applied.toml"));
    let diagnose = ["gap", "diagnose", &text(&case), "--json", &report, "--apply", &applied];
    must(&[&diagnose, &own[..]].concat());
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(report).expect("report")).expect("JSON");
    let found = &report["effects"][0];
    println!("{found}");
    assert_eq!((found["id"].as_str(), found["term"].as_str()), (Some("glazing"), Some("brake_friction")));
    let depth = found["parameters"]["depth"]["value"].as_f64().expect("depth");
    assert!((depth - 0.4).abs() < 0.04, "depth {depth}");
    let run = text(&case.join("holdout/other.dry.csv"));
    let estimate = ["estimate", &run, "--vehicle", &applied, "--out", &at("estimate.csv")];
    must(&[&estimate, &own[..]].concat());
    // Without its file nobody knows the effect.
    let unknown = run_of(&estimate);
    assert_eq!(unknown.0, Some(2));
    assert!(unknown.1.contains("effect `glazing` is not in the catalogue"), "{}", unknown.1);
    std::fs::write(&file, GLAZING.replace("pressing_force_n", "pressing_force_kn")).expect("effects");
    let wrong = run_of(&["gap", "effects", "--effects", &file]);
    println!("{}", wrong.1);
    assert_eq!(wrong.0, Some(2));
    assert!(
        wrong.1.contains("effects.toml:8: effect `glazing`, `state.rate`: nothing is called"),
        "{}",
        wrong.1
    );
}

/// A plan names what it separates, keeps to its limits and comes as a scenario that runs; the vehicle that made the recordings makes the
/// run, and what it says of the causes speaks for the right one.
#[test]
fn the_next_run_is_planned_within_its_limits_and_speaks_for_the_cause() {
    let folder = tempfile::tempdir().expect("folder");
    let case = case(folder.path());
    let at = |name: &str| text(&folder.path().join(name));
    let (json, scenario) = (at("plan.json"), at("planned.toml"));
    let limits = ["--v-max", "20", "--rails", "dry", "--length-s", "40"];
    let plan = ["gap", "plan", &text(&case), "--json", &json, "--scenario", &scenario];
    must(&[&plan, &limits[..]].concat());
    let plan: Value = serde_json::from_str(&std::fs::read_to_string(json).expect("plan")).expect("JSON");
    println!("{}", plan["words"]);
    assert_eq!(plan["separates"][0][0], "wheel_radius", "{plan}");
    assert!(plan["separates"].as_array().is_some_and(|sets| sets.len() >= 2), "{plan}");
    let number = |value: &Value| value.as_f64().expect("a number");
    let [before, after, random] =
        ["entropy_before", "entropy_after", "entropy_after_random"].map(|key| number(&plan[key]));
    assert!(after <= before && after <= random, "{before} {after} {random}");
    assert!(number(&plan["run"]["v0_m_s"]) <= 20.0 && plan["run"]["rail"] == "dry");
    let phases = plan["run"]["phases"].as_array().expect("phases");
    assert_eq!(phases.last().map(|phase| number(&phase["until_s"])), Some(40.0));
    must(&["simulate", "--scenario", &scenario, "--vehicle", &at("true.toml"), "--out", &at("planned")]);

    let missing = run_of(&["gap", "settle", &text(&case)]);
    assert_eq!(missing.0, Some(2));
    assert!(missing.1.contains("case/test: no such folder"), "{}", missing.1);
    std::fs::create_dir(case.join("test")).expect("folder");
    std::fs::copy(folder.path().join("planned/wagon01.dry.csv"), case.join("test/planned.dry.csv"))
        .expect("the run");
    must(&["gap", "settle", &text(&case), "--json", &at("settled.json")]);
    let settled: Value =
        serde_json::from_str(&std::fs::read_to_string(at("settled.json")).expect("settled")).expect("JSON");
    println!("{}", settled["words"]);
    assert_eq!(settled["effects"][0]["id"], "wheel_radius", "{settled}");
    let p = |sets: &Value| -> f64 {
        let holds =
            |set: &&Value| set["effects"].as_array().is_some_and(|ids| ids.contains(&"wheel_radius".into()));
        sets.as_array().expect("sets").iter().filter(holds).map(|set| number(&set["p"])).sum()
    };
    let [before, after] = ["before", "posterior"].map(|key| p(&settled[key]));
    assert!(after > before && after > 0.8, "{before} {after}");
    let wrong = run_of(&["gap", "plan", &text(&case), "--rails", "dry,ice"]);
    assert_eq!(wrong.0, Some(2));
    assert!(wrong.1.contains("no rail \"ice\"; there are dry, wet, low"), "{}", wrong.1);
}

/// Exit code, and what was said of errors.
fn run_of(arguments: &[&str]) -> (Option<i32>, String) {
    let output = run(arguments);
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn bad_cases_are_refused_with_file_line_and_column() {
    let folder = tempfile::tempdir().expect("folder");
    let good = case(folder.path());
    let refused = |file: &str, change: &dyn Fn(&str) -> String, wanted: &[&str]| {
        let path = good.join(file);
        let before = std::fs::read_to_string(&path).expect("file");
        std::fs::write(&path, change(&before)).expect("file");
        let output = run(&["gap", "diagnose", &text(&good)]);
        std::fs::write(&path, before).expect("file");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        println!("{said}");
        assert_eq!(output.status.code(), Some(2), "{said}");
        wanted.iter().for_each(|word| assert!(said.contains(word), "no {word:?} in: {said}"));
    };
    // Cell `column` of line `line` (from 1) set to a text.
    let cell = |text: &str, line: usize, column: usize, value: &str| -> String {
        let edit = |(index, row): (usize, &str)| {
            let mut cells: Vec<&str> = row.split(',').collect();
            if index + 1 == line {
                cells[column] = value;
            }
            cells.join(",") + "\n"
        };
        text.lines().enumerate().map(edit).collect()
    };
    let scaled = |text: &str, columns: &[usize], factor: f64| -> String {
        let edit = |(index, row): (usize, &str)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            if index > 0 {
                let scale = |x: &str| (x.parse::<f64>().expect("number") * factor).to_string();
                columns.iter().for_each(|column| cells[*column] = scale(&cells[*column]));
            }
            cells.join(",") + "\n"
        };
        text.lines().enumerate().map(edit).collect()
    };
    let run = "fit/stop.dry.csv";
    refused(run, &|t| t.replacen("omega_f_rad_s", "omega_x", 1), &["stop.dry.csv, line 1", "omega_x"]);
    refused(run, &|t| cell(t, 40, 1, "NaN"), &["stop.dry.csv, line 40, column v_m_s"]);
    refused(run, &|t| cell(t, 41, 0, "0.3944"), &["stop.dry.csv, line 41, column t_s"]);
    refused(
        run,
        &|t| t.lines().next().map(|l| format!("{l}\n")).expect("header"),
        &["stop.dry.csv", "empty run"],
    );
    refused(run, &|t| scaled(t, &[1], 3.6), &["stop.dry.csv, line 2, column v_m_s", "km/h"]);
    refused(run, &|t| scaled(t, &[4, 5], 1e-3), &["stop.dry.csv, line ", "column f_perp_f_n", "kN"]);
    let still = |t: &str, columns: &[usize]| scaled(t, columns, 0.0);
    refused(
        run,
        &|t| still(t, &[2]),
        &["stop.dry.csv, line 2, column omega_f_rad_s: reads 0 throughout", "dead"],
    );
    // Lines that end as on Windows are counted alike.
    refused(run, &|t| cell(t, 40, 1, "NaN").replace('\n', "\r\n"), &["stop.dry.csv, line 40, column v_m_s"]);
    let mass = |t: &str, to: &str| {
        t.lines()
            .map(|l| if l.starts_with("mass_kg") { format!("{to}\n") } else { format!("{l}\n") })
            .collect()
    };
    refused("vehicle.toml", &|t| mass(t, "mass_kg = -3.0"), &["vehicle.toml", "body.mass_kg", "-3"]);
    refused("vehicle.toml", &|t| mass(t, "mas_kg = 4e4"), &["vehicle.toml", "line", "mas_kg"]);
}
