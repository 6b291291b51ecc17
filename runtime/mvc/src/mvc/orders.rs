use backseat_units::Timestamp;

use super::Mvc;
use crate::event::{MvcEventKind, Status};
use crate::faults::{Fault, FaultKind};
use crate::file::SHUTDOWN_NOTICE;
use crate::script::rules::{Rules, Seen};
use crate::script::{Order, Orderer, Script};

/// Carries out what the script or the operator orders.
impl Mvc {
    /// Gives this run a script, which replaces the one that it has. Rules with a time that is over act at once.
    pub fn set_script(&mut self, script: Script) {
        self.rules = Rules::new(script);
    }

    /// The operator of the mock orders something now. It acts after everything that is due by `now`.
    ///
    /// # Errors
    /// Why the vehicle does not do it, in words. The log has a line in either case.
    pub fn order(&mut self, now: Timestamp, order: Order) -> Result<(), &'static str> {
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

    fn carry_out(&mut self, at: Timestamp, by: Orderer, order: Order) -> Result<(), &'static str> {
        let may = self.may_carry_out(&order);
        let (order_text, refused) = (Box::from(order.to_string()), may.err());
        self.server.note(
            at,
            MvcEventKind::Ordered {
                by,
                order: order_text,
                refused,
            },
        );
        may?;
        match order {
            Order::Fault(fault) => self.begin_fault(at, fault),
            Order::Shutdown => self.begin_fault(
                at,
                Fault {
                    at,
                    lasts: SHUTDOWN_NOTICE,
                    kind: FaultKind::Shutdown,
                },
            ),
            Order::Control(control) => self.mission.order_control(control),
            Order::Topside { transport, text, role } => {
                let mut parts = self.parts(at);
                parts.services.topside.hear(&mut parts.ctx, transport, text, role);
            }
            Order::Abort => self.mission.fail("aborted by the operator"),
        }
        self.settle(at);
        Ok(())
    }

    fn may_carry_out(&self, order: &Order) -> Result<(), &'static str> {
        match order {
            Order::Fault(_) | Order::Shutdown if self.faults.is_full() => Err("this run has had 100000 faults"),
            Order::Abort => match self.mission.status() {
                Status::Ready | Status::Running | Status::WrappingUp => Ok(()),
                Status::Aborting | Status::Completed | Status::Aborted | Status::Stopped => {
                    Err("no mission is running")
                }
            },
            Order::Fault(_) | Order::Shutdown | Order::Control(_) | Order::Topside { .. } => Ok(()),
        }
    }

    fn begin_fault(&mut self, at: Timestamp, fault: Fault) {
        let fault = Fault { at, ..fault };
        if let FaultKind::Link(_) = fault.kind {
            self.link_faults.push_back(fault.clone());
        }
        self.begin_now(at, fault);
    }
}
