//! Whether navigation can be true (SPI 6.1, 6.2; safety requirement 024).
//!
//! Single samples pass for possible that no vehicle can make one after the other. So navigation is held against itself
//! over windows: its position against its own velocity, its heading against its yaw rate, its depth against its rate, the
//! seabed that it tells of against what it told of just before. What has been integrated since a sample of the window and
//! what was measured since must agree within a step, which is what noise and a correction may do, and a drift, which is
//! what the two may differ by from one second to the next.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_spi::VelocityAndRates;
use backseat_units::EastNorth;

use crate::ended::EndCause;
use crate::monitor::limits::Limits;
use crate::monitor::limits::integrity::IntegrityLimits;
use crate::plugin::NavigationSample;

/// Samples are compared over so long: less than navigation must be steady for, so that what goes on being untrue is found
/// again before it steers.
const WINDOW_S: f64 = 9.5;
/// One sample in so long is kept for that; the newest is always compared with the one before it.
const KEPT_EVERY_S: f64 = 0.5;
/// Below this a vehicle may stand still, metres a second.
const UNDER_WAY_MPS: f64 = 0.3;
/// GPS is heard no deeper than this, antenna and waves included, whatever the sample says, metres.
const SURFACE_M: f64 = 3.0;
/// After a gap as long as this nothing is known of what lay between, seconds.
const GAP_S: f64 = 3.0;

/// What in navigation cannot be true.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Flaw {
    /// In a few words, for whoever loses control by it.
    pub(crate) what: EndCause,
    /// With figures.
    pub(crate) text: String,
}

/// A sample, and what had been integrated of the vehicle's rates until then.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Mark {
    at_s: f64,
    /// Position less what the velocities add up to, metres.
    off: EastNorth,
    depth_m: f64,
    /// Depth less what the velocity downwards adds up to, metres.
    depth_off_m: f64,
    /// Heading less what the yaw rate adds up to, degrees, not brought within a circle.
    heading_off_deg: f64,
    place: EastNorth,
    /// Depth plus altitude, where there was bottom lock, metres.
    seabed_m: Option<f64>,
}

