use std::time::Duration;

use backseat_core::StationLimits;
use backseat_core::plugin::{Judge, Request, StationRequest, VerticalRequest};
use backseat_spi::AckStatus;

use crate::course::envelope;
use crate::station::{glide, hovering, hovering_with, setup, station, station_limits, to_bottom, to_hull};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

/// Asks for station keeping now, and returns the rejection if there is one.
fn ask(trial: &mut Trial, request: StationRequest) -> Result<(), String> {
    trial.ask(0, [Request::Station(request)]);
    trial.run_for(0.4);
    match shorts(&trial.states(request.tag))[0] {
        "rejected" => Err(trial.rejection(request.tag)),
        _ => Ok(()),
    }
}

#[test]
fn sr_002_the_whole_way_of_a_move_on_the_hull_is_in_the_box_and_not_nearer_than_the_least_standoff() {
    // At 0.2 m/s the vehicle may stray by 1.1 m, and in addition by what it covers within navigation's age.
    let cases = [
        (to_hull(1, 10.0, 5.0, 2.2), None),
        (
            to_hull(2, 10.0, 5.0, 2.0),
            Some("distance from the hull may come to 0.90 m, 0.10 m beyond"),
        ),
        (to_hull(3, 10.0, 5.0, 2.0), Some("m beyond hull_box's distance_min_m 1")),
        (to_hull(4, 10.0, 5.0, 14.0), Some("hull_box's distance_max_m 15")),
        (to_hull(5, 49.0, 5.0, 12.0), Some("horizontal_max_m 50")),
        (to_hull(6, -49.0, 5.0, 5.0), Some("horizontal_min_m -50")),
        (to_hull(7, 0.0, 19.5, 5.0), Some("vertical_max_m 20")),
        (to_hull(8, 0.0, -4.5, 5.0), Some("vertical_min_m -5")),
    ];
    for (request, text) in cases {
        let mut trial = hovering();
        let outcome = ask(&mut trial, request);
        match text {
            None => assert_eq!(outcome, Ok(())),
            Some(text) => {
                let rejection = outcome.unwrap_err();
                assert!(rejection.starts_with("station: on its way: "), "{rejection}");
                assert!(rejection.contains(text), "{rejection}");
            }
        }
    }
}

#[test]
fn sr_002_a_move_past_a_screw_is_rejected_although_its_ends_are_clear() {
    // The vehicle and the target are at least 10 m from the screw, on either side of it.
    let mut trial = hovering();
    let rejection = ask(&mut trial, to_hull(1, 40.0, 7.0, 5.0)).unwrap_err();
    assert!(
        rejection.starts_with("station: on its way: it may come "),
        "{rejection}"
    );
    assert!(
        rejection.contains("m into keep_out_hull 'screw', over its "),
        "{rejection}"
    );
    // The first step of a way around the screw: away from the hull.
    assert_eq!(ask(&mut trial, to_hull(2, 0.0, 5.0, 9.0)), Ok(()));
    // From a place farther off the hull the straight line is clear, but the box that spans it is not, and the vehicle's
    // path between the two is not known.
    trial.vehicle.hull_m = Some([0.0, 5.0, 9.0]);
    trial.run_for(11.0);
    assert!(ask(&mut trial, to_hull(3, 40.0, 7.0, 5.0)).is_err());
}

