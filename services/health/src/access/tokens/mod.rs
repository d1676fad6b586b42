//! Tokens: 256 random bits each, kept as SHA-256 in a TOML file that only its owner may write.
//!
//! A slow hash such as argon2 protects secrets that people choose, because those can be guessed. 256 random bits cannot:
//! trying 10¹² a second would take 10⁵⁷ years. A fast hash is as safe here, and a request with a wrong token costs the
//! service half a microsecond instead of a tenth of a second, which anybody could use to stop it. Comparisons take the
//! same time wherever two hashes differ.
//!
//! The file is read again within a second when it changes. A file that is gone lets nobody in any more; one that cannot
//! be understood (half written by an editor) leaves the tokens that were known before.

mod book;
mod edit;
#[cfg(test)]
mod tests;
mod token;

pub(in crate::access) use book::TokenBook;
pub use edit::{add, revoke, rotate};
pub use token::{PREFIX, Token, parse, read};
pub(in crate::access) use token::{hex, random};
