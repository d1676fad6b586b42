//! Sessions of browsers: a cookie that names a token and an end, signed with a key of this machine.
//!
//! Nothing is kept of a session while it lasts, so that it survives a restart of the service; it ends with its time, with its token
//! (revoked, expired, or rotated and the overlap over), and when its owner logs out, which is kept beside the key. The key lies in the
//! folder of the running train, readable by the service's user only; one that others could read or made is not used, and where there
//! is none it is made.

use crate::access::tokens::{Token, hex, random};
use ring::hmac;
use std::collections::BTreeMap;
use std::io::Write;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

const KEY_BYTES: usize = 32;
/// Sessions that were ended by hand and would still be valid; beyond that there is a new key, which ends all of them.
const MAX_ENDED: usize = 4096;

/// Makes and checks sessions.
pub(super) struct Sessions {
    key_file: PathBuf,
    lasts: Duration,
    state: Mutex<State>,
}

struct State {
    key: hmac::Key,
    /// Sessions that were ended by hand, and when they would have ended, Unix s.
    ended: BTreeMap<String, i64>,
}

impl Sessions {
    pub(super) fn open(key_file: &Path, lasts: Duration) -> std::io::Result<Self> {
        let key = match kept_key(key_file) {
            Ok(key) => key,
            Err(error) => {
                tracing::warn!("{}: {error}; logins will end with this process", key_file.display());
                random()?
            }
        };
        let ended = kept_ends(&ends_file(key_file));
        let state = Mutex::new(State { key: hmac::Key::new(hmac::HMAC_SHA256, &key), ended });
        Ok(Self { key_file: key_file.to_owned(), lasts, state })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How long a session lasts.
    pub(super) fn lasts(&self) -> Duration {
        self.lasts
    }

    /// A session for the owner of that token.
    pub(super) fn begin(&self, token: &Token, now_s: i64) -> Option<String> {
        let end = now_s.saturating_add(i64::try_from(self.lasts.as_secs()).unwrap_or(i64::MAX));
        let hash = token.hashes(now_s).next()?;
        let nonce = hex(&random::<8>().ok()?);
        let said = format!("{}~{end}~{nonce}", token.name);
        let signature = hmac::sign(&self.state().key, format!("{said}~{}", hash.hex()).as_bytes());
        Some(format!("{said}~{}", hex(signature.as_ref())))
    }

    /// The token whose owner this session belongs to.
    pub(super) fn owner(&self, session: &str, tokens: &[Token], now_s: i64) -> Option<Token> {
        let mut parts = session.split('~');
        let (name, end, nonce, signature) = (parts.next()?, parts.next()?, parts.next()?, parts.next()?);
        let state = self.state();
        if parts.next().is_some() || end.parse::<i64>().ok()? <= now_s || state.ended.contains_key(nonce) {
            return None;
        }
        let signature = unhex(signature)?;
        let token = tokens.iter().find(|token| token.name == name)?;
        let signed = |hash: String| {
            let said = format!("{name}~{end}~{nonce}~{hash}");
            hmac::verify(&state.key, said.as_bytes(), &signature).is_ok()
        };
        token.hashes(now_s).any(|hash| signed(hash.hex())).then(|| token.clone())
    }

    /// Ends a session before its time.
    pub(super) fn end(&self, session: &str, now_s: i64) {
        let mut parts = session.split('~').skip(1);
        let (Some(Ok(end)), Some(nonce)) = (parts.next().map(str::parse::<i64>), parts.next()) else {
            return;
        };
        let mut state = self.state();
        state.ended.retain(|_, end| *end > now_s);
        state.ended.insert(nonce.to_owned(), end);
        let kept = if state.ended.len() > MAX_ENDED {
            self.end_all(&mut state)
        } else {
            let lines = state.ended.iter().map(|(nonce, end)| format!("{nonce} {end}\n"));
            write_private(&ends_file(&self.key_file), lines.collect::<String>().as_bytes())
        };
        if let Err(error) = kept {
            tracing::warn!(
                "{}: {error}; a logout holds until the service starts again",
                self.key_file.display()
            );
        }
    }

    /// Ends every session by a new key.
    fn end_all(&self, state: &mut State) -> std::io::Result<()> {
        let key = random::<KEY_BYTES>()?;
        state.key = hmac::Key::new(hmac::HMAC_SHA256, &key);
        state.ended.clear();
        write_private(&self.key_file, &key)?;
        write_private(&ends_file(&self.key_file), b"")
    }
}

/// Where it is kept which sessions were ended by hand: a line each, its nonce and when it would have ended, Unix s.
fn ends_file(key_file: &Path) -> PathBuf {
    key_file.with_file_name("session.ended")
}

fn kept_ends(file: &Path) -> BTreeMap<String, i64> {
    let of_line = |line: &str| {
        let (nonce, end) = line.split_once(' ')?;
        Some((nonce.to_owned(), end.parse().ok()?))
    };
    let text = std::fs::read_to_string(file).unwrap_or_default();
    text.lines().filter_map(of_line).take(MAX_ENDED).collect()
}

fn kept_key(file: &Path) -> std::io::Result<[u8; KEY_BYTES]> {
    let is_private = std::fs::symlink_metadata(file).is_ok_and(|found| {
        let ours = found.is_file() && found.uid() == rustix::process::geteuid().as_raw();
        ours && found.mode() & 0o077 == 0
    });
    if is_private && let Ok(key) = <[u8; KEY_BYTES]>::try_from(std::fs::read(file)?) {
        return Ok(key);
    }
    if !is_private && file.symlink_metadata().is_ok() {
        tracing::error!("{}: others made or could read this key; a new one takes its place", file.display());
    }
    let key = random::<KEY_BYTES>()?;
    write_private(file, &key)?;
    Ok(key)
}

/// Writes a file that only this user may read, whole or not at all.
fn write_private(file: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let new = file.with_extension(format!("new{}", std::process::id()));
    match std::fs::remove_file(&new) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut written = std::fs::File::options().write(true).create_new(true).mode(0o600).open(&new)?;
    written.write_all(bytes)?;
    std::fs::rename(&new, file)
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    if text.len() > 128 || !text.len().is_multiple_of(2) {
        return None;
    }
    let digit = |byte: u8| char::from(byte).to_digit(16);
    text.as_bytes()
        .chunks_exact(2)
        .map(|pair| u8::try_from(digit(pair[0])? * 16 + digit(pair[1])?).ok())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::role::Role;
    use crate::access::tokens;
    use crate::time::unix_s;

    #[test]
    fn a_key_that_others_made_or_read_is_not_used() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("folder");
        let key = folder.path().join("session.key");
        for mode in [0o666, 0o640, 0o604] {
            std::fs::write(&key, [0; KEY_BYTES]).expect("written");
            std::fs::set_permissions(&key, std::fs::Permissions::from_mode(mode)).expect("mode");
            let used = kept_key(&key).expect("a key");
            assert_ne!(used, [0; KEY_BYTES], "{mode:o}");
            assert_eq!(std::fs::metadata(&key).expect("key").mode() & 0o777, 0o600);
            assert_eq!(kept_key(&key).expect("a key"), used, "it is kept");
        }
        let (elsewhere, link) = (folder.path().join("elsewhere"), folder.path().join("link.key"));
        std::fs::write(&elsewhere, [0; KEY_BYTES]).expect("written");
        std::os::unix::fs::symlink(&elsewhere, &link).expect("link");
        assert_ne!(kept_key(&link).expect("a key"), [0; KEY_BYTES]);
    }