#[test]
fn sr_002_the_way_back_to_where_the_mission_was_suspended_is_part_of_a_move() {
    let mut trial = hovering();
    for (tag, target_m) in [(1, [0.0, 5.0, 9.0]), (2, [15.0, 5.0, 9.0])] {
        let [horizontal_m, vertical_m, distance_m] = target_m;
        assert_eq!(
            ask(&mut trial, to_hull(tag, horizontal_m, vertical_m, distance_m)),
            Ok(())
        );
        glide(&mut trial, target_m, 5.0);
    }
    // The way on from there is clear of the screw. The way back from its end to the first place, 5 m off the hull, is
    // not.
    let rejection = ask(&mut trial, to_hull(3, 40.0, 5.0, 9.0)).unwrap_err();
    assert!(rejection.contains("screw"), "{rejection}");
    assert!(trial.core.is_steering(), "the earlier move goes on");
    // A mission that has not gone on yet is still suspended at its first place.
    trial.ask(0, [Request::EndStation]);
    trial.run_for(0.5);
    let rejection = ask(&mut trial, to_hull(4, 40.0, 5.0, 9.0)).unwrap_err();
    assert!(rejection.contains("screw"), "{rejection}");
    // A mission that has gone on and is suspended here may go on from here.
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.5);
    assert_eq!(ask(&mut trial, to_hull(5, 40.0, 5.0, 9.0)), Ok(()));
}

#[test]
fn sr_020_from_a_bad_place_every_station_request_is_rejected_even_one_that_leads_back() {
    let places = [
        ([0.0, 5.0, 1.2], "distance_min_m 1"),
        ([0.0, 5.0, 16.0], "distance_max_m 15"),
        ([25.0, 10.0, 5.2], "screw"),
    ];
    for (place, text) in places {
        let mut trial = hovering();
        trial.vehicle.hull_m = Some(place);
        trial.run_for(11.0);
        for request in [station(1), to_hull(2, 0.0, 5.0, 5.0)] {
            let rejection = ask(&mut trial, request).unwrap_err();
            assert!(
                rejection.starts_with("station: where it is: ") && rejection.contains(text),
                "{rejection}"
            );
        }
    }
}

#[test]
fn sr_004_each_refresh_of_station_keeping_is_checked_again_and_the_box_ends_it() {
    let mut trial = hovering();
    assert_eq!(ask(&mut trial, station(1)), Ok(()));
    // The vehicle drifts towards the hull.
    while trial.core.is_steering() {
        let [horizontal_m, vertical_m, distance_m] = trial.vehicle.hull_m.unwrap();
        glide(&mut trial, [horizontal_m, vertical_m, distance_m - 0.1], 0.5);
    }
    let (_, reason) = trial.lease_ends().pop().expect("an end");
    assert!(reason.contains("distance_min_m 1"), "{reason}");
    let [_, _, distance_m] = trial.vehicle.hull_m.unwrap();
    assert!(distance_m > 1.3, "{distance_m}");
}

/// The vehicle moves to a place near the hull, and gets faster. The plugin asks for a move away from there, but the
/// vehicle is slow to acknowledge the speed limit that comes before it.
#[test]
fn sr_004_until_a_changed_move_is_sent_the_one_that_the_vehicle_flies_is_judged_too() {
    for slow in [false, true] {
        let mut trial = hovering();
        ask(&mut trial, to_hull(1, 10.0, 5.0, 2.2)).unwrap();
        if slow {
            let late = Reply::Late(Duration::from_millis(700), AckStatus::Succeeded);
            trial.vehicle.replies.insert("SPD", late);
        }
        let away = StationRequest {
            speed_mps: Some(0.4),
            ..to_hull(2, 0.0, 5.0, 5.0)
        };
        ask(&mut trial, away).unwrap();
        let faster = trial.now;
        trial.vehicle.speed_mps = 0.4;
        trial.run_for(0.2);
        assert_eq!(trial.sent("GHP").len(), if slow { 1 } else { 2 });
        assert_eq!(trial.sent_since("RES", faster).len(), usize::from(slow));
        assert_eq!(trial.core.is_steering(), !slow, "{:?}", trial.lease_ends());
    }
}

#[test]
fn sr_004_station_keeping_ends_at_the_sample_that_shows_the_vehicle_outside_its_box() {
    let mut trial = hovering();
    glide(&mut trial, [0.0, 5.0, 2.0], 6.0);
    assert_eq!(ask(&mut trial, station(1)), Ok(()));
    let sent = trial.sent("CON").len();
    while trial.sent("CON").len() == sent {
        trial.run_for(0.01);
    }
    let refreshed = trial.now;
    // The step is too small for a jump, but it leads nearer to the hull than allowed.
    trial.vehicle.hull_m = Some([0.0, 5.0, 1.2]);
    trial.run_for(1.0);
    let (ended, reason) = trial.lease_ends().pop().expect("an end");
    assert!(reason.contains("distance_min_m 1"), "{reason}");
    assert!(
        ended.since(refreshed) < Duration::from_millis(150),
        "{refreshed} {ended}"
    );
    assert_eq!(trial.sent_since("RES", refreshed), [ended]);
}

