//! What is written of a train is what the project's reader takes.
#![allow(clippy::unwrap_used, missing_docs)]

use std::path::Path;

use railgrip_recording::{Recording, Strictness, Table};
use railgrip_truth_plant::train::{FaultWish, TrainOrder, TrainSpec, files, label::Label};

fn written(folder: &Path, order: &TrainOrder<'_>, seed: u64) -> (TrainSpec, Label) {
    let spec = TrainSpec::draw_to(seed, order).unwrap();
    let label = files::write_train("t", &folder.join("t"), &folder.join("truth"), spec.clone()).unwrap();
    (spec, label)
}

#[test]
fn the_reader_takes_wagons_with_two_and_four_wheelsets_with_and_without_motors() {
    let order = TrainOrder {
        family: Some("freight_p"),
        wagons: Some(8),
        hours: 0.05,
        rate_hz: 50.0,
        fault: FaultWish::Of("tachometer_dropout"),
        ..TrainOrder::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let (spec, label) = written(folder.path(), &order, 7);
    let mut wheelsets = Vec::new();
    for (index, wagon) in spec.wagons.iter().enumerate() {
        let place = folder.path().join("t").join(files::wagon_folder(index));
        let run = Recording::read(&place.join("run.csv"), Strictness::Tolerant).unwrap();
        assert_eq!((run.wheelsets, run.len()), (wagon.wheelsets(), 9000));
        assert!((run.sample_rate_hz() - 50.0).abs() < 1e-9);
        let driven = run.drive_torque_nm.iter().flatten().any(|torque| *torque > 1e3);
        assert_eq!(driven, wagon.is_motored(), "wagon {}", index + 1);
        assert!(run.v_m_s.iter().any(|v| *v > 1.0) && run.brake_demand.is_some());
        assert_eq!(run.load_kg.is_some(), wagon.sensors.load_scale.is_some());
        let truth =
            Table::read(&folder.path().join(format!("truth/{}.csv", files::wagon_folder(index)))).unwrap();
        assert_eq!(truth.rows(), 1800);
        assert!(truth.column("mu_w").unwrap().iter().all(|value| value.is_finite()));
        assert!(truth.column(&format!("mu_b_{}", wagon.wheelsets())).is_some());
        wheelsets.push(run.wheelsets);
    }
    assert!(wheelsets.contains(&2) && wheelsets.contains(&4), "{wheelsets:?}");
    let fault = label.fault.unwrap();
    assert_eq!(
        (fault.cause.as_str(), fault.places.len(), fault.wheelsets.len()),
        ("tachometer_dropout", 1, 1)
    );
    let place = folder.path().join("t").join(files::wagon_folder(fault.places[0] - 1));
    let run = Recording::read(&place.join("run.csv"), Strictness::Tolerant).unwrap();
    let missing = |from_s: f64, to_s: f64| {
        let speeds = &run.wheel_speed_rad_s[fault.wheelsets[0] - 1];
        let rows: Vec<_> = (0..run.len()).filter(|row| (from_s..to_s).contains(&run.t_s[*row])).collect();
        rows.iter().filter(|row| speeds[**row].is_nan()).count() as f64 / rows.len() as f64
    };
    assert!(
        missing(fault.onset_s, 1e9) > 0.3 * fault.size,
        "{} of {}",
        missing(fault.onset_s, 1e9),
        fault.size
    );
    assert!(missing(0.0, fault.onset_s) < 0.01);
}

#[test]
fn a_free_wagon_is_a_train_of_one() {
    let order =
        TrainOrder { coupled: Some(false), hours: 0.02, fault: FaultWish::None, ..TrainOrder::default() };
    let folder = tempfile::tempdir().unwrap();
    let (spec, label) = written(folder.path(), &order, 3);
    assert_eq!((spec.wagons.len(), label.fault, label.coupled), (1, None, false));
    let text = std::fs::read_to_string(folder.path().join("t/train.toml")).unwrap();
    assert!(text.contains("folder = \"w01\"") && !text.contains("[couplers]"));
    let vehicle = std::fs::read_to_string(folder.path().join("t/w01/vehicle.toml")).unwrap();
    assert!(vehicle.contains("free = true") && vehicle.contains("mass_sigma"));
}
