//! Recordings good and bad, and what is estimated of them.

use super::*;
use railgrip_recording::Table;

fn columns_of(rows: &str, smooth: bool) -> Result<Table, CliError> {
    let folder = tempfile::tempdir().expect("folder");
    let [run, vehicle, out] = ["run.csv", "vehicle.toml", "out.csv"].map(|name| folder.path().join(name));
    std::fs::write(&vehicle, include_str!("../../../../config/vehicle.toml")).expect("write");
    let header = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n";
    std::fs::write(&run, format!("{header}\n{rows}")).expect("write");
    let none = OfTrain { coupled: None };
    let args = Args { smooth, train: None, ..Args::of_train(run, vehicle, out.clone(), none) };
    super::run(&args)?;
    Ok(Table::read(&out).expect("a table"))
}

/// Rows without a value once ran on to a speed of -12 m/s.
#[test]
fn where_nothing_is_measured_for_long_nothing_is_estimated() {
    let row = |k: u32| {
        let t_s = f64::from(k) * 0.01;
        if (5.0..30.0).contains(&t_s) {
            format!("{t_s},,,,,\n")
        } else {
            format!("{t_s},20.0,43.5,43.5,8000,8000\n")
        }
    };
    let rows: String = (0..4000).map(row).collect();
    for smooth in [false, true] {
        let table = columns_of(&rows, smooth).expect("estimates");
        let column = |name: &str| table.column(name).expect("column");
        assert_eq!(table.rows(), 4000);
        for name in ["v_m_s", "mu_w", "mu_b_f", "nis"] {
            let filled = |k: usize| column(name)[k].is_finite();
            assert!((710..2999).all(|k| !filled(k)), "{name}: only what is known is told");
            assert!((100..500).all(filled) && (3010..4000).all(filled), "{name}");
        }
        let known = column("v_m_s").iter().filter(|v| v.is_finite());
        assert!(
            known.clone().all(|v| (5.0..30.0).contains(v)),
            "{:?}",
            known.fold(1e9_f64, |a, b| a.min(*b))
        );
    }
}

#[test]
fn cells_without_a_value_are_counted_by_their_column() {
    let of = |rows: &str| {
        let header = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n";
        let text = format!("{header}\n{rows}");
        let label = Path::new("run.csv");
        let read = Recording::read_csv(text.as_bytes(), label, Strictness::Tolerant).expect("a recording");
        Recorded::Wagon(Box::new(read)).lacking()
    };
    assert_eq!(of("0.0,20,43.5,43.5,0,0\n0.1,20,43.5,43.5,0,0\n"), None);
    let holes = "0.0,NaN,43.5,43.5,0,0\n0.1,,43.5,,0,0\n0.2,20,43.5,43.5,0,0\n";
    assert_eq!(of(holes).as_deref(), Some("v_m_s 2, omega_r_rad_s 1"));
}

#[test]
fn without_any_measured_speed_there_is_nothing_to_estimate() {
    let rows: String = (0..4000).map(|k| format!("{},,,,8000,8000\n", f64::from(k) * 0.01)).collect();
    let error = columns_of(&rows, false).expect_err("nothing is measured");
    println!("{error}");
    assert_eq!(error.code(), 2);
}

/// One wagon of the demo scenario, for so long, once through and again.
fn simulated(duration_s: f64) -> (Recording, VehicleParameters) {
    let text = include_str!("../../../../config/scenarios/demo.toml");
    let text = text
        .replace("duration_s = 240.0", &format!("duration_s = {duration_s:?}"))
        .replace("wagons = 8", "wagons = 1");
    let scenario = railgrip_simulation::Scenario::parse(Path::new("demo.toml"), &text).expect("scenario");
    let vehicle: VehicleParameters =
        toml::from_str(include_str!("../../../../config/vehicle.toml")).expect("vehicle");
    let mut runs =
        railgrip_simulation::run(&scenario, std::slice::from_ref(&vehicle), 1, |_| ()).expect("a run");
    (runs.remove(0).recording, vehicle)
}

/// What is judged in pieces of long recordings once was never tried on one of the simulation.
#[test]
fn units_of_simulated_recordings_are_told_short_and_long() {
    for duration_s in [60.0, 240.0, 1800.0] {
        let (run, vehicle) = simulated(duration_s);
        assert_eq!(units::check(&run, &vehicle), Ok(()), "{duration_s} s");
        for factor in [1e3, 1e-3, 1e-5, -1.0] {
            let mut wrong = run.clone();
            wrong.pressing_force_n.iter_mut().flatten().for_each(|force| *force *= factor);
            let error = units::check(&wrong, &vehicle).expect_err("cannot be");
            println!("{duration_s} s, times {factor}: {error}");
            assert_eq!(error.column, "f_perp_f_n");
        }
    }
}

