//! Joins core and the client of the sonars' payload controller, which know nothing of each other.
//!
//! A [`Bridge`] holds the client. A driver hands in what core wants of the sonars ([`Bridge::tell`]) and what happens on
//! the connection ([`Bridge::handle`]), and carries out what [`Bridge::poll`] returns: bytes for the controller, and
//! reports for core. In simulation it does so between two events; at sea on a thread of its own. Like both sides, the
//! bridge does no I/O and reads no clock.

mod bridge;
mod from_client;
mod settings;
mod to_client;

pub use bridge::{Act, Bridge, PINGS_PER_S_MAX, PluginPing};
pub use settings::SonarSettings;
