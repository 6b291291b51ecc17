use crate::fields::of;
use crate::files::CALM;
use crate::payload::{ME, Payload};

/// No mission runs: the vehicle waits at 10 m for its start.
fn waiting() -> String {
    CALM.replace("[start]", "[start]\ndepth_m = 10")
        .replace("starts_after_s = 1", "starts_after_s = 5000")
}

fn settling(text: &str, silence: &str) -> String {
    text.replace("[spi]", &format!("[silence]\nsettle_s = 1\n{silence}\n[spi]"))
}

/// The thruster is off from 5.0 s on, by a modify to 0 rpm, which lapses at 10 s.
fn stopped(silence: &str) -> Payload {
    let mut payload = Payload::connected(&settling(CALM, silence), 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPRMB,070000.000,,,,0,0,");
    payload.until(5.2);
    payload.heard();
    payload
}

// SPI 7.22: "An immediate acknowledgement on the receipt of the command will be sent to the payload, followed by a
// deferred acknowledgement within 2 seconds indicating completion."
#[test]
fn silence_is_acknowledged_twice() {
    let mut payload = Payload::connected(&settling(&waiting(), ""), 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPSIL,070000.000,1");
    assert_eq!(payload.heard(), ["$BFACK,080005.000,SIL,070000.000,0,3,0,"]);
    payload.until(5.9);
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.until(7.0);
    assert_eq!(payload.heard(), ["$BFACK,080006.000,SIL,070000.000,0,2,0,"]);
    // And back to normal mode.
    payload.say("$BPSIL,070001.000,0");
    payload.until(9.0);
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080007.000,SIL,070001.000,0,3,0,",
            "$BFACK,080008.000,SIL,070001.000,0,2,0,"
        ]
    );
    payload.say("$BPSIL,070002.000,0");
    payload.until(11.0);
    assert_eq!(
        payload.heard()[1],
        "$BFACK,080010.000,SIL,070002.000,0,2,0,the vehicle was not silent"
    );
    payload.say("$BPSIL,070003.000,2");
    assert!(payload.heard()[0].starts_with("$BFACK,080011.000,SIL,070003.000,0,0,0,"));
}

