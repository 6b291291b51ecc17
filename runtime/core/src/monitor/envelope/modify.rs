//! What a modify can lead to (safety requirements 002 and 004).

use backseat_fence::{Shape, VerticalExtent};
use backseat_units::math::{SQRT_2, cos, hypot};
use backseat_units::{EastNorth, Timestamp, utm_convergence_deg};

use super::ends::{End, farthest_m};
use super::{BottomLock, Clocks, Envelope, MODIFY_TIMEOUT, Route, Setpoint, Track, turn_radius_m};
use crate::mutations::{Check, is_on};
use crate::plugin::{NavigationSample, Refusal};

/// Where a modify can lead until the vehicle has noticed our silence and turned away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    /// Where the vehicle is.
    here: EastNorth,
    /// Where it will be if it is on the requested heading already and flies straight on.
    ahead: EastNorth,
    /// How far it may be from the line between the two, metres.
    radius_m: f64,
    /// The distance from `here` to `ahead`, metres.
    along_m: f64,
    /// How long the way to `ahead` and the turn away take together, seconds.
    lasts_s: f64,
}

impl Reach {
    /// How far the vehicle can come from where it is, metres.
    fn farthest_m(&self) -> f64 {
        self.along_m + self.radius_m
    }
}

/// Where the live modify can lead until the vehicle has noticed our silence and turned away (safety requirement 002): all
/// places within a radius of a line. Metres in the fence's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeaseReach {
    /// Where the vehicle is.
    pub here: EastNorth,
    /// Where it will be if it is on the requested heading already and flies straight on.
    pub ahead: EastNorth,
    /// How far it may be from the line between the two, metres.
    pub radius_m: f64,
}

impl Envelope {
    /// Where a modify can lead, for people to look at.
    pub(crate) fn lease_reach(
        &self,
        setpoint: &Setpoint,
        navigation: &NavigationSample,
        seen_mps: f64,
        now: Timestamp,
    ) -> LeaseReach {
        let Reach {
            here, ahead, radius_m, ..
        } = self.reach(setpoint, navigation, seen_mps, now);
        LeaseReach { here, ahead, radius_m }
    }

    fn reach(&self, setpoint: &Setpoint, navigation: &NavigationSample, seen_mps: f64, now: Timestamp) -> Reach {
        let limits = &self.limits;
        let ground_mps = hypot(navigation.east_mps, navigation.north_mps);
        let speed_mps = setpoint.speed.as_mps().max(ground_mps);
        let radius_of_turn_m = turn_radius_m(speed_mps, limits.turn_rate_dps);
        let turn_deg = navigation.heading.turn_to_deg(setpoint.heading).abs();
        let obeyed_s =
            MODIFY_TIMEOUT.as_secs_f64() + now.since(navigation.solution).as_secs_f64() + limits.link_delay_max_s;
        let here = navigation.local;
        let along_m = speed_mps * obeyed_s;
        let convergence_deg = self.fence.frame().convergence_deg(navigation.position);
        let ahead = here.offset(setpoint.heading.as_deg() - convergence_deg, along_m);
        // The specification does not say from which north the vehicle counts, so the reach covers both.
        let other_north_m = along_m * utm_convergence_deg(navigation.position).to_radians().abs();
        // The terms, in order: the sideways distance of the turn onto the heading, and of the lag of that turn; the
        // width of a whole turn away from the heading, which the vehicle may fly at its greatest speed; the drift in
        // the current; the error of navigation; and the other north.
        let fastest_mps = speed_mps.max(self.fastest_mps(seen_mps));
        let radius_m = radius_of_turn_m * (1.0 - cos(turn_deg.to_radians()))
            + speed_mps * limits.turn_lag_s
            + self.turn_away_m(fastest_mps)
            + limits.current_max_mps * (obeyed_s + self.turn_away_s())
            + limits.navigation_error_m
            + other_north_m;
        Reach {
            here,
            ahead,
            radius_m,
            along_m,
            lasts_s: obeyed_s + self.turn_away_s(),
        }
    }

    /// Judges a modify by safety requirement 002: every position that the vehicle can reach until it has noticed our
    /// silence and turned away, and the ways back to its plan. Returns the smallest clearance, metres.
    pub(crate) fn judge_modify(
        &self,
        setpoint: &Setpoint,
        navigation: &NavigationSample,
        lock: Option<BottomLock>,
        route: &Route,
        (now, clocks): (Timestamp, Clocks),
    ) -> Result<f64, Refusal> {
        let reach = self.reach(setpoint, navigation, route.seen_mps, now);
        let extent = self.extent(
            setpoint.vertical,
            navigation.depth,
            lock,
            reach.here,
            reach.farthest_m(),
        )?;
        self.judge_reach(&reach, &extent, route, clocks)
    }

    fn judge_reach(
        &self,
        reach: &Reach,
        extent: &VerticalExtent,
        route: &Route,
        clocks: Clocks,
    ) -> Result<f64, Refusal> {
        if !is_on(Check::ModifyFence) {
            return Ok(f64::MAX);
        }
        let Reach {
            here,
            ahead,
            radius_m,
            lasts_s,
            ..
        } = *reach;
        // The longest way back leads from the farthest place that the vehicle can reach to the farthest place that it
        // may return to. It is straight, or leads by way of a line and is then at most sqrt(2) times as long.
        let legs_m = route
            .legs
            .iter()
            .flat_map(Track::points)
            .map(|end| SQRT_2 * (here.distance_m(end) + reach.farthest_m()));
        let to_m = route
            .to
            .iter()
            .map(|to| farthest_m(End::At(here), *to) + reach.farthest_m());
        let back_s = legs_m.chain(to_m).fold(0.0, f64::max) / self.slowest_mps();
        let when = clocks.next(lasts_s + back_s.max(route.before_s));
        let straight = || self.sweep(Shape::leg(here, ahead), radius_m, extent, when);
        if (route.legs.is_empty() && route.to.is_empty()) || !is_on(Check::ModifyWayBack) {
            return straight();
        }
        // On the ways back to the plan the vehicle flies at the plan's depths. These are the front seat's
        // responsibility, except that keep-out zones count. Each of these shapes contains the way straight ahead, so
        // that way need not be checked on its own. But if the way straight ahead is refused too, its refusal is
        // returned, because it shows best what is wrong.
        let legs = route.legs.iter().flat_map(|track| track.onto(&[here, ahead]));
        // The shape of a leg contains the way to what begins where that leg starts or ends.
        let ends_a_leg = |next: &&End| {
            let at = |point| **next == End::At(point);
            let mut legs = route.legs.iter();
            legs.any(|track| matches!(track, Track::Line(start, end) if at(*start) || at(*end)))
        };
        let to = route.to.iter().filter(|next| !ends_a_leg(next));
        let on = to.flat_map(|next| match next {
            End::At(next) => vec![Shape::triangle(here, ahead, *next)],
            End::Anywhere { .. } | End::Within { .. } => {
                let corners = next.corners().into_iter();
                Shape::convex_hulls(&corners.chain([here, ahead]).collect::<Vec<_>>())
            }
        });
        let ways: Vec<Shape> = legs.chain(on).collect();
        let within_m = route.legs.iter().map(Track::within_m).fold(0.0, f64::max);
        self.check_all(&ways, radius_m + within_m, extent, (route.passed_m(extent), when))
            .map(|clearance| clearance.metres)
            .map_err(|breach| {
                straight()
                    .err()
                    .unwrap_or_else(|| Refusal::on_the_way_on(breach.into()))
            })
    }
}
