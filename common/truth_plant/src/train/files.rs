//! Writing a train to disk: `train.toml`, one folder a wagon, and the truth in another place.

use std::{
    fmt::Write as _,
    fs::{self, File},
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

use super::{
    coupler::DrawGear,
    journey::Journey,
    label::{Label, Witness},
    sensors::Reading,
    spec::TrainSpec,
    truth::Truth,
    units::PerWheelset,
    wagon::{Wagon, WagonFile},
};
use crate::files::{WriteError, write};

/// The truth is written this often, s.
const TRUTH_PERIOD_S: f64 = 0.1;

/// Runs a train and writes it to `folder`, its truth to `truth_folder`, as `wNN/run.csv` and `wNN.csv`. Returns its label.
///
/// # Errors
/// A file that cannot be written.
pub fn write_train(
    name: &str,
    folder: &Path,
    truth_folder: &Path,
    spec: TrainSpec,
) -> Result<Label, WriteError> {
    write(&folder.join("train.toml"), &train_toml(&spec))?;
    let mut runs = Vec::with_capacity(spec.wagons.len());
    let mut truths = Vec::with_capacity(spec.wagons.len());
    for (index, wagon) in spec.wagons.iter().enumerate() {
        let place = folder.join(wagon_folder(index));
        write(&place.join("vehicle.toml"), &vehicle_toml(wagon, &spec))?;
        runs.push(Lines::create(place.join("run.csv"), &run_header(wagon))?);
        let path = truth_folder.join(format!("{}.csv", wagon_folder(index)));
        truths.push(Lines::create(path, &truth_header(wagon))?);
    }
    let every = ((TRUTH_PERIOD_S * spec.rate_hz).round() as usize).max(1);
    let mut journey = Journey::new(spec);
    let mut witness = Witness::default();
    let mut sample = 0;
    while journey.advance() {
        witness.observe(&journey);
        for (index, wagon) in journey.spec().wagons.iter().enumerate() {
            runs[index].add(|text| run_row(text, wagon, &journey.readings()[index]))?;
            if sample % every == 0 {
                truths[index].add(|text| truth_row(text, wagon.wheelsets(), &journey.truths()[index]))?;
            }
        }
        sample += 1;
    }
    for file in runs.into_iter().chain(truths) {
        file.finish()?;
    }
    Ok(witness.label(name, &journey))
}

/// `w01` of the first wagon.
#[must_use]
pub fn wagon_folder(index: usize) -> String {
    format!("w{:02}", index + 1)
}

/// The text of `train.toml`.
#[must_use]
pub fn train_toml(spec: &TrainSpec) -> String {
    let mut text = String::new();
    for (index, wagon) in spec.wagons.iter().enumerate() {
        let (folder, coupled) = (wagon_folder(index), index > 0);
        let number = &wagon.number;
        let _ =
            writeln!(text, "[[wagon]]\nnumber = \"{number}\"\nfolder = \"{folder}\"\ncoupled = {coupled}\n");
    }
    let _ = writeln!(text, "[line]\nid = \"L{}\"", spec.seed % 97 + 1);
    let count = spec.couplers.len() as f64;
    if count > 0.0 {
        let mean = |of: fn(&DrawGear) -> f64| spec.couplers.iter().map(of).sum::<f64>() / count;
        // A data sheet rounds, and knows the kind of draw gear rather than the piece.
        let rounded = |value: f64, digits: f64| (value / digits).round() * digits;
        let stiffness = rounded(mean(|gear| gear.stiffness_n_per_m), 1e6).max(1e6);
        let damping = rounded(mean(|gear| gear.damping_n_s_per_m), 1e4).max(1e4);
        let slack_mm = rounded(mean(|gear| gear.slack_m) * 1e3, 5.0);
        let _ = writeln!(
            text,
            "\n[couplers]\nstiffness_n_per_m = {stiffness:?}\ndamping_n_s_per_m = {damping:?}\nslack_m = {:?}",
            slack_mm / 1e3
        );
    }
    text
}

/// The text of a wagon's `vehicle.toml`.
#[must_use]
pub fn vehicle_toml(wagon: &Wagon, spec: &TrainSpec) -> String {
    let file = &wagon.file;
    let mut text = format!("schema = 1\nname = \"{}\"\n", file.name);
    let mut table = |name: &str, rows: &[(&str, f64)]| {
        let _ = writeln!(text, "\n[{name}]");
        for (key, value) in rows {
            let _ = writeln!(text, "{key} = {value:?}");
        }
        if name == "body" && file.positions_m.len() > 2 {
            let _ = writeln!(text, "wheelset_positions_m = {:?}", file.positions_m);
        }
    };
    let WagonFile { mass_kg, mass_sigma, com_height_m, wheelbase_m, .. } = *file;
    table(
        "body",
        &[
            ("mass_kg", mass_kg),
            ("mass_sigma", mass_sigma),
            ("com_height_m", com_height_m),
            ("wheelbase_m", wheelbase_m),
        ],
    );
    if let Some((wheelbase_m, pivot_height_m)) = file.bogie_m {
        table("bogie", &[("wheelbase_m", wheelbase_m), ("pivot_height_m", pivot_height_m)]);
    }
    table("wheelset", &[("radius_m", file.radius_m), ("inertia_kg_m2", file.inertia_kg_m2)]);
    table("brake", &[("radius_m", file.pad_radius_m), ("friction_coefficient", file.pad_friction)]);
    let [constant, linear, drag] = file.resistance;
    table(
        "resistance",
        &[("constant_n", constant), ("linear_n_s_per_m", linear), ("drag_n_s2_per_m2", drag)],
    );
    table("contact", &[("stiffness_n", file.stiffness_n), ("k_a", 1.0), ("k_s", 0.4)]);
    table("rail", &[("dry", 0.3), ("wet", 0.115), ("low", 0.065)]);
    let (v_sigma, wheel_sigma, force_sigma) = wagon.sensors.sigma;
    table(
        "sensors",
        &[
            ("sample_rate_hz", spec.rate_hz),
            ("speed_sigma_m_s", v_sigma),
            ("wheel_speed_sigma_rad_s", wheel_sigma),
            ("pressing_force_sigma_n", force_sigma),
        ],
    );
    let _ = writeln!(text, "\n[train]\nfree = {}", !spec.coupled);
    text
}

/// Suffix of a wheelset's columns: front and rear of two, else numbers.
fn suffix(wheelset: usize, wheelsets: usize) -> String {
    match (wheelsets, wheelset) {
        (2, 0) => "f".to_owned(),
        (2, _) => "r".to_owned(),
        _ => (wheelset + 1).to_string(),
    }
}

fn run_header(wagon: &Wagon) -> String {
    let count = wagon.wheelsets();
    let columns = |before: &str, after: &str| {
        (0..count).map(|k| format!(",{before}{}{after}", suffix(k, count))).collect::<String>()
    };
    let mut header = format!("t_s,v_m_s{}{}", columns("omega_", "_rad_s"), columns("f_perp_", "_n"));
    if wagon.is_motored() {
        header += &columns("m_w_", "_nm");
    }
    header += ",grade_rad,sanding,position_m";
    if wagon.sensors.load_scale.is_some() {
        header += ",load_kg";
    }
    header + ",brake_demand"
}

fn run_row(text: &mut String, wagon: &Wagon, row: &Reading) {
    let wheelsets = 0..wagon.wheelsets();
    // Time has as many decimals as any rate needs, and no comma before it.
    let start = text.len();
    fixed(text, row.time_s, 3);
    text.remove(start);
    fixed(text, row.v_m_s, 4);
    wheelsets.clone().for_each(|k| fixed(text, row.wheel_speed_rad_s[k], 4));
    wheelsets.clone().for_each(|k| fixed(text, row.pressing_force_n[k], 0));
    if wagon.is_motored() {
        wheelsets.for_each(|k| fixed(text, row.drive_torque_nm[k], 1));
    }
    fixed(text, row.grade_rad, 5);
    fixed(text, row.sanding, 0);
    fixed(text, row.position_m, 2);
    if wagon.sensors.load_scale.is_some() {
        fixed(text, row.load_kg, 0);
    }
    fixed(text, row.brake_demand, 3);
}

fn truth_header(wagon: &Wagon) -> String {
    let count = wagon.wheelsets();
    let names = ["mu_w", "mu_b", "mu_rail", "omega", "load_n"];
    let columns = names.map(|name| (1..=count).map(|k| format!(",{name}_{k}")).collect::<String>());
    format!("t_s,v_m_s,mu_w{},coupler_n,sliding", columns.concat())
}

fn truth_row(text: &mut String, wheelsets: usize, truth: &Truth) {
    let start = text.len();
    fixed(text, truth.time_s, 3);
    text.remove(start);
    fixed(text, truth.v_m_s, 5);
    fixed(text, truth.mu_w, 5);
    let mut each = |of: &PerWheelset, decimals: usize| {
        of[..wheelsets].iter().for_each(|value| fixed(text, *value, decimals));
    };
    each(&truth.mu_w_wheelset, 5);
    each(&truth.pad_friction, 5);
    each(&truth.rail, 5);
    each(&truth.wheel_speed_rad_s, 5);
    each(&truth.load_n, 0);
    fixed(text, truth.coupler_n, 0);
    fixed(text, f64::from(u8::from(truth.sliding)), 0);
}

/// Adds a comma and a number with at most so many decimals; nothing after the comma where there is no number.
fn fixed(text: &mut String, value: f64, decimals: usize) {
    text.push(',');
    if !value.is_finite() {
        return;
    }
    let scale = 10u64.pow(decimals as u32);
    let units = (value.abs() * scale as f64).round() as u64;
    if value < 0.0 && units > 0 {
        text.push('-');
    }
    let mut digits = [0u8; 20];
    let mut at = digits.len();
    let mut whole = units / scale;
    while {
        at -= 1;
        digits[at] = b'0' + (whole % 10) as u8;
        whole /= 10;
        whole > 0
    } {}
    digits[at..].iter().for_each(|digit| text.push(char::from(*digit)));
    let (mut rest, mut place) = (units % scale, scale);
    if rest > 0 {
        text.push('.');
    }
    while rest > 0 {
        place /= 10;
        text.push(char::from(b'0' + (rest / place) as u8));
        rest %= place;
    }
}

/// A file written line by line.
struct Lines {
    path: PathBuf,
    file: BufWriter<File>,
    line: String,
}

impl Lines {
    fn create(path: PathBuf, header: &str) -> Result<Self, WriteError> {
        let wrap = |source| WriteError::new(&path, source);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(wrap)?;
        }
        let mut file = BufWriter::with_capacity(1 << 16, File::create(&path).map_err(wrap)?);
        writeln!(file, "{header}").map_err(wrap)?;
        Ok(Self { path, file, line: String::new() })
    }

    fn add(&mut self, write_row: impl FnOnce(&mut String)) -> Result<(), WriteError> {
        self.line.clear();
        write_row(&mut self.line);
        self.line.push('\n');
        self.file.write_all(self.line.as_bytes()).map_err(|source| WriteError::new(&self.path, source))
    }

    fn finish(mut self) -> Result<(), WriteError> {
        self.file.flush().map_err(|source| WriteError::new(&self.path, source))
    }
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn numbers_have_no_needless_digits() {
        let written = |value: f64, decimals: usize| {
            let mut text = String::new();
            fixed(&mut text, value, decimals);
            text
        };
        assert_eq!(written(12.3456, 2), ",12.35");
        assert_eq!(written(-0.05, 3), ",-0.05");
        assert_eq!(written(-0.0001, 2), ",0");
        assert_eq!(written(1500.0, 0), ",1500");
        assert_eq!(written(f64::NAN, 3), ",");
        assert_eq!(written(0.005, 3), ",0.005");
    }
}