    #[test]
    fn more_logouts_than_are_kept_end_every_session() {
        let folder = tempfile::tempdir().expect("folder");
        let (file, key) = (folder.path().join("t.toml"), folder.path().join("session.key"));
        tokens::add(&file, "depot", Role::Read, None).expect("add");
        let all = tokens::read(&file).expect("read");
        let sessions = Sessions::open(&key, Duration::from_secs(100)).expect("key");
        let now = unix_s();
        sessions.state().ended = (0..MAX_ENDED).map(|n| (n.to_string(), now + 50)).collect();
        let (kept, over) = (sessions.begin(&all[0], now), sessions.begin(&all[0], now));
        let (kept, over) = (kept.expect("session"), over.expect("session"));
        sessions.end(&over, now);
        for sessions in [&sessions, &Sessions::open(&key, Duration::from_secs(100)).expect("key")] {
            assert!([&kept, &over].iter().all(|one| sessions.owner(one, &all, now).is_none()));
        }
    }

    #[test]
    fn a_session_belongs_to_its_token_and_ends_with_it() {
        let folder = tempfile::tempdir().expect("folder");
        let (file, key) = (folder.path().join("t.toml"), folder.path().join("session.key"));
        tokens::add(&file, "depot", Role::Read, None).expect("add");
        tokens::add(&file, "other", Role::Admin, None).expect("add");
        let all = tokens::read(&file).expect("read");
        let sessions = Sessions::open(&key, Duration::from_secs(100)).expect("key");
        let now = unix_s();
        let cookie = sessions.begin(&all[0], now).expect("session");
        let owner = |cookie: &str, now| sessions.owner(cookie, &all, now).map(|token| token.name);
        assert_eq!(owner(&cookie, now).as_deref(), Some("depot"));
        assert_eq!(owner(&cookie, now + 101), None, "over");
        assert_eq!(owner(&cookie.replace("depot", "other"), now), None, "another name");
        let end = (now + 100).to_string();
        assert_eq!(owner(&cookie.replace(&end, &(now + 10_000).to_string()), now), None, "a later end");
        for wrong in ["", "~", "~~~", "depot~9999999999~00~", "depot~9999999999~00~zz", &format!("{cookie}~")]
        {
            assert_eq!(owner(wrong, now), None, "{wrong}");
        }
        let restarted = Sessions::open(&key, Duration::from_secs(100)).expect("key");
        assert!(restarted.owner(&cookie, &all, now).is_some(), "the key is kept");
        sessions.end(&cookie, now);
        assert_eq!(owner(&cookie, now), None, "logged out");
        let restarted = Sessions::open(&key, Duration::from_secs(100)).expect("key");
        assert!(restarted.owner(&cookie, &all, now).is_none(), "a logout outlives the service");

        let cookie = sessions.begin(&all[0], now).expect("session");
        tokens::rotate(&file, "depot", 0).expect("rotate");
        assert!(sessions.owner(&cookie, &tokens::read(&file).expect("read"), now).is_none(), "rotated");
    }
}
