//! A flight step by step, as a payload receives it and as it is in truth.

use std::time::Duration;

use backseat_mvc::Truth;
use backseat_spi::{
    CartesianNavigation, Dvl, DvlBeams, Framer, FromVehicle, Navigation, Policy, PositionQuality, RelativeNavigation,
    ServoPositions, VelocityAndRates,
};
use backseat_units::{EastNorth, Timestamp};
use backseat_world::Stream;

use super::mission::{Kind, Said, said, speak, world};
use crate::payload::{ME, Payload};

/// One step of the vehicle.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub(super) at_s: f64,
    pub(super) navigation: Navigation,
    pub(super) velocity: VelocityAndRates,
    /// The place in BFNVG, in the world's frame.
    pub(super) place: EastNorth,
    pub(super) truth: Truth,
    /// In how many steps up to this one a fix may have moved the navigation.
    pub(super) fixes: u32,
    pub(super) dvl: Option<Dvl>,
    pub(super) beams: Option<DvlBeams>,
    pub(super) servo: Option<ServoPositions>,
    pub(super) relative: Option<RelativeNavigation>,
    pub(super) cartesian: Option<CartesianNavigation>,
}

/// Every step of a flight.
#[derive(Debug)]
pub(super) struct Flight {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) dt_s: f64,
    pub(super) steps: Vec<Step>,
    sums: Vec<Sums>,
}

/// What was integrated up to a step. Each part is the mean of the values in that step and in the one before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// The way by BFNVR.
    pub(super) way: EastNorth,
    pub(super) true_way: EastNorth,
    pub(super) sunk_m: f64,
    pub(super) turned_deg: f64,
}

impl Step {
    fn sums_after(&self, before: &Self, sums: Sums, dt_s: f64) -> Sums {
        let mean = |a: f64, b: f64| 0.5 * dt_s * (a + b);
        let (was, is) = (&before.velocity, &self.velocity);
        Sums {
            way: sums.way + EastNorth::new(mean(was.east_mps, is.east_mps), mean(was.north_mps, is.north_mps)),
            true_way: sums.true_way
                + EastNorth::new(
                    mean(before.truth.east_mps, self.truth.east_mps),
                    mean(before.truth.north_mps, self.truth.north_mps),
                ),
            sunk_m: sums.sunk_m + mean(was.down_mps, is.down_mps),
            turned_deg: sums.turned_deg + mean(was.yaw_rate_dps, is.yaw_rate_dps),
        }
    }
}

impl Flight {
    /// The pairs of steps that are this many seconds apart, and what was integrated between the two.
    pub(super) fn apart(&self, seconds: f64) -> impl Iterator<Item = (&Step, &Step, Sums)> {
        let steps = (seconds / self.dt_s).round() as usize;
        let between = |from: &Sums, to: &Sums| Sums {
            way: to.way - from.way,
            true_way: to.true_way - from.true_way,
            sunk_m: to.sunk_m - from.sunk_m,
            turned_deg: to.turned_deg - from.turned_deg,
        };
        self.steps
            .iter()
            .zip(&self.sums)
            .zip(self.steps.iter().zip(&self.sums).skip(steps))
            .map(move |((first, from), (last, to))| (first, last, between(from, to)))
    }
}

/// Flies a drawn mission with a drawn payload for this many seconds.
pub(super) fn drawn(kind: Kind, exact: bool, hz: u32, seed: u64, seconds: u32) -> Flight {
    let mut stream = Stream::new(seed, "possible payload");
    let (mut next_s, mut id) = (5, 0);
    let mut saying: Option<(Said, u32)> = None;
    let text = world(kind, exact, hz, seed);
    let name = format!("{kind:?}, {hz} Hz, exact {exact}, seed {seed}");
    flown(&text, name, kind, hz, seed, seconds, move |payload, second| {
        if second >= next_s {
            id += 1;
            let new = said(&mut stream, kind, id);
            next_s = second + new.for_s + (stream.uniform() * 12.0) as u32;
            saying = Some((new.clone(), second + new.for_s));
        }
        let Some((said, _)) = saying.as_ref().filter(|(_, until)| second < *until) else {
            return false;
        };
        speak(payload, said);
        said.fixes
    })
}

/// Flies a mission while a payload acts at each second. `acts` returns whether the payload gives a fix then.
pub(super) fn flown(
    text: &str,
    name: String,
    kind: Kind,
    hz: u32,
    seed: u64,
    seconds: u32,
    mut acts: impl FnMut(&mut Payload, u32) -> bool,
) -> Flight {
    let mut payload = Payload::connected(text, seed, &["NVG", "NVR", "DVL", "DV2", "PIT", "RNV", "CNV"]);
    let period = Duration::from_nanos(1_000_000_000 / u64::from(hz));
    let mut at = Timestamp::ZERO;
    let dt_s = period.as_secs_f64();
    let (mut steps, mut sums): (Vec<Step>, Vec<Sums>) = (Vec::new(), Vec::new());
    let mut with_gps = true;
    for tick in 1..=seconds * hz {
        at = at + period;
        payload.until(at.as_secs_f64() + 1e-4);
        let mut step = heard(&mut payload);
        let gps = step.navigation.quality == PositionQuality::Gps;
        step.fixes = steps.last().map_or(0, |step: &Step| step.fixes) + u32::from(gps || with_gps);
        with_gps = gps;
        let mut sum = Sums::default();
        if let (Some(before), Some(sums)) = (steps.last(), sums.last()) {
            sum = step.sums_after(before, *sums, dt_s);
        }
        sums.push(sum);
        steps.push(step);
        if tick.is_multiple_of(hz) && acts(&mut payload, tick / hz) {
            with_gps = true;
        }
    }
    assert_eq!(payload.heard_by(ME), Vec::<String>::new());
    Flight {
        name,
        kind,
        dt_s,
        steps,
        sums,
    }
}

/// The newest step, as the payload received it.
fn heard(payload: &mut Payload) -> Step {
    let (mut navigation, mut velocity) = (None, None);
    let (mut dvl, mut beams, mut servo, mut relative, mut cartesian) = (None, None, None, None, None);
    let mut framer = Framer::new(Policy::FromVehicle);
    for line in payload.heard() {
        let sum = line.trim_start_matches('$').bytes().fold(0, |sum, byte| sum ^ byte);
        framer.push(format!("{line}*{sum:02X}\r\n").as_bytes());
        while let Some(sentence) = framer.next_sentence() {
            #[expect(clippy::wildcard_enum_match_arm, reason = "the rest is no navigation")]
            match FromVehicle::decode(&sentence).expect("a message of the mock") {
                FromVehicle::Navigation(message) => navigation = Some(message),
                FromVehicle::VelocityAndRates(message) => velocity = Some(message),
                FromVehicle::Dvl(message) => dvl = Some(message),
                FromVehicle::DvlBeams(message) => beams = Some(message),
                FromVehicle::ServoPositions(message) => servo = Some(message),
                FromVehicle::RelativeNavigation(message) => relative = Some(message),
                FromVehicle::CartesianNavigation(message) => cartesian = Some(message),
                _ => {}
            }
        }
    }
    let navigation: Navigation = navigation.expect("BFNVG at every step");
    Step {
        at_s: payload.mvc.truth().time.as_secs_f64(),
        place: payload.mvc.frame().to_local(navigation.position),
        navigation,
        velocity: velocity.expect("BFNVR at every step"),
        truth: payload.mvc.truth(),
        fixes: 0,
        dvl,
        beams,
        servo,
        relative,
        cartesian,
    }
}
