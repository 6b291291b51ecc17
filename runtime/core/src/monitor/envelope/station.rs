//! Station keeping and moves of a hovering vehicle against the boxes of the operator (SPI 8; safety requirements 002
//! and 020).
//!
//! The specification does not say on which path the vehicle goes to a place on the hull or over the bottom. So the
//! monitor allows for every path in the smallest box, with edges parallel to the axes, that contains where the vehicle
//! is, where it is to go, and where its mission was suspended, to which it may return (8.3). This box is widened by how
//! far the vehicle may stray. It must lie in the allowed box and touch no keep-out box.

use std::time::Duration;

use backseat_units::math::hypot;
use backseat_units::{Depth, EastNorth, Timestamp};

use super::boxes::{Left, avoid, bottom_axes, contain, hull_axes, left, span};
use super::{BottomLock, Envelope, Vertical, vertical};
use crate::monitor::limits::station::StationLimits;
use crate::mutations::{Check, is_on};
use crate::plugin::{
    CameraRequest, CartesianSample, LightRequest, NavigationSample, Refusal, RelativeSample, SonarAngleRequest,
    StationRequest, StationTarget,
};
use crate::refusal::{Figure, Reason, Stretch};

/// The vehicle stays suspended for this long after the last BPSUS, BPCON, BPGHP or BPGBP that it received (SPI 8.1).
const SUSPENSION_TIMEOUT: Duration = Duration::from_secs(2);
/// The least limit of speed, m/s. BPSPD has three decimals, so a limit near 0 would be written as 0.
const SPEED_MIN_MPS: f64 = 0.01;
/// The camera moves for at most this many tenths of a second (SPI 8.10).
const CAMERA_MAX: i32 = 9;

/// A place to which a vehicle that keeps its station is sent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Aim {
    /// BPGHP.
    Hull {
        horizontal_m: f64,
        vertical_m: f64,
        distance_m: f64,
    },
    /// BPGBP.
    Bottom { x_m: f64, y_m: f64, vertical: Vertical },
}

/// Station keeping whose values have been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Hover {
    /// `None`: the vehicle stays where it is.
    pub(crate) aim: Option<Aim>,
    /// The speed limit of its moves: the requested one, or the vehicle's own.
    pub(crate) speed_mps: f64,
}

/// Where the mission was suspended, in each frame in which that was known. After BPRES the vehicle may return there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Suspended {
    /// Horizontal, vertical, distance.
    pub(crate) hull_m: Option<[f64; 3]>,
    /// X, y, depth.
    pub(crate) bottom_m: Option<[f64; 3]>,
    /// In the plane of the fence's local frame.
    pub(crate) local: Option<EastNorth>,
}

impl Suspended {
    /// Whether `other` is no farther than `within_m` away, in each of the frames of hull and bottom in which this place
    /// is known. False if this place is known in neither.
    pub(crate) fn is_near(&self, other: &Self, within_m: f64) -> bool {
        let apart_m = |a: [f64; 3], b: [f64; 3]| hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
        let near = |own: Option<[f64; 3]>, other: Option<[f64; 3]>| {
            own.is_none_or(|own| other.is_some_and(|other| apart_m(own, other) <= within_m))
        };
        let known = self.hull_m.is_some() || self.bottom_m.is_some();
        known && near(self.hull_m, other.hull_m) && near(self.bottom_m, other.bottom_m)
    }
}

/// What is known about a hovering vehicle at this moment. Relative navigation is absent unless it is fresh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings<'a> {
    pub(crate) relative: Option<&'a RelativeSample>,
    pub(crate) cartesian: Option<&'a CartesianSample>,
    pub(crate) navigation: &'a NavigationSample,
    pub(crate) lock: Option<BottomLock>,
    /// The places where the mission may be suspended. If empty, the mission can be suspended only here.
    pub(crate) suspended: &'a [Suspended],
    pub(crate) now: Timestamp,
}

