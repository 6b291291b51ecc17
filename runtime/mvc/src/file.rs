//! `world.toml` as it is written: every section, parsed and checked, before the seed draws anything.

mod acoustic;
mod adjustment;
mod dive;
mod dvl;
mod expect;
mod faults;
mod hovering;
mod interpretation;
mod mission;
mod mission_command;
mod power;
mod profile;
mod roles;
mod script;
mod sensors;
mod silence;
mod spi;
mod start;
mod topside;
mod vehicle;

use backseat_plan::PlanEntry;
use backseat_world::{
    CurrentConfig, FieldConfig, OriginConfig, SeabedConfig, TargetConfig, TideLevelConfig, WorldConfig,
};
use serde::Deserialize;
use serde::de::IgnoredAny;

pub use acoustic::{AcousticConfig, AcousticDevice, PeerConfig, PeerPacket};
pub use adjustment::AdjustmentConfig;
pub use dive::{DiveConfig, InvalidFile};
pub use dvl::{DvlTriggerConfig, LineFault};
pub use expect::{
    ContactsExpectation, ContourExpectation, CoverageExpectation, Expectations, MaximumExpectation, MeasureExpectation,
    SidescanName, TargetKinds,
};
pub(crate) use faults::FAULTS_MAX;
pub use faults::{DirectionName, FaultEntry, FaultFile, FaultName, SensorName, StageName};
pub use hovering::{HoveringConfig, ShipConfig, ShipSide};
pub use interpretation::{
    Acknowledged, AdjustmentWhenSilenced, AfterInterrupt, AfterSuspension, AllTopics, BrokenLine, CancelAllScope,
    Choice, CtdPressure, HeadingFrame, HullVertical, InsertPlace, InsertsAfterControl, InterpretationConfig,
    Interruption, ModifyBeyond, ModifyEmptyMode, ModifyFins, TrackcircleLayout, UnackedFrames, UnknownCommand,
};
pub use mission::{ControlWindow, MissionConfig, ModifyLimit, WrapUp};
pub use mission_command::MissionCommandConfig;
pub use power::PowerConfig;
pub(crate) use power::SHUTDOWN_NOTICE;
pub use roles::{RoleConfig, RoleError, WithoutRole};
pub use script::{BeganName, ControlName, MessageEntry, OrderEntry, RuleEntry, ScriptFile, WhenEntry};
pub(crate) use sensors::COMPASSES_MAX;
pub use sensors::{
    CompassConfig, DepthSensorConfig, DvlConfig, FixConfig, GpsConfig, ImuConfig, InsConfig, SensorConfig, SoundConfig,
    TailconeConfig, TelemetryConfig, WithoutLock,
};
pub use silence::SilenceConfig;
pub use spi::{AcknowledgeConfig, LineEnd, Profile, SpiConfig};
pub use start::StartConfig;
pub use topside::{TopsideConfig, TopsideEntry};
pub use vehicle::{MotionModel, VehicleConfig};

use crate::error::{MvcError, check};

