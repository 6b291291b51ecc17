use backseat_spi::{
    BehaviorId, CircleEntry, GpsHit, Interrupt, SpeedMode, SurfaceMode, Trackcircle, Trackline, VerticalMode,
};
use backseat_units::{EastNorth, LocalFrame};

use crate::event::{ClientId, Refusal};
use crate::interpretation::CircleLayout;
use crate::plan::{GpsTimes, RADIUS_M, Shape};
use crate::vehicle::Vertical;
use crate::vehicle::performance::Performance;

/// A behavior that a payload asks to insert into the plan (SPI 7.5 to 7.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Insert {
    pub(crate) client: ClientId,
    pub(crate) id: BehaviorId,
    /// The shape that was asked for, without lead-in and lead-out.
    pub(crate) shape: Shape,
    pub(crate) vertical: Vertical,
    pub(crate) speed_mps: f64,
    /// Whether the payload gave that speed in turns of the thruster a minute.
    pub(crate) by_rpm: bool,
    pub(crate) interrupt: bool,
    /// Whether it is a GPS hit with a spiral to the surface, which is "future implementation" (SPI 7.7).
    pub(crate) spiral: bool,
}

impl Insert {
    /// From BPRTK. An error is a text that names the field whose value has no meaning.
    pub(crate) fn trackline(
        client: ClientId,
        request: &Trackline,
        frame: &LocalFrame,
        performance: &Performance,
    ) -> Result<Self, String> {
        let shape = Shape::Trackline {
            start: frame.to_local(request.start),
            end: frame.to_local(request.end),
        };
        Ok(Self {
            client,
            id: request.identifier,
            shape,
            vertical: vertical(request.vertical_mode, request.vertical_m)?,
            speed_mps: speed_mps(request.speed_mode, request.speed, performance)?,
            by_rpm: request.speed_mode == SpeedMode::Rpm,
            interrupt: interrupt(request.interrupt)?,
            spiral: false,
        })
    }

    /// From BPRTC.
    pub(crate) fn trackcircle(
        client: ClientId,
        request: &Trackcircle,
        layout: CircleLayout,
        frame: &LocalFrame,
        performance: &Performance,
    ) -> Result<Self, String> {
        let (entry_deg, code) = entry_of(request, layout);
        let shape = Shape::Trackcircle {
            centre: frame.to_local(request.centre),
            radius_m: request.radius_m,
            orbits: request.orbits,
            entry_deg,
        };
        Ok(Self {
            client,
            id: request.identifier,
            shape,
            vertical: vertical(request.vertical_mode, request.vertical_m)?,
            speed_mps: speed_mps(request.speed_mode, request.speed, performance)?,
            by_rpm: request.speed_mode == SpeedMode::Rpm,
            interrupt: interrupt(code)?,
            spiral: false,
        })
    }

    /// From BPRGP, which gives neither depth nor speed for the way to the place: the insert keeps those of the plan.
    pub(crate) fn gps_hit(
        client: ClientId,
        request: &GpsHit,
        frame: &LocalFrame,
        times: GpsTimes,
        cruise: (Vertical, f64),
    ) -> Result<Self, String> {
        let (climbs, spiral) = match request.mode {
            SurfaceMode::StraightLine => (true, false),
            SurfaceMode::Spiral => (true, true),
            SurfaceMode::Manual => (false, false),
            SurfaceMode::Other(code) => return Err(format!("mode {code}: expected 0 to 2")),
        };
        Ok(Self {
            client,
            id: request.identifier,
            shape: Shape::GpsHit {
                at: frame.to_local(request.position),
                climbs,
                times,
            },
            vertical: cruise.0,
            speed_mps: cruise.1,
            by_rpm: false,
            interrupt: false,
            spiral,
        })
    }

    pub(crate) const fn is_gps_hit(&self) -> bool {
        matches!(self.shape, Shape::GpsHit { .. })
    }

