use crate::fields::{field, number, of, seconds};
use crate::files::CALM;
use crate::payload::Payload;

/// No mission runs: the vehicle waits at 10 m for its start.
fn waiting(adjustment: &str) -> String {
    CALM.replace("[start]", "[start]\ndepth_m = 10")
        .replace("starts_after_s = 1", "starts_after_s = 5000")
        .replace("[spi]", &format!("[adjustment]\n{adjustment}\n[spi]"))
}

const TOPICS: &[&str] = &["ACK", "TRM", "BOY", "MBS", "MBE"];

// SPI 7.23: "a successful acknowledgement to the $BPTRM message indicates that the trim adjustment behavior has begun";
// BFTRM "are sent to the payload periodically while the trim adjustment is in progress, with the final $BFTRM message
// indicating the final success or failure"; "$BFMBS and $BFMBE messages will be transmitted at the beginning and end".
#[test]
fn trim_is_adjusted_with_periodic_status() {
    let mut payload = Payload::connected(&waiting(""), 1, TOPICS);
    payload.until(5.0);
    payload.heard();
    payload.say("$BPTRM,070000.000");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080005.000,TRM,070000.000,0,2,0,", "$BFMBS,080005.000,,,,trim"]
    );
    payload.until(60.0);
    let heard = payload.heard();
    let status = of(&heard, "BFTRM");
    // 1.5 degrees of pitch, at 0.05 degrees a second, to within 0.1 degrees.
    assert!((28..31).contains(&status.len()), "{status:?}");
    let (last, running) = status.split_last().unwrap();
    assert!(running.iter().all(|line| line.contains(",1,0,adjusting,")));
    assert!(running.windows(2).all(|pair| number(&pair[1], 5) < number(&pair[0], 5)));
    assert!((seconds(&running[1]) - seconds(&running[0]) - 1.0).abs() < 0.11);
    assert!(last.contains(",2,0,complete,") && number(last, 5).abs() <= 0.1 && number(last, 6).abs() <= 0.1);
    assert_eq!(of(&heard, "BFMBE"), [format!("$BFMBE,{},,,,trim", field(last, 1))]);
    // The vehicle is level now: "If it is detected that no adjustment is necessary, the behavior will immediately
    // complete successfully."
    payload.say("$BPTRM,070001.000");
    let heard = payload.heard();
    assert_eq!(
        heard[..2],
        ["$BFACK,080100.000,TRM,070001.000,0,2,0,", "$BFMBS,080100.000,,,,trim"]
    );
    assert!(heard[2].starts_with("$BFTRM,080100.000,2,0,complete,"));
    assert_eq!(heard[3], "$BFMBE,080100.000,,,,trim");
}

// 7.24: "The Buoyancy adjustment may cause the vehicle to no longer be trimmed." 6.23: BFBOY comes "when no adjustment
// is in progress" as well.
#[test]
fn buoyancy_is_adjusted_and_puts_the_vehicle_out_of_trim() {
    let mut payload = Payload::connected(&waiting("trim_pitch_deg = 0\ntrim_roll_deg = 0"), 1, TOPICS);
    payload.until(30.0);
    let idle = of(&payload.heard(), "BFBOY");
    assert_eq!(idle.len(), 3);
    assert!(idle.iter().all(|line| line.contains(",0,0,idle,20")), "{idle:?}");
    payload.say("$BPBOY,070000.000");
    payload.until(100.0);
    let heard = payload.heard();
    assert_eq!(heard[0], "$BFACK,080030.000,BOY,070000.000,0,2,0,");
    let status = of(&heard, "BFBOY");
    let done = status.iter().find(|line| field(line, 2) == "2").unwrap();
    assert!(
        number(done, 5).abs() <= 0.5 && (seconds(done) - 69.0).abs() < 0.5,
        "{done}"
    );
    assert!(of(&heard, "BFMBE")[0].ends_with(",buoyancy"));
    assert!(status.last().unwrap().contains(",0,0,idle,"));
    payload.say("$BPTRM,070001.000");
    payload.until(110.0);
    let trim = of(&payload.heard(), "BFTRM");
    assert!(number(&trim[0], 5) < -0.3, "{trim:?}");
}

