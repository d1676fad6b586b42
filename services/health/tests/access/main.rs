//! Access with real sockets: TLS, tokens and roles, rotation, limits, slow clients, pages elsewhere, the audit log.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and prints"
)]

mod elsewhere;
mod encrypted;
mod limits;
mod service;
mod tokens;