/// The whole of `world.toml`.
///
/// Only `[start]`, `[origin]` and one `[[plan]]` are required; everything else has a default. A number of `[seabed]`,
/// `[current]` or a plume may be a range, `[least, greatest]`, from which the seed draws.
///
/// ```
/// let file = backseat_mvc::WorldFile::from_toml(r#"
/// [start]
/// utc = 2026-06-01T08:00:00Z
/// east_m = -50
///
/// [origin]
/// latitude_deg = 42.3
/// longitude_deg = -70.9
///
/// [seabed]
/// depth_m = [40, 60]
/// slope = [0.03, 0.045]
/// banks = 2
///
/// [current]
/// speed_mps = [0.0, 0.3]
/// rotation_h = 12.42
///
/// [[field.plumes]]
/// east_m = [-300, 300]
/// north_m = [-300, 300]
/// sigma_m = 120
/// temperature_c = 3
///
/// [vehicle]
/// class = "12-inch"
/// depth_max_m = 80
///
/// [sensors]
/// position_drift_m_per_sqrt_h = 4
///
/// [mission]
/// starts_after_s = 10
///
/// [spi]
/// profile = "field"
///
/// [interpretation]
/// after_interrupt = "seed"
/// lead_in_m = "seed"
///
/// [silence]
/// timeout_s = 300
///
/// [adjustment]
/// buoyancy_n = [10, 30]
/// implicit_at_s = [600, 1200]
///
/// [power]
/// capacity_wh = 4500
/// shutdown_below_percent = 10
///
/// [dvl]
/// stop_at_s = [900]
/// line_faults = [{ at_s = 1000, for_s = 8 }]
///
/// [[topside.messages]]
/// at_s = 120
/// transport = "acoustic-modem"
/// text = "survey the wreck"
/// role = "sonar"
///
/// [acoustic]
/// device = "WHOIPSK"
/// address = 1
/// first_s = 30
/// period_s = 60
/// length_s = 20
///
/// [[acoustic.peers]]
/// address = 3
/// east_m = 1500
/// north_m = 200
/// east_mps = -0.5
/// [[acoustic.peers.packets]]
/// first_s = 55
/// period_s = 60
/// mode = 1
/// frames = ["48656C6C6F"]
///
/// [expect]
/// max_violations = 0
/// mission_completed = true
///
/// [[plan]]
/// kind = "waypoint"
/// at = { east_m = 0, north_m = 0 }
/// depth_m = 5
/// speed_mps = 1.5
///
/// [[plan]]
/// kind = "command"
/// text = "start line 1"
///
/// [[plan]]
/// kind = "trackline"
/// lead_in_m = 20
/// payload_message = "line 1"
/// start = { latitude_deg = 42.301, longitude_deg = -70.9 }
/// end = { latitude_deg = 42.305, longitude_deg = -70.9 }
/// altitude_m = 10
/// speed_mps = 1.5
/// dynamic = true
///
/// [[plan]]
/// kind = "setpoint"
/// heading_deg = 90
/// duration_s = 60
/// depth_m = 10
/// speed_mps = 1.5
/// dynamic = true
/// dynamic_from_s = 10
///
/// [[plan]]
/// kind = "trackcircle"
/// centre = { east_m = 100, north_m = 0 }
/// radius_m = 40
/// orbits = -1.5
/// depth_m = 5
/// speed_mps = 1.5
/// "#)?;
/// assert_eq!(file.plan.len(), 5);
/// # Ok::<(), backseat_mvc::MvcError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldFile {
    /// When the run starts, and where the vehicle is then.
    pub start: StartConfig,
    /// Where the zero of the world's frame is.
    pub origin: OriginConfig,
    /// How deep the water is.
    #[serde(default)]
    pub seabed: SeabedConfig,
    /// How the water rises and falls.
    #[serde(default)]
    pub tide: TideLevelConfig,
    /// How the water flows.
    #[serde(default)]
    pub current: CurrentConfig,
    /// What the water carries: temperature, conductivity and a tracer.
    #[serde(default)]
    pub field: FieldConfig,
    /// Objects on the seabed.
    #[serde(default)]
    pub targets: Vec<TargetConfig>,
    /// The vehicle's class, how it moves, and its own limits.
    #[serde(default)]
    pub vehicle: VehicleConfig,
    /// What only a hovering vehicle has, and the ship that it inspects.
    #[serde(default)]
    pub hovering: HoveringConfig,
    /// Sensors and navigation.
    #[serde(default)]
    pub sensors: SensorConfig,
    /// How the mission starts and ends, and what it lets a payload do.
    #[serde(default)]
    pub mission: MissionConfig,
    /// The front seat's plan, in the order of flight.
    pub plan: Vec<PlanEntry>,
    /// The dives on the vehicle, in the order in which they are loaded. Without any, the vehicle has one, which `[mission]`
    /// and `[[plan]]` describe, and it is loaded from the start.
    #[serde(default)]
    pub dive: Vec<DiveConfig>,
    /// The server that payloads connect to.
    #[serde(default)]
    pub spi: SpiConfig,
    /// How the vehicle reads what the specification leaves open.
    #[serde(default)]
    pub interpretation: InterpretationConfig,
    /// Silent mode.
    #[serde(default)]
    pub silence: SilenceConfig,
    /// Trim and buoyancy.
    #[serde(default)]
    pub adjustment: AdjustmentConfig,
    /// The batteries.
    #[serde(default)]
    pub power: PowerConfig,
    /// External triggering of the DVL.
    #[serde(default)]
    pub dvl: DvlTriggerConfig,
    /// Text to and from the topside.
    #[serde(default)]
    pub topside: TopsideConfig,
    /// The acoustic modem.
    #[serde(default)]
    pub acoustic: AcousticConfig,
    /// What the run must achieve. The mock only carries it and does not judge the run.
    #[serde(default)]
    pub expect: Expectations,
    /// What goes wrong: `[[faults.fault]]` tables, with the keys that [`crate::FaultPlan`] reads from a separate file.
    #[serde(default)]
    pub faults: FaultFile,
    /// The mock payload controller: another crate reads this table, and the vehicle knows nothing of it.
    #[serde(default)]
    pub plc: IgnoredAny,
}