/// The navigation of one connection, as far back as the window reaches.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Integrity {
    limits: IntegrityLimits,
    slope_max: f64,
    marks: VecDeque<Mark>,
    last: Option<(Mark, Rates)>,
    /// What the rates have added up to.
    sum: Sum,
    /// Since when the position has been the same to the last digit while the velocity says that it cannot be, by the
    /// solutions' time.
    frozen_since_s: Option<f64>,
    /// The last sample was GPS's.
    by_gps: bool,
}

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Sum {
    at_s: f64,
    way: EastNorth,
    down_m: f64,
    turned_deg: f64,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Rates {
    way_mps: EastNorth,
    down_mps: f64,
    yaw_dps: f64,
}

impl Rates {
    fn of(message: &VelocityAndRates) -> Self {
        Self {
            way_mps: EastNorth::new(message.east_mps, message.north_mps),
            down_mps: message.down_mps,
            yaw_dps: message.yaw_rate_dps,
        }
    }

    fn speed_mps(&self) -> f64 {
        self.way_mps.distance_m(EastNorth::default())
    }
}

impl Integrity {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            limits: limits.integrity.resolved(limits),
            slope_max: limits.seabed_slope_max,
            marks: VecDeque::new(),
            last: None,
            sum: Sum::default(),
            frozen_since_s: None,
            by_gps: false,
        }
    }

    /// What came before says nothing of what comes: another connection, a jump, a fix.
    pub(crate) fn forget(&mut self) {
        self.marks.clear();
        self.last = None;
        self.frozen_since_s = None;
    }

    /// How long navigation may come without its velocities.
    pub(crate) fn velocity_gap_max(&self) -> Duration {
        Duration::from_secs_f64(self.limits.velocity_gap_s)
    }

    /// A sample with its velocities, `elapsed_s` of the vehicle's clock after the one before. The first flaw that it shows,
    /// after which nothing before it counts any more.
    pub(crate) fn follow(
        &mut self,
        sample: &NavigationSample,
        message: &VelocityAndRates,
        elapsed_s: f64,
    ) -> Option<Flaw> {
        let rates = Rates::of(message);
        let by_gps = sample.gps && sample.depth.as_m() <= SURFACE_M;
        let was_by_gps = core::mem::replace(&mut self.by_gps, by_gps);
        if elapsed_s > GAP_S || by_gps || was_by_gps {
            // On the surface GPS moves the solution as it likes.
            self.forget();
        }
        if let Some((_, before)) = &self.last {
            self.sum.add(before, &rates, elapsed_s);
        }
        let mark = self.sum.mark(sample);
        let flaw = self.flaw(&mark, &rates);
        if flaw.is_some() {
            self.marks.clear();
            self.frozen_since_s = None;
        }
        if self
            .marks
            .back()
            .is_none_or(|kept| mark.at_s - kept.at_s >= KEPT_EVERY_S)
        {
            self.marks.push_back(mark);
        }
        while self.marks.front().is_some_and(|kept| mark.at_s - kept.at_s > WINDOW_S) {
            self.marks.pop_front();
        }
        self.last = Some((mark, rates));
        flaw
    }

    fn flaw(&mut self, mark: &Mark, rates: &Rates) -> Option<Flaw> {
        let limits = self.limits;
        let speed_mps = rates.speed_mps();
        if exceeds(speed_mps, limits.speed_max_mps()) {
            let text = format!("{speed_mps:.1} m/s, over {:.1}", limits.speed_max_mps());
            return Some(flaw(EndCause::VelocityTooHigh, text));
        }
        if exceeds(rates.down_mps.abs(), limits.depth_rate_max_mps) {
            let text = format!("{:.1} m/s, over {:.1}", rates.down_mps, limits.depth_rate_max_mps);
            return Some(flaw(EndCause::VerticalVelocityTooHigh, text));
        }
        if let Some(frozen) = self.frozen(mark, speed_mps) {
            return Some(frozen);
        }
        let (last, _) = self.last.as_ref()?;
        let since = self.marks.iter().chain([last]);
        since.into_iter().find_map(|before| self.disagreement(before, mark))
    }

    /// The same position to the last digit, sample after sample, of a vehicle that says that it moves.
    fn frozen(&mut self, mark: &Mark, speed_mps: f64) -> Option<Flaw> {
        let same = self.last.as_ref().is_some_and(|(last, _)| last.place == mark.place);
        if !same || speed_mps < UNDER_WAY_MPS {
            self.frozen_since_s = None;
            return None;
        }
        let since_s = *self.frozen_since_s.get_or_insert(mark.at_s);
        let for_s = mark.at_s - since_s;
        (for_s >= self.limits.frozen_s).then(|| {
            let text = format!("the same for {for_s:.1} s at {speed_mps:.1} m/s");
            flaw(EndCause::PositionFrozen, text)
        })
    }

    /// Where a sample of the window and the newest cannot both be true.
    fn disagreement(&self, before: &Mark, mark: &Mark) -> Option<Flaw> {
        let limits = &self.limits;
        let span_s = mark.at_s - before.at_s;
        let off_m = mark.off.distance_m(before.off);
        if exceeds(off_m, limits.position_step_m + limits.position_drift_mps * span_s) {
            let text = format!("{off_m:.1} m apart within {span_s:.1} s");
            return Some(flaw(EndCause::PositionAgainstVelocity, text));
        }
        let moved_m = mark.place.distance_m(before.place);
        if exceeds(moved_m, limits.position_step_m + limits.speed_max_mps() * span_s) {
            let text = format!("{moved_m:.1} m within {span_s:.1} s");
            return Some(flaw(EndCause::PositionTooFast, text));
        }
        let dived_m = (mark.depth_m - before.depth_m).abs();
        if exceeds(dived_m, limits.depth_step_m + limits.depth_rate_max_mps * span_s) {
            let text = format!("{dived_m:.1} m within {span_s:.1} s");
            return Some(flaw(EndCause::DepthTooFast, text));
        }
        let depth_off_m = (mark.depth_off_m - before.depth_off_m).abs();
        if exceeds(depth_off_m, limits.depth_step_m + limits.depth_drift_mps * span_s) {
            let text = format!("{depth_off_m:.1} m apart within {span_s:.1} s");
            return Some(flaw(EndCause::DepthAgainstVelocity, text));
        }
        let turned_deg = within_half_a_circle(mark.heading_off_deg - before.heading_off_deg).abs();
        if exceeds(turned_deg, limits.heading_step_deg + limits.heading_drift_dps * span_s) {
            let text = format!("{turned_deg:.0} degrees apart within {span_s:.1} s");
            return Some(flaw(EndCause::HeadingAgainstYawRate, text));
        }
        if let (Some(there_m), Some(here_m)) = (before.seabed_m, mark.seabed_m) {
            let rises_m = (here_m - there_m).abs();
            let allowed_m = limits.seabed_step_m + self.slope_max * moved_m;
            if exceeds(rises_m, allowed_m) {
                let text = format!("{rises_m:.1} m within {moved_m:.1} m of way");
                return Some(flaw(EndCause::SeabedJumps, text));
            }
        }
        None
    }
}

impl Sum {
    /// Both samples' rates count half: the vehicle's turn between them is followed to the second order.
    fn add(&mut self, before: &Rates, now: &Rates, elapsed_s: f64) {
        let half_s = elapsed_s / 2.0;
        self.at_s += elapsed_s;
        self.way.east_m += half_s * (before.way_mps.east_m + now.way_mps.east_m);
        self.way.north_m += half_s * (before.way_mps.north_m + now.way_mps.north_m);
        self.down_m += half_s * (before.down_mps + now.down_mps);
        self.turned_deg += half_s * (before.yaw_dps + now.yaw_dps);
    }

    fn mark(&self, sample: &NavigationSample) -> Mark {
        let depth_m = sample.depth.as_m();
        Mark {
            at_s: self.at_s,
            off: EastNorth::new(
                sample.local.east_m - self.way.east_m,
                sample.local.north_m - self.way.north_m,
            ),
            depth_m,
            depth_off_m: depth_m - self.down_m,
            heading_off_deg: sample.heading.as_deg() - self.turned_deg,
            place: sample.local,
            seabed_m: sample.altitude.map(|altitude| depth_m + altitude.as_m()),
        }
    }
}

fn flaw(what: EndCause, text: String) -> Flaw {
    Flaw { what, text }
}

/// What is no number exceeds everything.
fn exceeds(figure: f64, limit: f64) -> bool {
    figure.is_nan() || figure > limit
}

fn within_half_a_circle(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}
