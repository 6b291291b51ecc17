//! What a plugin's author depends on: the types of the WIT world, the [`Plugin`] trait and the [`export!`] macro.
//!
//! A plugin is a function of its inputs. The runtime steps it now and then (as often as its [`Description`] says);
//! each [`StepInput`] holds the time, the vehicle's navigation, whether the backseat has control, and all that has
//! happened since the last step. The plugin answers with [`Request`]s. It has no clock, no random numbers, no files
//! and no network: the same inputs give the same requests, in simulation and at sea.
//!
//! ```
//! use backseat_sdk::{Description, Modify, NoConfig, Plugin, Request, StepInput, Vertical};
//!
//! struct NorthAtTenMetres;
//!
//! impl Plugin for NorthAtTenMetres {
//!     type Config = NoConfig;
//!
//!     fn describe() -> Description {
//!         Description { name: "north".into(), version: "0.1.0".into(), step_period_ns: 1_000_000_000, topics: vec![] }
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
//! Start from `plugins/template`. Its `Cargo.toml` has `crate-type = ["cdylib", "rlib"]`: the first is what becomes the
//! component, the second lets `cargo test` run the unit tests on the host, as plain Rust, where [`mod@log`] writes to
//! standard error and [`fence::check`] answers with a refusal, as there is no runtime to ask.
//!
//! # What the runtime bounds
//! Each call has a budget of fuel (roughly, WebAssembly instructions), each plugin a limit of memory. A step returns at
//! most 256 requests; a text is at most [`TEXT_BYTES`], a packet has at most [`FRAMES`] frames of at most
//! [`FRAME_BYTES`], a snapshot is at most 1 MiB. A plugin that breaks a bound or panics is started anew: a new instance
//! gets [`Plugin::new`], [`Plugin::restore`] with the last snapshot, and an [`Event::Restored`]. An `Err` from `step` is
//! recorded as a failure, and the instance lives on.
//!
//! # Requests and outcomes
//! Every request that can come to an end carries a `tag` of the plugin's choosing, which returns in
//! [`Event::Outcome`]: use a new one for each request whose fate matters. A [`Modify`], or a [`Station`] of a hovering
//! vehicle, stands for its duration and the runtime refreshes it, so ask again before it runs out, or whenever the
//! setpoint changes. A [`Trackline`] or [`Trackcircle`] is flown by the vehicle by itself once it has accepted it, and so
//! is a [`GpsHit`], which nobody can cancel. All others end when the vehicle has said whether it has done them.
//!
//! # Grants
//! A request that the mission does not grant the plugin is rejected, whatever it asks for, and a [`Request::Message`],
//! which has no outcome, is dropped. The operator grants by name, plugin by plugin:
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
//! | `message` | [`Request::Message`] |
//! | `surface` | [`Request::GpsHit`], where the fence lets the vehicle surface |
//! | `topside` | [`Request::Topside`] |
//! | `dvl` | [`Request::DvlTrigger`], of one plugin at a time |
//! | `silent` | [`Request::Silent`] |
//! | `trim` | [`Request::Trim`] |
//! | `buoyancy` | [`Request::Buoyancy`] |
//! | `acoustic` | [`Request::Packet`] |
//! | `station` | [`Request::Station`], [`Request::EndStation`] |
//! | `devices` | [`Request::SonarAngle`], [`Request::Camera`], [`Request::Light`] |
//!
//! [`Request::Timer`] needs none. What a plugin hears needs none either, but a [`Topic`] of its [`Description`], except
//! for [`Event::DvlTrigger`], which comes with `dvl`.

#[doc(hidden)]
pub mod bindings;
mod defaults;
#[doc(hidden)]
pub mod exports;
pub mod fence;
pub mod log;
mod outcome;
mod plugin;
mod request;

pub use backseat_units as units;
pub use bindings::backseat::plugin::types::{
    Axes, Battery, Beams, Behavior, BottomPosition, Buoyancy, Camera, Cartesian, Compass, Ctd, Description, Dvl,
    DvlBeams, DvlTrigger, Edge, EndKind, Ended, Event, Failure, FrameOutcome, GpsHit, HullPosition, Imu, Light, Modify,
    Navigation, Outcome, Packet, PlannedElement, PlannedPoint, Position, Pressure, ReceivedFrame, ReceivedPacket,
    Refusal, Relative, Request, Restored, Rule, Sample, Servo, Silent, SonarAngle, SoundVelocity, State, Station,
    StationTarget, StepInput, Surfaces, Telemetry, Timer, Topic, Topside, TopsideMessage, Trackcircle, Trackline,
    Transport, Trim, VehicleSpeed, Vertical, Window,
};
pub use plugin::{NoConfig, Plugin};
pub use request::{FRAME_BYTES, FRAMES, TEXT_BYTES, is_plain};
