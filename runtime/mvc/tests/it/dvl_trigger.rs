use crate::fields::of;
use crate::files::CALM;
use crate::payload::{ME, Payload};

fn with(dvl: &str) -> String {
    CALM.replace("[spi]", &format!("[dvl]\n{dvl}\n[spi]"))
}

fn dvt(payload: &mut Payload) -> Vec<String> {
    of(&payload.heard(), "BFDVT")
}

/// The payload may trigger from 2.0 s on, and says so.
fn triggering(dvl: &str) -> Payload {
    let mut payload = Payload::connected(&with(dvl), 1, &["ACK"]);
    payload.until(1.0);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(2.0);
    payload.say("$BPDVR,070001.000,1,1");
    payload.heard();
    payload
}

// SPI 7.4: "it should first send this message with the request field set to 1 and the currently triggering field set to
// 0. When it is safe to begin external triggering, the Bluefin vehicle will send a BFDVT message".
#[test]
fn the_vehicle_permits_triggering_once_it_is_safe() {
    let mut payload = Payload::connected(&with("safe_after_s = 3"), 1, &["ACK"]);
    payload.until(1.0);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(3.9);
    assert_eq!(payload.heard(), ["$BFACK,080001.000,DVR,070000.000,0,2,0,"]);
    payload.until(4.0);
    assert_eq!(payload.heard(), ["$BFDVT,080004.000,1"]);
    payload.say("$BPDVR,070001.000,1,1");
    payload.until(100.0);
    assert_eq!(payload.heard(), ["$BFACK,080004.000,DVR,070001.000,0,2,0,"]);
}

// "The former [0,1] will elicit a stop triggering command from the Bluefin vehicle after which the payload should
// respond with a request=0, triggering=0 message." The latter, 0,0, does not.
#[test]
fn the_payload_can_end_external_triggering_in_two_ways() {
    let mut payload = triggering("");
    payload.until(10.0);
    payload.say("$BPDVR,070002.000,0,1");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080010.000,DVR,070002.000,0,2,0,", "$BFDVT,080010.000,0"]
    );
    payload.say("$BPDVR,070003.000,0,0");
    payload.until(30.0);
    assert_eq!(payload.heard(), ["$BFACK,080010.000,DVR,070003.000,0,2,0,"]);

    let mut payload = triggering("");
    payload.until(10.0);
    payload.say("$BPDVR,070002.000,0,0");
    payload.until(30.0);
    assert_eq!(payload.heard(), ["$BFACK,080010.000,DVR,070002.000,0,2,0,"]);
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("the DVL is triggered internally"))
    );
}