#[test]
fn sr_002_a_fast_vehicle_strays_further() {
    let mut trial = hovering();
    trial.vehicle.speed_mps = 1.5;
    trial.run_for(1.0);
    // The vehicle moves on at 1.5 m/s for 3 s: 4.5 m, and the hull is 5 m away.
    let rejection = ask(&mut trial, station(1)).unwrap_err();
    assert!(rejection.contains("where it is: distance from the hull"), "{rejection}");
}

#[test]
fn sr_002_the_whole_way_of_a_move_over_the_bottom_is_in_the_box_and_within_its_depths() {
    let depth = VerticalRequest::DepthM;
    let cases = [
        (to_bottom(1, 10.0, 10.0, depth(25.0)), None),
        (to_bottom(2, 49.5, 10.0, depth(20.0)), Some("x may come to")),
        (to_bottom(3, 10.0, -49.5, depth(20.0)), Some("bottom_box's y_min_m -50")),
        (
            to_bottom(4, 10.0, 0.0, depth(29.5)),
            Some("bottom_box's depth_max_m 30"),
        ),
        (to_bottom(5, 10.0, 0.0, depth(2.5)), Some("bottom_box's depth_min_m 2")),
        (to_bottom(6, 40.0, 0.0, depth(20.0)), Some("keep_out_bottom 'mooring'")),
        // Both ends are clear, but the box between them is not.
        (to_bottom(7, 22.0, 20.0, depth(20.0)), Some("keep_out_bottom 'mooring'")),
        (to_bottom(8, 5.0, 40.0, depth(20.0)), None),
    ];
    for (request, text) in cases {
        let mut trial = hovering();
        let outcome = ask(&mut trial, request);
        match text {
            None => assert_eq!(outcome, Ok(())),
            Some(text) => {
                let rejection = outcome.unwrap_err();
                assert!(
                    rejection.starts_with("station: on its way: ") && rejection.contains(text),
                    "{rejection}"
                );
            }
        }
    }
}

#[test]
fn sr_002_heights_above_the_bottom_need_a_water_depth() {
    let altitude = VerticalRequest::AltitudeM;
    let shallow = |min_m, max_m| {
        let mut setup = setup(Some(station_limits()));
        setup.limits.water_depth_min_m = min_m;
        setup.limits.water_depth_max_m = max_m;
        let mut trial = Trial::with(setup);
        trial.vehicle.speed_mps = 0.0;
        trial.vehicle.bottom_m = Some([0.0, 0.0]);
        trial.vehicle.altitude_m = None;
        trial.run_for(3.0);
        trial
    };
    // The water is 24 to 26 m deep, and the vehicle is at 20 m.
    let mut trial = shallow(Some(24.0), Some(26.0));
    assert_eq!(ask(&mut trial, to_bottom(1, 5.0, 0.0, altitude(4.0))), Ok(()));
    let rejection = ask(&mut trial, to_bottom(2, 5.0, 0.0, altitude(3.0))).unwrap_err();
    assert!(rejection.contains("altitude may come to 1.90 m, 0.10"), "{rejection}");
    assert!(rejection.contains("altitude_min_m 2"), "{rejection}");
    let rejection = ask(&mut trial, to_bottom(3, 5.0, 0.0, VerticalRequest::DepthM(22.0))).unwrap_err();
    assert!(rejection.contains("altitude_min_m 2"), "{rejection}");
    // This altitude leads to the surface.
    let rejection = ask(&mut trial, to_bottom(4, 5.0, 0.0, altitude(23.0))).unwrap_err();
    assert!(rejection.contains("bottom_box's depth_min_m 2"), "{rejection}");
    let rejection = ask(&mut shallow(None, Some(26.0)), to_bottom(1, 5.0, 0.0, altitude(4.0))).unwrap_err();
    assert!(rejection.contains("water_depth_min_m"), "{rejection}");
    let rejection = ask(&mut shallow(Some(24.0), None), to_bottom(1, 5.0, 0.0, altitude(4.0))).unwrap_err();
    assert!(rejection.contains("water_depth_max_m"), "{rejection}");
}

