//! The way in for the user that runs the service: a socket in the folder of the train, which nobody else can open. Through
//! it `railgrip status` works without a token, a certificate or a free seat.

use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use tokio::net::{UnixListener, UnixStream};

/// An open local socket; its file goes when it is dropped.
pub struct LocalSocket {
    listener: UnixListener,
    path: PathBuf,
    inode: u64,
}

impl LocalSocket {
    /// Opens the socket. Without one everything else works, so a failure is only logged.
    #[must_use]
    pub fn open(path: &Path) -> Option<Self> {
        let opened = bind(path);
        if let Err(error) = &opened {
            tracing::warn!("{}: {error}; `railgrip status` needs --url here", path.display());
        }
        opened.ok()
    }

    pub(super) async fn accept(&self) -> io::Result<UnixStream> {
        self.listener.accept().await.map(|(stream, _)| stream)
    }
}

fn bind(path: &Path) -> io::Result<LocalSocket> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let listener = UnixListener::bind(path)?;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600))?;
    Ok(LocalSocket { listener, path: path.to_owned(), inode: std::fs::metadata(path)?.ino() })
}

impl Drop for LocalSocket {
    fn drop(&mut self) {
        // A successor may have put its own socket there already; that one stays.
        if std::fs::metadata(&self.path).is_ok_and(|metadata| metadata.ino() == self.inode) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}