impl WorldFile {
    /// Reads and checks a file's text.
    ///
    /// # Errors
    /// [`MvcError`] on one line: with line and column if the text is not what TOML and the sections allow, and with the
    /// key if a value is out of range. The caller must add the file's name.
    pub fn from_toml(text: &str) -> Result<Self, MvcError> {
        let file: Self = toml::from_str(text).map_err(|error| toml_error(text, &error))?;
        file.validate()?;
        Ok(file)
    }

    /// The part of the file from which the world is made.
    #[must_use]
    pub fn world_config(&self) -> WorldConfig {
        WorldConfig {
            origin: self.origin,
            seabed: self.seabed.clone(),
            tide: self.tide,
            current: self.current.clone(),
            field: self.field.clone(),
            targets: self.targets.clone(),
        }
    }

    fn validate(&self) -> Result<(), MvcError> {
        self.start.validate()?;
        self.vehicle.validate()?;
        self.sensors.validate()?;
        self.mission.validate()?;
        dive::validate(&self.dive)?;
        let (online_s, starts_s) = (self.mission.online_after_s, self.mission.starts_after_s);
        check(
            !self.dive.is_empty() || starts_s >= online_s,
            "mission.starts_after_s",
            starts_s,
            "mission.online_after_s or more",
        )?;
        self.spi.validate()?;
        self.interpretation.validate()?;
        self.faults.plan()?;
        self.silence.validate(1.0 / f64::from(self.vehicle.tick_hz))?;
        self.adjustment.validate()?;
        self.power.validate()?;
        self.dvl.validate()?;
        self.topside.validate()?;
        self.acoustic.validate()?;
        self.expect.coverage.map_or(Ok(()), |coverage| coverage.check())?;
        self.expect.contacts.map_or(Ok(()), |contacts| contacts.check())?;
        self.expect.measure.iter().try_for_each(MeasureExpectation::check)?;
        let (most_s, tick_s) = (self.spi.pending_s.most(), 1.0 / f64::from(self.vehicle.tick_hz));
        let expected = "2 s less one step of the vehicle: requests are decided at a step, within 2 s";
        check(most_s <= 2.0 - tick_s + 1e-9, "spi.pending_s", most_s, expected)?;
        // World and plan check themselves. These checks need neither the seed nor the grid.
        let world = self.world_config();
        world.validate()?;
        let frame = world.frame()?;
        self.hovering.validate(&self.vehicle, &self.start, &frame)?;
        crate::plan::resolve(&self.plan, &frame, &self.vehicle)?;
        for (number, dive) in (1..).zip(&self.dive).filter(|(_, dive)| !dive.plan.is_empty()) {
            crate::plan::resolve(&dive.plan, &frame, &self.vehicle).map_err(|error| error.of_dive(number))?;
        }
        Ok(())
    }
}

/// Checks a list of times, seconds after the start: none may be less than the one before it.
pub(crate) fn ordered_times(key: &'static str, times: &[f64]) -> Result<(), MvcError> {
    let mut before = 0.0;
    for time in times {
        check(
            (before..=1e9).contains(time),
            key,
            *time,
            "0 to 1e9 s, in order of time",
        )?;
        before = *time;
    }
    Ok(())
}

