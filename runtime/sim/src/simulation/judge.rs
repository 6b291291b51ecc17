use backseat_core::{ControlHook, FailAction};
use backseat_mission::{Mission, MissionFile};
use backseat_mvc::{Activity, Truth};
use backseat_oracle::{Caps, Limits, Oracle, OracleError, Position, State, Statistics, Violation};
use backseat_units::Timestamp;

use crate::link::DELAY_MAX;

/// The oracle. It knows none of our types, and this is the only place that converts them into its own.
pub(super) struct Judge(Oracle);

impl Judge {
    pub(super) fn new(mission: &Mission) -> Result<Self, OracleError> {
        let limits = Limits {
            link_delay_s: DELAY_MAX.as_secs_f64(),
            ..limits(&mission.file)
        };
        Oracle::new(&mission.fence_text, limits).map(Self)
    }

    pub(super) fn link(&mut self, at: Timestamp, up: bool) {
        self.0.link(at.as_nanos(), up);
    }

    pub(super) fn runtime_stopped(&mut self, at: Timestamp) {
        self.0.runtime_stopped(at.as_nanos());
    }

    pub(super) fn runtime_continued(&mut self, at: Timestamp) {
        self.0.runtime_continued(at.as_nanos());
    }

    pub(super) fn runtime_started(&mut self, at: Timestamp) {
        self.0.runtime_started(at.as_nanos());
    }

    pub(super) fn operator(&mut self, at: Timestamp, held: bool) {
        self.0.operator(at.as_nanos(), held);
    }

    pub(super) fn deaf(&mut self, at: Timestamp, deaf: bool) {
        self.0.deaf(at.as_nanos(), deaf);
    }

    pub(super) fn vehicle_writes(&mut self, at: Timestamp, bytes: &[u8]) {
        self.0.from_vehicle(at.as_nanos(), bytes);
    }

    pub(super) fn runtime_writes(&mut self, at: Timestamp, bytes: &[u8]) {
        self.0.to_vehicle(at.as_nanos(), bytes);
    }

    pub(super) fn arrived(&mut self, at: Timestamp, bytes: &[u8]) {
        self.0.arrived(at.as_nanos(), bytes);
    }

    /// Passes on the vehicle's true state, and how far from it the vehicle's belief is.
    pub(super) fn truth(&mut self, truth: &Truth) {
        let activity = match truth.activity {
            Activity::Plan { .. } => backseat_oracle::Activity::Plan,
            Activity::Insert { id } => backseat_oracle::Activity::Insert(id.get()),
            Activity::Modified { .. } => backseat_oracle::Activity::Modified,
            Activity::Suspended => backseat_oracle::Activity::Suspended,
            Activity::Waiting | Activity::WrappingUp | Activity::Stopped => backseat_oracle::Activity::Other,
        };
        let error_m = truth.believed.distance_m(truth.local);
        self.0.believed(error_m, (truth.believed_depth_m - truth.depth_m).abs());
        self.0.truth(&backseat_oracle::Truth {
            at_ns: truth.time.as_nanos(),
            position: Position {
                latitude_deg: truth.position.latitude.as_deg(),
                longitude_deg: truth.position.longitude.as_deg(),
            },
            depth_m: truth.depth_m,
            altitude_m: truth.altitude_m,
            activity,
        });
    }

    pub(super) const fn state(&self) -> State {
        self.0.state()
    }

    pub(super) fn statistics(&self) -> Statistics {
        self.0.statistics()
    }

    pub(super) fn finish(self, at: Timestamp) -> Vec<Violation> {
        self.0.finish(at.as_nanos())
    }
}

/// What a mission allows, in the oracle's own terms, for a link without delay.
pub(crate) fn limits(mission: &MissionFile) -> Limits {
    let limits = &mission.limits;
    let station = limits.station.as_ref();
    let plugins = u32::try_from(mission.plugins.len()).unwrap_or(u32::MAX);
    Limits {
        speed_min_mps: limits.speed_min_mps,
        speed_max_mps: limits.speed_max_mps,
        control: match &mission.session.control {
            ControlHook::Bfctl => backseat_oracle::ControlHook::BackseatControl,
            ControlHook::Running => backseat_oracle::ControlHook::MissionRunning,
            ControlHook::MissionCommand { grant, revoke } => backseat_oracle::ControlHook::MissionCommand {
                grant: grant.clone(),
                revoke: revoke.clone(),
            },
        },
        tracking_error_m: limits.tracking_error_m,
        navigation_age_max_s: limits.navigation_age_max_s,
        operator_commands: orders(mission),
        inserts_open_max: limits.inserts_open_max,
        inserts_total_max: limits.inserts_total_max,
        inserts_duration_max_s: limits.inserts_duration_max_s,
        caps: Caps {
            gps_hits_total_max: limits.gps_hits_total_max,
            adjustments_total_max: limits.adjustments_total_max,
            silences_total_max: limits.silences_total_max,
            silent_term_s: limits.silent_term_s,
            topside_per_min: limits.topside_per_min,
            packets_per_min: limits.packets_per_min,
            messages_per_s: plugins,
            device_commands_per_s: plugins.saturating_mul(limits.requests_per_s),
        },
        water_depth_known: limits.water_depth_max_m.is_some(),
        hull_box: station.and_then(|station| station.hull_box.as_ref()).map(|bounds| {
            [
                [bounds.horizontal_min_m, bounds.horizontal_max_m],
                [bounds.vertical_min_m, bounds.vertical_max_m],
                [bounds.distance_min_m, bounds.distance_max_m],
            ]
        }),
        bottom_box: station.and_then(|station| station.bottom_box.as_ref()).map(|bounds| {
            [
                [bounds.x_min_m, bounds.x_max_m],
                [bounds.y_min_m, bounds.y_max_m],
                [bounds.depth_min_m, bounds.depth_max_m],
            ]
        }),
        link_delay_s: 0.0,
        answered_within_s: limits.link_delay_max_s,
        position_step_m: limits.integrity.position_step_m,
        position_drift_mps: limits.integrity.position_drift_mps,
        velocity_gap_s: limits.integrity.velocity_gap_s,
        runtime_late_s: 0.0,
        truth_told: true,
    }
}

/// Whether the operator of a mission has ordered anything in advance that no plugin may send.
fn orders(mission: &MissionFile) -> bool {
    let aborts = |plugin: &backseat_mission::PluginTable| plugin.on_failure == FailAction::Abort;
    !mission.policies.is_empty() || mission.recovery.abort_after_s.is_some() || mission.plugins.iter().any(aborts)
}
