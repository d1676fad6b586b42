//! Changes of the token file: each replaces it whole, one after the other.

use super::token::{Hash, MAX_TOKENS, PREFIX, SECRET_BYTES, Token, check_name, hex, random, read, text};
use crate::access::error::AccessError;
use crate::access::role::Role;
use crate::time::unix_s;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// Makes a token and returns its secret, which nobody can look up later.
///
/// # Errors
/// A name that is taken or not allowed; a file that cannot be read or written.
pub fn add(file: &Path, name: &str, role: Role, expires_s: Option<i64>) -> Result<String, AccessError> {
    let wrong = |problem: String| AccessError::Tokens { file: file.to_owned(), problem };
    check_name(name).map_err(wrong)?;
    change(file, |tokens| {
        if tokens.iter().any(|token| token.name == name) {
            return Err(wrong(format!(
                "there is a token \"{name}\" already; `token rotate` renews its secret"
            )));
        }
        if tokens.len() >= MAX_TOKENS {
            return Err(wrong(format!("holds {MAX_TOKENS} tokens already, more are not allowed")));
        }
        let (secret, hash) = secret(file)?;
        let name = name.to_owned();
        tokens.push(Token { name, role, created_s: unix_s(), expires_s, previous: None, hash });
        Ok(secret)
    })
}

/// Ends a token.
///
/// # Errors
/// No such token; a file that cannot be read or written.
pub fn revoke(file: &Path, name: &str) -> Result<(), AccessError> {
    change(file, |tokens| {
        let at = find(file, tokens, name)?;
        tokens.remove(at);
        Ok(())
    })
}

/// Gives a token a new secret; the old one counts for `overlap_s` seconds more.
///
/// # Errors
/// No such token; a file that cannot be read or written.
pub fn rotate(file: &Path, name: &str, overlap_s: i64) -> Result<String, AccessError> {
    change(file, |tokens| {
        let at = find(file, tokens, name)?;
        let (secret, hash) = secret(file)?;
        let token = &mut tokens[at];
        token.previous = (overlap_s > 0).then_some((token.hash, unix_s().saturating_add(overlap_s)));
        token.hash = hash;
        Ok(secret)
    })
}

fn find(file: &Path, tokens: &[Token], name: &str) -> Result<usize, AccessError> {
    tokens.iter().position(|token| token.name == name).ok_or_else(|| {
        let names: Vec<&str> = tokens.iter().map(|token| token.name.as_str()).collect();
        let there = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let problem = format!("there is no token \"{}\"; there is {there}", name.escape_debug());
        AccessError::Tokens { file: file.to_owned(), problem }
    })
}

fn secret(file: &Path) -> Result<(String, Hash), AccessError> {
    let bytes =
        random::<SECRET_BYTES>().map_err(|source| AccessError::File { file: file.to_owned(), source })?;
    let secret = format!("{PREFIX}{}", hex(&bytes));
    let hash = Hash::of(&secret);
    Ok((secret, hash))
}

/// Reads, changes and replaces the file while nobody else does. A reader sees the old file or the new one.
fn change<T>(
    file: &Path,
    edit: impl FnOnce(&mut Vec<Token>) -> Result<T, AccessError>,
) -> Result<T, AccessError> {
    let failed = |file: &Path| {
        let file = file.to_owned();
        move |source| AccessError::File { file, source }
    };
    if let Some(folder) = file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
    }
    let lock_path = beside(file, ".lock");
    let lock = private().create(true).truncate(false).open(&lock_path).map_err(failed(&lock_path))?;
    lock.lock().map_err(failed(&lock_path))?;
    let mut tokens = read(file)?;
    let result = edit(&mut tokens)?;
    let new = beside(file, ".new");
    let _ = std::fs::remove_file(&new);
    let mut written = private().create_new(true).open(&new).map_err(failed(&new))?;
    let text = format!(
        "# Tokens of railgrip's HTTP service, as SHA-256. Made by `railgrip token`; read again when this file changes.\n{}",
        text(&tokens)
    );
    written.write_all(text.as_bytes()).and_then(|()| written.sync_all()).map_err(failed(&new))?;
    keep_owner(file, &written);
    std::fs::rename(&new, file).map_err(failed(file))?;
    Ok(result)
}

/// Root may change a file that the service's user must still read afterwards.
fn keep_owner(old: &Path, new: &File) {
    if let Ok(old) = std::fs::metadata(old)
        && let Err(error) = std::os::unix::fs::fchown(new, Some(old.uid()), Some(old.gid()))
    {
        tracing::debug!(%error, "the owner of the token file changes");
    }
}

fn private() -> OpenOptions {
    let mut options = File::options();
    options.write(true).mode(0o600);
    options
}

fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    file.with_file_name(name)
}
