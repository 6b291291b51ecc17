//! When a geometry may be flown, for zones that are valid for a limited time (safety requirement 002).

use std::time::Duration;

use backseat_fence::{Breach, Clearance, Shape, Span, Sweep, VerticalExtent};
use backseat_units::Utc;

use super::Envelope;

/// If our UTC and the vehicle's differ by more than this, it is not known which of them is right.
pub(crate) const APART_MAX: Duration = Duration::from_secs(60);
/// A longer time counts as unknown, seconds.
const SECONDS_MAX: f64 = 7.0 * 86_400.0;

/// What is known about the time when a question is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clocks {
    /// Our UTC.
    pub(crate) utc: Utc,
    /// By how much the vehicle's UTC differs from ours; `None` if that is not known or is more than [`APART_MAX`].
    pub(crate) apart: Option<Duration>,
}

impl Clocks {
    /// The next `seconds`, by either of the clocks. `None` if the time is not known, or if `seconds` is not from 0 to
    /// seven days.
    pub(crate) fn next(&self, seconds: f64) -> Option<Span> {
        let apart = self.apart.filter(|apart| *apart <= APART_MAX)?;
        if !(0.0..=SECONDS_MAX).contains(&seconds) {
            return None;
        }
        let from = self.utc.as_unix_nanos();
        let apart_nanos = u64::try_from(apart.as_nanos()).ok()?;
        Some(Span {
            from: Utc::from_unix_nanos(from.saturating_sub(apart_nanos)),
            until: self.utc + Duration::from_secs_f64(seconds) + apart,
        })
    }
}

impl Envelope {
    /// The least speed at which the vehicle moves over the ground, m/s.
    pub(crate) fn slowest_mps(&self) -> f64 {
        self.limits.speed_min_mps - self.limits.current_max_mps
    }

    /// Checks a sweep against the fence as it is during `when`. Without `when`, every zone that is valid for a limited
    /// time counts at its worst.
    pub(super) fn check(
        &self,
        sweep: &Sweep,
        extent: &VerticalExtent,
        when: Option<Span>,
    ) -> Result<Clearance, Breach> {
        match when {
            Some(span) => self.fence.during(span).check(sweep, extent),
            None => self.fence.check(sweep, extent),
        }
    }

    /// As [`Envelope::check_passing`], for several shapes with one radius.
    pub(super) fn check_all(
        &self,
        shapes: &[Shape],
        radius_m: f64,
        extent: &VerticalExtent,
        (depths_m, when): ([f64; 2], Option<Span>),
    ) -> Result<Clearance, Breach> {
        match when {
            Some(span) => self.fence.during(span).check_all(shapes, radius_m, extent, depths_m),
            None => self.fence.check_all(shapes, radius_m, extent, depths_m),
        }
    }

    /// As [`Envelope::check`], for a way on which the vehicle may also be at other depths, from the first of `depths_m`
    /// to the second. Keep-out zones count at all of them.
    pub(super) fn check_passing(
        &self,
        sweep: &Sweep,
        extent: &VerticalExtent,
        (depths_m, when): ([f64; 2], Option<Span>),
    ) -> Result<Clearance, Breach> {
        match when {
            Some(span) => self.fence.during(span).check_passing(sweep, extent, depths_m),
            None => self.fence.check_passing(sweep, extent, depths_m),
        }
    }

    /// As [`Envelope::check`], for a place where the vehicle surfaces.
    pub(super) fn check_surfacing(
        &self,
        sweep: &Sweep,
        extent: &VerticalExtent,
        when: Option<Span>,
    ) -> Result<Clearance, Breach> {
        match when {
            Some(span) => self.fence.during(span).check_surfacing(sweep, extent),
            None => self.fence.check_surfacing(sweep, extent),
        }
    }

    /// As [`Envelope::check_surfacing`], of a path on which the vehicle may also be at other depths.
    pub(super) fn check_surfacing_passing(
        &self,
        sweep: &Sweep,
        extent: &VerticalExtent,
        (depths_m, when): ([f64; 2], Option<Span>),
    ) -> Result<Clearance, Breach> {
        match when {
            Some(span) => self.fence.during(span).check_surfacing_passing(sweep, extent, depths_m),
            None => self.fence.check_surfacing_passing(sweep, extent, depths_m),
        }
    }
}