// "The command will only be accepted if the vehicle is either not currently in a mission, or if a mission is executing
// but the tailcone is not spinning."
#[test]
fn silence_is_refused_while_the_tailcone_is_driven() {
    let mut payload = Payload::connected(&settling(CALM, ""), 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPSIL,070000.000,1");
    payload.until(9.0);
    assert_eq!(
        payload.heard(),
        ["$BFACK,080005.000,SIL,070000.000,0,1,0,the tailcone is spinning"]
    );
}

// "Before the deferred acknowledgement is sent, the current state of the tailcone is checked to see if it has stopped.
// If it has not, the deferred acknowledgement will be held off for another two seconds. If the tailcone is still
// spinning after that, the deferred acknowledgement will be an error."
#[test]
fn a_tailcone_that_spins_down_delays_the_acknowledgement() {
    for (spins_s, at, outcome) in [
        // Silence is requested at 5.2 s, and the tailcone is checked at 6.2 s and 8.2 s; the thruster was last on at
        // 5.0 s.
        (1.1, "080006.200", "2,0,"),
        (1.3, "080008.200", "2,0,"),
        (3.1, "080008.200", "2,0,"),
        (3.3, "080008.200", "1,0,the tailcone is still spinning"),
    ] {
        let mut payload = stopped(&format!("spin_down_s = {spins_s}"));
        payload.say("$BPSIL,070001.000,1");
        payload.until(9.3);
        let answer = format!("$BFACK,{at},SIL,070001.000,0,{outcome}");
        assert_eq!(
            payload.heard(),
            ["$BFACK,080005.200,SIL,070001.000,0,3,0,", answer.as_str()],
            "{spins_s}"
        );
    }
}

#[test]
fn a_tailcone_that_starts_again_meanwhile_is_an_error() {
    let mut payload = stopped("");
    payload.say("$BPSIL,070001.000,1");
    payload.say("$BPEMB,070001.000");
    payload.until(9.3);
    let heard = payload.heard();
    assert_eq!(
        heard.last().unwrap(),
        "$BFACK,080008.200,SIL,070001.000,0,1,0,the tailcone is still spinning"
    );
}

#[test]
fn silence_keeps_the_thruster_off_whatever_is_asked() {
    let mut payload = stopped("spin_down_s = 0");
    payload.say("$BPSIL,070001.000,1");
    payload.until(60.0);
    // The modify has lapsed long ago, and the plan asks for 2 m/s.
    payload.heard();
    payload.say("$BPRMB,070002.000,90,10,0,2,1,0");
    payload.until(64.0);
    assert_eq!(payload.heard().len(), 1);
    assert!(payload.mvc.truth().speed_mps < 0.05);
    payload.say("$BPSIL,070003.000,0");
    payload.until(80.0);
    assert!(payload.mvc.truth().speed_mps > 1.5);
}

// "The silent mode will time out after a configurable amount of time (default 5 minutes) ... The vehicle will resume as
// normal with no feedback to the payload. If the command to enter silent mode is sent again while in silent mode, it
// will not act to extend it beyond the time limit."
#[test]
fn silence_times_out_after_five_minutes_and_is_not_extended() {
    let mut payload = stopped("spin_down_s = 0");
    payload.say("$BPSIL,070001.000,1");
    payload.until(300.0);
    payload.heard();
    payload.say("$BPSIL,070002.000,1");
    payload.until(302.0);
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080500.000,SIL,070002.000,0,3,0,",
            "$BFACK,080501.000,SIL,070002.000,0,2,0,already silent: the time is not extended"
        ]
    );
    payload.log();
    // The vehicle is silent from 6.2 s on.
    payload.until(306.1);
    assert_eq!(payload.log(), Vec::<String>::new());
    payload.until(306.2);
    assert_eq!(payload.log(), ["306.200 s: silent mode ended: timed out"]);
    payload.until(330.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
    assert!(payload.mvc.truth().speed_mps > 1.5);
}

#[test]
fn the_time_out_is_a_setting() {
    let mut payload = stopped("spin_down_s = 0\ntimeout_s = 20");
    payload.say("$BPSIL,070001.000,1");
    payload.until(26.1);
    assert!(payload.mvc.truth().speed_mps < 0.5);
    payload.log();
    payload.until(26.2);
    assert_eq!(payload.log(), ["26.200 s: silent mode ended: timed out"]);
}

#[test]
fn a_request_for_normal_mode_overtakes_one_for_silence() {
    let mut payload = Payload::connected(&settling(&waiting(), ""), 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPSIL,070000.000,1");
    payload.say("$BPSIL,070001.000,0");
    payload.until(9.0);
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080005.000,SIL,070000.000,0,3,0,",
            "$BFACK,080005.000,SIL,070000.000,0,1,0,normal mode was requested meanwhile",
            "$BFACK,080005.000,SIL,070001.000,0,3,0,",
            "$BFACK,080006.000,SIL,070001.000,0,2,0,the vehicle was not silent"
        ]
    );
    assert!(!payload.log().iter().any(|line| line.contains("silent mode began")));
}

#[test]
fn a_device_may_fail_to_go_quiet() {
    let mut payload = Payload::connected(&settling(&waiting(), "failure_chance = 1"), 1, &["ACK"]);
    payload.say("$BPSIL,070000.000,1");
    payload.until(3.0);
    assert_eq!(
        payload.heard()[1],
        "$BFACK,080001.000,SIL,070000.000,0,1,0,a device did not go quiet"
    );
}

