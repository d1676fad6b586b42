//! The host in an address, and whether it is this machine: a secret for another one needs TLS.

use crate::access::is_loopback;

/// What is before `@` and after it in a URL that follows its scheme: user and password, then host and port.
pub(super) fn authority(rest: &str) -> (Option<&str>, &str) {
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    authority.rsplit_once('@').map_or((None, authority), |(login, host)| (Some(login), host))
}

/// The host of what follows the scheme of a URL.
pub(super) fn host(rest: &str) -> &str {
    let (_, host) = authority(rest);
    match host.strip_prefix('[') {
        Some(bracketed) => bracketed.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    }
}

/// True for names and addresses of loopback.
pub(crate) fn is_this_machine(host: &str) -> bool {
    host.eq_ignore_ascii_case("localhost") || host.parse().is_ok_and(is_loopback)
}
