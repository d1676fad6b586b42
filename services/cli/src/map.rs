//! `railgrip map`: what the columns of a file may mean, as a `[mapping]` to begin with, and plots of the first minute.

use std::path::PathBuf;

use railgrip_diagnosis::html;
use railgrip_recording::{FirstMinute, first_minute, proposal, survey};
use railgrip_words::{reword, speak, t};

use crate::CliError;
use crate::gap_shared::{LanguageArgs, write};
use crate::output::{apart, say};

/// Characters of a plot in text.
const WIDTH: usize = 60;
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Propose a [mapping] for a recording with columns of its own, and show what was understood.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording, CSV or Parquet
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Plots of the first minute as a page that works offline
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    language: LanguageArgs,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    apart(&[("--html", args.html.as_deref())], &[&args.file])?;
    let surveyed = survey(&args.file).map_err(CliError::bad_input)?;
    let minute = first_minute(&args.file, &surveyed).map_err(CliError::bad_input)?;
    let timed = surveyed.iter().filter_map(|column| column.guess.as_ref()).any(|guess| guess.to == "t_s");
    let text = speak(args.language.chosen(), || {
        let text = proposal(&surveyed, reword);
        say(&text);
        let heading = match timed {
            true => t("the first minute, in the units of a run:"),
            false => t("no time is understood; the first rows:"),
        };
        say(&format!("# {heading}"));
        for column in &minute {
            say(&format!("# {}", line(column)));
        }
        text
    });
    if let Some(page) = &args.html {
        let name = args.file.display().to_string();
        let page_text = speak(args.language.chosen(), || html::survey::render(&name, &minute, &text, timed));
        write(page, &page_text)?;
    }
    if surveyed.iter().all(|column| column.guess.is_none()) {
        let why = "no column is understood; name them in a [mapping] by hand";
        return Err(CliError::bad_input(format!("{}: {why}", args.file.display())));
    }
    Ok(())
}

/// A column as one line of text.
fn line(column: &FirstMinute) -> String {
    let values = || column.points.iter().map(|point| point[1]).filter(|value| value.is_finite());
    let least = values().fold(f64::INFINITY, f64::min);
    let most = values().fold(f64::NEG_INFINITY, f64::max);
    if least > most {
        return format!("{:<15} {}", column.to, t("no value"));
    }
    let plot = sparkline(&column.points, least, most);
    let (least, most) = (short(least), short(most));
    let span = railgrip_words::say(
        "{least} to {most} {unit}",
        &[("least", &least), ("most", &most), ("unit", &t(column.unit))],
    );
    format!("{:<15} {plot} {span}", column.to)
}

fn short(value: f64) -> String {
    if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.3}") }
}

/// The means of equal stretches of time; a blank where nothing was measured.
fn sparkline(points: &[[f64; 2]], least: f64, most: f64) -> String {
    let across = points.last().map_or(0.0, |last| last[0]).max(f64::MIN_POSITIVE);
    let mut sums = [(0.0, 0_u32); WIDTH];
    for [at, value] in points.iter().filter(|point| point[0].is_finite() && point[1].is_finite()) {
        let place = (at / across * WIDTH as f64) as usize;
        let (sum, count) = &mut sums[place.min(WIDTH - 1)];
        (*sum, *count) = (*sum + value, *count + 1);
    }
    let bar = |(sum, count): (f64, u32)| {
        if count == 0 {
            return ' ';
        }
        let share = if most > least { (sum / f64::from(count) - least) / (most - least) } else { 0.5 };
        BARS[((share * 8.0) as usize).min(7)]
    };
    sums.into_iter().map(bar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_words::Language;

    #[test]
    fn the_first_minute_is_drawn_in_text_and_on_a_page_of_its_own() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("run.csv");
        let rows: String = (0..9000)
            .map(|k| {
                let t_s = f64::from(k) * 0.01;
                let speed =
                    if (20.0..40.0).contains(&t_s) { String::new() } else { (36.0 + t_s).to_string() };
                format!("{t_s},{speed},3.8\n")
            })
            .collect();
        std::fs::write(&file, format!("t_s,speed km/h,p_cyl bar\n{rows}")).expect("write");
        let surveyed = survey(&file).expect("table");
        let minute = first_minute(&file, &surveyed).expect("table");
        let speed = line(&minute[0]);
        assert!(speed.starts_with("v_m_s") && speed.ends_with("10.000 to 26.667 m/s"), "{speed}");
        let plot: Vec<char> = speed.chars().skip(16).take(WIDTH).collect();
        assert_eq!((plot[0], plot[WIDTH - 1]), ('▁', '█'), "{speed}");
        assert!(
            plot[21..39].iter().all(|bar| *bar == ' '),
            "nothing is drawn where nothing was measured: {speed}"
        );
        for language in [Language::English, Language::German] {
            let page = speak(language, || {
                html::survey::render("run.csv", &minute, &proposal(&surveyed, reword), true)
            });
            assert_eq!(page.matches("<svg").count(), 2, "{page}");
            let doubt = if language == Language::English { "# doubt: " } else { "# Zweifel: " };
            assert!(page.contains(doubt), "{page}");
            assert!(page.contains("class=\"calibrated-line\""), "{page}");
            assert!(
                !page.contains("http://") && !page.contains("https://") && !page.contains("<script"),
                "{page}"
            );
        }
    }

    #[test]
    fn every_doubt_and_remark_has_its_german() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("run.csv");
        for header in [
            "speed", "wheel", "pressure", "f_perp", "torque", "slope", "km", "m_w_f_nm", "p Pa", "driver",
            "position",
        ] {
            for most in [-900.0, 0.0, 0.015, 3.2, 40.0, 140.0, 900.0, 3800.0, 380_000.0] {
                for time in ["t_s", "time", "hour"] {
                    let row = |k: u32| {
                        format!(
                            "{},{},{}\n",
                            f64::from(k) * 0.01,
                            25.0 - f64::from(k) * 0.1,
                            most * f64::from(k) / 99.0
                        )
                    };
                    let rows: String = (0..100).map(row).collect();
                    std::fs::write(&file, format!("{time},v_m_s,{header}\n{rows}")).expect("write");
                    let surveyed = survey(&file).expect("table");
                    let unknown = std::cell::RefCell::new(Vec::new());
                    let german = |sentence: &str| {
                        let found = railgrip_words::german(sentence);
                        found.unwrap_or_else(|| {
                            unknown.borrow_mut().push(sentence.to_owned());
                            String::new()
                        })
                    };
                    let text = proposal(&surveyed, german);
                    assert_eq!(*unknown.borrow(), Vec::<String>::new(), "{text}");
                }
            }
        }
    }
}
