//! The two ends of the vehicle link, and the vehicle.

use std::time::Duration;

use backseat_core::Input;
use backseat_mvc::{ClientId, Direction as Way, FaultEdge, FaultKind, LinkFaultKind, MvcEventKind, Status, Truth};
use backseat_units::Timestamp;

use crate::control::Control;
use crate::digest::Direction;
use crate::simulation::{SimError, Simulation};

/// If the vehicle has not acknowledged a write for this long, the connection ends, as it does at sea.
const UNACKNOWLEDGED_MAX: Duration = Duration::from_secs(2);

impl Simulation {
    /// When a write that is not acknowledged ends the connection.
    fn gives_up(&self) -> Option<Timestamp> {
        #[cfg(feature = "mutations")]
        {
            use backseat_core::mutations::{Check, is_on};
            if !is_on(Check::StaleSends) {
                return None;
            }
        }
        self.to_vehicle.gives_up(UNACKNOWLEDGED_MAX)
    }

    pub(super) fn connect(&mut self) -> Result<(), SimError> {
        if let Some(process) = &mut self.process {
            process.connect_at = None;
        }
        self.client = ClientId(self.client.0 + 1);
        if self.faults.refuses(self.now, self.client, None) {
            return self.feed(Input::LinkDown);
        }
        if !self.faults.is_empty() {
            let link = |way| Some(self.faults.link(self.now, self.client, None, way));
            self.to_vehicle.open(link(Way::ToVehicle));
            self.to_payload.open(link(Way::FromVehicle));
        }
        self.connected = true;
        self.oracle.link(self.now, true);
        self.mvc.connect(self.now, self.client);
        self.feed(Input::LinkUp)?;
        self.drain_mvc()
    }

    pub(super) fn disconnect(&mut self) {
        if self.connected {
            self.connected = false;
            self.mvc.disconnect(self.now, self.client);
            self.oracle.link(self.now, false);
            self.to_payload.cut();
            self.to_vehicle.cut();
        }
    }

    /// The connection has ended, and not by the runtime. A stopped process learns of it when it goes on.
    pub(super) fn lose_link(&mut self) -> Result<(), SimError> {
        self.disconnect();
        if self.is_awake() {
            return self.feed(Input::LinkDown);
        }
        self.miss_reset();
        Ok(())
    }

    pub(super) fn link_fault_due(&self) -> Option<Timestamp> {
        [
            self.to_vehicle.next_fault(),
            self.to_payload.next_fault(),
            self.gives_up(),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// Releases what faults have held back, or ends the connection.
    pub(super) fn link_fault(&mut self) -> Result<(), SimError> {
        let now = self.now;
        let unacknowledged = self.gives_up().is_some_and(|at| now >= at);
        if unacknowledged || self.to_vehicle.is_cut(now) || self.to_payload.is_cut(now) {
            return self.lose_link();
        }
        self.to_vehicle.release(now, |_| {});
        let oracle = &mut self.oracle;
        self.to_payload.release(now, |bytes| oracle.vehicle_writes(now, bytes));
        Ok(())
    }

    pub(super) fn arrive_at_vehicle(&mut self) -> Result<(), SimError> {
        let Some(bytes) = self.to_vehicle.take() else {
            return Ok(());
        };
        self.oracle.arrived(self.now, &bytes);
        self.mvc.receive(self.now, self.client, &bytes);
        self.to_vehicle.recycle(bytes);
        self.drain_mvc()
    }

    pub(super) fn arrive_at_payload(&mut self) -> Result<(), SimError> {
        let Some(bytes) = self.to_payload.take() else {
            return Ok(());
        };
        if self.is_awake() {
            self.feed(Input::Received(&bytes))?;
        } else if !self.pile_up(&bytes) {
            self.lose_link()?;
        }
        self.to_payload.recycle(bytes);
        Ok(())
    }

    pub(super) fn drain_mvc(&mut self) -> Result<(), SimError> {
        while let Some(fault) = self.mvc.poll_link_fault() {
            self.break_link(&fault);
        }
        let mut buffer = std::mem::take(&mut self.scratch);
        while self.mvc.poll_transmit(&mut buffer).is_some() {
            self.digest.write(Direction::FromVehicle, self.now, &buffer);
            // The oracle sees only what is on its way to us, because we cannot know what a fault has swallowed.
            let (oracle, now) = (&mut self.oracle, self.now);
            self.to_payload
                .write(now, &buffer, |bytes| oracle.vehicle_writes(now, bytes));
        }
        self.scratch = buffer;
        while let Some(event) = self.mvc.poll_event() {
            if let MvcEventKind::Fault(fault) = &event.kind {
                let begins = fault.edge == FaultEdge::Begin;
                self.faults_begun += u64::from(begins);
                if let FaultKind::Link(link) = &fault.kind
                    && link.kind == LinkFaultKind::Deaf
                {
                    self.oracle.deaf(self.now, begins);
                }
            }
            if let Some(recorder) = &mut self.recorder {
                recorder.vehicle_event(self.now, &event.to_string())?;
            }
        }
        let mut cut = false;
        while self.mvc.poll_disconnect().is_some() {
            cut = true;
        }
        if cut && self.connected {
            self.lose_link()?;
        }
        if self.over_at.is_none() && self.mvc.mission_over() {
            self.over_at = Some(self.now);
        }
        Ok(())
    }

    /// Shows the vehicle's true state to the oracle and to the trace.
    pub(super) fn look(&mut self) -> Result<(), SimError> {
        let truth: Truth = self.mvc.truth();
        let sampled = self.trace.truth(&truth);
        if sampled {
            let control = match &self.process {
                None => Control::NoProcess,
                Some(process) => process.core.uncontrolled().map_or(Control::Granted, Control::Lost),
            };
            let second = truth.time.as_nanos() / 1_000_000_000;
            let runs = self.mvc.mission_status() == Status::Running;
            self.control.second(second, control, runs);
        }
        if sampled && let (Some(recorder), Some(sample)) = (&mut self.recorder, self.trace.samples.last()) {
            recorder.truth(self.now, sample)?;
        }
        self.oracle.truth(&truth);
        Ok(())
    }
}