#[test]
fn an_estimate_of_impossible_forces_is_refused_with_their_column() {
    for force in ["-8000", "8e9"] {
        let rows: String =
            (0..500).map(|k| format!("{},20.0,43.5,43.5,{force},8000\n", f64::from(k) * 0.01)).collect();
        let error = columns_of(&rows, false).expect_err(force);
        assert!(error.code() == 2 && error.to_string().contains("f_perp_f_n"), "{error}");
    }
}

#[test]
fn what_is_read_is_not_overwritten() {
    let folder = tempfile::tempdir().expect("folder");
    let [run, vehicle, link] = ["run.csv", "vehicle.toml", "link.csv"].map(|name| folder.path().join(name));
    std::fs::write(&run, "t_s").expect("write");
    std::os::unix::fs::symlink(&run, &link).expect("link");
    for (out, why) in [(run.clone(), "is read here"), (link, "is read here"), ("/dev/stdout".into(), ".csv")]
    {
        let none = OfTrain { coupled: None };
        let args = Args { train: None, ..Args::of_train(run.clone(), vehicle.clone(), out, none) };
        let error = super::run(&args).expect_err(why);
        assert!(error.code() == 2 && error.to_string().contains(why), "{error}");
    }
    assert_eq!(std::fs::read_to_string(&run).expect("as it was"), "t_s");
}

/// The same numbers for the same seed.
fn dice(state: &mut u64, most: usize) -> usize {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*state >> 33) % most as u64) as usize
}

/// Five hundred recordings with holes of all lengths: no panic, and no figure, least of all zero, where nothing is known.
#[test]
fn of_five_hundred_recordings_with_holes_nothing_is_invented() {
    const ROWS: usize = 400;
    let (mut refused, mut told, mut empty) = (0, 0, 0);
    for seed in 0..500_u64 {
        let mut state = seed;
        let row = |k: usize| {
            let v = 20.0 - 0.02 * k as f64;
            [0.05 * k as f64, v, v / 0.46, v / 0.46, 9e3, 8e3].map(|value| value.to_string()).to_vec()
        };
        let mut rows: Vec<Vec<String>> = (0..ROWS).map(row).collect();
        for _ in 0..1 + dice(&mut state, 8) {
            let (from, length) = (dice(&mut state, ROWS), dice(&mut state, ROWS));
            let words = ["", "", "", "NaN", "1e300", "-1e9", "x"];
            let word = words[dice(&mut state, words.len())];
            let (first, count) = (1 + dice(&mut state, 5), 1 + dice(&mut state, 5));
            for cells in rows.iter_mut().skip(from).take(length) {
                cells.iter_mut().skip(first).take(count).for_each(|cell| word.clone_into(cell));
            }
        }
        let text: String = rows.iter().map(|cells| cells.join(",") + "\n").collect();
        let table = match columns_of(&text, false) {
            Ok(table) => table,
            Err(error) => {
                assert_eq!(error.code(), 2, "{seed}: {error}");
                refused += 1;
                continue;
            }
        };
        let known = |cells: &[String]| cells[1..4].iter().any(|cell| cell.parse().is_ok_and(f64::is_finite));
        let mut last = 0;
        for (k, cells) in rows.iter().enumerate() {
            if known(cells) {
                last = k;
            }
            let blind = 0.05 * (k - last) as f64 > 2.0 + 1e-9;
            for name in ["v_m_s", "mu_w", "mu_w_sigma", "mu_b_f", "mu_b_r_sigma", "slip_f", "nis"] {
                let value = table.column(name).expect(name)[k];
                assert!(!blind || value.is_nan(), "{seed}: {name} is {value} in row {k}");
                assert!(!value.is_infinite(), "{seed}: {name} in row {k}");
                if name.ends_with("sigma") {
                    assert!(value.is_nan() || value > 0.0, "{seed}: {name} is {value} in row {k}");
                }
                if value.is_nan() { empty += 1 } else { told += 1 }
            }
        }
    }
    println!("{refused} refused, {told} figures told, {empty} left empty");
    assert!(refused > 50 && told > 100_000 && empty > 10_000, "{refused} {told} {empty}");
}
