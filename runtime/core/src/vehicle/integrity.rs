//! Whether navigation can be true (SPI 6.1, 6.2; safety requirement 024).
//!
//! Each of two samples can be possible although no vehicle can make one after the other. So navigation is compared with
//! itself over a window: its position with its own velocity, its heading with its yaw rate, its depth with its vertical
//! velocity, and the seabed that it shows with the one that it showed just before. What has been integrated since an
//! earlier sample of the window, and what has been measured since, must agree within a step and a drift. The step is
//! what noise and a correction may do. The drift is by how much more the two may differ with each second.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_spi::VelocityAndRates;
use backseat_units::EastNorth;

use crate::ended::EndCause;
use crate::monitor::limits::Limits;
use crate::monitor::limits::integrity::IntegrityLimits;
use crate::plugin::NavigationSample;

/// How long the window is. It is shorter than the time for which navigation must be steady, so that navigation which
/// stays untrue is found again before it steers.
const WINDOW_S: f64 = 9.5;
/// The window keeps one sample in this time. The newest sample is always compared with the one before it too.
const KEPT_EVERY_S: f64 = 0.5;
/// A vehicle that is slower than this may be standing still, metres a second.
const UNDER_WAY_MPS: f64 = 0.3;
/// GPS cannot be received deeper than this, antenna and waves included, whatever the sample says, metres.
const SURFACE_M: f64 = 3.0;
/// After a gap longer than this, nothing is known about what lay in it, seconds.
const GAP_S: f64 = 3.0;

/// A way in which navigation cannot be true.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Flaw {
    /// What is wrong: the cause with which leases end.
    pub(crate) what: EndCause,
    /// The figures, as a text.
    pub(crate) text: String,
}

/// A sample, and what had been integrated of the vehicle's rates until then.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Mark {
    at_s: f64,
    /// Position minus the integrated velocity, metres.
    off: EastNorth,
    depth_m: f64,
    /// Depth minus the integrated downward velocity, metres.
    depth_off_m: f64,
    /// Heading minus the integrated yaw rate, degrees, not reduced to one circle.
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
    /// The integrated rates.
    sum: Sum,
    /// Since when the position has been the same to the last digit although the velocity says that the vehicle moves,
    /// by the times of the solutions.
    frozen_since_s: Option<f64>,
    /// The last sample was from GPS, at the surface.
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

    /// Forgets the window. After a new connection, a jump or a fix, earlier samples say nothing about later ones.
    pub(crate) fn forget(&mut self) {
        self.marks.clear();
        self.last = None;
        self.frozen_since_s = None;
    }

    /// How long navigation may come without its velocities.
    pub(crate) fn velocity_gap_max(&self) -> Duration {
        Duration::from_secs_f64(self.limits.velocity_gap_s)
    }

    /// Takes a sample with its velocities, `elapsed_s` after the one before by the vehicle's clock. Returns the first
    /// flaw that it shows. After a flaw, earlier samples do not count any more.
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
            // At the surface, GPS can move the solution by any distance.
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

    /// Whether velocities are over the limits of speed.
    pub(crate) fn too_fast(&self, message: &VelocityAndRates) -> Option<Flaw> {
        self.over_speed(&Rates::of(message))
    }

    fn over_speed(&self, rates: &Rates) -> Option<Flaw> {
        let limits = &self.limits;
        let speed_mps = rates.speed_mps();
        if exceeds(speed_mps, limits.speed_max_mps()) {
            let text = format!("{speed_mps:.1} m/s, over {:.1}", limits.speed_max_mps());
            return Some(flaw(EndCause::VelocityTooHigh, text));
        }
        if exceeds(rates.down_mps.abs(), limits.depth_rate_max_mps) {
            let text = format!("{:.1} m/s, over {:.1}", rates.down_mps, limits.depth_rate_max_mps);
            return Some(flaw(EndCause::VerticalVelocityTooHigh, text));
        }
        None
    }

    fn flaw(&mut self, mark: &Mark, rates: &Rates) -> Option<Flaw> {
        if let Some(flaw) = self.over_speed(rates).or_else(|| self.frozen(mark, rates.speed_mps())) {
            return Some(flaw);
        }
        let (last, _) = self.last.as_ref()?;
        let since = self.marks.iter().chain([last]);
        since.into_iter().find_map(|before| self.disagreement(before, mark))
    }

    /// The position is the same to the last digit, sample after sample, although the vehicle reports that it moves.
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

    /// A flaw if a sample of the window and the newest one cannot both be true.
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
                let text = format!("{rises_m:.1} m over {moved_m:.1} m travelled");
                return Some(flaw(EndCause::SeabedJumps, text));
            }
        }
        None
    }
}

impl Sum {
    /// The rates of both samples count half (the trapezoidal rule), so a turn between them is followed to the second
    /// order.
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

/// NaN exceeds every limit.
fn exceeds(figure: f64, limit: f64) -> bool {
    figure.is_nan() || figure > limit
}

fn within_half_a_circle(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}
