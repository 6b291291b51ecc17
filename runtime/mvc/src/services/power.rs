use core::time::Duration;

use backseat_spi::{Battery, Shutdown};
use backseat_units::Timestamp;
use backseat_units::math::exp;
use backseat_world::Stream;

use crate::context::Context;
use crate::event::{DropReason, MvcEventKind};
use crate::file::{PowerConfig, SHUTDOWN_NOTICE, WorldFile};
use crate::server::topics::Topic;

/// Standard deviation of the cells' voltages, volts.
const CELL_SPREAD_V: f64 = 0.004;

/// The batteries, and the payload's power (SPI 5.2, 6.8).
#[derive(Debug)]
pub(crate) struct Power {
    config: PowerConfig,
    /// Energy taken from all batteries, joules.
    used_j: f64,
    drawn_w: f64,
    /// How far the weakest and the strongest cell of each battery are from the mean, volts.
    spread: Vec<(f64, f64)>,
    next_status: Timestamp,
    shutdown_at: Option<Timestamp>,
    shutdown_said: bool,
    is_on: bool,
}

impl Power {
    pub(crate) fn new(file: &WorldFile, seed: u64) -> Self {
        let config = file.power;
        let mut stream = Stream::new(seed, "cells");
        let spread = (0..config.batteries)
            .map(|_| {
                let (low, high) = (stream.gaussian().abs(), stream.gaussian().abs());
                (low * CELL_SPREAD_V, high * CELL_SPREAD_V)
            })
            .collect();
        let used = 1.0 - config.initial_percent / 100.0;
        Self {
            config,
            used_j: config.capacity_wh * 3600.0 * used,
            drawn_w: config.hotel_w,
            spread,
            next_status: Timestamp::ZERO,
            shutdown_at: file
                .mission
                .shutdown_after_s
                .map(|s| Timestamp::ZERO + Duration::from_secs_f64(s)),
            shutdown_said: false,
            is_on: true,
        }
    }

    /// Whether the payload has power.
    pub(crate) const fn is_on(&self) -> bool {
        self.is_on
    }

    /// State of charge, 0 to 1.
    fn charge(&self) -> f64 {
        (1.0 - self.used_j / (self.config.capacity_wh * 3600.0)).clamp(0.0, 1.0)
    }

    /// Schedules the end of the payload's power in one minute, or leaves an earlier schedule.
    pub(crate) fn shut_down(&mut self, now: Timestamp) {
        self.shut_down_at(now + SHUTDOWN_NOTICE);
    }

    /// Schedules the end of the payload's power, or leaves an earlier schedule.
    fn shut_down_at(&mut self, at: Timestamp) {
        self.shutdown_at = Some(self.shutdown_at.map_or(at, |before| before.min(at)));
    }

    fn status(&self, number: u32, water_c: f64) -> BatteryReading {
        let charge = self.charge();
        let cells = f64::from(self.config.cells);
        let open_v = open_circuit_v(charge);
        // The voltage drop of all batteries in parallel at the drawn power, from one fixed-point iteration.
        let sag_v = self.drawn_w / (open_v * cells) * self.config.resistance_ohm / cells;
        let cell_v = (open_v - sag_v).max(0.0);
        let spread = match number.checked_sub(1).and_then(|index| self.spread.get(index as usize)) {
            Some(spread) => *spread,
            None => self.spread.iter().fold((0.0, 0.0), |most: (f64, f64), spread| {
                (most.0.max(spread.0), most.1.max(spread.1))
            }),
        };
        let share = if number == 0 {
            1.0
        } else {
            1.0 / f64::from(self.config.batteries)
        };
        BatteryReading {
            stack_v: cell_v * cells,
            cell_min_v: (cell_v - spread.0).max(0.0),
            cell_max_v: cell_v + spread.1,
            temperature_c: water_c + self.config.warming_c_per_100w * self.drawn_w / 100.0,
            capacity_kwh: self.config.capacity_wh * share / 1000.0,
            charge_percent: charge * 100.0,
        }
    }
}

