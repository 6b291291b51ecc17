//! What passes between core and the client of the sonars' payload controller. The driver runs the client beside core,
//! and converts: core knows nothing of the 7k format.

use backseat_units::Timestamp;
use serde::{Deserialize, Serialize};

use crate::plugin::{NavigationSample, PluginId, SonarEvent, SonarPing, SonarSetting};
use crate::settings::StatusCondition;

/// What the client reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FromSonar {
    /// A ping for a plugin.
    Ping(PluginId, SonarPing),
    /// Something for the plugins that asked for it.
    Event(SonarEvent),
    /// A request has ended.
    Outcome {
        /// Its number in the ledger.
        request: u64,
        /// How.
        outcome: SonarOutcome,
    },
    /// The state of the sonars, for BPSTS (SPI 7.2).
    Status {
        /// In words, at most 80 characters.
        text: String,
        /// What counts as a fault of the payload, if the mission lists it: of [`StatusCondition`] those of the sonar.
        conditions: Vec<StatusCondition>,
    },
    /// A line for the log.
    Line(String),
}

/// How a request ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SonarOutcome {
    /// The controller has accepted it.
    Accepted,
    /// It was sent, and by the mission's own setting the controller does not acknowledge anything.
    Unconfirmed,
    /// The controller or the client refused it, or not all of it was done: in words.
    Failed(String),
    /// It was not answered, or could not be sent in time.
    TimedOut,
    /// The connection was lost before the answer.
    Lost,
}

/// What the client is asked to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToSonar {
    /// Carry out a request, and report its outcome.
    Order {
        /// Its number in the ledger.
        request: u64,
        /// What to do.
        order: SonarOrder,
    },
    /// The vehicle wants data logged, or no longer (BFBDL, BFSDL, SPI 5.3, 5.4).
    VehicleLogs(bool),
    /// The power will be cut (BFSHT, SPI 5.2): shut the controller down.
    Shutdown,
    /// A navigation solution of the vehicle (BFNVG, SPI 6.1).
    Navigation(NavigationSample, Option<SonarRates>),
    /// A speed of sound that the vehicle told (BFSVS, SPI 6.4).
    SoundSpeed {
        /// When it was measured, on our clock.
        measured: Timestamp,
        /// Metres per second.
        sound_speed_mps: f64,
    },
}

/// What a request asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SonarOrder {
    /// Change a setting of a sensor.
    Set {
        /// The sensor's index in the payload controller.
        sensor: i32,
        /// What to change.
        setting: SonarSetting,
    },
    /// Switch logging.
    Log {
        /// On or off.
        on: bool,
        /// The name of the file.
        file: Option<String>,
    },
}

/// The vehicle's velocities and rates at the time of a solution (BFNVR, SPI 6.2).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarRates {
    /// Degrees per second.
    pub roll_rate_dps: f64,
    /// Degrees per second.
    pub pitch_rate_dps: f64,
}
