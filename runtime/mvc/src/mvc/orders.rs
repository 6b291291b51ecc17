use backseat_units::Timestamp;

use super::Mvc;
use crate::error::{MvcError, OrderError};
use crate::event::MvcEventKind;
use crate::faults::{Fault, FaultKind};
use crate::file::{FAULTS_MAX, SHUTDOWN_NOTICE};
use crate::script::rules::{Rules, Seen};
use crate::script::{Order, Orderer, Script};

/// Carries out what the script or the operator orders.
impl Mvc {
    /// Gives this run a script, which replaces the one that it has. Rules with a time that is over act at once.
    ///
    /// # Errors
    /// [`MvcError::Rule`] if a rule loads a dive that the vehicle does not have. The run then keeps its old script.
    pub fn set_script(&mut self, script: Script) -> Result<(), MvcError> {
        for (number, rule) in (1..).zip(&script.rules) {
            if let Order::Load(dive) = &rule.order
                && !self.dives().any(|known| known == dive.as_str())
            {
                let known: Vec<String> = self.dives().map(|known| format!("`{known}`")).collect();
                return Err(MvcError::Rule {
                    line: rule.line,
                    number,
                    fault: format!("no dive is named `{dive}`, expected one of {}", known.join(", ")),
                });
            }
        }
        self.rules = Rules::new(script);
        Ok(())
    }

    /// The operator of the mock orders something now. It acts after everything that is due by `now`.
    ///
    /// # Errors
    /// [`OrderError`] in one line if the vehicle does not do it. The log has the order, and this line.
    pub fn order(&mut self, now: Timestamp, order: Order) -> Result<(), OrderError> {
        self.handle_timeout(now);
        let done = self.carry_out(now, Orderer::Operator, order);
        self.fire(now);
        done
    }

    /// The next fault of a link that an order has begun. The driver must play it with [`crate::LinkFaults::inject`] and
    /// [`crate::FaultyLink::inject`], before it passes on anything else. It begins at `fault.at`, which is never later
    /// than the last input.
    #[must_use]
    pub fn poll_link_fault(&mut self) -> Option<Fault> {
        self.link_faults.pop_front()
    }

    /// Lets every rule act that is due.
    pub(super) fn fire(&mut self, now: Timestamp) {
        self.observe();
        while let Some((number, order)) = self.rules.next_due(now) {
            // The log has the reason for a refusal.
            let _logged = self.carry_out(now, Orderer::Rule(number), order);
            self.observe();
        }
    }

    /// Tells the rules what has happened since the last call.
    pub(super) fn observe(&mut self) {
        for (at, seen) in self.server.take_seen() {
            self.rules.see(at, seen);
        }
    }

    pub(super) fn see_command(&mut self, now: Timestamp, name: backseat_spi::CommandName) {
        self.rules.see(now, Seen::Received(name));
    }

    fn carry_out(&mut self, at: Timestamp, by: Orderer, order: Order) -> Result<(), OrderError> {
        let text = Box::from(order.to_string());
        self.server.note(at, MvcEventKind::Ordered { by, order: text });
        let done = self.do_now(at, order);
        if let Err(error) = &done {
            let why = Box::from(error.to_string());
            self.server.note(at, MvcEventKind::NotDone { by, why });
        }
        self.settle(at);
        done
    }

    fn do_now(&mut self, at: Timestamp, order: Order) -> Result<(), OrderError> {
        let mut parts = self.parts(at);
        match order {
            Order::Fault(fault) => self.begin_fault(at, fault)?,
            Order::Shutdown => self.begin_fault(
                at,
                Fault {
                    at,
                    lasts: SHUTDOWN_NOTICE,
                    kind: FaultKind::Shutdown,
                },
            )?,
            Order::Control(control) => parts.mission.order_control(control),
            Order::Topside { transport, text, role } => {
                parts.services.topside.hear(&mut parts.ctx, transport, text, role);
            }
            Order::Load(dive) => parts.mission.load_dive(&mut parts.ctx, dive.as_str())?,
            Order::Start => parts.mission.start_dive(&mut parts.ctx)?,
            Order::End => parts.mission.end_dive(&mut parts.ctx)?,
            Order::Abort => parts.mission.abort_dive(&mut parts.ctx)?,
        }
        Ok(())
    }

    fn begin_fault(&mut self, at: Timestamp, fault: Fault) -> Result<(), OrderError> {
        if self.faults.is_full() {
            return Err(OrderError::Faults(FAULTS_MAX));
        }
        let fault = Fault { at, ..fault };
        if let FaultKind::Link(_) = fault.kind {
            self.link_faults.push_back(fault.clone());
        }
        self.begin_now(at, fault);
        Ok(())
    }
}
