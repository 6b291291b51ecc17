use backseat_mvc::{Activity, EndReason, MvcEvent, MvcEventKind};
use backseat_spi::BehaviorId;

use crate::files::CALM;
use crate::payload::{Payload, course, done, line};

/// A GPS hit about 111 m north and 69 m east of the origin.
fn hit(id: u32, mode: u32) -> String {
    format!("$BPRGP,070000.000,{id},4218.06,N,07053.95,W,120,5,{mode}")
}

fn flying(payload: &Payload, id: u32) -> bool {
    payload.mvc.truth().activity
        == Activity::Insert {
            id: BehaviorId::new(id),
        }
}

/// SPI 7.7, surface mode 0: "straight line". The vehicle goes to the place, surfaces, gets its fix, and goes on with
/// the mission.
#[test]
fn a_gps_hit_goes_to_its_place_surfaces_gets_its_fix_and_goes_on() {
    let text = CALM.replace("[mission]", "[mission]\ngps_fix_s = 20");
    let mut payload = Payload::connected(&text, 1, &["ACK", "MBS", "MBE", "NVG"]);
    payload.until(10.0);
    payload.heard();
    payload.say(&hit(7, 0));
    assert_eq!(
        payload.heard(),
        ["$BFACK,080010.000,RGP,070000.000,7,2,0,"],
        "7.7 knows no pending"
    );
    assert!(payload.until_that(400.0, |truth| truth.activity
        == Activity::Insert { id: BehaviorId::new(7) }));
    payload.heard();
    assert!(payload.until_that(700.0, |truth| truth.depth_m < 5.0));
    let place = backseat_units::EastNorth::new(68.7, 111.1);
    let off_m = payload.mvc.truth().local.distance_m(place);
    assert!(off_m < 30.0, "it climbs near its place: {off_m}");
    assert!(payload.until_that(900.0, |truth| truth.depth_m < 0.3));
    let up = payload.now.as_secs_f64();
    payload.until(up + 19.8);
    assert!(flying(&payload, 7), "just before the fix");
    assert!(
        payload
            .heard()
            .last()
            .is_some_and(|line| line.starts_with("$BFNVG") && line.split(',').nth(6) == Some("1"))
    );
    payload.until(up + 20.2);
    assert!(!flying(&payload, 7), "just after the fix");
    let ended = payload.heard();
    assert_eq!(course(&ended), ["-i7", "+2"]);
    assert!(
        ended
            .iter()
            .any(|line| line.starts_with("$BFMBE") && line.ends_with(",,,7,gps")),
        "{ended:?}"
    );
    done(&mut payload);
    assert!(payload.log().iter().any(|line| line.ends_with("gps fix of insert 7")));
}

/// SPI 7.7: "maximum time to surface ... uses vehicle default": without a fix by then the vehicle goes on.
#[test]
fn a_gps_hit_without_a_fix_gives_up() {
    let text = CALM.replace("[mission]", "[mission]\ngps_fix_s = 20\ngps_within_s = 30");
    let mut payload = Payload::connected(&text, 1, &["MBE"]);
    payload.until(10.0);
    // Manual: "no automatic surfacing", and the payload does not bring the vehicle up.
    payload.say(&hit(7, 2));
    let mut least_m = f64::INFINITY;
    assert!(payload.until_that(900.0, |truth| truth.activity
        == Activity::Insert { id: BehaviorId::new(7) }));
    while flying(&payload, 7) {
        payload.until(payload.now.as_secs_f64() + 1.0);
        least_m = least_m.min(payload.mvc.truth().depth_m);
    }
    assert!(least_m > 9.0, "{least_m}");
    let timed_out = |event: &MvcEvent| matches!(event.kind, MvcEventKind::BehaviorEnded(behavior, EndReason::TimedOut) if behavior.kind == "gps");
    assert!(payload.events.iter().any(timed_out));
}

