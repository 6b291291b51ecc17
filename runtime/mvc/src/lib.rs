//! A mock of the Bluefin main vehicle computer: mission executive, vehicle, sensors, SPI server side.
//!
//! Sans-IO: [`Mvc`] reads no clock and no socket. A driver calls, in this order:
//!
//! 1. An input, with the current time, which never goes back: [`Mvc::connect_from`], [`Mvc::disconnect`],
//!    [`Mvc::receive`] or [`Mvc::handle_timeout`].
//! 2. [`Mvc::poll_transmit`], [`Mvc::poll_disconnect`] and [`Mvc::poll_event`], each until it returns `None`.
//! 3. [`Mvc::poll_timeout`], which says when to call `handle_timeout`.
//!
//! The vehicle works in steps, ten a second unless configured otherwise. A step moves the vehicle, sends its navigation
//! messages and decides pending requests. The mock answers what a client sends at once. A modify and a suspension
//! lapse, and faults begin and end, at their own times between the steps.
//!
//! The mock shares the sentences and the quantities with the runtime, but no code that judges. [`Mvc::truth`] and
//! [`Mvc::world`] give what the mock knows and a payload cannot know. The same [`WorldFile`], seed and inputs give the
//! same bytes.
//!
//! A [`FaultPlan`] says what goes wrong. The faults of the vehicle act in this crate; a driver plays those of the link
//! with [`LinkFaults`]. Each begin and each end of a fault is an event.

mod context;
mod error;
mod estimate;
mod event;
mod executive;
mod faults;
mod file;
mod interpretation;
mod link;
mod mvc;
mod plan;
mod script;
mod sensors;
mod server;
mod services;
mod truth;
mod vehicle;

// `world.toml` and a mission write the plan in the same format.
pub use backseat_plan::{PlaceConfig, PlanEntry, PlanKind, VehicleClass};

pub use error::{DiveError, MvcError, OrderError};
pub use event::{
    AcousticEvent, AdjustmentEvent, AdjustmentKind, Behavior, CancelCause, ClientId, DropReason, DvlTriggerEvent,
    EndReason, HoveringEvent, MissionEvent, ModifyEnd, ModifyHorizontal, ModifySpeed, ModifyValues, ModifyVertical,
    MvcEvent, MvcEventKind, Refusal, SilenceEvent, Source, Status, SuspensionEnd, Told, TopsideEvent,
};
pub use faults::{
    AckFilter, AckStage, Directions, Fault, FaultEdge, FaultEvent, FaultKind, FaultPlan, LinkFault, LinkFaultKind,
    NegativeStatus, Sensor, SensorFailure, Untrue, Whom,
};
pub use file::{
    AcknowledgeConfig, Acknowledged, AcousticConfig, AcousticDevice, AdjustmentConfig, AdjustmentWhenSilenced,
    AfterInterrupt, AfterSuspension, AllTopics, BeganName, BrokenLine, CancelAllScope, Choice, CompassConfig,
    ContactsExpectation, ContourExpectation, ControlName, ControlWindow, CoverageExpectation, CtdPressure,
    DepthSensorConfig, DirectionName, DiveConfig, DvlConfig, DvlTriggerConfig, Expectations, FaultEntry, FaultFile,
    FaultName, FixConfig, GpsConfig, HeadingFrame, HoveringConfig, HullVertical, ImuConfig, InsConfig, InsertPlace,
    InsertsAfterControl, InterpretationConfig, Interruption, InvalidFile, LineEnd, LineFault, MaximumExpectation,
    MeasureExpectation, MessageEntry, MissionCommandConfig, MissionConfig, ModifyBeyond, ModifyEmptyMode, ModifyFins,
    ModifyLimit, MotionModel, OrderEntry, PeerConfig, PeerPacket, PowerConfig, Profile, RoleConfig, RoleError,
    RuleEntry, ScriptFile, SensorConfig, SensorName, ShipConfig, ShipSide, SidescanName, SilenceConfig, SoundConfig,
    SpiConfig, StageName, StartConfig, TailconeConfig, TargetKinds, TelemetryConfig, TopsideConfig, TopsideEntry,
    TrackcircleLayout, UnackedFrames, UnknownCommand, VehicleConfig, WhenEntry, WithoutLock, WithoutRole, WorldFile,
    WrapUp,
};
pub use interpretation::{Interpretation, ResumeFrom};
pub use link::{Chunk, Direction, FaultyLink, LinkFaults};
pub use mvc::Mvc;
pub use script::line::OperatorLine;
pub use script::{Beginning, ControlOrder, Order, Orderer, Rule, Script, Trigger};
pub use truth::{Activity, HoveringTruth, Truth};
pub use vehicle::performance::Performance;
