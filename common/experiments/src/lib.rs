//! The papers' experiments: each runs a rig, feeds the product's filters, and writes what the paper shows – a table
//! with the paper's figure, ours and the difference (CSV and Markdown), and a plot laid out like the paper's (SVG).
//!
//! **Adding one**: write its module and add its line to [`EXPERIMENTS`].
//!
//! * [`traction`] – Zhao et al. 2014: traction rig, 13-state unscented filter.
//! * [`roller`] – Schwarz & Keck 2020: roller rig, wheel-slide protection and sanding, 4-state extended filter.
//! * [`bogie`] – Shrestha et al. 2021: bogie roller rig, decision-maker, brake controllers in simulation.
//! * [`rigs`] – both rigs as sources of recordings, live or as files.
//! * [`mod@bench`] – time of one filter step, for `railgrip bench` and the reports.
//!
//! Everything is seeded: a rerun writes the same bytes, but for measured times.

pub mod bench;
pub mod bogie;
mod error;
pub mod plot;
mod report;
pub mod rigs;
pub mod roller;
mod table;
pub mod traction;

pub use error::ExperimentError;
pub use report::Report;
pub use table::{Criterion, Row, Table};

use std::path::Path;

/// One experiment.
pub struct Experiment {
    /// Name on the command line.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Runs it and writes its files into a directory that exists.
    pub run: fn(&Path) -> Result<Report, ExperimentError>,
}

/// Every experiment railgrip knows.
pub static EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "zhao-traction",
        about: "Zhao et al. 2014: friction from motor currents on base, water and oil; UKF against EKF",
        run: traction::experiment,
    },
    Experiment {
        name: "schwarz-wsp",
        about: "Schwarz & Keck 2020, Fig. 4: adhesion through near-continuous wheel-slide protection from 120 km/h",
        run: roller::wsp_experiment,
    },
    Experiment {
        name: "schwarz-sanding",
        about: "Schwarz & Keck 2020, Figs. 5 and 6: adhesion over time and slip while sanding from 200 km/h",
        run: roller::sanding_experiment,
    },
    Experiment {
        name: "schwarz-noise",
        about: "Schwarz & Keck 2020, Fig. 3: what Q and R of the wheel speed decide where protection reverses the branch",
        run: roller::noise_experiment,
    },
    Experiment {
        name: "schwarz-beyond",
        about: "Both tests with the sensors of a train: matrices (20), one tuning, multiple models, default, smoothing",
        run: roller::beyond_experiment,
    },
    Experiment {
        name: "shrestha-peak",
        about: "Shrestha et al. 2021, Figs. 8 and 12 to 16: adhesion from both sensors over slip and speed, dry and wet",
        run: bogie::peak_experiment,
    },
    Experiment {
        name: "shrestha-transition",
        about: "Shrestha et al. 2021, Figs. 11 and 17: water on a braked wheelset, heard, decided and controlled",
        run: bogie::transition_experiment,
    },
    Experiment {
        name: "shrestha-acoustics",
        about: "Shrestha et al. 2021, Fig. 11: dry or wet by ear, accuracy and confusion on noise never heard",
        run: bogie::acoustics_experiment,
    },
    Experiment {
        name: "shrestha-stopping",
        about: "Shrestha et al. 2021, Figs. 18 to 20: stops with no, a conventional and the proposed controller",
        run: bogie::stopping_experiment,
    },
];

/// The experiment of that name.
pub fn find(name: &str) -> Option<&'static Experiment> {
    EXPERIMENTS.iter().find(|experiment| experiment.name == name)
}

/// The names of all experiments, for people.
pub fn names() -> String {
    EXPERIMENTS.iter().map(|experiment| experiment.name).collect::<Vec<_>>().join(", ")
}

impl Experiment {
    /// Creates `directory` and runs the experiment into it.
    ///
    /// # Errors
    /// Files that cannot be written, or a filter that cannot be built.
    pub fn run_into(&self, directory: &Path) -> Result<Report, ExperimentError> {
        std::fs::create_dir_all(directory)
            .map_err(|source| ExperimentError::Write { path: directory.to_owned(), source })?;
        let mut report = (self.run)(directory)?;
        for (ending, text) in [("csv", report.table.csv()), ("md", report.markdown(self.about))] {
            let path = directory.join(format!("{}.{ending}", self.name));
            std::fs::write(&path, text)
                .map_err(|source| ExperimentError::Write { path: path.clone(), source })?;
            report.files.push(path);
        }
        Ok(report)
    }
}
