//! The tokens of a running service.

use super::token::{Hash, PREFIX, Token, read};
use crate::access::error::AccessError;
use crate::time::unix_s;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use subtle::ConstantTimeEq;

/// What tells whether a file is another than before.
type Mark = (i64, i64, u64, u64);

/// The tokens that count now, renewed when their file changes.
pub(in crate::access) struct TokenBook {
    file: PathBuf,
    tokens: RwLock<Arc<Vec<Token>>>,
    seen: Mutex<Option<Mark>>,
    generation: AtomicU64,
}

impl TokenBook {
    pub(in crate::access) fn open(file: &Path) -> Result<Self, AccessError> {
        let seen = mark(file);
        let tokens = read(file)?;
        if !tokens.iter().any(|token| token.usable(unix_s())) {
            tracing::error!("{} holds no token that is valid: nobody can come in", file.display());
        }
        Ok(Self {
            file: file.to_owned(),
            tokens: RwLock::new(Arc::new(tokens)),
            seen: Mutex::new(seen),
            generation: AtomicU64::new(0),
        })
    }

    /// Reads the file again if it is another; says what came of it.
    pub(in crate::access) fn look(&self) -> Option<String> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let now = mark(&self.file);
        if *seen == now {
            return None;
        }
        *seen = now;
        Some(match read(&self.file) {
            Ok(tokens) => {
                let count = tokens.len();
                tracing::info!("{}: {count} tokens", self.file.display());
                *self.tokens.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(tokens);
                self.generation.fetch_add(1, Ordering::Release);
                format!("{count} tokens")
            }
            Err(error) => {
                tracing::error!("{error}; the tokens known before still count");
                format!("refused: {error}")
            }
        })
    }

    /// Counts how often the tokens changed.
    pub(in crate::access) fn generation(&self) -> u64 {
        self.generation.load(Ordering::Acquire)
    }

    pub(in crate::access) fn all(&self) -> Arc<Vec<Token>> {
        Arc::clone(&self.tokens.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// The token of that secret.
    pub(in crate::access) fn of_secret(&self, secret: &str, now_s: i64) -> Option<Token> {
        if !secret.starts_with(PREFIX) {
            return None;
        }
        let presented = Hash::of(secret);
        let tokens = self.all();
        let mut found = None;
        for token in tokens.iter() {
            for hash in token.hashes(now_s) {
                if bool::from(hash.0.ct_eq(&presented.0)) {
                    found = Some(token);
                }
            }
        }
        found.cloned()
    }
}

fn mark(file: &Path) -> Option<Mark> {
    let metadata = std::fs::metadata(file).ok()?;
    Some((metadata.mtime(), metadata.mtime_nsec(), metadata.ino(), metadata.len()))
}
