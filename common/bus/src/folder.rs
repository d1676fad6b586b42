//! The folder of an instance: this user's alone, whoever made it.

use std::path::Path;

use crate::BusError;

/// Makes the folder of an instance, or sees to it that it is this user's and that nobody else can write to it: in `/tmp` anybody
/// can have made one of its name beforehand, with a key in it that they know.
///
/// # Errors
/// [`BusError::ForeignFolder`]; what the system refused.
pub fn own_folder(folder: &Path) -> Result<(), BusError> {
    use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
    let failed = |source| BusError::File { path: folder.to_owned(), source };
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(folder).map_err(failed)?;
    let found = std::fs::metadata(folder).map_err(failed)?;
    let user = rustix::process::geteuid().as_raw();
    let foreign = |folder: &Path, owner| BusError::ForeignFolder { folder: folder.to_owned(), owner, user };
    if found.uid() != user {
        return Err(foreign(folder, found.uid()));
    }
    // Whoever owns a folder above it where everybody may write can put another in its place.
    let folder = std::path::absolute(folder).map_err(failed)?;
    for (above, one) in folder.ancestors().skip(1).zip(folder.ancestors()) {
        let (above, one_is) =
            (std::fs::metadata(above).map_err(failed)?, std::fs::metadata(one).map_err(failed)?);
        if above.mode() & 0o002 != 0 && ![user, 0].contains(&one_is.uid()) {
            return Err(foreign(one, one_is.uid()));
        }
    }
    let folder = folder.as_path();
    if found.mode() & 0o022 != 0 {
        tracing::warn!(folder = %folder.display(), "others could write to the folder of this train; now they cannot");
        std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o700)).map_err(failed)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};

    use super::*;

    #[test]
    fn a_folder_is_made_for_this_user_closed_to_others_or_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let ours = folder.path().join("deep/ours");
        let mode = |folder: &Path| std::fs::metadata(folder).expect("it exists").mode() & 0o777;
        own_folder(&ours).expect("made");
        assert_eq!(mode(&ours), 0o700);
        std::fs::set_permissions(&ours, std::fs::Permissions::from_mode(0o777)).expect("mode");
        own_folder(&ours).expect("ours");
        assert_eq!(mode(&ours), 0o700);
        std::fs::set_permissions(&ours, std::fs::Permissions::from_mode(0o755)).expect("mode");
        own_folder(&ours).expect("others may look");
        // The root of the file system is root's; root meets a folder of somebody else's.
        let foreign = if rustix::process::geteuid().is_root() {
            let foreign = folder.path().join("foreign");
            std::fs::create_dir(&foreign).expect("made");
            std::os::unix::fs::chown(&foreign, Some(65_534), None).expect("given away");
            let link = folder.path().join("link");
            std::os::unix::fs::symlink(&foreign, &link).expect("link");
            link
        } else {
            Path::new("/").to_owned()
        };
        let error = own_folder(&foreign).expect_err("it is not ours").to_string();
        println!("{error}");
        assert!(error.contains("belongs to user"), "{error}");
        if rustix::process::geteuid().is_root() {
            let open = folder.path().join("open");
            std::fs::create_dir(&open).expect("made");
            std::fs::set_permissions(&open, std::fs::Permissions::from_mode(0o1777)).expect("mode");
            std::fs::create_dir(open.join("railgrip-0")).expect("made");
            std::os::unix::fs::chown(open.join("railgrip-0"), Some(65_534), None).expect("given away");
            let error = own_folder(&open.join("railgrip-0/demo")).expect_err("somebody's").to_string();
            assert!(error.contains("railgrip-0 belongs to user 65534"), "{error}");
        }
    }
}
