//! Whether the holdout gaps that a report states follow from its prediction files.

use std::{collections::HashMap, fs, path::Path};

use serde_json::Value;

use crate::sealed::files::read;

const MODELS: [&str; 3] = ["nominal", "calibrated", "extended"];
/// Relative difference that rounding in files may make.
const TOLERANCE: f64 = 2e-3;

/// Recomputes the gaps; `Err` says what does not follow.
pub(super) fn check(case: &Path, predictions: &Path, report: &Value) -> Result<(), String> {
    let sigma = sigmas(case)?;
    let mut squares = HashMap::new();
    let mut outputs = Vec::new();
    let holdout = case.join("holdout");
    for entry in fs::read_dir(&holdout).map_err(|error| error.to_string())? {
        let path = entry.map_err(|error| error.to_string())?.path();
        let name = path.file_name().unwrap_or_default();
        let recorded = table(&path)?;
        let predicted = table(&predictions.join(name))?;
        outputs = outputs_of(&recorded);
        add(&mut squares, &outputs, &recorded, &predicted, sigma)
            .map_err(|what| format!("{}: {what}", path.display()))?;
    }
    let by = |output: &str, model: &str| -> f64 {
        let key = (output.to_owned(), model.to_owned());
        squares.get(&key).map_or(f64::NAN, |(sum, count)| (sum / count).sqrt())
    };
    for model in MODELS {
        let mean = outputs.iter().map(|output| by(output, model).powi(2)).sum::<f64>() / outputs.len() as f64;
        let total = mean.sqrt();
        agree(report, &format!("/gap/holdout/{model}"), total)?;
        if model != "nominal" {
            for output in &outputs {
                agree(report, &format!("/gap/holdout/by_signal/{output}/{model}"), by(output, model))?;
            }
        }
    }
    Ok(())
}

fn agree(report: &Value, pointer: &str, recomputed: f64) -> Result<(), String> {
    let stated =
        report.pointer(pointer).and_then(Value::as_f64).ok_or_else(|| format!("{pointer} is missing"))?;
    if (stated - recomputed).abs() <= TOLERANCE * recomputed.abs().max(1.0) {
        return Ok(());
    }
    Err(format!("{pointer} says {stated}, the prediction files give {recomputed}"))
}

/// Outputs of a recording: speed and the speed of every wheelset.
fn outputs_of(recorded: &Table) -> Vec<String> {
    let mut wheels: Vec<String> =
        recorded.keys().filter(|name| name.starts_with("omega_")).cloned().collect();
    wheels.sort();
    [vec!["v_m_s".to_owned()], wheels].concat()
}

/// Sums of squared errors over sigma, and how many, by output and model.
type Squares = HashMap<(String, String), (f64, f64)>;

/// Adds the errors of one run; a cell that was not recorded has none.
fn add(
    squares: &mut Squares,
    outputs: &[String],
    recorded: &Table,
    predicted: &Table,
    sigma: [f64; 2],
) -> Result<(), String> {
    let times = column(recorded, "t_s")?;
    let rows: HashMap<i64, usize> = times.iter().enumerate().map(|(row, t)| (tick(*t), row)).collect();
    let predicted_times = column(predicted, "t_s")?;
    for (index, output) in outputs.iter().enumerate() {
        let truth = column(recorded, output)?;
        let shown = column(predicted, output)?;
        let scale = if index == 0 { sigma[0] } else { sigma[1] };
        let mut was_recorded = Vec::with_capacity(shown.len());
        for (time, shown) in predicted_times.iter().zip(shown) {
            let row = rows.get(&tick(*time)).ok_or_else(|| format!("no recorded sample at {time} s"))?;
            let differs = (truth[*row] - shown).abs() > 1e-3 * scale.max(1e-3);
            if truth[*row].is_finite() && (differs || shown.is_nan()) {
                return Err(format!("{output} at {time} s is not what was recorded"));
            }
            was_recorded.push(truth[*row].is_finite());
        }
        for model in MODELS {
            let values = column(predicted, &format!("{output}_{model}"))?;
            let (sum, count) = squares.entry((output.clone(), model.to_owned())).or_default();
            let both = values.iter().zip(shown).zip(&was_recorded).filter(|(_, was_recorded)| **was_recorded);
            for ((value, shown), _) in both {
                *sum += ((value - shown) / scale).powi(2);
                *count += 1.0;
            }
        }
    }
    Ok(())
}

fn tick(time_s: f64) -> i64 {
    (time_s * 1000.0).round() as i64
}

type Table = HashMap<String, Vec<f64>>;

fn column<'a>(table: &'a Table, name: &str) -> Result<&'a Vec<f64>, String> {
    table.get(name).ok_or_else(|| format!("column {name} is missing"))
}

fn table(path: &Path) -> Result<Table, String> {
    let text = read(path).map_err(|error| error.to_string())?;
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').map(str::trim).collect();
    let mut columns = vec![Vec::new(); names.len()];
    for line in lines {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.trim().parse().unwrap_or(f64::NAN));
        }
    }
    Ok(names.into_iter().map(str::to_owned).zip(columns).collect())
}

/// Sigmas of speed and wheel speed, from `vehicle.toml`.
fn sigmas(case: &Path) -> Result<[f64; 2], String> {
    let text = read(&case.join("vehicle.toml")).map_err(|error| error.to_string())?;
    let value = |key: &str| {
        let line =
            text.lines().find_map(|line| line.strip_prefix(key)?.trim().strip_prefix('=').map(str::trim));
        line.and_then(|value| value.parse().ok()).ok_or_else(|| format!("vehicle.toml lacks {key}"))
    };
    Ok([value("speed_sigma_m_s")?, value("wheel_speed_sigma_rad_s")?])
}
