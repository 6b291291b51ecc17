use backseat_mvc::SensorFailure;
use backseat_units::EastNorth;

use crate::files::CALM;
use crate::payload::Payload;
use crate::sentences::{field, off, with};

/// A vehicle under way whose navigation is this many metres too far east, and takes itself to be good to about 5 m each
/// way.
fn astray(east_m: f64) -> Payload {
    let text = with(CALM, "sensors.gps", "error_m = 5");
    let mut payload = Payload::connected(&text, 1, &["NVG", "ACK"]);
    payload.until(100.0);
    // Moves the error of navigation from its present value to exactly that one.
    let line = payload.heard().pop().expect("navigation");
    let way = EastNorth::new(east_m, 0.0) - off(&payload, &line);
    payload.mvc.fail_sensor(SensorFailure::Jump(way));
    payload
}

/// Sends a BPNPU of this place, with this accuracy and these times, and returns the acknowledgements.
fn fix(payload: &mut Payload, at: EastNorth, error_m: &str, force: u8, times: (&str, &str)) -> Vec<String> {
    let position = payload.mvc.frame().to_position(at);
    let angle = |degrees: f64, width: usize| {
        let whole = degrees.abs().trunc();
        let minutes = (degrees.abs() - whole) * 60.0;
        format!("{whole:0width$}{minutes:09.6}")
    };
    let (created, measured) = times;
    payload.heard();
    payload.say(&format!(
        "$BPNPU,{created},{},N,{},W,{error_m},10,{force},{measured}",
        angle(position.latitude.as_deg(), 2),
        angle(position.longitude.as_deg(), 3),
    ));
    payload
        .heard()
        .into_iter()
        .filter(|line| line.starts_with("$BFACK"))
        .collect()
}

fn now_off(payload: &mut Payload) -> EastNorth {
    payload.heard();
    let next = payload.now.as_secs_f64() + 0.1;
    payload.until(next);
    let line = payload
        .heard()
        .into_iter()
        .rfind(|line| line.starts_with("$BFNVG"))
        .expect("navigation");
    off(payload, &line)
}

const SAME: (&str, &str) = ("120000.000", "120000.000");

/// SPI 7.21: "provides the vehicle with an additional navigation fix".
#[test]
fn a_fix_moves_the_navigation_according_to_its_accuracy() {
    let moved = |error_m: &str| {
        let mut payload = astray(6.0);
        let truth = payload.mvc.truth().local;
        let acks = fix(&mut payload, truth, error_m, 0, SAME);
        assert_eq!(acks.len(), 1);
        assert!(
            acks[0].contains(",NPU,120000.000,0,2,0,the navigation moved by "),
            "{acks:?}"
        );
        6.0 - now_off(&mut payload).east_m
    };
    // The circle that contains half the fixes has a radius of 1.177 standard deviations. A fix as good as the
    // navigation itself moves it half the way.
    assert!((moved("5.887") - 3.0).abs() < 0.05, "{}", moved("5.887"));
    assert!(moved("0.5") > 5.8, "{}", moved("0.5"));
    let poor = moved("50");
    assert!((0.02..0.2).contains(&poor), "{poor}");
    assert!(moved("0") > 5.9);
}

#[test]
fn after_a_fix_the_navigation_trusts_itself_more() {
    let mut payload = astray(6.0);
    let mut left = vec![6.0];
    for _ in 0..3 {
        let truth = payload.mvc.truth().local;
        fix(&mut payload, truth, "5.887", 0, SAME);
        left.push(now_off(&mut payload).east_m);
    }
    // The fixes remove a half, a third and a quarter of what is left.
    for (index, share) in [(1, 0.5), (2, 2.0 / 3.0), (3, 0.75)] {
        assert!((left[index] / left[index - 1] - share).abs() < 0.03, "{left:?}");
    }
}

/// SPI 7.21: "Force update".
#[test]
fn an_outlier_is_refused_unless_it_is_forced() {
    let mut payload = astray(100.0);
    let truth = payload.mvc.truth().local;
    let acks = fix(&mut payload, truth, "2", 0, SAME);
    assert!(
        acks[0].contains(",NPU,120000.000,0,1,0,the fix is an outlier: 100."),
        "{acks:?}"
    );
    assert!((now_off(&mut payload).east_m - 100.0).abs() < 0.1);
    let log = payload.log();
    assert!(
        log.iter()
            .any(|line| line.contains("a fix of client 1 was not used: the fix is an outlier")),
        "{log:?}"
    );
    let truth = payload.mvc.truth().local;
    let acks = fix(&mut payload, truth, "2", 1, SAME);
    assert!(
        acks[0].contains(",NPU,120000.000,0,2,0,the navigation moved by 100."),
        "{acks:?}"
    );
    assert!(now_off(&mut payload).east_m.abs() < 0.1);
}

#[test]
fn the_outlier_limit_counts_the_standard_deviations_of_fix_and_navigation() {
    // 5 m of the fix and 5 m of the navigation, each way, make 7.07 m: five times that is 35.4 m.
    for (metres, status) in [(34.9, ",2,0,"), (35.9, ",1,0,")] {
        let mut payload = astray(metres);
        let truth = payload.mvc.truth().local;
        let acks = fix(&mut payload, truth, "5.887", 0, SAME);
        assert!(acks[0].contains(status), "{metres} {acks:?}");
    }
}