impl Surroundings<'_> {
    /// The vehicle's place in each frame.
    pub(crate) fn here(&self) -> Suspended {
        Suspended {
            hull_m: self.relative.map(hull_place),
            bottom_m: self.cartesian.map(|sample| bottom_place(sample, self.navigation)),
            local: Some(self.navigation.local),
        }
    }

    /// The vehicle's speed in three dimensions, m/s.
    fn speed_mps(&self) -> f64 {
        let navigation = self.navigation;
        hypot(hypot(navigation.east_mps, navigation.north_mps), navigation.down_mps)
    }
}

impl Envelope {
    /// The operator's limits for hovering vehicles.
    pub(crate) fn station_limits(&self) -> Result<&StationLimits, Refusal> {
        let limits = self.limits.station.as_ref();
        limits.ok_or(Refusal::State(Reason::NoStationLimits))
    }

    pub(crate) fn admit_station(&self, request: &StationRequest) -> Result<Hover, Refusal> {
        let limits = self.station_limits()?;
        if request.duration.is_zero() || request.duration > limits.term_max() {
            return Err(Figure::StationTerm.not_within(request.duration.as_secs_f64(), 0.0, limits.term_max_s));
        }
        if let Some(mps) = request.speed_mps
            && !(SPEED_MIN_MPS..=limits.speed_max_mps).contains(&mps)
        {
            return Err(Figure::StationSpeed.not_within(mps, SPEED_MIN_MPS, limits.speed_max_mps));
        }
        let speed_mps = request.speed_mps.unwrap_or(limits.speed_default_mps);
        let aim = match request.target {
            StationTarget::Here => None,
            StationTarget::Hull {
                horizontal_m,
                vertical_m,
                distance_m,
            } => Some(Aim::Hull {
                horizontal_m,
                vertical_m,
                distance_m,
            }),
            StationTarget::Bottom {
                x_m,
                y_m,
                vertical: asked,
            } => Some(Aim::Bottom {
                x_m,
                y_m,
                vertical: vertical(asked)?,
            }),
        };
        if aim.is_some() && speed_mps > limits.speed_max_mps {
            return Err(Figure::DefaultSpeed.over(speed_mps, limits.speed_max_mps));
        }
        Ok(Hover { aim, speed_mps })
    }

    /// Judges station keeping: where the vehicle is, and the way to its target if it has one. Returns the smallest
    /// clearance, metres.
    pub(crate) fn judge_station(&self, hover: &Hover, around: &Surroundings<'_>) -> Result<f64, Refusal> {
        let limits = self.station_limits()?;
        // The vehicle runs on at its present speed until it has stopped.
        let mut least_m = f64::MAX;
        let mut known = false;
        let here = around.here();
        if let (Some(_), Some(place)) = (&limits.hull_box, here.hull_m) {
            known = true;
            least_m = least_m.min(self.judge_hull(Stretch::Here, &[place], around.speed_mps(), around)?);
        }
        if let (Some(_), Some(place)) = (&limits.bottom_box, here.bottom_m) {
            known = true;
            least_m = least_m.min(self.judge_bottom(Stretch::Here, &[place], None, around.speed_mps(), around)?);
        }
        if !known {
            return Err(Reason::BoxesUnknown.into());
        }
        let speed_mps = hover.speed_mps.max(around.speed_mps());
        let way_m = match hover.aim {
            None => f64::MAX,
            Some(Aim::Hull {
                horizontal_m,
                vertical_m,
                distance_m,
            }) => {
                let mut places = vec![
                    here.hull_m.ok_or(Refusal::State(Reason::HullPlaceUnknown))?,
                    [horizontal_m, vertical_m, distance_m],
                ];
                for suspended in around.suspended.iter().filter(|_| is_on(Check::StationReturn)) {
                    places.push(suspended.hull_m.ok_or(unknown_suspension())?);
                }
                self.judge_hull(Stretch::Way, &places, speed_mps, around)?
            }
            Some(Aim::Bottom { x_m, y_m, vertical }) => {
                let mut places = vec![here.bottom_m.ok_or(Refusal::State(Reason::BottomPlaceUnknown))?];
                for suspended in around.suspended.iter().filter(|_| is_on(Check::StationReturn)) {
                    places.push(suspended.bottom_m.ok_or(unknown_suspension())?);
                }
                let target = Some((x_m, y_m, vertical));
                self.judge_bottom(Stretch::Way, &places, target, speed_mps, around)?
            }
        };
        Ok(least_m.min(way_m))
    }

