//! A mock of the Bluefin main vehicle computer: mission executive, vehicle, sensors, SPI server side.
//!
//! Sans-IO: [`Mvc`] reads no clock and no socket. A driver calls, in this order:
//!
//! 1. an input: [`Mvc::connect_from`], [`Mvc::disconnect`], [`Mvc::receive`] or [`Mvc::handle_timeout`], each with the time
//!    of now, which never goes back;
//! 2. then [`Mvc::poll_transmit`], [`Mvc::poll_disconnect`] and [`Mvc::poll_event`], each until it has no more;
//! 3. then [`Mvc::poll_timeout`], which says when to call `handle_timeout`.
//!
//! Everything happens in steps of the vehicle, ten a second unless configured: its motion, its navigation messages,
//! the lapse of a modify, the outcome of a pending request. What a client sends is answered at once.
//!
//! The mock is the honest other side: it shares the sentences and the quantities with the runtime, and nothing that
//! judges. What it knows and a payload cannot is in [`Mvc::truth`] and [`Mvc::world`]. The same [`WorldFile`], seed
//! and inputs give the same bytes.
//!
//! What goes wrong is a [`FaultPlan`]: the vehicle's own faults act in here, those of the link are played by a driver
//! with [`LinkFaults`], and each begin and end is an event.

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
mod sensors;
mod server;
mod services;
mod truth;
mod vehicle;

// The plan is written alike in `world.toml` and for a mission.
pub use backseat_plan::{PlaceConfig, PlanEntry, PlanKind, VehicleClass};

pub use error::MvcError;
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
    AfterInterrupt, AfterSuspension, CancelAllScope, Choice, CompassConfig, ContourExpectation, ControlWindow,
    DepthSensorConfig, DirectionName, DvlConfig, DvlTriggerConfig, Expectations, FaultEntry, FaultFile, FaultName,
    FixConfig, GpsConfig, HeadingFrame, HoveringConfig, HullVertical, ImuConfig, InsConfig, InsertPlace,
    InsertsAfterControl, InterpretationConfig, Interruption, LineFault, MaximumExpectation, MissionCommandConfig,
    MissionConfig, ModifyBeyond, ModifyFins, ModifyLimit, MotionModel, PeerConfig, PeerPacket, PowerConfig, Profile,
    RoleConfig, RoleError, SensorConfig, SensorName, ShipConfig, ShipSide, SilenceConfig, SoundConfig, SpiConfig,
    StageName, StartConfig, TailconeConfig, TelemetryConfig, TopsideConfig, TopsideEntry, TrackcircleLayout,
    UnackedFrames, VehicleConfig, WithoutLock, WithoutRole, WorldFile, WrapUp,
};
pub use interpretation::{Interpretation, ResumeFrom};
pub use link::{Chunk, Direction, FaultyLink, LinkFaults};
pub use mvc::Mvc;
pub use truth::{Activity, HoveringTruth, Truth};
pub use vehicle::performance::Performance;
