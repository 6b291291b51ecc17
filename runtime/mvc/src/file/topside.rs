use backseat_spi::Transport;
use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[topside]` section: text to and from the topside (SPI 5.5, 7.3, 7.14).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TopsideConfig {
    /// Whether the vehicle accepts BPTMR ("not available on most vehicles").
    pub relay: bool,
    /// How many messages may wait for their delivery, 1 to 1000. A BPTOP beyond that fails.
    pub queue_max: u32,
    /// The link that carries messages at the surface.
    pub surfaced: Transport,
    /// The link that carries messages under water. In silent mode the acoustic modem sends nothing.
    pub submerged: Transport,
    /// How long the delivery of one message takes, seconds, 0 to 3600.
    pub delivery_s: f64,
    /// The messages from the topside to the payload, in order of time.
    pub messages: Vec<TopsideEntry>,
}

/// A message from the topside.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TopsideEntry {
    /// When it arrives, seconds after the start.
    pub at_s: f64,
    /// The link that it comes by.
    pub transport: Transport,
    /// Its text: 1 to 200 printable ASCII characters without comma, asterisk and dollar.
    pub text: String,
    /// The role of the client that gets it (SPI 4.1); `None` for every client.
    #[serde(default)]
    pub role: Option<String>,
}

impl Default for TopsideConfig {
    fn default() -> Self {
        Self {
            relay: true,
            queue_max: 16,
            surfaced: Transport::RfModem,
            submerged: Transport::AcousticModem,
            delivery_s: 2.0,
            messages: Vec::new(),
        }
    }
}

impl TopsideConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        let queue = f64::from(self.queue_max);
        check((1.0..=1000.0).contains(&queue), "topside.queue_max", queue, "1 to 1000")?;
        let delivery = self.delivery_s;
        check(
            (0.0..=3600.0).contains(&delivery),
            "topside.delivery_s",
            delivery,
            "0 to 3600 s",
        )?;
        let links = [
            ("topside.surfaced", self.surfaced),
            ("topside.submerged", self.submerged),
        ];
        let entries = self
            .messages
            .iter()
            .map(|entry| ("topside.messages.transport", entry.transport));
        for (key, transport) in links.into_iter().chain(entries) {
            let known = !matches!(transport, Transport::Other(_));
            check(
                known,
                key,
                f64::from(transport.code()),
                "a transport of the specification",
            )?;
        }
        for entry in &self.messages {
            let texts = [
                ("topside.messages.text", Some(&entry.text)),
                ("topside.messages.role", entry.role.as_ref()),
            ];
            for (key, text) in texts {
                if let Some(text) = text
                    && (text.is_empty() || text.len() > 200 || backseat_spi::Text::new(text).is_err())
                {
                    let expected = "1 to 200 printable ascii characters without comma, asterisk and dollar";
                    let value = format!("{text:?}");
                    return Err(MvcError::Value { key, value, expected });
                }
            }
        }
        let times: Vec<f64> = self.messages.iter().map(|entry| entry.at_s).collect();
        super::ordered_times("topside.messages.at_s", &times)
    }
}