/// SPI 7.7, surface mode 2, "manual": the payload brings the vehicle up with BPRMB, and the fix ends the behavior.
#[test]
fn a_manual_gps_hit_is_brought_up_by_the_payload() {
    let text = CALM.replace("[mission]", "[mission]\ngps_fix_s = 5\ncontrol = \"mission\"");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(10.0);
    payload.say(&hit(7, 2));
    payload.say("$BPRCB,070000.000,0");
    assert!(flying(&payload, 7));
    payload.until(150.0);
    assert!(payload.mvc.truth().depth_m > 9.0);
    for second in 150..230 {
        payload.until(f64::from(second));
        payload.say("$BPRMB,070000.000,90,0,0,1.5,1,0");
    }
    assert!(payload.log().iter().any(|line| line.ends_with("gps fix of insert 7")));
}

/// SPI 7.7: "1 = spiral (future implementation)". The identifier rules are those of the other inserts.
#[test]
fn wrong_gps_hits_are_refused_with_a_reason() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    let mut answer = |said: &str| {
        payload.say(said);
        payload.heard().pop().unwrap_or_default()
    };
    assert!(answer(&hit(7, 0)).ends_with(",RGP,070000.000,7,1,0,dynamic requests are not allowed now"));
    payload.until(10.0);
    let mut answer = |said: &str| {
        payload.say(said);
        payload.heard().pop().unwrap_or_default()
    };
    assert!(answer(&hit(7, 1)).ends_with(",7,1,0,surfacing in a spiral is not implemented"));
    assert!(answer(&hit(7, 3)).ends_with(",RGP,070000.000,7,0,0,mode 3: expected 0 to 2"));
    assert!(answer(&hit(0, 0)).ends_with(",0,0,0,identifier 0: expected 1 or more"));
    assert!(
        answer(&line(7, 20, 0)).ends_with(",7,2,0,"),
        "a refused identifier is not used up"
    );
    assert!(answer(&hit(7, 0)).ends_with(",7,1,0,the identifier has been used in this mission"));
    let far = "$BPRGP,070000.000,8,4318.06,N,07053.95,W,120,5,0";
    assert!(answer(far).ends_with(",8,1,0,the place is over 50 km from the origin"));
    assert!(answer("$BPRGP,070000.000,8,4218.06,N").contains(",RGP,070000.000,0,0,0,"));
    // The time and the number are ignored: they may be empty.
    assert!(answer("$BPRGP,070000.000,8,4218.06,N,07053.95,W,,,0").ends_with(",8,2,0,"));
}

/// SPI 7.8 cancels "a behavior inserted by a preceding BPRTK or BPRTC request", and no GPS hit; 7.9 does not say
/// whether it cancels one.
#[test]
fn bprcn_does_not_cancel_a_gps_hit_bprca_may_and_bprcb_does() {
    for (gps, left) in [("false", "1 cancelled"), ("true", "2 cancelled")] {
        let text = format!("{CALM}\n[interpretation]\ncancel_all_gps = {gps}");
        let mut payload = Payload::connected(&text, 1, &["ACK", "MBS", "MBE"]);
        payload.until(10.0);
        payload.say(&hit(7, 0));
        payload.say(&line(8, 20, 0));
        payload.heard();
        payload.say("$BPRCN,070000.000,7");
        assert!(payload.heard()[0].ends_with(",RCN,070000.000,7,1,0,a gps hit cannot be cancelled"));
        payload.say("$BPRCA,070000.000");
        assert!(payload.heard()[0].ends_with(left), "{gps}");
    }
    let mut payload = Payload::connected(CALM, 1, &["MBS", "MBE"]);
    payload.until(10.0);
    payload.say(&hit(7, 0));
    payload.say("$BPRCB,070000.000,0");
    payload.say("$BPRCB,070000.000,0");
    assert_eq!(course(&payload.heard()), ["+1", "-1", "+i7", "-i7", "+2"]);
}

/// SPI 6.20: a GPS hit is a waypoint of the plan.
#[test]
fn the_plan_contains_a_gps_hit_as_a_waypoint() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    payload.until(10.0);
    payload.say(&hit(7, 0));
    payload.say("$BPRMP,070000.000");
    payload.until(12.0);
    let heard = payload.heard();
    assert_eq!(&heard[2][17..], ",,7,0,0,4218.060000,N,07053.950000,W,,,", "{heard:?}");
}
