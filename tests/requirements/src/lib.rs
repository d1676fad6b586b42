//! Tests that need more than Rust and a C compiler: a broker, a browser, recordings beside the project.
//!
//! Where a requirement is missing, the test is counted as ignored, with the reason beside its name, and never as passed. Where
//! `RAILGRIP_REQUIRE` names the requirement (or says `all`), a missing one is a failure: `tests/run` sets it for what it installs.
//!
//! A test file uses this in place of the built-in harness. In `Cargo.toml`:
//!
//! ```toml
//! [[test]]
//! name = "rules"
//! harness = false
//! ```
//!
//! and in `tests/rules.rs`, where every test of the file is listed with what it needs:
//!
//! ```
//! railgrip_requirements::tests! {
//!     rules_are_well_formed: [PROMTOOL],
//!     rules_have_unique_names: [],
//! }
//!
//! fn rules_are_well_formed() { /* … */ }
//! fn rules_have_unique_names() { /* … */ }
//! ```

use libtest_mimic::{Arguments, Completion, Trial};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// Names of the requirements, separated by commas, that must be met; `all` for all.
const REQUIRE: &str = "RAILGRIP_REQUIRE";

/// Something outside the project that a test needs.
#[derive(Debug)]
pub struct Requirement {
    /// Name for people and for `RAILGRIP_REQUIRE`.
    pub name: &'static str,
    place: Place,
    /// How to get it, in words.
    remedy: &'static str,
}