struct BatteryReading {
    stack_v: f64,
    cell_min_v: f64,
    cell_max_v: f64,
    temperature_c: f64,
    capacity_kwh: f64,
    charge_percent: f64,
}

impl Power {
    /// One step of the vehicle. Returns whether the payload's power goes off in it.
    #[must_use]
    pub(crate) fn step(&mut self, ctx: &mut Context<'_>) -> bool {
        let seconds = ctx.period.as_secs_f64();
        let speed_mps = if ctx.quiet.driven {
            ctx.vehicle.motion().surge_mps.max(0.0)
        } else {
            0.0
        };
        self.drawn_w = self.config.hotel_w + self.config.propulsion_w_at_1_mps * speed_mps * speed_mps * speed_mps;
        self.used_j += self.drawn_w * seconds;
        if ctx.now >= self.next_status {
            self.next_status = ctx.now + Duration::from_secs_f64(self.config.status_period_s);
            self.report_batteries(ctx);
        }
        self.watch(ctx)
    }

    fn report_batteries(&self, ctx: &mut Context<'_>) {
        if !ctx.wanted(Topic::Battery.bit()) {
            return;
        }
        let water_c = ctx
            .world
            .temperature_c(ctx.vehicle.motion().at, ctx.vehicle.motion().depth_m, ctx.now);
        // The pseudo battery 0 exists only in systems with several batteries (SPI 6.8).
        let first = u32::from(self.config.batteries == 1);
        for number in first..=self.config.batteries {
            let reading = self.status(number, water_c);
            let message = Battery {
                created: ctx.stamp(),
                number,
                voltage_v: Some(reading.stack_v),
                cell_min_v: Some(reading.cell_min_v),
                cell_max_v: Some(reading.cell_max_v),
                temperature_c: Some(reading.temperature_c),
                capacity_kwh: Some(reading.capacity_kwh),
                charge_percent: Some(reading.charge_percent),
            };
            ctx.publish(Some(Topic::Battery), &message.into());
        }
    }

    /// Announces the end of the payload's power, and switches it off when it is due. Returns whether it goes off now.
    /// Every client is then cut off.
    #[must_use]
    pub(crate) fn watch(&mut self, ctx: &mut Context<'_>) -> bool {
        let low = self
            .config
            .shutdown_below_percent
            .is_some_and(|threshold| self.charge() * 100.0 <= threshold);
        if low && !self.shutdown_said {
            self.shut_down(ctx.now);
        }
        let Some(at) = self.shutdown_at else { return false };
        if !self.shutdown_said && ctx.now + SHUTDOWN_NOTICE + ctx.period > at {
            self.shutdown_said = true;
            // The notice is never shorter, even if the scheduled time is that of the next step.
            self.shutdown_at = Some(at.max(ctx.now + SHUTDOWN_NOTICE));
            let created = ctx.stamp();
            ctx.note(MvcEventKind::ShutdownSoon);
            ctx.publish(None, &Shutdown { created }.into());
        } else if self.is_on && ctx.now >= at {
            self.is_on = false;
            ctx.note(MvcEventKind::PowerOff);
            ctx.server.cut_off_all(DropReason::PowerOff);
            return true;
        }
        false
    }
}

/// Voltage of a lithium-ion cell without load, volts, for a state of charge from 0 to 1. Source: Chen and Rincon-Mora,
/// "Accurate electrical battery model capable of predicting runtime and I-V performance", IEEE Transactions on Energy
/// Conversion 21(2), 2006.
fn open_circuit_v(charge: f64) -> f64 {
    let square = charge * charge;
    -1.031 * exp(-35.0 * charge) + 3.685 + 0.2156 * charge - 0.1178 * square + 0.3201 * square * charge
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_published_voltages() {
        assert!((open_circuit_v(1.0) - 4.1029).abs() < 1e-4);
        assert!((open_circuit_v(0.0) - 2.654).abs() < 1e-9);
        let falls = (0..100).all(|i| open_circuit_v(f64::from(i) / 100.0) < open_circuit_v(f64::from(i + 1) / 100.0));
        assert!(falls);
    }
}