#[test]
fn each_kind_of_move_needs_its_own_navigation_and_its_own_box() {
    let bottom = |tag| to_bottom(tag, 5.0, 0.0, VerticalRequest::DepthM(20.0));
    let mut trial = hovering();
    trial.vehicle.hull_m = None;
    trial.run_for(1.5);
    let rejection = ask(&mut trial, to_hull(1, 5.0, 5.0, 5.0)).unwrap_err();
    assert_eq!(rejection, "navigation: a move on the hull needs fresh BFRNV");
    assert_eq!(
        ask(&mut trial, station(2)),
        Ok(()),
        "either of the two positions is enough"
    );
    // The mission was suspended at a place whose position on the hull is not known.
    trial.vehicle.hull_m = Some([0.0, 5.0, 5.0]);
    trial.run_for(1.0);
    let rejection = ask(&mut trial, to_hull(3, 5.0, 5.0, 5.0)).unwrap_err();
    assert!(rejection.contains("where the mission was suspended"), "{rejection}");
    trial.vehicle.bottom_m = None;
    trial.run_for(1.5);
    let rejection = ask(&mut trial, bottom(4)).unwrap_err();
    assert_eq!(rejection, "navigation: a move over the bottom needs fresh BFCNV");

    let mut trial = hovering_with(StationLimits {
        hull_box: None,
        ..station_limits()
    });
    let rejection = ask(&mut trial, to_hull(1, 5.0, 5.0, 5.0)).unwrap_err();
    assert_eq!(rejection, "station: the mission has no [limits.station.hull_box]");
    assert_eq!(ask(&mut trial, bottom(2)), Ok(()));

    let mut trial = hovering_with(StationLimits {
        bottom_box: None,
        ..station_limits()
    });
    let rejection = ask(&mut trial, bottom(1)).unwrap_err();
    assert_eq!(rejection, "station: the mission has no [limits.station.bottom_box]");
    trial.vehicle.hull_m = None;
    trial.run_for(1.5);
    let rejection = ask(&mut trial, station(2)).unwrap_err();
    assert!(rejection.contains("neither BFRNV with a hull_box"), "{rejection}");
}

#[test]
fn a_plugins_query_and_its_request_get_the_same_answer() {
    let limits = setup(Some(station_limits())).limits;
    let judge = envelope(limits);
    let requests = [
        to_hull(1, 10.0, 5.0, 5.0),
        to_hull(2, 10.0, 5.0, 1.5),
        to_hull(3, 40.0, 7.0, 5.0),
        to_hull(4, f64::NAN, 7.0, 5.0),
        to_bottom(5, 10.0, 0.0, VerticalRequest::AltitudeM(66.0)),
        to_bottom(6, 40.0, 0.0, VerticalRequest::DepthM(20.0)),
        station(7),
        StationRequest {
            speed_mps: Some(3.0),
            ..station(8)
        },
    ];
    for request in requests {
        let mut trial = hovering();
        let input = trial.steps(0).pop().unwrap().1;
        let answer = judge.judge(&Request::Station(request), &input);
        let outcome = ask(&mut trial, request);
        match answer {
            Ok(metres) => {
                assert!(metres > 0.0);
                assert_eq!(outcome, Ok(()));
            }
            Err(refusal) => {
                let place = |text: &str| text.split(" may come").next().unwrap().to_owned();
                let said = place(&refusal.to_string());
                assert_eq!(said, place(&outcome.unwrap_err()));
            }
        }
    }
}
