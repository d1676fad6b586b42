//! What tests on withheld answers share: seals, hashes of folders, files, and work on several threads.

pub(crate) mod digest;
pub(crate) mod files;
pub(crate) mod parallel;
pub(crate) mod seal;
