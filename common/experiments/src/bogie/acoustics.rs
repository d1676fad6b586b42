//! The acoustic classifier: how often it is right on noise that it never heard, and Fig. 11 with the network itself.

use super::controller::Control;
use super::ear::{EarListener, HeardWindow};
use super::run::{Instant, simulate_with, stop};
use super::transition::{BRAKE_S, WATER_S, setup};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report};
use railgrip_acoustics::FEATURES;
use railgrip_classifier::dataset::synthesise;
use railgrip_classifier::recipe::{Circumstances, HELD_OUT_NOISE_DB, Noise, Speeds, TEST_RIGS, UNHEARD_RIG};
use railgrip_classifier::{Confusion, Model};
use railgrip_vehicle::bogie_rig::RailCondition;
use std::fmt::Write;
use std::path::Path;

/// Clips of each cell; half of them wet.
const CLIPS: usize = 160;
/// Seed of the clips: never that of a training.
const CLIP_SEED: u64 = 20_210_914;
/// Seed of the run that Fig. 11 shows.
const RUN_SEED: u64 = 2021;

/// One rig at one level of noise.
struct Cell {
    rig: &'static str,
    noise_db: f64,
    confusion: Confusion,
}

/// Accuracy, confusion and Fig. 11.
///
/// # Errors
/// Files that cannot be written.
pub fn acoustics_experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let model = Model::built_in()?;
    let mut report = Report::default();
    let provenance = model.provenance().clone();
    let table = &mut report.table;
    table.push("network", "features", "", Some(26.0), FEATURES as f64, "zero crossings to RMS, as librosa");
    table.push("network", "seconds of audio learnt from", "s", None, provenance.clips as f64, "synthesised");
    table.push(
        "network",
        "right of a fifth set aside",
        "",
        None,
        provenance.validation_accuracy,
        "speeds and noise as in training; the paper gives no figure",
    );
    let cells = judge(&model);
    for cell in &cells {
        let Confusion { dry_dry, dry_wet, wet_dry, wet_wet, brier, .. } = cell.confusion;
        let group = format!("rig {}, held-out speeds", cell.rig);
        let remark = format!(
            "dry heard dry {dry_dry}, wet {dry_wet}; wet heard dry {wet_dry}, wet {wet_wet}; Brier {brier:.3}"
        );
        let what = format!("right, background {} dB", cell.noise_db);
        report.table.push(group, what, "", None, cell.confusion.accuracy(), remark);
    }
    criteria(&mut report, &cells);
    let mut ear = EarListener::new(RUN_SEED)?;
    let test = setup(Control::Proposed, 1.0, RUN_SEED);
    let run = simulate_with(&test, &mut ear);
    transition_rows(&mut report, &ear.windows, &run, stop(&test, &run).locked_s);

    let path = directory.join("shrestha-acoustics.svg");
    write_svg(&path, 1, (900, 260), &heard_panels(&ear, &run))?;
    report.files.push(path);
    let path = directory.join("shrestha-acoustics-accuracy.svg");
    write_svg(&path, 1, (760, 380), &[accuracy_panel(&cells)])?;
    report.files.push(path);
    let path = directory.join("shrestha-acoustics-confusion.svg");
    std::fs::write(&path, confusion_svg(&cells))
        .map_err(|source| ExperimentError::Write { path: path.clone(), source })?;
    report.files.push(path);
    Ok(report)
}

fn judge(model: &Model) -> Vec<Cell> {
    let mut cells = Vec::new();
    for rig in TEST_RIGS.into_iter().chain([UNHEARD_RIG]) {
        for noise_db in HELD_OUT_NOISE_DB {
            let circumstances =
                Circumstances { rigs: vec![rig], speeds: Speeds::HeldOut, noise: Noise::Level(noise_db) };
            let confusion = Confusion::of(model, &synthesise(&circumstances, CLIPS, CLIP_SEED));
            cells.push(Cell { rig, noise_db, confusion });
        }
    }
    cells
}

/// Mean accuracy over the rigs that training knows, or over the one that it does not, at one level.
fn accuracy(cells: &[Cell], heard: bool, noise_db: f64) -> f64 {
    let own: Vec<f64> = cells
        .iter()
        .filter(|cell| (cell.rig != UNHEARD_RIG) == heard && cell.noise_db == noise_db)
        .map(|cell| cell.confusion.accuracy())
        .collect();
    own.iter().sum::<f64>() / own.len().max(1) as f64
}

