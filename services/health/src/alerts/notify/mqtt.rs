//! Notifications to an MQTT broker, with quality of service 1: each is confirmed before the next.

use super::notifier::{ANSWER, Notifier, Outcome};
use crate::alerts::nflog::Queued;
use railgrip_settings::MqttSettings;
use rumqttc::{Client, Connection, Event, MqttOptions, Packet, QoS, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Time between two signs of life of an idle connection.
const KEEP_ALIVE: Duration = Duration::from_secs(30);
/// Largest notification, bytes.
const LARGEST: usize = 1 << 20;

/// The way to a broker.
pub(super) struct Mqtt {
    settings: MqttSettings,
    train: String,
    connection: Option<(Client, Connection)>,
    used: Instant,
}

impl Mqtt {
    pub fn new(settings: MqttSettings, train: String) -> Self {
        Self { settings, train, connection: None, used: Instant::now() }
    }

    fn connect(&self) -> Result<(Client, Connection), String> {
        let settings = &self.settings;
        let mut options = MqttOptions::new(&settings.client_id, &settings.host, settings.port);
        options.set_keep_alive(KEEP_ALIVE);
        options.set_clean_session(true);
        options.set_max_packet_size(LARGEST, LARGEST);
        if let Some(user) = &settings.user {
            let password = match &settings.password_file {
                Some(file) => {
                    std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?
                }
                None => String::new(),
            };
            options.set_credentials(user, password.trim());
        }
        Ok(Client::new(options, 10))
    }

    /// Publishes and waits for the broker's confirmation.
    fn publish(&mut self, notification: &Queued) -> Result<(), String> {
        let topic = self
            .settings
            .topic
            .replace("{train}", &self.train)
            .replace("{id}", &notification.alert.to_string());
        // The broker has cut an idle connection that nobody looked after.
        let fresh = self.connection.take().filter(|_| self.used.elapsed() < KEEP_ALIVE / 2);
        let (client, mut connection) = match fresh {
            Some(connection) => connection,
            None => self.connect()?,
        };
        client
            .publish(topic, QoS::AtLeastOnce, self.settings.retain, notification.body.as_bytes())
            .map_err(|error| error.to_string())?;
        let until = Instant::now() + ANSWER;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match connection.recv_timeout(left) {
                Ok(Ok(Event::Incoming(Packet::PubAck(_)))) => {
                    self.connection = Some((client, connection));
                    self.used = Instant::now();
                    return Ok(());
                }
                Ok(Ok(_)) => {}
                Ok(Err(error)) => return Err(error.to_string()),
                Err(RecvTimeoutError::Timeout) => return Err("the broker did not confirm in time".to_owned()),
                Err(RecvTimeoutError::Disconnected) => return Err("the connection has ended".to_owned()),
            }
        }
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