#[test]
fn a_new_connection_does_not_receive_the_outcome_for_the_old_one() {
    let mut payload = Payload::connected(&settling(&waiting(), ""), 1, &["ACK"]);
    payload.say("$BPSIL,070000.000,1");
    payload.mvc.disconnect(payload.now, ME);
    payload.connect(ME);
    payload.say("$BPLOG,ACK,ON");
    payload.heard();
    payload.until(4.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
    assert!(payload.log().iter().any(|line| line.ends_with("silent mode began")));
}

// 7.23, 7.24: "Any implicit adjustments ... will be immediately terminated (will not continue) if the vehicle is
// commanded to go silent".
#[test]
fn silence_ends_implicit_adjustments_at_once_and_forbids_others() {
    let text = settling(&waiting(), "").replace("[spi]", "[adjustment]\nimplicit_at_s = [3, 20]\n[spi]");
    let mut payload = Payload::connected(&text, 1, &["ACK", "BOY", "MBS"]);
    payload.until(5.0);
    let running = of(&payload.heard(), "BFBOY");
    assert!(running.last().unwrap().contains(",1,0,adjusting,"), "{running:?}");
    payload.say("$BPSIL,070000.000,1");
    let heard = payload.heard();
    assert!(
        heard[0].starts_with("$BFBOY,080005.000,3,2,canceled: silence was commanded,"),
        "{heard:?}"
    );
    assert_eq!(heard[1], "$BFACK,080005.000,SIL,070000.000,0,3,0,");
    for command in ["TRM", "BOY"] {
        payload.say(&format!("$BP{command},070001.000"));
        let answer = format!("$BFACK,080005.000,{command},070001.000,0,1,0,the vehicle is silent");
        assert_eq!(payload.heard(), [answer]);
    }
    // The next implicit adjustment does not begin either.
    payload.until(25.0);
    let heard = of(&payload.heard(), "BFBOY");
    assert!(heard.iter().all(|line| line.contains(",0,0,idle,")), "{heard:?}");
}

#[test]
fn silence_and_a_requested_adjustment_exclude_each_other() {
    let mut payload = Payload::connected(&settling(&waiting(), ""), 1, &["ACK", "TRM"]);
    payload.say("$BPTRM,070000.000");
    payload.until(5.0);
    payload.heard();
    payload.say("$BPSIL,070001.000,1");
    let heard = payload.heard();
    assert!(
        heard[0].starts_with("$BFTRM,080005.000,3,2,canceled: silence was commanded,"),
        "{heard:?}"
    );
    assert_eq!(heard[1], "$BFACK,080005.000,SIL,070001.000,0,3,0,");

    let text = settling(&waiting(), "").replace(
        "[spi]",
        "[interpretation]\nadjustment_when_silenced = \"refuse\"\n[spi]",
    );
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.say("$BPTRM,070000.000");
    payload.until(5.0);
    payload.heard();
    payload.say("$BPSIL,070001.000,1");
    assert_eq!(
        payload.heard(),
        ["$BFACK,080005.000,SIL,070001.000,0,1,0,a trim or buoyancy adjustment is running"]
    );
}

#[test]
fn the_wrap_up_ends_silence() {
    let text = settling(CALM, "spin_down_s = 0").replace("[mission]", "[mission]\nwrap_up = \"surface\"");
    let text = text.split("[[plan]]").next().unwrap().to_owned()
        + "[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = 30\ndepth_m = 10\nspeed_mps = 2\n"
        + "dynamic = true\n";
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.until(25.0);
    payload.say("$BPRMB,070000.000,,,,0,0,");
    payload.until(25.2);
    payload.say("$BPSIL,070001.000,1");
    payload.until(30.9);
    assert!(payload.log().iter().any(|line| line.ends_with("silent mode began")));
    payload.until(40.0);
    let log = payload.log();
    assert!(
        log.iter()
            .any(|line| line.ends_with("silent mode ended: the mission wraps up")),
        "{log:?}"
    );
    assert!(payload.mvc.truth().speed_mps > 0.3);
}