fn criteria(report: &mut Report, cells: &[Cell]) {
    let [quiet, .., loud] = HELD_OUT_NOISE_DB;
    let known = accuracy(cells, true, quiet);
    let known_loud = accuracy(cells, true, loud);
    for noise_db in HELD_OUT_NOISE_DB {
        let what = format!("right, background {noise_db} dB");
        let remark = "mean over the rigs of training, at speeds that training never had";
        report.table.push("all rigs of training", what, "", None, accuracy(cells, true, noise_db), remark);
    }
    for (name, figure, met) in [
        ("nine of ten seconds are heard right in the quiet, at speeds never heard", known, known >= 0.88),
        (
            "noise as loud as the wheel costs, as in the paper, but not all",
            known_loud,
            (0.6..known).contains(&known_loud),
        ),
    ] {
        report.criteria.push(Criterion { name: name.into(), figure: format!("{figure:.3}"), met });
    }
}

/// Fig. 11: the sixth part of its windows falls into a change.
fn transition_rows(report: &mut Report, windows: &[HeardWindow], run: &[Instant], locked_s: f64) {
    let group = "Fig. 11, water on the braked rig";
    let heard: Vec<&HeardWindow> = windows.iter().filter(|window| window.wet.is_some()).collect();
    let right = |from: f64, to: f64| {
        let inside: Vec<_> = heard.iter().filter(|window| (from..to).contains(&window.time_s)).collect();
        let good = inside
            .iter()
            .filter(|window| window.wet.is_some_and(|wet| (wet > 0.5) == (window.wetness > 0.5)))
            .count();
        good as f64 / inside.len().max(1) as f64
    };
    let (dry, wet) = (right(0.0, WATER_S + 0.1), right(WATER_S + 1.1, f64::INFINITY));
    let decided_s = run
        .iter()
        .find(|i| i.sample.time_s > WATER_S && i.decision.condition == RailCondition::Wet)
        .map_or(f64::NAN, |i| i.sample.time_s - WATER_S);
    let table = &mut report.table;
    table.push(
        group,
        "windows heard right before the water",
        "",
        Some(1.0),
        dry,
        "paper: its figure shows no slip",
    );
    table.push(
        group,
        "windows heard right after it",
        "",
        Some(1.0),
        wet,
        "to the end; paper: all but the 66th and 74th second",
    );
    table.push(group, "time until \"wet\" is decided", "s", Some(1.0), decided_s, "paper: one window of 1 s");
    table.push(
        group,
        "time locked",
        "s",
        Some(0.0),
        locked_s,
        "the network in the loop of the simulated controller",
    );
    let stop_s = run.last().map_or(f64::NAN, |last| last.sample.time_s - BRAKE_S);
    table.push(group, "time to stop", "s", None, stop_s, "from the brakes on");
    report.criteria.push(Criterion {
        name: "the network hears the water and the wheelset does not lock for longer than 0.5 s".into(),
        figure: format!("decided after {decided_s:.1} s, locked for {locked_s:.2} s"),
        met: decided_s <= 4.0 && locked_s <= 0.5,
    });
}

fn heard_panels(ear: &EarListener, run: &[Instant]) -> Vec<Panel> {
    let end = run.last().map_or(1.0, |last| last.sample.time_s);
    let steps = |value: &dyn Fn(f64) -> f64| {
        let mut points = Vec::new();
        for window in &ear.windows {
            let height = window.wet.map_or(f64::NAN, value);
            points.extend([(window.time_s - 1.0, height), (window.time_s, height)]);
        }
        points
    };
    let mut wave = Vec::new();
    for (time_s, peak) in &ear.envelope {
        wave.extend([(*time_s, *peak), (*time_s, -peak)]);
    }
    let truth = run.iter().map(|i| (i.sample.time_s, i.wetness)).collect();
    let decided = run
        .iter()
        .map(|i| (i.sample.time_s, f64::from(u8::from(i.decision.condition == RailCondition::Wet))))
        .collect();
    vec![
        Panel::new("Fig. 11: noise at the microphone; brakes at 15 s, water at 50 s", "time, s", "amplitude")
            .x(0.0, end)
            .with(Series::new("", 1, Mark::Line, wave)),
        Panel::new(
            "Output of the network for windows of 1 s; a gap: nothing could be heard",
            "time, s",
            "probability",
        )
        .x(0.0, end)
        .y(-0.05, 1.05)
        .with(Series::new("dry", 5, Mark::Bold, steps(&|wet| 1.0 - wet)))
        .with(Series::new("wet", 1, Mark::Bold, steps(&|wet| wet)))
        .with(Series::new("0.5", 0, Mark::Line, vec![(0.0, 0.5), (end, 0.5)])),
        Panel::new("Condition decided (thick) and water in truth (thin)", "time, s", "0 dry, 1 wet")
            .x(0.0, end)
            .y(-0.05, 1.05)
            .with(Series::new("truth", 0, Mark::Line, truth))
            .with(Series::new("decided", 2, Mark::Bold, decided)),
    ]
}

