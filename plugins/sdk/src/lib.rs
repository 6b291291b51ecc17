//! The SDK for writing plugins: the types of the WIT world, the [`Plugin`] trait and the [`export!`] macro.
//!
//! A plugin is a function of its inputs. The runtime calls [`Plugin::step`] at the period that the plugin's
//! [`Description`] gives. Each [`StepInput`] holds the time, the vehicle's navigation, whether the backseat has
//! control, and the events since the last step. The plugin returns [`Request`]s. It has no clock, no random numbers, no
//! files and no network, so the same inputs give the same requests, in simulation and at sea.
//!
//! ```
//! use backseat_sdk::{Description, Grant, Modify, NoConfig, Plugin, Request, StepInput, Vertical};
//!
//! struct NorthAtTenMetres;
//!
//! impl Plugin for NorthAtTenMetres {
//!     type Config = NoConfig;
//!
//!     fn describe() -> Description {
//!         Description {
//!             name: "north".into(),
//!             version: "0.1.0".into(),
//!             step_period_ns: 1_000_000_000,
//!             topics: vec![],
//!             grants: vec![Grant::Modify],
//!         }
//!     }
//!
//!     fn new(_: NoConfig) -> Result<Self, String> {
//!         Ok(Self)
//!     }
//!
//!     fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
//!         if !input.control {
//!             return Ok(vec![]);
//!         }
//!         Ok(vec![Request::Modify(Modify {
//!             tag: 1,
//!             heading: 0.0,
//!             vertical: Vertical::Depth(10.0),
//!             speed: 1.5,
//!             duration_ns: 5_000_000_000,
//!         })])
//!     }
//! }
//!
//! backseat_sdk::export!(NorthAtTenMetres);
//!
//! let mut plugin = NorthAtTenMetres;
//! let input = StepInput { control: true, ..StepInput::default() };
//! assert_eq!(plugin.step(&input).unwrap().len(), 1);
//! ```
//!
//! # A plugin's crate
//! Start from a copy of `plugins/template`. Its `Cargo.toml` has `crate-type = ["cdylib", "rlib"]`. The first becomes
//! the component. The second lets `cargo test` run unit tests on the host, as plain Rust. There is no runtime on the
//! host: [`mod@log`] and [`measures`] write to standard error, and [`fence::check`] always returns a refusal. A test that
//! wants more steps the plugin by a `testing::Harness`, or lets it fly a simple vehicle by `testing::Basin`.
//!
//! # Limits
//! Each call has a budget of fuel (about one unit for each WebAssembly instruction), and each plugin a limit of memory.
//! A step returns at most 256 requests, a text has at most [`TEXT_BYTES`] bytes, a packet has at most [`FRAMES`] frames
//! of at most [`FRAME_BYTES`] bytes each, and a snapshot has at most 1 MiB. A plugin that exceeds a limit or panics is
//! restarted: the runtime creates an instance with [`Plugin::new`], calls [`Plugin::restore`] with the last snapshot,
//! and sends an [`Event::Restored`]. An `Err` from `step` is recorded as a failure, but the instance continues.
//!
//! # The mission
//! [`Plugin::brief`] is called once, after [`Plugin::new`], with what the mission is: the fence's zones as polygons of the
//! local frame, the limits of requests, the plugin's grants and its budget. So a survey can be planned inside them.
//! Whether a certain request passes is a question to [`fence::check`].
//!
//! # Requests and outcomes
//! Most requests carry a `tag` that the plugin chooses. Each [`Event::Outcome`] reports a new [`State`] of the request
//! with that tag. Use a new tag for each request that you want to follow.
//!
//! - A [`Modify`], or a [`Station`] of a hovering vehicle, lasts for its duration, and the runtime refreshes it for
//!   that time. Request it again before that time is over, or when the setpoint changes.
//! - Once the vehicle has accepted a [`Trackline`], [`Trackcircle`] or [`GpsHit`], it flies it by itself. A [`GpsHit`]
//!   cannot be cancelled.
//! - Any other request ends when the vehicle has reported whether it carried it out.
//!
//! # Grants
//! The runtime rejects a request that the mission does not grant to the plugin. A [`Request::Message`] has no outcome,
//! and is dropped in that case. A plugin's [`Description`] lists the grants without which it cannot do its work: a
//! mission that does not give them is refused. The operator lists the grants of each plugin in `mission.toml`:
//!
//! ```toml
//! [[plugin]]
//! name = "survey"
//! component = "survey"
//! grants = ["modify", "insert", "message"]
//! ```
//!
//! | grant | what it allows |
//! |---|---|
//! | `modify` | [`Request::Modify`], [`Request::EndModify`] |
//! | `insert` | [`Request::Trackline`], [`Request::Trackcircle`], [`Request::Cancel`] |
//! | `interrupt` | together with `insert`: a [`Trackline`] or [`Trackcircle`] that interrupts the current behavior |
//! | `message` | [`Request::Message`] |
//! | `surface` | [`Request::GpsHit`], where the fence lets the vehicle surface |
//! | `topside` | [`Request::Topside`] |
//! | `dvl` | [`Request::DvlTrigger`], for one plugin at a time |
//! | `silent` | [`Request::Silent`] |
//! | `trim` | [`Request::Trim`] |
//! | `buoyancy` | [`Request::Buoyancy`] |
//! | `acoustic` | [`Request::Packet`] |
//! | `station` | [`Request::Station`], [`Request::EndStation`] |
//! | `devices` | [`Request::SonarAngle`], [`Request::Camera`], [`Request::Light`] |
//! | `sonar` | [`Request::SonarSet`], [`Request::SonarLog`] |
//!
//! [`Request::Timer`] needs no grant. Events need no grant either, but some are only sent to plugins that list their
//! [`Topic`] in the [`Description`]. [`Event::DvlTrigger`] is sent to plugins with the grant `dvl`.

