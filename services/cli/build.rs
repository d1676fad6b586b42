//! Tells the program from which commit it is built: `RAILGRIP_COMMIT` if that is set, else what an archive of git (`git archive`,
//! a downloaded tarball) says in the file `commit`, else what git says, else `unknown`.

use std::path::Path;
use std::process::Command;

/// Digits of a commit that are shown.
const DIGITS: usize = 9;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=commit");
    println!("cargo::rerun-if-env-changed=RAILGRIP_COMMIT");
    let given = std::env::var("RAILGRIP_COMMIT").ok().filter(|commit| !commit.is_empty());
    let commit = given.or_else(of_archive).or_else(of_git).unwrap_or("unknown".to_owned());
    println!("cargo::rustc-env=RAILGRIP_COMMIT={commit}");
}

/// What git wrote into an archive of the sources; in a repository nothing stands there yet.
fn of_archive() -> Option<String> {
    let commit = std::fs::read_to_string("commit").ok()?;
    let commit = commit.trim();
    let is_one = commit.len() >= DIGITS && commit.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_one.then(|| commit[..DIGITS].to_owned())
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