    /// Refuses an insert that this vehicle can never fly.
    pub(crate) fn within(&self, performance: &Performance, altitude_min_m: f64) -> Result<(), Refusal> {
        if self.spiral {
            return Err(Refusal::Spiral);
        }
        let vertical_ok = match self.vertical {
            Vertical::Depth(depth_m) => (0.0..=performance.depth_max_m).contains(&depth_m),
            Vertical::Altitude(altitude_m) => (altitude_min_m..=1000.0).contains(&altitude_m),
            Vertical::Pitch(_) | Vertical::Elevator(_) => false,
        };
        if !vertical_ok {
            let (Vertical::Depth(value)
            | Vertical::Altitude(value)
            | Vertical::Pitch(value)
            | Vertical::Elevator(value)) = self.vertical;
            return Err(Refusal::Vertical(value));
        }
        // An insert needs a speed above 0, even for a vehicle that can stand still.
        if !(performance.speed_min_mps.max(0.05)..=performance.speed_max_mps).contains(&self.speed_mps) {
            return Err(Refusal::Speed(self.speed_mps));
        }
        let near = |point: EastNorth| point.distance_m(EastNorth::default()) <= RADIUS_M;
        let (near, flyable) = match self.shape {
            Shape::Trackline { start, end } => (near(start) && near(end), start.distance_m(end) >= 1.0),
            Shape::Trackcircle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => (
                near(centre),
                (5.0..=20_000.0).contains(&radius_m)
                    && (0.01..=1000.0).contains(&orbits.abs())
                    && entry_deg.is_none_or(|angle| angle.abs() <= 360.0),
            ),
            Shape::Waypoint { to } | Shape::GpsHit { at: to, .. } => (near(to), true),
            Shape::Setpoint { .. } | Shape::Command | Shape::Idle => (true, true),
        };
        match (near, flyable) {
            (false, _) => Err(Refusal::FarAway),
            (true, false) => Err(Refusal::Geometry),
            (true, true) => Ok(()),
        }
    }
}

fn vertical(mode: VerticalMode, metres: f64) -> Result<Vertical, String> {
    match mode {
        VerticalMode::Depth => Ok(Vertical::Depth(metres)),
        VerticalMode::Altitude => Ok(Vertical::Altitude(metres)),
        VerticalMode::Other(code) => Err(format!("vertical_mode {code}: expected 0 or 1")),
    }
}

fn speed_mps(mode: SpeedMode, speed: f64, performance: &Performance) -> Result<f64, String> {
    match mode {
        SpeedMode::MetresPerSecond => Ok(speed),
        SpeedMode::Rpm => Ok(performance.speed_mps(speed)),
        SpeedMode::Other(code) => Err(format!("speed_mode {code}: expected 0 or 1")),
    }
}

/// The entry angle of a circle, degrees, and its interrupt code, as a vehicle with this layout of BPRTC reads them.
fn entry_of(request: &Trackcircle, layout: CircleLayout) -> (Option<f64>, Interrupt) {
    match (layout, request.entry_angle_deg) {
        (CircleLayout::Either | CircleLayout::Table, CircleEntry::Angle(degrees)) => (Some(degrees), request.interrupt),
        (CircleLayout::Either, CircleEntry::Anywhere | CircleEntry::Absent)
        | (CircleLayout::Table, CircleEntry::Anywhere)
        | (CircleLayout::Header, CircleEntry::Absent) => (None, request.interrupt),
        (CircleLayout::Table, CircleEntry::Absent) => (Some(f64::from(request.interrupt.code())), Interrupt::default()),
        (CircleLayout::Header, CircleEntry::Anywhere) => (None, Interrupt::default()),
        (CircleLayout::Header, CircleEntry::Angle(code)) => (None, Interrupt::from_code(code as i32)),
    }
}

fn interrupt(code: Interrupt) -> Result<bool, String> {
    match code {
        Interrupt::AfterCurrent => Ok(false),
        Interrupt::InterruptCurrent => Ok(true),
        Interrupt::Other(code) => Err(format!("interrupt {code}: expected 0 or 4")),
    }
}