/// The TOML crate's error on one line. Its own text takes five lines.
fn toml_error(text: &str, error: &toml::de::Error) -> MvcError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let before = text.get(..start).unwrap_or("");
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line_text = text
        .get(line_start..)
        .and_then(|rest| rest.lines().next())
        .unwrap_or("");
    MvcError::Toml {
        line: before.matches('\n').count() + 1,
        column: before.get(line_start..).map_or(0, |rest| rest.chars().count()) + 1,
        message: error.message().split_whitespace().collect::<Vec<_>>().join(" "),
        text: line_text.trim().chars().take(100).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"
[start]
utc = 2026-06-01T08:00:00Z
[origin]
latitude_deg = 42.3
longitude_deg = -70.9
[[plan]]
kind = "trackline"
start = { east_m = 0, north_m = 100 }
end = { latitude_deg = 42.31, longitude_deg = -70.9 }
depth_m = 10
speed_mps = 1.5
dynamic = true
"#;

    fn fault(from: &str, to: &str) -> String {
        assert!(SMALL.contains(from));
        WorldFile::from_toml(&SMALL.replace(from, to)).unwrap_err().to_string()
    }

    #[test]
    fn a_small_file_is_enough() {
        let file = WorldFile::from_toml(SMALL).unwrap();
        assert_eq!(file.start.utc.as_unix_nanos(), 1_780_300_800_000_000_000);
        assert_eq!(file.plan.len(), 1);
        assert_eq!(file.expect, Expectations::default());
    }

    #[test]
    fn errors_are_one_line_with_place_key_and_what_was_expected() {
        let unknown = fault("depth_m = 10", "depth = 10");
        assert!(
            unknown.starts_with("line 11, column 1: unknown field `depth`, expected one of"),
            "{unknown}"
        );
        let kind = fault("speed_mps = 1.5", "speed_mps = \"fast\"");
        assert!(
            kind.starts_with("line 12, column 13: invalid type: string \"fast\", expected f64"),
            "{kind}"
        );
        assert!(kind.ends_with("`speed_mps = \"fast\"`"), "{kind}");
        for message in [
            unknown,
            kind,
            fault("kind = \"trackline\"", "kind = \"loop\""),
            fault("08:00:00Z", "08:00:00"),
            fault("[origin]", "[origin"),
        ] {
            assert!(!message.contains('\n') && message.starts_with("line "), "{message}");
        }
    }

    #[test]
    fn the_services_sections_are_checked_too() {
        for (section, message) in [
            (
                "[silence]\nsettle_s = 1.95",
                "silence.settle_s is 1.95, expected 2 s less one step of the vehicle",
            ),
            (
                "[silence]\ntimeout_s = 0",
                "silence.timeout_s is 0, expected 1 to 86400 s",
            ),
            (
                "[adjustment]\nbuoyancy_n = [0, 2000]",
                "adjustment.buoyancy_n is 2000, expected within 1000 N",
            ),
            (
                "[adjustment]\ntrim_rate_dps = 0",
                "adjustment.trim_rate_dps is 0, expected 0.001 to 10",
            ),
            (
                "[adjustment]\nimplicit_at_s = [5, 3]",
                "adjustment.implicit_at_s is 3, expected 0 to 1e9 s, in order of time",
            ),
            ("[power]\nbatteries = 0", "power.batteries is 0, expected 1 to 32"),
            (
                "[power]\nshutdown_below_percent = 101",
                "power.shutdown_below_percent is 101, expected 0 to 100 %",
            ),
            ("[dvl]\ntimeout_s = 0", "dvl.timeout_s is 0, expected 0.1 to 3600 s"),
            (
                "[dvl]\nline_faults = [{ at_s = -1, for_s = 2 }]",
                "dvl.line_faults.at_s is -1, expected 0 to 1e9 s",
            ),
            ("[dvl]\nstop_at_s = [nan]", "dvl.stop_at_s is NaN, expected 0 to 1e9 s"),
            (
                "[topside]\nsurfaced = { other = 9 }",
                "topside.surfaced is 9, expected a transport",
            ),
            (
                "[[topside.messages]]\nat_s = 1\ntransport = \"rf-modem\"\ntext = \"a,b\"",
                "topside.messages.text is \"a,b\", expected 1 to 200 printable",
            ),
            (
                "[acoustic]\nperiod_s = 20\nlength_s = 20",
                "acoustic.length_s is 20, expected 0.1 s to 0.1 s less",
            ),
            (
                "[acoustic]\nloss_chance = 1.5",
                "acoustic.loss_chance is 1.5, expected 0 to 1",
            ),
            (
                "[acoustic]\ndevice = \"Pinger\"",
                "line 5, column 10: unknown variant `Pinger`",
            ),
            (
                "[acoustic]\n[[acoustic.peers]]\naddress = 1\neast_m = 0\nnorth_m = 0",
                "acoustic.peers.address is 1, expected an address of its own",
            ),
            (
                "[[acoustic.peers]]\naddress = 3\neast_m = 0\nnorth_m = 0\n\
                 [[acoustic.peers.packets]]\nfirst_s = 1\nframes = [\"0\"]",
                "acoustic.peers.packets.frames is [\"0\"], expected 1 to 8 frames",
            ),
            (
                "[power]\ncapacity_kwh = 3",
                "line 5, column 1: unknown field `capacity_kwh`",
            ),
        ] {
            let found = fault("[origin]", &format!("{section}\n[origin]"));
            assert!(found.starts_with(message), "{found}");
        }
    }

    #[test]
    fn values_out_of_range_name_their_key() {
        let message = fault("[origin]", "[sensors]\nheading_noise_deg = -1\n[origin]");
        assert_eq!(message, "sensors.heading_noise_deg is -1, expected 0 to 1000");
        let message = fault("speed_mps = 1.5", "speed_mps = 9");
        assert!(
            message.starts_with("plan element 1: speed_mps is 9, expected"),
            "{message}"
        );
        let message = fault("end = {", "centre = {");
        assert_eq!(message, "plan element 1: a trackline needs `end`");
        let message = fault("end = {", "centre = { east_m = 1, north_m = 2 }\nend = {");
        assert_eq!(message, "plan element 1: a trackline has no `centre`");
        let message = fault("north_m = 100", "north_m = 100000");
        assert!(message.contains("within 50 km of the origin"), "{message}");
    }
}
