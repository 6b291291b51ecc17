use std::time::Duration;

use crate::earth::Position;
use crate::error::OracleError;

/// What the mission allows, and how the link behaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// The message that gives control to the backseat.
    pub control: ControlHook,
    /// The least speed that may be requested, m/s.
    pub speed_min_mps: f64,
    /// The greatest speed that may be requested, m/s.
    pub speed_max_mps: f64,
    /// The greatest distance between the vehicle and a planned leg while it still flies that leg, metres.
    pub tracking_error_m: f64,
    /// Navigation older than this is stale, seconds.
    pub navigation_age_max_s: f64,
    /// How many inserts may be open at once.
    pub inserts_open_max: u32,
    /// How many inserts may be sent in the whole run. Those that the vehicle refused do not count.
    pub inserts_total_max: u32,
    /// How long the open inserts together may still take, seconds.
    pub inserts_duration_max_s: f64,
    /// How many other requests are allowed.
    pub caps: Caps,
    /// Whether the mission says how deep the water is at most. If it does not, an altitude may be requested only with
    /// bottom lock.
    pub water_depth_known: bool,
    /// Where a hovering vehicle may be sent relative to a hull: horizontal, vertical, distance, each from and to,
    /// metres.
    pub hull_box: Option<[[f64; 2]; 3]>,
    /// Where a hovering vehicle may be sent relative to the bottom: x, y, depth, each from and to, metres.
    pub bottom_box: Option<[[f64; 2]; 3]>,
    /// The longest one-way delay of the undisturbed link, seconds: from when the vehicle's bytes start on their way to
    /// us until we have them. Bytes that a fault holds back start when it releases them.
    pub link_delay_s: f64,
    /// The longest round trip from a command to its acknowledgement that still proves that the vehicle hears us,
    /// seconds.
    pub answered_within_s: f64,
    /// How far the reported position may step away from its velocities, metres.
    pub position_step_m: f64,
    /// How far the position and the integrated velocities may drift apart in a second, m/s.
    pub position_drift_mps: f64,
    /// How long navigation may come without velocities, seconds.
    pub velocity_gap_s: f64,
    /// How late the runtime may record what it does, seconds: zero in simulation, and what a busy computer may cost if
    /// a run is judged by the runtime's own log.
    pub runtime_late_s: f64,
    /// The run has the vehicle's true state. Without it, the oracle does not know what became of inserts while the link
    /// was lost.
    pub truth_told: bool,
    /// Whether the operator's policies may send what no plugin can: aborts, kills, cancels without an identifier, and
    /// sentences that move the vehicle's estimate of its position.
    pub operator_commands: bool,
}

impl Default for Limits {
    /// Speeds from 0.5 to 2.5 m/s, 5 m of tracking error, 1 s of navigation age, a position step of 10 m and a drift of
    /// 0.3 m/s, 1.5 s without velocities; 4 inserts open, 100 in all, 3600 s of them; a link without delay; no operator
    /// commands; a known depth of the water and no boxes.
    fn default() -> Self {
        Self {
            control: ControlHook::BackseatControl,
            speed_min_mps: 0.5,
            speed_max_mps: 2.5,
            tracking_error_m: 5.0,
            navigation_age_max_s: 1.0,
            inserts_open_max: 4,
            inserts_total_max: 100,
            inserts_duration_max_s: 3600.0,
            caps: Caps::default(),
            water_depth_known: true,
            hull_box: None,
            bottom_box: None,
            link_delay_s: 0.0,
            answered_within_s: 1.0,
            position_step_m: 10.0,
            position_drift_mps: 0.3,
            velocity_gap_s: 1.5,
            runtime_late_s: 0.0,
            truth_told: true,
            operator_commands: false,
        }
    }
}