/// SPI 7.21: a fix has a time of its own, and that of a USBL is seconds old when it arrives. Its age is measured on the
/// payload's clock. Here that differs by hours from the vehicle's clock, which is never a reason to refuse.
#[test]
fn an_old_fix_counts_for_the_place_where_the_vehicle_was() {
    let mut payload = astray(4.0);
    let then = payload.mvc.truth().local;
    payload.until(110.0);
    let way_m = payload.mvc.truth().local.distance_m(then);
    assert!(way_m > 19.0);
    let acks = fix(&mut payload, then, "0.2", 0, ("000004.000", "235954.000"));
    assert!(acks[0].contains(",2,0,"), "over midnight: {acks:?}");
    // The vehicle steers back to its line meanwhile, so the test looks at the error that navigation has now.
    let off = now_off(&mut payload);
    assert!(off.distance_m(EastNorth::default()) < 0.3, "{off:?}");
}

#[test]
fn a_fix_counts_less_with_its_age_and_then_not_at_all() {
    let text_off = |age: &str| {
        let mut payload = astray(4.0);
        let then = payload.mvc.truth().local;
        let now = payload.now.as_secs_f64() + 50.0;
        payload.until(now);
        let acks = fix(&mut payload, then, "5.887", 0, ("120100.000", age));
        (acks, now_off(&mut payload).east_m)
    };
    let (acks, _) = text_off("120000.000");
    assert!(acks[0].contains(",2,0,"), "60 s: {acks:?}");
    let (acks, left_m) = text_off("115959.900");
    assert!(acks[0].contains(",1,0,the fix is 60.1 s old"), "{acks:?}");
    assert!((left_m - 4.0).abs() < 0.1, "{left_m}");
    let moved = |keys: &str| {
        let text = with(&with(CALM, "sensors.gps", "error_m = 5"), "sensors.fixes", keys);
        let mut payload = Payload::connected(&text, 1, &["NVG", "ACK"]);
        payload.until(100.0);
        let line = payload.heard().pop().expect("navigation");
        payload
            .mvc
            .fail_sensor(SensorFailure::Jump(EastNorth::new(4.0, 0.0) - off(&payload, &line)));
        let then = payload.mvc.truth().local;
        payload.until(140.0);
        fix(&mut payload, then, "5.887", 0, ("120040.000", "120000.000"));
        4.0 - now_off(&mut payload).east_m
    };
    // 40 s of age add 20 m to the 5 m.
    let (fresh, aged) = (moved("age_error_mps = 0"), moved("age_error_mps = 0.5"));
    assert!(
        (fresh - 2.0).abs() < 0.1 && (0.1..0.3).contains(&aged),
        "{fresh} {aged}"
    );
}

#[test]
fn a_fix_without_meaning_is_invalid_and_one_far_away_fails() {
    let mut payload = astray(0.0);
    let truth = payload.mvc.truth().local;
    let acks = fix(&mut payload, truth, "-3", 0, SAME);
    assert!(
        acks[0].contains(",NPU,120000.000,0,0,0,circular error probability -3: expected 0 to 100000 m"),
        "{acks:?}"
    );
    payload.say("$BPNPU,120000.000,0000.0,N,00000.0,E,5,10,1,120000.000");
    let heard = payload.heard();
    assert!(
        heard.iter().any(|line| line.contains(",1,0,the fix is over 50 km")),
        "{heard:?}"
    );
    payload.say("$BPNPU,120000.000,4218.0,N,07054.0,W,5,10");
    let heard = payload.heard();
    assert!(
        heard.iter().any(|line| line.contains(",NPU,120000.000,0,0,0,")),
        "{heard:?}"
    );
    assert!(now_off(&mut payload).distance_m(EastNorth::default()) < 0.1);
}

#[test]
fn the_vehicle_steers_by_the_navigation_that_a_fix_has_moved() {
    let mut payload = astray(8.0);
    let place = payload.mvc.truth().local;
    fix(&mut payload, place, "1", 1, SAME);
    payload.until(170.0);
    let east_m = payload.mvc.truth().local.east_m;
    assert!(east_m.abs() < 1.0, "{east_m}");
}

/// SPI 7.15: the payload's CTD data aid the navigation. Without a sensor the vehicle estimates BFSVS from them (6.4).
#[test]
fn a_payloads_ctd_data_are_logged_and_give_the_speed_of_sound() {
    let text = with(CALM, "sensors", "ctd_fitted = false");
    let mut payload = Payload::connected(&text, 1, &["SVS", "ACK"]);
    payload.until(10.5);
    assert_eq!(field(&payload.heard().pop().expect("a value"), 2), 1500.0);
    // Standard sea water at 15 degrees near the surface.
    payload.say("$BPCTD,120000.000,42914,15,101.325,120000.000");
    let heard = payload.heard();
    assert!(heard[0].contains(",CTD,120000.000,0,2,0,"), "{heard:?}");
    let log = payload.log();
    assert!(
        log.iter()
            .any(|line| line.contains("client 1 measures 42914.0 uS/cm, 15.000 degC, 101.3 kPa")),
        "{log:?}"
    );
    payload.until(70.4);
    assert!((field(&payload.heard().pop().expect("a value"), 2) - 1506.66).abs() < 0.05);
    // A minute after their arrival the data are no longer used.
    payload.until(71.5);
    assert_eq!(field(&payload.heard().pop().expect("a value"), 2), 1500.0);
}

#[test]
fn ctd_data_without_meaning_are_invalid() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    for (values, text) in [
        ("-1,15,100", "conductivity -1: expected 0 to 100000 uS/cm"),
        ("40000,90,100", "temperature 90: expected -5 to 50 degC"),
        ("40000,15,-3", "pressure -3: expected 0 to 150000 kPa"),
    ] {
        payload.say(&format!("$BPCTD,120000.000,{values},120000.000"));
        let heard = payload.heard();
        assert!(heard[0].contains(&format!(",CTD,120000.000,0,0,0,{text}")), "{heard:?}");
    }
    payload.say("$BPCTD,120000.000,40000,warm,100,120000.000");
    assert!(payload.heard()[0].contains(",CTD,120000.000,0,0,0,"));
}
