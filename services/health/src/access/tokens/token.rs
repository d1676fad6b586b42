//! A token, and the file that keeps tokens.

use crate::access::error::AccessError;
use crate::access::role::Role;
use crate::time::{parse_rfc3339, rfc3339_s};
use ring::digest::{SHA256, digest};
use ring::rand::{SecureRandom, SystemRandom};
use serde::{Deserialize, Serialize};
use std::fs::Metadata;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// What every token begins with, so that people and scanners know one when they see it.
pub const PREFIX: &str = "railgrip_";
pub(super) const SECRET_BYTES: usize = 32;
/// Most tokens of one file; each request with a token is compared with all of them.
pub(super) const MAX_TOKENS: usize = 1000;

/// A token as the file keeps it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token {
    /// Who or what it stands for.
    pub name: String,
    /// What its owner may do.
    pub role: Role,
    /// Unix time at which it was made, s.
    pub created_s: i64,
    /// Unix time at which it ends, s.
    pub expires_s: Option<i64>,
    /// The secret before the last rotation, while it still counts.
    pub(super) previous: Option<(Hash, i64)>,
    pub(super) hash: Hash,
}

/// SHA-256 of a secret.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Hash(pub(super) [u8; SECRET_BYTES]);

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileForm {
    schema: u32,
    #[serde(default)]
    token: Vec<TokenForm>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenForm {
    name: String,
    role: Role,
    sha256: String,
    created: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    expires: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    previous_sha256: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    previous_until: Option<String>,
}

impl Token {
    /// True if it lets somebody in at that Unix time.
    #[must_use]
    pub fn usable(&self, now_s: i64) -> bool {
        self.expires_s.is_none_or(|end| now_s < end)
    }

    /// Hashes that count now: the current one and, for a while after a rotation, the one before.
    pub(crate) fn hashes(&self, now_s: i64) -> impl Iterator<Item = Hash> {
        let previous = self.previous.filter(|(_, until)| now_s < *until).map(|(hash, _)| hash);
        std::iter::once(self.hash).chain(previous).take(if self.usable(now_s) { 2 } else { 0 })
    }
}

impl Hash {
    pub(super) fn of(secret: &str) -> Self {
        let mut hash = [0; SECRET_BYTES];
        hash.copy_from_slice(digest(&SHA256, secret.as_bytes()).as_ref());
        Self(hash)
    }

    fn parse(text: &str) -> Option<Self> {
        let mut hash = [0; SECRET_BYTES];
        let digits = text.as_bytes();
        if digits.len() != 2 * SECRET_BYTES {
            return None;
        }
        for (byte, pair) in hash.iter_mut().zip(digits.chunks_exact(2)) {
            let digit = |at: usize| char::from(pair[at]).to_digit(16);
            *byte = u8::try_from(digit(0)? * 16 + digit(1)?).ok()?;
        }
        Some(Self(hash))
    }

    /// As digits, for the file and for signatures.
    pub(crate) fn hex(self) -> String {
        hex(&self.0)
    }
}

/// Bytes as hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Random bytes of the system.
pub(crate) fn random<const N: usize>() -> std::io::Result<[u8; N]> {
    let mut bytes = [0; N];
    let failed = |_| std::io::Error::other("the system gives no random numbers");
    SystemRandom::new().fill(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Reads a token file; one that does not exist holds no token.
///
/// # Errors
/// A file that cannot be read, that others may write, or that is not a token file; the message names line or token.
pub fn read(file: &Path) -> Result<Vec<Token>, AccessError> {
    let failed = |source| AccessError::File { file: file.to_owned(), source };
    match std::fs::metadata(file) {
        Ok(metadata) => check_mode(file, &metadata)?,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(failed(error)),
    }
    parse(file, &std::fs::read_to_string(file).map_err(failed)?)
}

/// Whoever may write the file may let anybody in.
fn check_mode(file: &Path, metadata: &Metadata) -> Result<(), AccessError> {
    if metadata.mode() & 0o022 == 0 {
        return Ok(());
    }
    let problem =
        format!("mode is {:o}; others than its owner may write it: chmod 600", metadata.mode() & 0o777);
    Err(AccessError::Tokens { file: file.to_owned(), problem })
}

/// Parses the text of a token file; `file` is for messages only.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &Path, text: &str) -> Result<Vec<Token>, AccessError> {
    let wrong = |problem: String| AccessError::Tokens { file: file.to_owned(), problem };
    let form: FileForm = toml::from_str(text).map_err(|error| {
        let offset = text.floor_char_boundary(error.span().map_or(0, |span| span.start));
        let line = text[..offset].matches('\n').count() + 1;
        wrong(format!("line {line}: {}", error.message().replace('\n', "; ")))
    })?;
    if form.schema != 1 {
        return Err(wrong(format!("`schema` is {}, allowed is 1", form.schema)));
    }
    if form.token.len() > MAX_TOKENS {
        return Err(wrong(format!("{} tokens, allowed is {MAX_TOKENS}", form.token.len())));
    }
    let mut tokens: Vec<Token> = Vec::with_capacity(form.token.len());
    for (index, form) in form.token.into_iter().enumerate() {
        let token = checked(form).map_err(|problem| wrong(format!("token {}: {problem}", index + 1)))?;
        if tokens.iter().any(|other| other.name == token.name) {
            return Err(wrong(format!("token {}: there are two of the name \"{}\"", index + 1, token.name)));
        }
        tokens.push(token);
    }
    Ok(tokens)
}

fn checked(form: TokenForm) -> Result<Token, String> {
    check_name(&form.name)?;
    let instant = |key: &str, text: &str| {
        parse_rfc3339(text).map(|s| s as i64).ok_or_else(|| {
            format!("`{key}` is \"{text}\", allowed is an instant such as 2026-03-01T12:00:00Z")
        })
    };
    let hash = |key: &str, text: &str| {
        Hash::parse(text).ok_or_else(|| format!("`{key}` is not the 64 hexadecimal digits of a SHA-256"))
    };
    let previous = match (&form.previous_sha256, &form.previous_until) {
        (None, None) => None,
        (Some(old), Some(until)) => Some((hash("previous_sha256", old)?, instant("previous_until", until)?)),
        _ => return Err("`previous_sha256` and `previous_until` go together".to_owned()),
    };
    Ok(Token {
        role: form.role,
        created_s: instant("created", &form.created)?,
        expires_s: form.expires.as_deref().map(|text| instant("expires", text)).transpose()?,
        previous,
        hash: hash("sha256", &form.sha256)?,
        name: form.name,
    })
}

/// A name that is fit for logs and cookies.
pub(super) fn check_name(name: &str) -> Result<(), String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if (1..=64).contains(&name.len()) && name.chars().all(plain) && !matches!(name, "local" | "anyone") {
        return Ok(());
    }
    Err(format!(
        "name \"{}\": allowed are 1 to 64 letters, digits, `-`, `_`, `.`; not `local`, not `anyone`",
        name.escape_debug()
    ))
}

pub(super) fn text(tokens: &[Token]) -> String {
    let instant = rfc3339_s;
    let forms = tokens.iter().map(|token| TokenForm {
        name: token.name.clone(),
        role: token.role,
        sha256: token.hash.hex(),
        created: instant(token.created_s),
        expires: token.expires_s.map(instant),
        previous_sha256: token.previous.map(|(hash, _)| hash.hex()),
        previous_until: token.previous.map(|(_, until)| instant(until)),
    });
    toml::to_string(&FileForm { schema: 1, token: forms.collect() }).unwrap_or_default()
}
