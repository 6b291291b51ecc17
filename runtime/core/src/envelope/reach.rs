//! What a modify can lead to, and for how long a judgement of it holds while the vehicle goes on (safety requirements
//! 002 and 004).
//!
//! A judgement says by how many metres the fence holds: no edge comes nearer than that to anything that was judged. All
//! that was judged are convex hulls of the vehicle's place, of the end of what it can reach, of the points of lines abeam
//! of the two and of points of the plan, each grown by one radius. Where those two places have moved by no more than `d`,
//! the points abeam by no more than `s d`, where `s` is [`FAN_STRETCH`], and the radius has grown by no more than `g`, no
//! point of the new hulls is further than `s d + g` from a point of the old ones, and the whole judgement made anew would
//! still find at least the old clearance less `s d + g`. So as long as that is not negative, the depths and the
//! altitude are within what was judged, and plan and inserts are the same, there is nothing to find; in every other case
//! the whole judgement is made.
//!
//! Depths and altitude have no clearance. They are judged with some room, so that a setpoint above an uneven bottom is not
//! judged in full at every sample; where that room is not there, without it.

use backseat_fence::{Shape, VerticalExtent};
use backseat_units::math::{SQRT_2, cos, hypot};
use backseat_units::{EastNorth, Timestamp, utm_convergence_deg};

use super::ends::{End, farthest_m};
use super::onto::FAN_STRETCH;
use super::{BottomLock, Clocks, Envelope, MODIFY_TIMEOUT, Route, Setpoint, Track, refusal, turn_radius_m};
use crate::plugin::{NavigationSample, Refusal};
use crate::switches::{Check, is_on};

/// The room that depths and altitude are judged with where they have it, metres.
const ROOM_M: f64 = 2.0;
/// What rounding could take from a clearance, and far more, metres.
const SLACK_M: f64 = 1e-3;

/// Where a modify can lead until the vehicle has noticed our silence and turned away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    /// Where the vehicle is.
    here: EastNorth,
    /// Where it is if it is straight on its heading already.
    ahead: EastNorth,
    /// How far it may be from the line between the two, metres.
    radius_m: f64,
    /// From here to there, metres.
    along_m: f64,
    /// How long it may be on its way there and in the turn away, seconds.
    lasts_s: f64,
}

/// A modify that was judged and holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Judgement {
    reach: Reach,
    extent: VerticalExtent,
    /// By how many metres it holds in the plane.
    clearance_m: f64,
}

impl Reach {
    /// How far the vehicle can come from where it is, metres.
    fn farthest_m(&self) -> f64 {
        self.along_m + self.radius_m
    }
}

impl Envelope {
    fn reach(&self, setpoint: &Setpoint, navigation: &NavigationSample, now: Timestamp) -> Reach {
        let limits = &self.limits;
        let ground_mps = hypot(navigation.east_mps, navigation.north_mps);
        let speed_mps = setpoint.speed.as_mps().max(ground_mps);
        let radius_of_turn_m = turn_radius_m(speed_mps, limits.turn_rate_dps);
        let turn_deg = navigation.heading.turn_to_deg(setpoint.heading).abs();
        let obeyed_s =
            MODIFY_TIMEOUT.as_secs_f64() + now.since(navigation.solution).as_secs_f64() + limits.link_delay_max_s;
        let turn_away_s = 180.0 / limits.turn_rate_dps;
        let here = navigation.local;
        let along_m = speed_mps * obeyed_s;
        let convergence_deg = self.fence.frame().convergence_deg(navigation.position);
        let ahead = here.offset(setpoint.heading.as_deg() - convergence_deg, along_m);
        // The specification does not say which north the vehicle counts from, so the set covers both.
        let other_north_m = along_m * utm_convergence_deg(navigation.position).to_radians().abs();
        // Sideways in the turn onto the heading, a whole turn's width in the turn away from it, where the vehicle may go as
        // fast again as it is let, and the current's part.
        let fastest_mps = speed_mps.max(limits.speed_max_mps);
        let radius_m = radius_of_turn_m * (1.0 - cos(turn_deg.to_radians()))
            + 2.0 * turn_radius_m(fastest_mps, limits.turn_rate_dps)
            + limits.current_max_mps * (obeyed_s + turn_away_s)
            + limits.navigation_error_m
            + other_north_m;
        Reach {
            here,
            ahead,
            radius_m,
            along_m,
            lasts_s: obeyed_s + turn_away_s,
        }
    }

    /// Safety requirement 002 for a modify: every position that the vehicle can reach until it has noticed our silence
    /// and turned away, and the ways back to its plan. By how many metres it holds.
    pub(crate) fn judge_modify(
        &self,
        setpoint: &Setpoint,
        navigation: &NavigationSample,
        lock: Option<BottomLock>,
        route: &Route,
        (now, clocks): (Timestamp, Clocks),
    ) -> Result<f64, Refusal> {
        let reach = self.reach(setpoint, navigation, now);
        let extent = self.extent(
            setpoint.vertical,
            navigation.depth,
            lock,
            reach.here,
            reach.farthest_m(),
        )?;
        self.judge_reach(&reach, &extent, route, clocks)
    }

