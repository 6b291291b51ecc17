//! Random hovering vehicles, links, plugins and operators. The trial's judge checks the cadence of station keeping, its
//! rate, its control and its order with modifies. The test here checks what else must hold in every run.

use std::ops::Range;
use std::time::Duration;

use backseat_core::Operator;
use backseat_core::plugin::{
    CameraRequest, FaultKind, LightRequest, Request, SonarAngleRequest, StationRequest, StationTarget, VerticalRequest,
};
use backseat_spi::ToVehicle;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use crate::course::modify;
use crate::random::{figure, it_recovers, ledger_is_consistent, reply};
use crate::station::{setup, station_limits};
use crate::trial::{Seen, Trial};
use crate::vehicle::Reply;

#[derive(Clone, Debug)]
enum Act {
    Wait(u64),
    Ask(usize, Vec<Request>),
    Replies(&'static str, Reply),
    /// The vehicle drifts by this much.
    Drift([f64; 3]),
    Back,
    Hull(bool),
    Bottom(bool),
    Frozen(bool),
    Control(bool),
    Status(&'static str),
    Begin,
    Cut,
    Delay(u64),
    Stall(u64),
    Sleep(u64),
    Fail(usize, FaultKind),
    Hold,
    Release,
}

fn target() -> BoxedStrategy<StationTarget> {
    let vertical = prop_oneof![
        figure(1.0..31.0).prop_map(VerticalRequest::DepthM),
        figure(55.0..75.0).prop_map(VerticalRequest::AltitudeM),
    ];
    let on_hull = |h: Range<f64>, v: Range<f64>, d: Range<f64>| {
        (figure(h), figure(v), figure(d)).prop_map(|(horizontal_m, vertical_m, distance_m)| StationTarget::Hull {
            horizontal_m,
            vertical_m,
            distance_m,
        })
    };
    let over_bottom = |range: Range<f64>, vertical: BoxedStrategy<VerticalRequest>| {
        (figure(range.clone()), figure(range), vertical).prop_map(|(x_m, y_m, vertical)| StationTarget::Bottom {
            x_m,
            y_m,
            vertical,
        })
    };
    prop_oneof![
        2 => Just(StationTarget::Here),
        6 => on_hull(-20.0..20.0, 1.0..10.0, 3.0..10.0),
        1 => on_hull(-20.0..60.0, -6.0..21.0, 0.0..16.0),
        4 => over_bottom(-15.0..15.0, (10.0..25.0).prop_map(VerticalRequest::DepthM).boxed()),
        1 => over_bottom(-55.0..55.0, vertical.boxed()),
    ]
    .boxed()
}

fn request() -> BoxedStrategy<Request> {
    let tag = 0..4u64;
    let speed = proptest::option::weighted(0.9, figure(0.02..0.4));
    prop_oneof![
        10 => (tag.clone(), target(), speed, 1..70u64).prop_map(|(tag, target, speed_mps, seconds)| {
            Request::Station(StationRequest { tag, target, speed_mps, duration: Duration::from_secs(seconds) })
        }),
        2 => Just(Request::EndStation),
        1 => tag.clone().prop_map(|tag| Request::Modify(modify(tag))),
        1 => (tag.clone(), figure(-50.0..50.0))
            .prop_map(|(tag, angle_deg)| Request::SonarAngle(SonarAngleRequest { tag, angle_deg })),
        1 => (tag.clone(), -12..12).prop_map(|(tag, pan)| Request::Camera(CameraRequest { tag, pan, tilt: 0, zoom: 0 })),
        1 => (tag, any::<bool>()).prop_map(|(tag, on)| Request::Light(LightRequest { tag, light: 0, on })),
    ]
    .boxed()
}

fn act() -> BoxedStrategy<Act> {
    let names = vec!["SUS", "CON", "SPD", "GHP", "GBP", "RES", "RMB", "EMB"];
    let kinds = vec![FaultKind::Trap, FaultKind::Error, FaultKind::Overflow];
    let step = || -0.8..0.8f64;
    prop_oneof![
        20 => (0..2500u64).prop_map(Act::Wait),
        20 => (0..2usize, vec(request(), 0..4)).prop_map(|(plugin, requests)| Act::Ask(plugin, requests)),
        2 => (select(names), reply()).prop_map(|(name, reply)| Act::Replies(name, reply)),
        3 => (step(), step(), step()).prop_map(|(a, b, c)| Act::Drift([a, b, c])),
        1 => Just(Act::Back),
        1 => select(vec![true, true, false]).prop_map(Act::Hull),
        1 => select(vec![true, true, false]).prop_map(Act::Bottom),
        1 => select(vec![false, false, true]).prop_map(Act::Frozen),
                1 => select(vec![true, true, false]).prop_map(Act::Control),
        1 => select(vec!["Running", "Running", "Ready"]).prop_map(Act::Status),
        1 => Just(Act::Begin),
        1 => Just(Act::Cut),
        2 => (0..20u64).prop_map(Act::Delay),
        1 => (0..3000u64).prop_map(Act::Stall),
        1 => (0..3000u64).prop_map(Act::Sleep),
        1 => (0..2usize, select(kinds)).prop_map(|(plugin, kind)| Act::Fail(plugin, kind)),
        1 => Just(Act::Hold),
        4 => Just(Act::Release),
    ]
    .boxed()
}

const HOME_M: [f64; 3] = [0.0, 5.0, 6.0];

fn start() -> Trial {
    let mut trial = Trial::with(setup(Some(station_limits())));
    trial.vehicle.speed_mps = 0.0;
    (trial.vehicle.hull_m, trial.vehicle.bottom_m) = (Some(HOME_M), Some([0.0, 0.0]));
    trial.run_for(2.0);
    trial
}

fn play(trial: &mut Trial, acts: Vec<Act>) {
    for act in acts {
        let now = trial.now;
        match act {
            Act::Wait(ms) => trial.run_for(ms as f64 / 1e3),
            Act::Ask(plugin, requests) => trial.ask(plugin, requests),
            Act::Replies(name, reply) => {
                trial.vehicle.replies.insert(name, reply);
            }
            Act::Drift(by_m) => {
                let place = trial.vehicle.hull_m.unwrap_or(HOME_M);
                trial.vehicle.hull_m = Some([0, 1, 2].map(|axis| place[axis] + by_m[axis]));
            }
            Act::Back => trial.vehicle.hull_m = Some(HOME_M),
            Act::Hull(says) => trial.vehicle.hull_m = says.then_some(HOME_M),
            Act::Bottom(says) => trial.vehicle.bottom_m = says.then_some([0.0, 0.0]),
            Act::Frozen(frozen) => trial.vehicle.hull_frozen = frozen.then_some(now),
            Act::Control(granted) => trial.vehicle.set_control(now, granted),
            Act::Status(status) => trial.vehicle.set_status(now, status),
            Act::Begin => trial.vehicle.begin(now, Some(2), None),
            Act::Cut => trial.cut(),
            Act::Delay(ms) => trial.delay = Duration::from_millis(ms),
            Act::Stall(ms) => trial.stalled_until = now + Duration::from_millis(ms),
            Act::Sleep(ms) => trial.asleep_until = now + Duration::from_millis(ms),
            Act::Fail(plugin, kind) => trial.fail(plugin, kind),
            Act::Hold => trial.operator(Operator::Hold),
            Act::Release => trial.operator(Operator::Release),
        }
    }
}

/// Checks that no move leads to a forbidden place or leaves without a speed limit of at most 0.5 m/s, and that the
/// vehicle's own limit is set before each BPRES.
fn moves_are_bounded(trial: &Trial) {
    let mut limit_mps = 1.5;
    for (at, seen) in &trial.seen {
        match seen {
            Seen::Sent(ToVehicle::HullSpeedLimit(limit)) => limit_mps = limit.speed_mps,
            Seen::Sent(ToVehicle::HullPosition(to)) => {
                let (h, v, d) = (to.horizontal_m, to.vertical_m, to.distance_m);
                let inside = h.abs() < 49.5 && (-4.5..19.5).contains(&v) && (1.5..14.5).contains(&d);
                let screw = (19.5..30.5).contains(&h) && (4.5..15.5).contains(&v) && d < 5.5;
                assert!(inside && !screw && limit_mps <= 0.5, "{to:?} at {at}, {limit_mps} m/s");
            }
            Seen::Sent(ToVehicle::BottomPosition(to)) => {
                let mooring = (19.5..25.5).contains(&to.x_m) && to.y_m.abs() < 5.5;
                let inside = to.x_m.abs() < 49.5 && to.y_m.abs() < 49.5;
                assert!(
                    inside && !mooring && limit_mps <= 0.5,
                    "{to:?} at {at}, {limit_mps} m/s"
                );
            }
            Seen::Sent(ToVehicle::Resume(_)) => assert_eq!(limit_mps, 1.5, "BPRES at {at}"),
            _ => {}
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn sr_005_sr_009_whatever_happens_station_keeping_is_bounded_and_refreshed_and_has_one_end(acts in vec(act(), 1..80)) {
        let mut trial = start();
        play(&mut trial, acts);
        ledger_is_consistent(&trial);
        it_recovers(&mut trial);
        ledger_is_consistent(&trial);
        moves_are_bounded(&trial);
    }
}