    fn judge_hull(
        &self,
        stretch: Stretch,
        places_m: &[[f64; 3]],
        speed_mps: f64,
        around: &Surroundings<'_>,
    ) -> Result<f64, Refusal> {
        let limits = self.station_limits()?;
        let Some(allowed) = &limits.hull_box else {
            return Err(Reason::NoHullBox.into());
        };
        let allowance_m =
            self.drift_allowance_m(speed_mps, around.relative.map(|sample| sample.measured), around.now)?;
        let spans_m = [0, 1, 2].map(|axis| span(places_m.iter().map(|place| place[axis]), allowance_m));
        let mut least_m = contain(stretch, "hull_box", &hull_axes(allowed, spans_m))?;
        for kept in &limits.keep_out_hull {
            least_m = least_m.min(avoid(stretch, "keep_out_hull", &kept.name, &hull_axes(kept, spans_m))?);
        }
        Ok(least_m)
    }

    fn judge_bottom(
        &self,
        stretch: Stretch,
        places_m: &[[f64; 3]],
        target: Option<(f64, f64, Vertical)>,
        speed_mps: f64,
        around: &Surroundings<'_>,
    ) -> Result<f64, Refusal> {
        let limits = self.station_limits()?;
        let Some(allowed) = &limits.bottom_box else {
            return Err(Reason::NoBottomBox.into());
        };
        let allowance_m =
            self.drift_allowance_m(speed_mps, around.cartesian.map(|sample| sample.measured), around.now)?;
        let all = |axis: usize, more: Option<f64>| {
            let places = places_m.iter().map(move |place| place[axis]);
            span(places.chain(more), allowance_m)
        };
        let x_m = all(0, target.map(|(x_m, _, _)| x_m));
        let y_m = all(1, target.map(|(_, y_m, _)| y_m));
        let reach_m = hypot(x_m[1] - x_m[0], y_m[1] - y_m[0]);
        let (shallowest_m, deepest_m) = self.water_depths(around.lock, around.navigation.local, reach_m);
        let Some(shallowest_m) = shallowest_m else {
            return Err(Reason::BottomUnknown.into());
        };
        // `depths_m` has the depths between which the vehicle flies, `altitude_m` the least altitude that it may have.
        let mut depths_m: Vec<f64> = places_m.iter().map(|place| place[2]).collect();
        let mut altitude_m = f64::MAX;
        match target {
            None => {}
            Some((_, _, Vertical::Depth(set))) => depths_m.push(set.as_m()),
            Some((_, _, Vertical::Altitude(set))) => altitude_m = set.as_m(),
        }
        let deepest_way_m = depths_m.iter().copied().fold(f64::MIN, f64::max);
        let altitude_m = altitude_m.min(shallowest_m - deepest_way_m) - allowance_m;
        if let Some((_, _, Vertical::Altitude(set))) = target {
            let Some(deepest_m) = deepest_m else {
                return Err(Reason::WaterDepthUnknown.into());
            };
            depths_m.extend([shallowest_m - set.as_m(), deepest_m - set.as_m()]);
        }
        let spans_m = [x_m, y_m, span(depths_m.into_iter(), allowance_m)];
        let mut least_m = contain(stretch, "bottom_box", &bottom_axes(allowed, spans_m))?;
        let above_m = altitude_m - limits.altitude_min_m;
        // NaN is no clearance either.
        if (above_m.is_nan() || above_m < 0.0) && is_on(Check::StationBox) {
            return Err(left(Left {
                stretch,
                name: "limits.station",
                axis: "altitude",
                key: "altitude_min_m",
                reached_m: altitude_m,
                bound_m: limits.altitude_min_m,
                missing_m: -above_m,
            }));
        }
        least_m = least_m.min(above_m);
        for kept in &limits.keep_out_bottom {
            least_m = least_m.min(avoid(
                stretch,
                "keep_out_bottom",
                &kept.name,
                &bottom_axes(kept, spans_m),
            )?);
        }
        Ok(least_m)
    }

