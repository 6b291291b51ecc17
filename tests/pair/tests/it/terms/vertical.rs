use backseat_core::Limits;
use backseat_core::plugin::{Request, TracklineRequest, VerticalRequest};
use backseat_mvc::Truth;
use backseat_pair::Dive;

use super::scene::{
    ORIGIN, Zone, closest_admitted, exact, fence, line, place, setpoint, setup, steer_until_refused, watch, world,
};

const BOX: [f64; 4] = [-700.0, -700.0, 700.0, 700.0];

/// On a line of the plan to the east; then it requests another one beside it.
fn asks(band: &str, limits: &Limits, more: &str, vertical: VerticalRequest) -> Dive {
    let inside = Zone("keep-in", BOX, band.to_owned());
    let plan = line((-300.0, 0.0), (100.0, 0.0));
    let world = world(ORIGIN, (-300.0, 0.0, 90.0), &plan, more);
    let mut dive = Dive::new(setup(world, fence(ORIGIN, &[inside]), limits.clone()));
    dive.run_for(12.0);
    assert!(dive.core.has_control(), "{:#?}", dive.notes);
    dive.ask(Request::Trackline(TracklineRequest {
        tag: 1,
        start: place(-200.0, 30.0),
        end: place(0.0, 30.0),
        vertical,
        speed_mps: 2.0,
        interrupt: true,
    }));
    dive.run_for(0.3);
    dive
}

/// The depth sensor shows some metres too little.
const READS_TOO_LITTLE: &str = "[sensors.depth]\nbias_kpa = 30\n";

#[test]
fn the_error_of_the_depth() {
    const DEEPEST_M: f64 = 60.0;
    let band = format!("\"depth_max_m\":{DEEPEST_M},\"altitude_min_m\":2");
    let asked = |error_m: f64, above_m: f64| {
        let limits = Limits {
            vertical_error_m: error_m,
            ..exact()
        };
        asks(
            &band,
            &limits,
            READS_TOO_LITTLE,
            VerticalRequest::DepthM(DEEPEST_M - above_m),
        )
    };
    let truth = asked(10.0, 40.0).mvc.truth();
    let error_m = truth.depth_m - truth.believed_depth_m;
    assert!(error_m > 1.0, "the seed's sensor reads too much: {error_m}");
    // It overshoots by a little.
    let error_m = error_m + 0.3;
    let (_, mut dive) = closest_admitted((0.0, 40.0), |above_m| asked(error_m, above_m));
    let least_m = watch(&mut dive, 160.0, &|truth: &Truth| DEEPEST_M - truth.depth_m);
    assert!((0.0..error_m).contains(&least_m), "{least_m}");
}

/// The seabed rises to the east.
const RISES: &str = "[seabed]\ndepth_m = 90\nslope = 0.15\nmeanders = 0\ndownslope_deg = 270\n";

fn up_a_slope() -> Limits {
    Limits {
        water_depth_min_m: None,
        water_depth_max_m: None,
        seabed_slope_max: 0.15,
        ..exact()
    }
}

#[test]
fn the_slope_of_the_bed() {
    const ALTITUDE_MIN_M: f64 = 10.0;
    let band = format!("\"depth_max_m\":150,\"altitude_min_m\":{ALTITUDE_MIN_M}");
    // The shallower the requested depth, the farther from the seabed.
    let (_, mut dive) = closest_admitted((0.0, 90.0), |above_m| {
        asks(&band, &up_a_slope(), RISES, VerticalRequest::DepthM(100.0 - above_m))
    });
    let least_m = watch(&mut dive, 160.0, &|truth: &Truth| truth.altitude_m - ALTITUDE_MIN_M);
    // The greatest depth counts, on every path to the line and from it.
    assert!((0.0..60.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_slope_of_the_bed_below_an_altitude() {
    const DEEPEST_M: f64 = 60.0;
    let band = format!("\"depth_max_m\":{DEEPEST_M},\"altitude_min_m\":2");
    let falls = RISES.replace("270", "90");
    // Down the slope at an altitude it gets deeper and deeper.
    let (_, mut dive) = closest_admitted((5.0, 120.0), |altitude_m| {
        asks(&band, &up_a_slope(), &falls, VerticalRequest::AltitudeM(altitude_m))
    });
    let least_m = watch(&mut dive, 160.0, &|truth: &Truth| DEEPEST_M - truth.depth_m);
    assert!((0.0..60.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_error_of_the_altitude() {
    const ALTITUDE_MIN_M: f64 = 10.0;
    let band = format!("\"depth_max_m\":150,\"altitude_min_m\":{ALTITUDE_MIN_M}");
    let limits = Limits {
        vertical_error_m: 1.0,
        water_depth_max_m: Some(150.0),
        ..up_a_slope()
    };
    let (_, mut dive) = closest_admitted((5.0, 30.0), |altitude_m| {
        asks(&band, &limits, RISES, VerticalRequest::AltitudeM(altitude_m))
    });
    let least_m = watch(&mut dive, 160.0, &|truth: &Truth| truth.altitude_m - ALTITUDE_MIN_M);
    assert!((0.0..1.1).contains(&least_m), "{least_m}");
}

#[test]
fn the_age_of_the_bottom_lock() {
    const ALTITUDE_MIN_M: f64 = 60.0;
    let band = format!("\"depth_max_m\":150,\"altitude_min_m\":{ALTITUDE_MIN_M}");
    let dive = |fault: &str| {
        let inside = Zone("keep-in", BOX, band.clone());
        let plan = setpoint(265.0, 2.0);
        let world = world(ORIGIN, (-50.0, 0.0, 265.0), &plan, &format!("{RISES}{fault}"));
        let mut dive = Dive::under_way(setup(world, fence(ORIGIN, &[inside]), up_a_slope()));
        dive.lost = vec!["$BPEMB"];
        dive
    };
    let ended = steer_until_refused(&mut dive(""), 90.0, 2.0);
    // The seabed was last seen just before, and the vehicle continues for as long as that counts.
    let dark_s = ended.as_secs_f64() - 0.25;
    let fault =
        format!("[[faults.fault]]\nat_s = {dark_s}\nfor_s = 60\nkind = \"sensor_dropout\"\nsensor = \"altimeter\"\n");
    let mut dive = dive(&fault);
    steer_until_refused(&mut dive, 90.0, 2.0);
    let least_m = watch(&mut dive, 5.0 + 14.0, &|truth: &Truth| {
        truth.altitude_m - ALTITUDE_MIN_M
    });
    assert!((0.0..0.15 * 5.0 * 2.0).contains(&least_m), "{least_m}");
}
