//! The train's HTTP service, seen by a client.

use std::time::Duration;

use serde_json::Value;

/// A client of one service.
#[derive(Debug, Clone)]
pub struct Http {
    base: String,
    agent: ureq::Agent,
}

impl Http {
    /// A client of the service at `address`, for example `127.0.0.1:8080`.
    #[must_use]
    pub fn new(address: &str) -> Self {
        let config = ureq::Agent::config_builder()
            .timeout_global(Some(Duration::from_secs(5)))
            .http_status_as_error(false)
            .build();
        Self { base: format!("http://{address}"), agent: config.into() }
    }

    /// Status and text of a page; `None` if nobody answers.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<(u16, String)> {
        let mut answer = self.agent.get(format!("{}{path}", self.base)).call().ok()?;
        let status = answer.status().as_u16();
        Some((status, answer.body_mut().read_to_string().ok()?))
    }

    /// The JSON of a page that answers 200.
    #[must_use]
    pub fn json(&self, path: &str) -> Option<Value> {
        let (status, text) = self.get(path)?;
        if status == 200 { serde_json::from_str(&text).ok() } else { None }
    }

    /// True if the service says that all wagons are live.
    #[must_use]
    pub fn ready(&self) -> bool {
        self.get("/health/ready").is_some_and(|(status, _)| status == 200)
    }
}