// "At any time when in external triggering mode the Bluefin vehicle may initiate a stop triggering command ... The
// payload may indicate that it still wishes to be in external trigger mode with this response. In this case, the
// vehicle will re-enter external triggering mode as soon as is possible".
#[test]
fn the_vehicle_stops_external_triggering_and_resumes_it_if_the_payload_still_wants_it() {
    let mut payload = triggering("stop_at_s = [10]\nstop_for_s = 7");
    payload.until(9.9);
    assert_eq!(dvt(&mut payload), Vec::<String>::new());
    payload.until(10.5);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080010.000,0"]);
    payload.say("$BPDVR,070002.000,1,0");
    payload.until(16.9);
    assert_eq!(dvt(&mut payload), Vec::<String>::new());
    payload.until(17.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080017.000,1"]);

    // The payload no longer wants it.
    let mut payload = triggering("stop_at_s = [10]");
    payload.until(10.5);
    payload.heard();
    payload.say("$BPDVR,070002.000,0,0");
    payload.until(60.0);
    assert_eq!(dvt(&mut payload), Vec::<String>::new());

    // The payload answers late, and may begin a second after its answer.
    let mut payload = triggering("stop_at_s = [10]");
    payload.until(40.0);
    payload.heard();
    payload.say("$BPDVR,070002.000,1,0");
    payload.until(41.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080041.000,1"]);
}

#[test]
fn a_stop_before_the_permission_only_delays_it() {
    let mut payload = Payload::connected(&with("stop_at_s = [1.5]\nstop_for_s = 7"), 1, &[]);
    payload.until(1.0);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(30.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080008.500,1"]);
}

// "If the payload does not trigger the DVL for a set amount of time while in external trigger mode (5 seconds by
// default), the DVL will revert to internal trigger mode. [(Not Implemented) The vehicle will send a BFDVT message
// ...]"
#[test]
fn without_pulses_for_five_seconds_the_dvl_is_triggered_internally() {
    let reverted = |payload: &mut Payload| {
        let log = payload.log();
        log.into_iter()
            .find(|line| line.ends_with("the payload did not trigger it"))
    };
    // The payload itself says that it does not trigger, at 2.0 s.
    let mut payload = Payload::connected(&with(""), 1, &[]);
    payload.until(1.0);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(2.0);
    payload.say("$BPDVR,070001.000,1,0");
    payload.until(6.9);
    assert_eq!(reverted(&mut payload), None);
    payload.until(7.1);
    assert!(reverted(&mut payload).unwrap().starts_with("7.000 s"));
    assert_eq!(dvt(&mut payload), ["$BFDVT,080002.000,1"]);
    // The payload may ask again.
    payload.say("$BPDVR,070002.000,1,0");
    payload.until(9.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080008.100,1"]);

    // The triggering line is dead for less than five seconds, and then for more.
    let mut payload = triggering("line_faults = [{ at_s = 10, for_s = 4.5 }, { at_s = 20.05, for_s = 30 }]");
    payload.until(24.9);
    assert_eq!(reverted(&mut payload), None);
    payload.until(30.0);
    assert!(reverted(&mut payload).unwrap().starts_with("25.000 s"));

    let mut payload = triggering("payload_triggers = false\ntimeout_s = 2");
    payload.until(30.0);
    assert!(reverted(&mut payload).unwrap().starts_with("4.000 s"));

    // The vehicle announces it if `dvl_timeout_announced` is set.
    let text =
        with("payload_triggers = false").replace("[spi]", "[interpretation]\ndvl_timeout_announced = true\n[spi]");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(1.0);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(30.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080002.000,1", "$BFDVT,080007.000,0"]);
}

#[test]
fn a_payload_that_has_disconnected_no_longer_triggers() {
    let mut payload = triggering("");
    payload.until(10.0);
    payload.mvc.disconnect(payload.now, ME);
    payload.until(20.0);
    let log = payload.log();
    let reverted = log.iter().find(|line| line.ends_with("did not trigger it")).unwrap();
    assert!(reverted.starts_with("15.000 s"), "{log:?}");
}

#[test]
fn triggering_without_permission_is_refused() {
    let mut payload = Payload::connected(&with(""), 1, &["ACK"]);
    payload.until(1.0);
    payload.say("$BPDVR,070000.000,1,1");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080001.000,DVR,070000.000,0,1,0,triggering not permitted",
            "$BFDVT,080001.000,0"
        ]
    );
    payload.until(30.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

#[test]
fn every_other_message_of_the_handshake_changes_nothing() {
    // While triggering is internal: 0,0. While a request waits: the request again, and then its withdrawal.
    let mut payload = Payload::connected(&with("safe_after_s = 5"), 1, &[]);
    payload.say("$BPDVR,070000.000,0,0");
    payload.say("$BPDVR,070001.000,1,0");
    payload.until(4.0);
    payload.say("$BPDVR,070002.000,1,0");
    payload.until(5.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080005.000,1"]);
    let mut payload = Payload::connected(&with("safe_after_s = 5"), 1, &[]);
    payload.say("$BPDVR,070001.000,1,0");
    payload.until(4.0);
    payload.say("$BPDVR,070002.000,0,0");
    payload.until(30.0);
    assert_eq!(dvt(&mut payload), Vec::<String>::new());
    // While triggering is internal, the payload says that it triggers and wants to end: the vehicle tells it to stop.
    payload.say("$BPDVR,070003.000,0,1");
    assert_eq!(dvt(&mut payload), ["$BFDVT,080030.000,0"]);
    // The payload goes on after the vehicle has told it to stop, and stops later.
    let mut payload = triggering("stop_at_s = [10]");
    payload.until(11.0);
    payload.heard();
    payload.say("$BPDVR,070003.000,1,1");
    payload.say("$BPDVR,070003.000,0,1");
    payload.until(30.0);
    assert_eq!(dvt(&mut payload), Vec::<String>::new());
    payload.say("$BPDVR,070004.000,1,0");
    payload.until(32.0);
    assert_eq!(dvt(&mut payload), ["$BFDVT,080031.000,1"]);
}

#[test]
fn a_vehicle_without_the_lines_says_so() {
    let mut payload = Payload::connected(&with("triggering_equipped = false"), 1, &["ACK"]);
    payload.say("$BPDVR,070000.000,1,0");
    payload.until(5.0);
    assert_eq!(
        payload.heard(),
        ["$BFACK,080000.000,DVR,070000.000,0,1,0,no DVL triggering lines are fitted"]
    );
    payload.say("$BPDVR,070000.000,2,0");
    assert!(payload.heard()[0].starts_with("$BFACK,080005.000,DVR,070000.000,0,0,0,"));
}
