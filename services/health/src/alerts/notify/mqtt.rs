//! Notifications to an MQTT broker, with quality of service 1: each is confirmed before the next.

use super::notifier::{ANSWER, Notifier, Outcome};
use crate::alerts::nflog::Queued;
use railgrip_mqtt::{Authorities, Broker, Connection, MqttError};
use railgrip_settings::MqttSettings;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Time between two signs of life of an idle connection.
const KEEP_ALIVE: Duration = Duration::from_secs(30);

/// The way to a broker.
pub(super) struct Mqtt {
    settings: MqttSettings,
    train: String,
    stop: Arc<AtomicBool>,
    connection: Option<Connection>,
    used: Instant,
}

impl Mqtt {
    /// An attempt ends soon after `stop` is set.
    pub fn new(settings: MqttSettings, train: String, stop: Arc<AtomicBool>) -> Self {
        Self { settings, train, stop, connection: None, used: Instant::now() }
    }

    fn connect(&self, until: Instant) -> Result<Connection, MqttError> {
        let settings = &self.settings;
        let broker = Broker {
            host: &settings.host,
            port: settings.port,
            client_id: &settings.client_id,
            user: settings.user.as_deref(),
            password_file: settings.password_file.as_deref(),
            tls: settings.tls.as_ref().map(|tls| Authorities::of(tls.ca_file.as_deref())),
        };
        Connection::open(&broker, KEEP_ALIVE, until, &self.stop)
    }

    /// Publishes and waits for the broker's confirmation.
    fn publish(&mut self, notification: &Queued) -> Result<(), MqttError> {
        let topic = self
            .settings
            .topic
            .replace("{train}", &self.train)
            .replace("{id}", &notification.alert.to_string());
        // Connecting and confirming share the time of an answer.
        let until = Instant::now() + ANSWER;
        // The broker has cut an idle connection that nobody looked after.
        let fresh = self.connection.take().filter(|_| self.used.elapsed() < KEEP_ALIVE / 2);
        let mut connection = match fresh {
            Some(connection) => connection,
            None => self.connect(until)?,
        };
        connection.publish(&topic, notification.body.as_bytes(), self.settings.retain, until)?;
        self.connection = Some(connection);
        self.used = Instant::now();
        Ok(())
    }
}

impl Notifier for Mqtt {
    fn notify(&mut self, notification: &Queued) -> Outcome {
        match self.publish(notification) {
            Ok(()) => Outcome::Confirmed,
            Err(said) => {
                Outcome::Later(format!("mqtt {}:{}: {said}", self.settings.host, self.settings.port))
            }
        }
    }
}
