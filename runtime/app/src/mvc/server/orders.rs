use backseat_mission::with_suggestion;
use backseat_mvc::{Direction, Fault, OperatorLine};

use super::{SETTLE, SETTLE_MAX, Server};
use crate::speed::Speed;

/// What the operator and the script do to the vehicle and its links, and how the vehicle's clock begins.
impl Server {
    /// Does what the operator has typed, or says in one line why not.
    pub(super) fn obey(&mut self, line: &str) {
        let is_empty = line.trim().is_empty();
        self.status.prompt(is_empty);
        match OperatorLine::parse(line) {
            Ok(None) => {}
            Ok(Some(OperatorLine::Order(order))) => {
                let now = self.now();
                // The vehicle's log has the order, and why the vehicle does not do it.
                let _logged = self.vehicle.order(now, order);
                self.collect(now);
                self.play_faults();
                self.flush();
            }
            Ok(Some(OperatorLine::Status)) => {
                let state = self.status.state(&self.vehicle, self.connections.len());
                self.status.answer(&state);
            }
            Ok(Some(OperatorLine::Help)) => {
                for line in OperatorLine::help() {
                    self.status.answer(&line);
                }
            }
            Err(error) => self.status.answer(&with_suggestion(&error)),
        }
    }

    /// Begins a fault of links, on those that are there and on those to come.
    pub(super) fn break_links(&mut self, fault: &Fault) {
        for (client, connection) in &mut self.connections {
            let role = self.vehicle.role(*client);
            let link = |direction| self.faults.link(fault.at, *client, role, direction);
            let links = connection
                .faults
                .get_or_insert_with(|| Box::new((link(Direction::ToVehicle), link(Direction::FromVehicle))));
            links.0.inject(fault);
            links.1.inject(fault);
        }
        self.faults.inject(fault);
    }

    /// Says for whom the vehicle's clock waits.
    pub(super) fn tell_of_waiting(&mut self) {
        let Some(wait) = self.vehicle_clock.waits_for() else {
            return;
        };
        let text = match (wait, self.connections.len()) {
            (1, 0) => "the vehicle's clock waits for the first client".to_owned(),
            (wait, 0) => format!("the vehicle's clock waits for {wait} clients"),
            (wait, there) => format!("the vehicle's clock waits: {there} of {wait} clients connected"),
        };
        self.status.say(self.clock.elapsed(), &text);
    }

    /// A client has come, or gone. With enough of them the vehicle's clock begins.
    pub(super) fn count_connected(&mut self) {
        if self.vehicle_clock.connected(self.connections.len()) {
            if self.speed == Speed::Max {
                let now = self.clock.elapsed();
                self.settling = Some((now + SETTLE, now + SETTLE_MAX));
            }
            self.status.say(self.clock.elapsed(), "the vehicle's clock begins");
        } else {
            self.tell_of_waiting();
        }
    }
}