impl Limits {
    pub(crate) fn check(&self) -> Result<(), OracleError> {
        let limits = [
            ("speed_min_mps", self.speed_min_mps),
            ("speed_max_mps", self.speed_max_mps),
            ("tracking_error_m", self.tracking_error_m),
            ("navigation_age_max_s", self.navigation_age_max_s),
            ("inserts_duration_max_s", self.inserts_duration_max_s),
            ("link_delay_s", self.link_delay_s),
            ("answered_within_s", self.answered_within_s),
            ("position_step_m", self.position_step_m),
            ("position_drift_mps", self.position_drift_mps),
            ("velocity_gap_s", self.velocity_gap_s),
            ("runtime_late_s", self.runtime_late_s),
            ("silent_term_s", self.caps.silent_term_s),
        ];
        for (what, value) in limits {
            if !(0.0..=1e6).contains(&value) {
                return Err(OracleError::Limit {
                    what,
                    value,
                    expected: "a number from 0 to 1e6",
                });
            }
        }
        Ok(())
    }

    /// The longest time from when the vehicle's bytes start on their way until the runtime has acted on them.
    pub(crate) fn link_delay(&self) -> Duration {
        seconds(self.link_delay_s) + self.runtime_late()
    }

    /// How late the runtime may be by its own clock.
    pub(crate) fn runtime_late(&self) -> Duration {
        seconds(self.runtime_late_s)
    }
}

/// How many requests other than tracklines and trackcircles one process of the runtime may send.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caps {
    /// GPS hits that the vehicle did not refuse, in all.
    pub gps_hits_total_max: u32,
    /// Trim and buoyancy adjustments that the vehicle accepted, in all.
    pub adjustments_total_max: u32,
    /// Entries into silent mode that the vehicle accepted, in all.
    pub silences_total_max: u32,
    /// How long silent mode lasts unless it is ended, seconds.
    pub silent_term_s: f64,
    /// Messages to the topside, each minute on the average.
    pub topside_per_min: u32,
    /// Acoustic packets, each minute on the average.
    pub packets_per_min: u32,
    /// Lines in the vehicle's log, each second on the average.
    pub messages_per_s: u32,
    /// Commands to a hovering vehicle's sonar, camera and lights, each second on the average.
    pub device_commands_per_s: u32,
}

impl Default for Caps {
    /// 10 GPS hits, 10 adjustments, 20 silences of 300 s; 6 messages and 12 packets each minute;
    /// 10 lines in the log and 100 commands to devices each second.
    fn default() -> Self {
        Self {
            gps_hits_total_max: 10,
            adjustments_total_max: 10,
            silences_total_max: 20,
            silent_term_s: 300.0,
            topside_per_min: 6,
            packets_per_min: 12,
            messages_per_s: 10,
            device_commands_per_s: 100,
        }
    }
}

/// The duration of a checked limit.
pub(crate) fn seconds(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// What gives control to the backseat (SPI 6.24).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ControlHook {
    /// BFCTL 1.
    #[default]
    BackseatControl,
    /// The mission runs.
    MissionRunning,
    /// A mission command (SPI 5.1) with the operator's text.
    MissionCommand {
        /// The text that gives control.
        grant: String,
        /// The text that takes it back.
        revoke: String,
    },
}

/// The true state of the mock vehicle, which no sentence can hide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The time, nanoseconds since the start of the run.
    pub at_ns: u64,
    /// The position.
    pub position: Position,
    /// The depth, metres below the surface.
    pub depth_m: f64,
    /// The altitude, metres above the seabed; zero or less is aground.
    pub altitude_m: f64,
    /// What it flies.
    pub activity: Activity,
}

/// What the vehicle flies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// A behavior of its own plan.
    Plan,
    /// An insert of ours, by its identifier; its transit and lead-in are part of it.
    Insert(u32),
    /// Any behavior under our modify.
    Modified,
    /// A hovering vehicle's mission is suspended, and the vehicle goes where we send it.
    Suspended,
    /// No mission runs, or it is being aborted or wrapped up.
    Other,
}