// 7.23: "a failure acknowledgement indicates that the trim-adjustment functionality is not available or otherwise could
// not be deployed"; "The vehicle must also not be on the surface."
#[test]
fn adjustments_are_refused_with_their_reason() {
    let equipped = waiting("trim_equipped = false\nbuoyancy_equipped = false");
    let surfaced = waiting("").replace("depth_m = 10\nutc", "depth_m = 0.2\nutc");
    for (text, command, why) in [
        (&equipped, "TRM", "no trim adjustment system is fitted"),
        (&equipped, "BOY", "no variable buoyancy system is fitted"),
        (&surfaced, "TRM", "the vehicle is on the surface"),
        (&surfaced, "BOY", "the vehicle is on the surface"),
        (&CALM.to_owned(), "TRM", "the tailcone is spinning"),
        (&CALM.to_owned(), "BOY", "the tailcone is spinning"),
    ] {
        let mut payload = Payload::connected(text, 1, &["ACK", "MBS"]);
        payload.until(20.0);
        payload.heard();
        payload.say(&format!("$BP{command},070000.000"));
        let answer = format!("$BFACK,080020.000,{command},070000.000,0,1,0,{why}");
        assert_eq!(payload.heard(), [answer]);
    }
    let mut payload = Payload::connected(&waiting(""), 1, &["ACK"]);
    payload.say("$BPTRM,070000.000");
    payload.heard();
    payload.say("$BPBOY,070001.000");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080000.000,BOY,070001.000,0,1,0,another adjustment is running"]
    );
}

// 7.23: "$BFTRM must be registered using the $BPLOG command before requesting the trim behavior". The specification
// leaves open whether the request fails otherwise.
#[test]
fn the_status_message_may_have_to_be_on() {
    let text = waiting("").replace("[spi]", "[interpretation]\nadjustment_needs_status = true\n[spi]");
    let mut payload = Payload::connected(&text, 1, &["ACK", "BOY"]);
    payload.say("$BPTRM,070000.000");
    assert!(payload.heard()[0].ends_with(",1,0,its status message is not switched on"));
    payload.say("$BPBOY,070000.000");
    assert!(payload.heard()[0].ends_with(",2,0,"));
}

// "The operation can be canceled with the Cancel Current Behavior command".
#[test]
fn an_adjustment_is_cancelled_as_the_current_behavior() {
    let mut payload = Payload::connected(&waiting(""), 1, TOPICS);
    payload.say("$BPTRM,070000.000");
    payload.until(3.0);
    payload.heard();
    payload.say("$BPRCB,070001.000,0");
    let heard = payload.heard();
    assert!(heard[0].starts_with("$BFTRM,080003.000,3,2,canceled,"), "{heard:?}");
    assert_eq!(heard[1], "$BFMBE,080003.000,,,,trim");
    assert_eq!(heard[2], "$BFACK,080003.000,RCB,070001.000,0,2,0,");
    payload.until(20.0);
    assert_eq!(of(&payload.heard(), "BFTRM"), Vec::<String>::new());
}

// "The behavior will return an error status and end if unable to complete ... within a specified time, typically 20
// minutes."
#[test]
fn an_adjustment_fails_after_twenty_minutes() {
    let mut payload = Payload::connected(&waiting("buoyancy_rate_n_per_s = 0.001"), 1, TOPICS);
    payload.say("$BPBOY,070000.000");
    payload.until(1199.9);
    let heard = payload.heard();
    assert!(of(&heard, "BFMBE").is_empty());
    assert!(of(&heard, "BFBOY").last().unwrap().contains(",1,0,adjusting,"));
    payload.until(1200.1);
    let heard = payload.heard();
    assert!(
        heard[0].starts_with("$BFBOY,082000.000,3,1,it took too long,"),
        "{heard:?}"
    );
    assert_eq!(heard[1], "$BFMBE,082000.000,,,,buoyancy");
}

// 6.22, 6.23: error codes 1, operation failed, and 3, at limit.
#[test]
fn an_adjustment_fails_at_its_limit_or_by_chance() {
    for (adjustment, command, end) in [
        ("trim_range_deg = 1", "TRM", ",3,3,at limit,0.5,0"),
        ("buoyancy_range_n = 5", "BOY", ",3,3,at limit,15"),
        ("failure_chance = 1", "TRM", ",3,1,the system does not answer,"),
        ("failure_chance = 1", "BOY", ",3,1,the system does not answer,"),
    ] {
        let mut payload = Payload::connected(&waiting(adjustment), 1, TOPICS);
        payload.say(&format!("$BP{command},070000.000"));
        payload.until(200.0);
        let heard = payload.heard();
        let ended = of(&heard, &format!("BF{command}"));
        assert!(ended.iter().any(|line| line.contains(end)), "{adjustment}: {ended:?}");
        assert_eq!(of(&heard, "BFMBE").len(), 1);
    }
}

