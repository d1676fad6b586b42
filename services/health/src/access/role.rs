//! Roles, and which route asks for which.
//!
//! | route | role | why |
//! | --- | --- | --- |
//! | `/health/live`, `/health/ready` | none | a supervisor or load balancer holds no secret; without one the answer is a status, no reasons |
//! | `/login`, `/logout`, `/login.css` | none | where a browser trades a token for a session |
//! | every other GET, `/metrics` and `/openapi.json` included | read | figures of the train's operation; Prometheus sends a token (`authorization.credentials_file`) |
//! | anything but GET below `/api/v1/alerts/`, and notes on a wagon | acknowledge | changes what other people see |
//! | `/api/v1/audit`, and whatever else changes something | admin | |

use axum::http::{HeaderMap, Method, header};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What somebody may do; each role includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Look.
    Read,
    /// Look, acknowledge and silence alerts.
    Acknowledge,
    /// Everything.
    Admin,
}

impl Role {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Read, Self::Acknowledge, Self::Admin];

    /// Its name.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Acknowledge => "acknowledge",
            Self::Admin => "admin",
        }
    }
}

/// Who asks; handlers find it among the extensions of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Name of the token; `local` for the user that runs the service, `anyone` where no tokens are asked for.
    pub name: Arc<str>,
    /// What they may do.
    pub role: Role,
    /// How they showed who they are.
    pub by: Proof,
}

impl Identity {
    /// The name, where a token or session vouches for it: nobody then acts in another's name.
    #[must_use]
    pub fn vouched_name(&self) -> Option<&str> {
        matches!(self.by, Proof::Token | Proof::Session).then_some(&*self.name)
    }

    /// The name that is vouched for, and in brackets who says to be sitting there: a token may stand for a whole workshop.
    #[must_use]
    pub fn signature(&self, said: Option<&str>) -> Option<String> {
        let name = self.vouched_name()?;
        let said = said.map(str::trim).filter(|said| !said.is_empty() && *said != name);
        Some(said.map_or_else(|| name.to_owned(), |said| format!("{name} ({said})")))
    }
}

/// How somebody showed who they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Proof {
    /// Not at all: no tokens are asked for.
    None,
    /// By the folder that holds the local socket.
    Local,
    /// By a token in the `Authorization` header.
    Token,
    /// By the cookie of a session.
    Session,
}

/// The role that a request needs; `None` where nothing is asked.
pub(super) fn needed(method: &Method, path: &str, headers: &HeaderMap) -> Option<Role> {
    match path {
        "/health/live" | "/health/ready" | "/login" | "/logout" | "/login.css" => return None,
        "/api/v1/audit" => return Some(Role::Admin),
        _ => {}
    }
    // A browser's question whether it may ask carries no token; it is answered with headers only.
    if method == Method::OPTIONS && headers.contains_key(header::ACCESS_CONTROL_REQUEST_METHOD) {
        return None;
    }
    if is_safe(method) {
        Some(Role::Read)
    } else if path.starts_with("/api/v1/alerts/") || is_note(path) {
        Some(Role::Acknowledge)
    } else {
        Some(Role::Admin)
    }
}

/// Whether a path is that of the notes on a wagon.
fn is_note(path: &str) -> bool {
    path.strip_prefix("/api/v1/wagons/")
        .and_then(|rest| rest.strip_suffix("/notes"))
        .is_some_and(|id| !id.contains('/'))
}

/// True if the method changes nothing.
pub(super) fn is_safe(method: &Method) -> bool {
    matches!(*method, Method::GET | Method::HEAD | Method::OPTIONS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_route_asks_for_its_role() {
        let none = HeaderMap::new();
        for (method, path, role) in [
            (Method::GET, "/health/live", None),
            (Method::POST, "/login", None),
            (Method::GET, "/", Some(Role::Read)),
            (Method::GET, "/metrics", Some(Role::Read)),
            (Method::GET, "/api/v1/alerts/3", Some(Role::Read)),
            (Method::POST, "/api/v1/alerts/3/acknowledge", Some(Role::Acknowledge)),
            (Method::DELETE, "/api/v1/alerts/3/silence", Some(Role::Acknowledge)),
            (Method::POST, "/api/v1/alerts", Some(Role::Admin)),
            (Method::POST, "/api/v1/wagons/3/notes", Some(Role::Acknowledge)),
            (Method::GET, "/api/v1/wagons/3/notes", Some(Role::Read)),
            (Method::POST, "/api/v1/wagons/3/x/notes", Some(Role::Admin)),
            (Method::PUT, "/", Some(Role::Admin)),
            (Method::GET, "/api/v1/audit", Some(Role::Admin)),
            (Method::OPTIONS, "/api/v1/wagons", Some(Role::Read)),
            (Method::GET, "/health/live/", Some(Role::Read)),
        ] {
            assert_eq!(needed(&method, path, &none), role, "{method} {path}");
        }
        assert!(Role::Read < Role::Acknowledge && Role::Acknowledge < Role::Admin);
    }
}
