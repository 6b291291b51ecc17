//! The client of the sonar's payload controller (PLC, RESON 6046): a state machine beside core, without I/O.
//!
//! It follows the grammar of core: a driver passes each event and its time to [`Sonar::handle`], drains
//! [`Sonar::poll_output`], and calls again no later than [`Sonar::poll_timeout`].
//!
//! ```text
//! loop {
//!     sonar.handle(now, input);
//!     while let Some(output) = sonar.poll_output() { carry_out(output) }
//!     input = whichever_is_first(what_happens(), sonar.poll_timeout());
//! }
//! ```
//!
//! At sea this loop has a thread of its own with bounded queues to core's loop, so nothing that the controller does can
//! delay core. The crate reads no clock and opens no socket.
//!
//! The controller is not trusted. Whatever it sends, every queue, list and text that the client keeps has a bound; what
//! is dropped is counted in [`Counts`], and the counts are reported.

mod alarm;
mod client;
mod clock;
mod config;
mod counts;
mod decimation;
mod event;
mod exchange;
mod io;
mod job;
mod logging;
mod order;
mod outbox;
mod ping;
mod record;
mod status;
mod swath;
mod timer;
mod vehicle;

pub use alarm::{ALARMS_MAX, AlarmState};
pub use client::{ORDER_WAIT, SHUTDOWN_WITHIN, Sonar};
pub use config::{
    ChecksumPolicy, ConfigError, ExpectedLayout, LoggingSetup, NavigationTimes, SensorConfig, ShutdownKind, SonarConfig,
};
pub use counts::Counts;
pub use decimation::Decimation;
pub use event::Event;
pub use io::{Input, Output, Start, Ticket};
pub use logging::FileDetails;
pub use order::{ORDERS_MAX, Order, Outcome};
pub use outbox::{EVENTS_MAX, PINGS_MAX, SENDS_MAX};
pub use ping::{CHANNELS_MAX, PingChannel, PingGrant, PingTime, SonarPing};
pub use status::{Condition, STATUS_CHARS};
pub use swath::{AltitudeSource, Swath};
pub use vehicle::{VehicleNavigation, VehicleRates, VehicleSoundSpeed};