#[derive(Debug)]
enum Place {
    /// A folder, relative to the folder in which the project lies.
    Beside(&'static str),
    /// A program: the variable that may name it, then the names under which it is looked for.
    Program(&'static str, &'static [&'static str]),
    /// A file: the variable that may name it, then where `tests/run` puts it, relative to the project.
    File(&'static str, &'static str),
    /// A private mount in a namespace of its own.
    PrivateMount,
}

/// The labelled cases of the sim-to-real gap, with truth beside the recordings.
pub static LABELLED_CASES: Requirement = Requirement {
    name: "labelled-cases",
    place: Place::Beside("shared/gap/open"),
    remedy: "a folder shared/gap/open beside the project",
};
/// More of them, each of which was answered wrongly once.
pub static HARD_CASES: Requirement = Requirement {
    name: "hard-cases",
    place: Place::Beside("shared/gap/open2"),
    remedy: "a folder shared/gap/open2 beside the project",
};
/// Measured creep points of a roller rig.
pub static CREEP_POINTS: Requirement = Requirement {
    name: "creep-points",
    place: Place::Beside("shared/real/vt_roller_rig_creep"),
    remedy: "a folder shared/real/vt_roller_rig_creep beside the project",
};
/// An MQTT broker.
pub static MOSQUITTO: Requirement = Requirement {
    name: "mosquitto",
    place: Place::Program("MOSQUITTO", &["mosquitto"]),
    remedy: "apt-get install mosquitto",
};
/// A browser that runs headless.
pub static CHROMIUM: Requirement = Requirement {
    name: "chromium",
    place: Place::Program(
        "CHROMIUM",
        &["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"],
    ),
    remedy: "apt-get install chromium",
};
/// The rules by which pages are checked for people with disabilities.
pub static AXE_CORE: Requirement = Requirement {
    name: "axe-core",
    place: Place::File("AXE_CORE", "target/axe-core/axe_playwright_python/axe.min.js"),
    remedy: "tests/run, or AXE_CORE=axe.min.js of any copy of axe-core",
};
/// The program that checks rules and config of Prometheus.
pub static PROMTOOL: Requirement = Requirement {
    name: "promtool",
    place: Place::Program("PROMTOOL", &["promtool"]),
    remedy: "apt-get install prometheus",
};
/// The program that checks units of systemd.
pub static SYSTEMD_ANALYZE: Requirement = Requirement {
    name: "systemd-analyze",
    place: Place::Program("SYSTEMD_ANALYZE", &["systemd-analyze"]),
    remedy: "apt-get install systemd",
};
/// The iceoryx2 package for Python, of the version of the project.
pub static ICEORYX2_PYTHON: Requirement = Requirement {
    name: "iceoryx2-python",
    place: Place::File("ICEORYX2_PYTHON", "target/iceoryx2-python/iceoryx2/__init__.py"),
    remedy: "tests/run, or ICEORYX2_PYTHON=FOLDER/iceoryx2/__init__.py of any installed copy",
};
/// A compiler for C++.
pub static CXX: Requirement = Requirement {
    name: "c++",
    place: Place::Program("CXX", &["c++", "g++", "clang++"]),
    remedy: "apt-get install g++",
};
/// The program that makes Debian packages; where it is, dpkg and strip are.
pub static DPKG_DEB: Requirement = Requirement {
    name: "dpkg-deb",
    place: Place::Program("DPKG_DEB", &["dpkg-deb"]),
    remedy: "a Debian system",
};
/// The right to mount a small file system that no other process sees.
pub static PRIVATE_MOUNT: Requirement = Requirement {
    name: "private-mount",
    place: Place::PrivateMount,
    remedy: "root, or a kernel that lets users make namespaces (unshare -rm)",
};

/// Every requirement there is.
pub static ALL: [&Requirement; 12] = [
    &LABELLED_CASES,
    &HARD_CASES,
    &CREEP_POINTS,
    &MOSQUITTO,
    &CHROMIUM,
    &AXE_CORE,
    &CXX,
    &DPKG_DEB,
    &PROMTOOL,
    &SYSTEMD_ANALYZE,
    &ICEORYX2_PYTHON,
    &PRIVATE_MOUNT,
];

impl Requirement {
    /// Where it is: the folder or the program; for a private mount the program `unshare`. `None` where it is missing.
    pub fn find(&self) -> Option<PathBuf> {
        match self.place {
            Place::Beside(folder) => {
                let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..").join(folder);
                path.canonicalize().ok().filter(|path| path.is_dir())
            }
            Place::Program(variable, names) => match std::env::var_os(variable) {
                Some(path) => Some(PathBuf::from(path)).filter(|path| path.is_file()),
                None => names.iter().find_map(|name| on_path(name)),
            },
            Place::File(variable, file) => {
                let usual = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
                let path = std::env::var_os(variable).map_or_else(usual, PathBuf::from);
                path.canonicalize().ok().filter(|path| path.is_file())
            }
            Place::PrivateMount => ["-rm", "-m"].iter().find_map(|flags| {
                let mut command = Command::new("unshare");
                command.args([flags, "mount", "-t", "tmpfs", "none", "/tmp"]);
                let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
                status.is_ok_and(|status| status.success()).then(|| PathBuf::from("unshare"))
            }),
        }
    }

    /// Where it is.
    ///
    /// # Panics
    /// Where it is missing: only a test that lists the requirement may ask.
    pub fn path(&self) -> PathBuf {
        self.find().unwrap_or_else(|| panic!("{}", self.missing()))
    }

    fn missing(&self) -> String {
        format!("{} is missing: {}", self.name, self.remedy)
    }
}

/// A program by its name, in the search path or where system services lie.
fn on_path(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain([PathBuf::from("/usr/sbin"), PathBuf::from("/sbin")]);
    folders.map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// A test: its name, what it needs, and its function.
pub type Test = (&'static str, &'static [&'static Requirement], fn());

/// Runs the tests of a file as the built-in harness would, with the same arguments and exit codes; no more than `at_once` of
/// them beside each other (`None`: as many as the machine has cores), unless the command line or `RUST_TEST_THREADS` says it.
pub fn run(tests: &[Test], at_once: Option<usize>) -> ExitCode {
    let required = std::env::var(REQUIRE).unwrap_or_default();
    if let Some(name) = required.split(',').find(|name| !is_name(name)) {
        let known: Vec<&str> = ALL.iter().map(|known| known.name).collect();
        eprintln!("{REQUIRE}: no requirement {name:?}; all, or some of {}", known.join(","));
        return ExitCode::from(2);
    }
    let trials = tests.iter().map(|(name, needs, function)| trial(name, needs, *function, &required));
    let mut arguments = Arguments::from_args();
    let told = std::env::var("RUST_TEST_THREADS").ok().and_then(|text| text.parse().ok());
    arguments.test_threads = arguments.test_threads.or(told).or(at_once);
    libtest_mimic::run(&arguments, trials.collect()).exit_code()
}

fn is_name(name: &str) -> bool {
    name.is_empty() || name == "all" || ALL.iter().any(|known| known.name == name)
}

fn trial(name: &str, needs: &'static [&'static Requirement], function: fn(), required: &str) -> Trial {
    let required = required.to_owned();
    Trial::ignorable_test(name, move || {
        if let Some(missing) = needs.iter().find(|need| need.find().is_none()) {
            let must = required.split(',').any(|name| name == "all" || name == missing.name);
            return if must {
                Err(format!("{} ({REQUIRE}={required})", missing.missing()).into())
            } else {
                Ok(Completion::ignored_with(missing.missing()))
            };
        }
        function();
        Ok(Completion::Completed)
    })
}

/// The `main` of a test file: its test functions, each with the requirements that it needs. `at_once = 1;` in front is for
/// tests that each take a machine of their own: a train and a browser.
#[macro_export]
macro_rules! tests {
    (at_once = $at_once:expr; $($name:ident: [$($need:ident),* $(,)?]),+ $(,)?) => {
        fn main() -> std::process::ExitCode {
            const TESTS: &[$crate::Test] = &[$((stringify!($name), &[$(&$crate::$need),*], $name)),+];
            $crate::run(TESTS, $at_once.into())
        }
    };
    ($($name:ident: [$($need:ident),* $(,)?]),+ $(,)?) => {
        $crate::tests! { at_once = None; $($name: [$($need),*]),+ }
    };
}