    /// How far the vehicle may be from where the samples and the setpoint say: the errors, and how far it runs on
    /// before it notices our silence.
    fn drift_allowance_m(&self, speed_mps: f64, measured: Option<Timestamp>, now: Timestamp) -> Result<f64, Refusal> {
        let measured = measured.ok_or(Refusal::State(Reason::RelativeStale))?;
        let runs_on_s =
            SUSPENSION_TIMEOUT.as_secs_f64() + now.since(measured).as_secs_f64() + self.limits.link_delay_max_s;
        Ok(self.station_limits()?.position_error_m + speed_mps * runs_on_s)
    }

    pub(crate) fn admit_sonar_angle(&self, request: &SonarAngleRequest) -> Result<(), Refusal> {
        let limits = self.station_limits()?;
        let (Some(min_deg), Some(max_deg)) = (limits.sonar_angle_min_deg, limits.sonar_angle_max_deg) else {
            return Err(Reason::NoSonarAngle.into());
        };
        if (min_deg..=max_deg).contains(&request.angle_deg) {
            return Ok(());
        }
        Err(Figure::SonarAngle.not_within(request.angle_deg, min_deg, max_deg))
    }

    pub(crate) fn admit_camera(&self, request: &CameraRequest) -> Result<(), Refusal> {
        self.station_limits()?;
        for (figure, tenths) in [
            (Figure::CameraPan, request.pan),
            (Figure::CameraTilt, request.tilt),
            (Figure::CameraZoom, request.zoom),
        ] {
            if !(-CAMERA_MAX..=CAMERA_MAX).contains(&tenths) {
                return Err(figure.not_within(tenths as f64, -CAMERA_MAX as f64, CAMERA_MAX as f64));
            }
        }
        Ok(())
    }

    pub(crate) fn admit_light(&self, request: &LightRequest) -> Result<(), Refusal> {
        self.station_limits()?;
        if request.light < 0 {
            return Err(Figure::Light.under(request.light as f64, 0.0));
        }
        Ok(())
    }
}

/// The place of a sample in the coordinates of BPGHP.
pub(crate) fn hull_place(sample: &RelativeSample) -> [f64; 3] {
    [sample.horizontal_m, sample.vertical_m, sample.distance_m]
}

/// The place of a sample in the coordinates of BPGBP. The depth is that of BFNVG, because the specification does not
/// say in which direction BFCNV's z points.
pub(crate) fn bottom_place(sample: &CartesianSample, navigation: &NavigationSample) -> [f64; 3] {
    [sample.x_m, sample.y_m, navigation.depth.as_m()]
}

/// A move to where the vehicle is, in the frame of another move.
pub(crate) fn aim_at_here(other: &Aim, here: Suspended) -> Result<Aim, Refusal> {
    match other {
        Aim::Hull { .. } => {
            let place = here.hull_m.ok_or(Refusal::State(Reason::HullStopUnknown))?;
            Ok(Aim::Hull {
                horizontal_m: place[0],
                vertical_m: place[1],
                distance_m: place[2],
            })
        }
        Aim::Bottom { .. } => {
            let place = here.bottom_m.ok_or(Refusal::State(Reason::BottomStopUnknown))?;
            let depth = Depth::from_m(place[2]).map_err(Figure::Depth.out_of_range())?;
            Ok(Aim::Bottom {
                x_m: place[0],
                y_m: place[1],
                vertical: Vertical::Depth(depth),
            })
        }
    }
}

const fn unknown_suspension() -> Refusal {
    Refusal::State(Reason::SuspensionUnknown)
}
