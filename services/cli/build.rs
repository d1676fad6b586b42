//! Tells the program from which commit it is built: `RAILGRIP_COMMIT` if that is set, else what git says, else `unknown`.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=RAILGRIP_COMMIT");
    let commit = std::env::var("RAILGRIP_COMMIT").ok().filter(|commit| !commit.is_empty());
    println!("cargo::rustc-env=RAILGRIP_COMMIT={}", commit.or_else(of_git).unwrap_or("unknown".to_owned()));
}

/// The commit that is checked out, and a note to Cargo to ask again when another one is.
fn of_git() -> Option<String> {
    // Sources unpacked inside somebody else's repository are not of its commit.
    git(&["rev-parse", "--show-prefix"]).filter(|prefix| prefix.is_empty())?;
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD".to_owned()].into_iter().chain(branch) {
        let file = git(&["rev-parse", "--path-format=absolute", "--git-path", &name])?;
        if Path::new(&file).exists() {
            println!("cargo::rerun-if-changed={file}");
        }
    }
    git(&["rev-parse", "--short=9", "HEAD"])
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(["-C", "../.."]).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
