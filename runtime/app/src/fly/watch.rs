//! What a flight shows of itself: to the screen while it lasts, to the map afterwards.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use backseat_core::plugin::RequestState;
use backseat_core::{Core, Note, Output, Owner, RequestCounts, RequestKind, Transition};
use backseat_mvc::{Activity, Mvc, Truth};
use backseat_sim::{Sample, Steering, Trace};
use backseat_spi::{Sentence, ToVehicle};
use backseat_units::Timestamp;

use crate::helm::Helm;
use crate::mvc::status::place;
use crate::run::driver::Onlooker;

/// What is known of a flight, for all threads.
#[derive(Debug, Default)]
pub(super) struct Flight(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    at: Timestamp,
    mission: &'static str,
    place: String,
    /// Why nothing steers.
    reason: Option<String>,
    steers: String,
    inserts: usize,
    counts: RequestCounts,
    trace: Trace,
}

impl Flight {
    fn lock(&self) -> MutexGuard<'_, State> {
        // It is whole after each line that changes it.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The vehicle after a step.
    pub(super) fn seen(&self, vehicle: &Mvc, truth: &Truth) {
        let second = |at: Timestamp| at.as_nanos() / 1_000_000_000;
        let mut state = self.lock();
        state.at = truth.time;
        state.mission = vehicle.mission_status().name();
        if state
            .trace
            .samples
            .last()
            .is_none_or(|last| second(last.at) != second(truth.time))
        {
            state.place = place(vehicle);
            state.trace.samples.push(Sample {
                at: truth.time,
                local: truth.local,
                position: truth.position,
                depth_m: truth.depth_m,
                water_depth_m: truth.water_depth_m,
                steering: match truth.activity {
                    Activity::Plan { .. } => Steering::Plan,
                    Activity::Insert { .. } => Steering::Insert,
                    Activity::Modified { .. } => Steering::Modify,
                    Activity::Waiting | Activity::Suspended | Activity::WrappingUp | Activity::Stopped => {
                        Steering::Nobody
                    }
                },
            });
        }
    }

    /// The state in two lines: who does what, and where the vehicle is.
    pub(super) fn lines(&self) -> (String, String) {
        let state = self.lock();
        let seconds = state.at.as_nanos() / 1_000_000_000;
        let inserts = match state.inserts {
            0 => String::new(),
            1 => ", 1 open insert".to_owned(),
            more => format!(", {more} open inserts"),
        };
        let control = match &state.reason {
            Some(reason) => format!("no control: {reason}"),
            None => "has control".to_owned(),
        };
        let doing = format!(
            "{}:{:02}:{:02} {} | {control}; {} steers{inserts}",
            seconds / 3600,
            seconds / 60 % 60,
            seconds % 60,
            state.mission,
            state.steers,
        );
        (doing, state.place.clone())
    }

    pub(super) fn requests(&self) -> RequestCounts {
        self.lock().counts
    }

    /// What the map needs. Afterwards it is empty.
    pub(super) fn trace(&self) -> Trace {
        std::mem::take(&mut self.lock().trace)
    }
}

/// Watches the runtime.
pub(super) struct Watch {
    flight: std::sync::Arc<Flight>,
    names: Vec<String>,
    /// Whose lease was sent last.
    leads: Option<Owner>,
    /// Inserts that have no end yet, and those of them that are being flown.
    open: BTreeSet<u64>,
    flown: BTreeSet<u64>,
}

impl Watch {
    pub(super) fn new(flight: std::sync::Arc<Flight>, names: Vec<String>) -> Self {
        Self {
            flight,
            names,
            leads: None,
            open: BTreeSet::new(),
            flown: BTreeSet::new(),
        }
    }

    fn follow(&mut self, transition: &Transition) {
        use RequestKind as K;
        if matches!(transition.kind, K::Modify | K::Station) && transition.state == RequestState::Sent {
            self.leads = Some(transition.owner);
        }
        if !matches!(transition.kind, K::Trackline | K::Trackcircle | K::GpsHit) {
            return;
        }
        let number = transition.request;
        match &transition.state {
            RequestState::Sent | RequestState::Pending | RequestState::Accepted | RequestState::Unknown => {
                self.open.insert(number);
            }
            RequestState::Started => {
                self.flown.insert(number);
            }
            RequestState::Rejected(_)
            | RequestState::Failed(_)
            | RequestState::TimedOut
            | RequestState::Ended(_)
            | RequestState::Cancelled => {
                self.open.remove(&number);
                self.flown.remove(&number);
            }
        }
    }

    fn steers(&self, core: &Core) -> String {
        if core.is_steering() {
            return match self.leads {
                Some(Owner::Plugin(plugin)) => self.names.get(plugin.0).cloned(),
                Some(Owner::Operator | Owner::External(_)) => Some("the operator".to_owned()),
                None => None,
            }
            .unwrap_or_else(|| "a plugin".to_owned());
        }
        let what = if self.flown.is_empty() {
            "the front seat"
        } else {
            "an insert"
        };
        what.to_owned()
    }
}

impl Onlooker for Watch {
    fn output(&mut self, output: &Output) {
        if let Output::Note(Note::Request(transition)) = output {
            self.follow(transition);
        }
        if let Output::Send(bytes) = output
            && (bytes.starts_with(b"$BPRT") || bytes.starts_with(b"$BPRG"))
        {
            let message = std::str::from_utf8(bytes)
                .ok()
                .and_then(|line| Sentence::parse(line.trim_end()).ok())
                .and_then(|sentence| ToVehicle::decode(&sentence).ok());
            self.flight.lock().trace.inserts.extend(message);
        }
    }

    fn comes_round(&mut self, core: &Core, helm: &Helm) {
        let steers = self.steers(core);
        let mut state = self.flight.lock();
        state.reason = match helm.reason() {
            None if !core.has_control() => Some("not yet".to_owned()),
            reason => reason.map(str::to_owned),
        };
        state.steers = steers;
        state.inserts = self.open.len();
        state.counts = core.request_counts();
    }
}