#[doc(hidden)]
pub mod bindings;
mod defaults;
#[doc(hidden)]
pub mod exports;
pub mod fence;
#[cfg(not(target_arch = "wasm32"))]
mod host;
pub mod kept;
pub mod log;
pub mod measures;
mod outcome;
mod plugin;
mod request;
pub mod sonar;
pub mod survey;
#[cfg(not(target_arch = "wasm32"))]
pub mod testing;

pub use backseat_units as units;
pub use bindings::backseat::plugin::mission::{
    Area, Briefing, Budget, Description, Grant, KeepIn, Limits, Point, Zone,
};
pub use bindings::backseat::plugin::types::{
    AltitudeSource, Axes, Battery, Beams, Behavior, BottomPosition, Buoyancy, Camera, Cartesian, Compass, Ctd,
    Decimation, Dvl, DvlBeams, DvlTrigger, Edge, EndKind, Ended, Event, Failure, FrameOutcome, GpsHit, HullPosition,
    Imu, Light, Modify, Navigation, Outcome, Packet, PingNavigation, PingTime, PlannedElement, PlannedPoint, Position,
    Pressure, ReceivedFrame, ReceivedPacket, Refusal, Relative, Request, Restored, Rule, Sample, SensorHealth, Servo,
    Silent, SonarAlarm, SonarAngle, SonarChannel, SonarEvent, SonarLog, SonarLogging, SonarPing, SonarSet,
    SonarSetting, SonarSide, SoundVelocity, State, Station, StationTarget, StepInput, Surfaces, Swath, Telemetry,
    Timer, Topic, Topside, TopsideMessage, Trackcircle, Trackline, Transport, Trim, VehicleSpeed, Vertical, Window,
};
pub use plugin::{NoConfig, Plugin};
pub use request::{FRAME_BYTES, FRAMES, TEXT_BYTES, is_plain};