    /// The same, for a lease whose judgement is to be kept.
    pub(crate) fn judge_lease(
        &self,
        setpoint: &Setpoint,
        navigation: &NavigationSample,
        lock: Option<BottomLock>,
        route: &Route,
        (now, clocks): (Timestamp, Clocks),
    ) -> Result<Judgement, Refusal> {
        let reach = self.reach(setpoint, navigation, now);
        let exact = self.extent(
            setpoint.vertical,
            navigation.depth,
            lock,
            reach.here,
            reach.farthest_m(),
        )?;
        let roomy = VerticalExtent {
            depth_min_m: (exact.depth_min_m - ROOM_M).max(0.0),
            depth_max_m: exact.depth_max_m + ROOM_M,
            altitude_min_m: exact.altitude_min_m - ROOM_M,
        };
        // What holds with room holds without.
        let (extent, clearance_m) = match self.judge_reach(&reach, &roomy, route, clocks) {
            Ok(clearance_m) => (roomy, clearance_m),
            Err(_) => (exact, self.judge_reach(&reach, &exact, route, clocks)?),
        };
        Ok(Judgement {
            reach,
            extent,
            clearance_m,
        })
    }

    /// Whether a judgement of the same setpoint, plan and inserts still answers for what the vehicle can reach now. False
    /// where it may not: then all is to be judged anew.
    pub(crate) fn still_holds(
        &self,
        judged: &Judgement,
        setpoint: &Setpoint,
        navigation: &NavigationSample,
        lock: Option<BottomLock>,
        now: Timestamp,
    ) -> bool {
        // What holds now may not a moment later, whatever the distance.
        if self.timed {
            return false;
        }
        let reach = self.reach(setpoint, navigation, now);
        let Ok(extent) = self.extent(
            setpoint.vertical,
            navigation.depth,
            lock,
            reach.here,
            reach.farthest_m(),
        ) else {
            return false;
        };
        let moved_m = reach
            .here
            .distance_m(judged.reach.here)
            .max(reach.ahead.distance_m(judged.reach.ahead));
        let grown_m = (reach.radius_m - judged.reach.radius_m).max(0.0);
        // Written so that a figure that is none fails.
        FAN_STRETCH * moved_m + grown_m + SLACK_M <= judged.clearance_m
            && extent.depth_min_m >= judged.extent.depth_min_m
            && extent.depth_max_m <= judged.extent.depth_max_m
            && extent.altitude_min_m >= judged.extent.altitude_min_m
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
        // It takes no longer back than from the farthest that it can come to the farthest that it may return to, straight
        // or by way of a line.
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
        // Back to the plan its own depths hold, which are the front seat's affair, but for what is to be kept out of. Each
        // of the ways covers the way straight ahead, which need not be looked at again, but says best what is wrong.
        let legs = route.legs.iter().flat_map(|track| track.onto(&[here, ahead]));
        // What begins where a leg ends is in the leg's shape.
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
                Shape::hulls(&corners.chain([here, ahead]).collect::<Vec<_>>())
            }
        });
        let ways: Vec<Shape> = legs.chain(on).collect();
        let within_m = route.legs.iter().map(Track::within_m).fold(0.0, f64::max);
        self.check_all(&ways, radius_m + within_m, extent, (route.passed_m(extent), when))
            .map(|clearance| clearance.metres)
            .map_err(|breach| straight().err().unwrap_or_else(|| refusal(&breach)))
    }
}

#[cfg(test)]
mod tests {
    use backseat_fence::Fence;
    use backseat_units::{Altitude, Depth, Heading, Speed, Utc};

    use super::*;
    use crate::envelope::{Approach, Vertical, bottom_lock};
    use crate::limits::Limits;
    use crate::limits::tests::limits;

