//! Sessions of browsers: a cookie that names a token and an end, signed with a key of this machine.
//!
//! Nothing is kept per session, so a session survives a restart of the service; it ends with its time, with its token
//! (revoked, expired, or rotated and the overlap over), and when its owner logs out. The key lies in the folder of the
//! running train, readable by the service's user only; it is made when there is none.

use crate::access::tokens::{Token, hex, random};
use ring::hmac;
use std::collections::HashMap;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

const KEY_BYTES: usize = 32;
/// Sessions that were ended by hand and would still be valid; beyond that the oldest are forgotten.
const MAX_ENDED: usize = 4096;

/// Makes and checks sessions.
pub(super) struct Sessions {
    key: hmac::Key,
    lasts: Duration,
    ended: Mutex<HashMap<String, i64>>,
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
        Ok(Self { key: hmac::Key::new(hmac::HMAC_SHA256, &key), lasts, ended: Mutex::default() })
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
        let signature = hmac::sign(&self.key, format!("{said}~{}", hash.hex()).as_bytes());
        Some(format!("{said}~{}", hex(signature.as_ref())))
    }

    /// The token whose owner this session belongs to.
    pub(super) fn owner(&self, session: &str, tokens: &[Token], now_s: i64) -> Option<Token> {
        let mut parts = session.split('~');
        let (name, end, nonce, signature) = (parts.next()?, parts.next()?, parts.next()?, parts.next()?);
        if parts.next().is_some() || end.parse::<i64>().ok()? <= now_s || self.has_ended(nonce) {
            return None;
        }
        let signature = unhex(signature)?;
        let token = tokens.iter().find(|token| token.name == name)?;
        let signed = |hash: String| {
            let said = format!("{name}~{end}~{nonce}~{hash}");
            hmac::verify(&self.key, said.as_bytes(), &signature).is_ok()
        };
        token.hashes(now_s).any(|hash| signed(hash.hex())).then(|| token.clone())
    }

    /// Ends a session before its time.
    pub(super) fn end(&self, session: &str, now_s: i64) {
        let mut parts = session.split('~').skip(1);
        let (Some(Ok(end)), Some(nonce)) = (parts.next().map(str::parse::<i64>), parts.next()) else {
            return;
        };
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        ended.retain(|_, end| *end > now_s);
        if ended.len() >= MAX_ENDED
            && let Some(first) = ended.iter().min_by_key(|(_, end)| **end).map(|(nonce, _)| nonce.clone())
        {
            ended.remove(&first);
        }
        ended.insert(nonce.to_owned(), end);
    }

    fn has_ended(&self, nonce: &str) -> bool {
        self.ended.lock().unwrap_or_else(PoisonError::into_inner).contains_key(nonce)
    }
}

fn kept_key(file: &Path) -> std::io::Result<[u8; KEY_BYTES]> {
    let read = || std::fs::read(file).ok().and_then(|bytes| <[u8; KEY_BYTES]>::try_from(bytes).ok());
    if let Some(key) = read() {
        return Ok(key);
    }
    let key = random::<KEY_BYTES>()?;
    let new = file.with_extension(format!("new{}", std::process::id()));
    let mut options = std::fs::File::options();
    let mut written = options.write(true).create(true).truncate(true).mode(0o600).open(&new)?;
    written.write_all(&key)?;
    std::fs::rename(&new, file)?;
    Ok(key)
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

        let cookie = sessions.begin(&all[0], now).expect("session");
        tokens::rotate(&file, "depot", 0).expect("rotate");
        assert!(sessions.owner(&cookie, &tokens::read(&file).expect("read"), now).is_none(), "rotated");
    }
}
