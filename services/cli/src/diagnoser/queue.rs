//! Which case is next.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use railgrip_estimator::gap_record::GROWING;
use railgrip_health::alerts::diagnosis::ANSWER;

/// A case that was to be written anew is taken as it is after this time: its estimator has started again meanwhile.
const GROWN_AFTER: Duration = Duration::from_secs(300);

/// The oldest case that has no answer yet and is not about to be written anew.
pub(super) fn next(gaps: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(gaps).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut due: Vec<(SystemTime, PathBuf)> =
        entries.filter(|case| is_due(case)).filter_map(|case| Some((kept_at(&case)?, case))).collect();
    due.sort();
    due.into_iter().next().map(|(_, case)| case)
}

/// When a case was written.
fn kept_at(case: &Path) -> Option<SystemTime> {
    case.join("vehicle.toml").metadata().and_then(|metadata| metadata.modified()).ok()
}

fn is_due(case: &Path) -> bool {
    // What begins with a dot is half written.
    let named = case.file_name().is_some_and(|name| name.to_string_lossy().starts_with("wagon-"));
    if !named || case.join(ANSWER).exists() {
        return false;
    }
    let Some(kept_at) = kept_at(case) else { return false };
    // A clock that was set back makes no case wait for ever.
    let age = SystemTime::now().duration_since(kept_at).unwrap_or(GROWN_AFTER);
    !case.join(GROWING).exists() || age >= GROWN_AFTER
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_waits_while_it_grows_and_is_diagnosed_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let case = |name: &str| {
            let case = folder.path().join(name);
            std::fs::create_dir_all(&case).expect("a case");
            std::fs::write(case.join("vehicle.toml"), "").expect("a vehicle");
            case
        };
        assert_eq!(next(folder.path()), None, "nothing was kept");
        let half = case(".wagon-1-100");
        let growing = case("wagon-1-100");
        std::fs::write(growing.join(GROWING), "").expect("a mark");
        assert_eq!(next(folder.path()), None, "{} is not whole", half.display());
        let whole = case("wagon-2-200");
        assert_eq!(next(folder.path()), Some(whole.clone()));
        std::fs::write(whole.join(ANSWER), "{}").expect("an answer");
        assert_eq!(next(folder.path()), None, "it has its answer");
        let old = SystemTime::now() - GROWN_AFTER;
        let vehicle =
            std::fs::File::options().write(true).open(growing.join("vehicle.toml")).expect("a file");
        vehicle.set_modified(old).expect("a time");
        assert_eq!(next(folder.path()), Some(growing), "nobody writes it anew any more");
    }
}