// "The implemented buoyancy algorithm will adjust the buoyancy after it is detected that the vehicle has stopped moving
// forward."
#[test]
fn in_a_mission_an_adjustment_waits_for_the_vehicle_to_stop_and_the_plan_goes_on_afterwards() {
    let mut payload = Payload::connected(CALM, 1, TOPICS);
    payload.until(60.0);
    payload.heard();
    payload.say("$BPRMB,070000.000,,,,0,0,");
    payload.until(61.4);
    payload.say("$BPBOY,070001.000");
    // The tailcone takes 1.5 s to stop.
    assert!(
        payload
            .heard()
            .last()
            .unwrap()
            .ends_with(",1,0,the tailcone is spinning")
    );
    payload.until(61.6);
    payload.say("$BPBOY,070002.000");
    assert!(payload.mvc.truth().speed_mps > 1.0);
    payload.until(63.0);
    let heard = payload.heard();
    assert!(heard[0].ends_with("BOY,070002.000,0,2,0,"), "{heard:?}");
    assert!(
        of(&heard, "BFBOY")
            .iter()
            .all(|line| line.contains(",1,0,waiting for the vehicle to stop,20"))
    );
    assert!(payload.until_that(200.0, |truth| truth.speed_mps <= 0.1));
    let stopped = payload.now.as_secs_f64();
    payload.until(150.0);
    let heard = payload.heard();
    let status = of(&heard, "BFBOY");
    let first = status.iter().find(|line| line.contains(",adjusting,")).unwrap();
    assert!(seconds(first) >= stopped - 0.01, "{first} {stopped}");
    assert_eq!(of(&heard, "BFMBE").len(), 1, "{heard:?}");
    assert!(status.iter().any(|line| line.contains(",2,0,complete,")));
    // The vehicle flies the plan's line again.
    assert!(payload.mvc.truth().speed_mps > 1.5);
}

#[test]
fn the_end_of_the_mission_ends_an_adjustment() {
    let text = CALM.replace("[mission]", "[mission]\ntime_limit_s = 70");
    let mut payload = Payload::connected(&text, 1, TOPICS);
    payload.until(60.0);
    payload.say("$BPRMB,070000.000,,,,0,0,");
    payload.until(62.0);
    payload.say("$BPTRM,070001.000");
    payload.heard();
    payload.until(80.0);
    let heard = payload.heard();
    let status = of(&heard, "BFTRM");
    assert!(
        status.last().unwrap().contains(",3,2,canceled: the mission ended,"),
        "{status:?}"
    );
}

#[test]
fn a_powered_ascent_does_not_wait_for_an_adjustment() {
    let text = waiting("buoyancy_rate_n_per_s = 0.001")
        .replace("starts_after_s = 5000", "starts_after_s = 40\nwrap_up = \"surface\"");
    let plan = "[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 30\ndepth_m = 10\nspeed_mps = 2\n";
    let text = text.split("[[plan]]").next().unwrap().to_owned() + plan;
    let mut payload = Payload::connected(&text, 1, TOPICS);
    payload.until(30.0);
    payload.say("$BPBOY,070000.000");
    payload.until(69.0);
    // The mission's time runs although the thruster is off.
    assert!(payload.mvc.truth().speed_mps < 0.05);
    payload.heard();
    payload.until(80.0);
    let heard = payload.heard();
    let ended = heard
        .iter()
        .any(|line| line.contains(",3,2,canceled: the mission wraps up,"));
    assert!(ended, "{heard:?}");
    assert!(payload.mvc.truth().speed_mps > 0.5);
}

// 7.24: "It is possible that the vehicle may perform implicit buoyancy adjustments".
#[test]
fn the_vehicle_adjusts_by_itself_and_stops_for_a_request() {
    let mut payload = Payload::connected(&waiting("implicit_at_s = [5]"), 1, TOPICS);
    payload.until(10.0);
    let heard = payload.heard();
    assert!(of(&heard, "BFMBS").is_empty());
    assert!(of(&heard, "BFBOY").last().unwrap().contains(",1,0,adjusting,"));
    payload.say("$BPTRM,070000.000");
    let heard = payload.heard();
    assert!(heard[0].starts_with("$BFBOY,080010.000,3,2,canceled: another was requested,"));
    assert_eq!(heard[1], "$BFACK,080010.000,TRM,070000.000,0,2,0,");
}

#[test]
fn a_neutrally_buoyant_vehicle_does_not_float_up() {
    let mission = CALM.replace("starts_after_s = 1", "starts_after_s = 1\ntime_limit_s = 100");
    let rise = |buoyancy: &str| {
        let text = mission.replace("[spi]", &format!("[adjustment]\n{buoyancy}\n[spi]"));
        let mut payload = Payload::connected(&text, 1, &[]);
        payload.until(120.0);
        let before = payload.mvc.truth().depth_m;
        payload.until(150.0);
        before - payload.mvc.truth().depth_m
    };
    assert!((rise("") - 3.0).abs() < 0.1);
    assert!((rise("buoyancy_n = 5") - 1.5).abs() < 0.1);
    assert!(rise("buoyancy_n = 0").abs() < 0.05);
    assert!(rise("buoyancy_n = -20") < -2.9);
}