fn accuracy_panel(cells: &[Cell]) -> Panel {
    let title = "Seconds heard right at held-out speeds, over the level of the background";
    let mut panel = Panel::new(title, "background over dry rolling noise, dB", "share").y(0.4, 1.0);
    for (number, rig) in TEST_RIGS.into_iter().chain([UNHEARD_RIG]).enumerate() {
        let own = cells.iter().filter(|cell| cell.rig == rig);
        let points = own.map(|cell| (cell.noise_db, cell.confusion.accuracy())).collect();
        let label = if rig == UNHEARD_RIG { format!("{rig} (never heard)") } else { rig.to_owned() };
        panel = panel.with(Series::new(label, number + 1, Mark::Bold, points));
    }
    panel
}

/// Confusion matrices, one row a rig, one column a level of noise.
fn confusion_svg(cells: &[Cell]) -> String {
    let (side, gap, left, top) = (58.0, 34.0, 110.0, 70.0);
    let block = 2.0 * side + gap;
    let rigs: Vec<&str> = TEST_RIGS.into_iter().chain([UNHEARD_RIG]).collect();
    let (width, height) = (left + block * HELD_OUT_NOISE_DB.len() as f64, top + block * rigs.len() as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"sans-serif\" font-size=\"13\"><rect width=\"100%\" height=\"100%\" fill=\"white\"/>\
         <text x=\"12\" y=\"22\" font-size=\"15\">Confusion at held-out speeds: rows the rail, columns what is heard, \
         share of the row</text>"
    );
    for cell in cells {
        let row = rigs.iter().position(|rig| *rig == cell.rig).unwrap_or(0) as f64;
        let column = HELD_OUT_NOISE_DB.iter().position(|db| *db == cell.noise_db).unwrap_or(0) as f64;
        let (x, y) = (left + column * block, top + row * block);
        if row == 0.0 {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\">{} dB</text>",
                x + side - 20.0,
                top - 22.0,
                cell.noise_db
            );
        }
        if column == 0.0 {
            let _ = write!(svg, "<text x=\"12\" y=\"{}\">{}</text>", y + side, cell.rig);
        }
        let c = &cell.confusion;
        for (line, (name, [dry, wet])) in
            [("dry", [c.dry_dry, c.dry_wet]), ("wet", [c.wet_dry, c.wet_wet])].into_iter().enumerate()
        {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" font-size=\"11\" text-anchor=\"end\">{name}</text><text x=\"{}\" y=\"{}\" \
                 font-size=\"11\" text-anchor=\"middle\">{name}</text>",
                x - 4.0,
                y + side * (line as f64 + 0.55),
                x + side * (line as f64 + 0.5),
                y - 5.0
            );
            for (place, count) in [dry, wet].into_iter().enumerate() {
                let share = count as f64 / (dry + wet).max(1) as f64;
                let right = place == line;
                let colour = if right { "0,114,178" } else { "213,94,0" };
                let ink = if share > 0.55 { "white" } else { "black" };
                let (px, py) = (x + side * place as f64, y + side * line as f64);
                let _ = write!(
                    svg,
                    "<rect x=\"{px}\" y=\"{py}\" width=\"{side}\" height=\"{side}\" stroke=\"white\" \
                     fill=\"rgba({colour},{:.3})\"/><text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"{ink}\">{:.0} %</text>",
                    0.08 + 0.92 * share,
                    px + 0.5 * side,
                    py + 0.58 * side,
                    100.0 * share
                );
            }
        }
    }
    svg.push_str("</svg>\n");
    svg
}