    /// Some 1650 by 2200 m, with a wreck in the middle that is forbidden below 30 m.
    const FENCE: &str = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"name":"box","kind":"inclusion","margin_m":10,"depth_max_m":60,"altitude_min_m":3},
         "geometry":{"type":"Polygon","coordinates":[
            [[-70.01,41.99],[-69.99,41.99],[-69.99,42.01],[-70.01,42.01],[-70.01,41.99]]]}},
        {"type":"Feature","properties":{"name":"wreck","kind":"exclusion","margin_m":20,"depth_min_m":30},
         "geometry":{"type":"Polygon","coordinates":[
            [[-70.001,41.999],[-69.999,41.999],[-69.999,42.001],[-70.001,42.001],[-70.001,41.999]]]}}]}"#;

    /// The time is not known.
    const UNKNOWN: Clocks = Clocks {
        utc: Utc::from_unix_nanos(0),
        apart: None,
    };

    /// A small generator: the same walk wherever the test runs.
    struct Draw(u64);

    impl Draw {
        fn within(&mut self, min: f64, max: f64) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            min + (max - min) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
        }
    }

    fn sample(envelope: &Envelope, local: EastNorth, depth_m: f64, altitude_m: f64, millis: u64) -> NavigationSample {
        NavigationSample {
            solution: Timestamp::from_millis(millis),
            position: envelope.fence().frame().to_position(local),
            local,
            depth: Depth::from_m(depth_m).unwrap(),
            altitude: Some(Altitude::from_m(altitude_m).unwrap()),
            heading: Heading::from_deg(0.0).unwrap(),
            roll_deg: 0.0,
            pitch_deg: 0.0,
            east_mps: 0.0,
            north_mps: 0.0,
            down_mps: 0.0,
            yaw_rate_dps: 0.0,
            gps: false,
        }
    }

    #[test]
    fn sr_004_a_judgement_that_still_holds_never_hides_one_that_would_not() {
        let envelope = Envelope::new(
            Fence::from_geojson(FENCE).unwrap(),
            Limits {
                water_depth_max_m: Some(200.0),
                ..limits()
            },
        );
        let mut draw = Draw(5);
        let (mut kept, mut renewed, mut ended) = (0, 0, 0);
        for _ in 0..300 {
            let mut local = EastNorth::new(draw.within(-800.0, 800.0), draw.within(-1000.0, 1000.0));
            let (mut depth_m, mut bottom_m) = (draw.within(2.0, 60.0), 80.0);
            let mut course_deg = draw.within(0.0, 360.0);
            let vertical = if draw.within(0.0, 1.0) < 0.5 {
                Vertical::Depth(Depth::from_m(draw.within(2.0, 58.0)).unwrap())
            } else {
                Vertical::Altitude(Altitude::from_m(draw.within(4.0, 40.0)).unwrap())
            };
            let setpoint = Setpoint {
                heading: Heading::from_deg(draw.within(0.0, 359.0)).unwrap(),
                vertical,
                speed: Speed::from_mps(draw.within(1.0, 2.0)).unwrap(),
            };
            let to = EastNorth::new(draw.within(-700.0, 700.0), draw.within(-900.0, 900.0));
            let leg = (EastNorth::new(-300.0, -600.0), EastNorth::new(300.0, -600.0));
            let approach = Approach {
                begun: EastNorth::new(-260.0, -610.0),
                within_m: 3.0,
                to: [leg.0, leg.0 + EastNorth::new(50.0, 0.0)],
            };
            let route = Route {
                to: vec![End::At(to)],
                legs: vec![Track::Line(leg.0, leg.1), Track::Approach(approach)],
                ..Route::default()
            };
            let mut judged: Option<Judgement> = None;
            for tick in 0..400u64 {
                course_deg += draw.within(-3.0, 3.0);
                local = local.offset(course_deg, draw.within(0.0, 0.4));
                depth_m = (depth_m + draw.within(-0.2, 0.2)).clamp(0.0, 70.0);
                bottom_m = (bottom_m + draw.within(-0.5, 0.5)).clamp(62.0, 120.0);
                let mut navigation = sample(&envelope, local, depth_m, bottom_m - depth_m, 100 * tick);
                navigation.east_mps = draw.within(-2.0, 2.0);
                navigation.heading = Heading::from_deg(course_deg.rem_euclid(360.0)).unwrap();
                let now = Timestamp::from_millis(100 * tick + 40);
                let lock = bottom_lock(&navigation);
                let when = (now, UNKNOWN);
                let whole = envelope.judge_modify(&setpoint, &navigation, lock, &route, when);
                if let Some(judged) = &judged
                    && envelope.still_holds(judged, &setpoint, &navigation, lock, now)
                {
                    assert!(whole.is_ok(), "{whole:?} at {local:?}");
                    kept += 1;
                    continue;
                }
                let lease = envelope.judge_lease(&setpoint, &navigation, lock, &route, when);
                assert_eq!(lease.is_ok(), whole.is_ok());
                match lease {
                    Ok(judgement) => judged = Some(judgement),
                    Err(_) => {
                        ended += 1;
                        break;
                    }
                }
                renewed += 1;
            }
        }
        assert!(ended > 50, "{ended}");
        assert!(kept > 5 * renewed, "{kept} kept, {renewed} judged in full");
    }

    #[test]
    fn what_is_not_always_valid_is_judged_in_full_each_time() {
        let timed = FENCE.replace("\"depth_min_m\":30", "\"valid_until\":\"2030-01-01T00:00:00Z\"");
        let envelope = Envelope::new(Fence::from_geojson(&timed).unwrap(), limits());
        let navigation = sample(&envelope, EastNorth::new(-400.0, 0.0), 20.0, 60.0, 0);
        let setpoint = Setpoint {
            heading: Heading::from_deg(0.0).unwrap(),
            vertical: Vertical::Depth(Depth::from_m(20.0).unwrap()),
            speed: Speed::from_mps(1.5).unwrap(),
        };
        let (lock, now) = (bottom_lock(&navigation), Timestamp::ZERO);
        let judged = envelope
            .judge_lease(&setpoint, &navigation, lock, &Route::default(), (now, UNKNOWN))
            .unwrap();
        assert!(!envelope.still_holds(&judged, &setpoint, &navigation, lock, now));
    }
}
