use backseat_mvc::{Mvc, WorldFile};

use crate::files::CALM;
use crate::hovering::HARBOUR;
use crate::payload::{ME, Payload};

fn refusal(text: &str) -> String {
    let file = WorldFile::from_toml(text).expect("every value is in its range");
    Mvc::new(&file, 1).expect_err("it cannot be flown").to_string()
}

/// The vehicle could fly a depth below the seabed only as another depth.
#[test]
fn a_plan_below_the_seabed_is_refused_with_its_place() {
    let fault = refusal(&CALM.replacen("depth_m = 60", "depth_m = 8", 1));
    assert!(
        fault.starts_with("plan element 1: the water is 8.00 m deep at 0 m east") && fault.contains("at least 10.00 m"),
        "{fault}"
    );
    // The limit is exact to the centimetre.
    for (water_m, fits) in [("9.99", false), ("10.01", true)] {
        let text = CALM.replacen("depth_m = 60", &format!("depth_m = {water_m}"), 1);
        let file = WorldFile::from_toml(&text).expect("every value is in its range");
        assert_eq!(Mvc::new(&file, 1).is_ok(), fits, "{water_m}");
    }
}

#[test]
fn a_start_below_the_seabed_is_refused() {
    let fault = refusal(&CALM.replace("[start]", "[start]\ndepth_m = 70"));
    assert_eq!(
        fault,
        "start.depth_m is 70 in 60.00 m of water, expected at most the water's depth"
    );
}

/// SPI 6.20: "the sequence of waypoints contained in a series of BFPLN messages will accurately describe a mission's
/// planned course".
#[test]
fn the_plan_contains_lines_with_their_lead_ins_and_lead_outs() {
    let text = CALM
        .replacen("kind = \"trackline\"", "kind = \"trackline\"\nlead_in_m = 200", 1)
        .replace("[spi]", "[interpretation]\nlead_in_m = 50\n[spi]");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPRTK,070000.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0");
    payload.say("$BPRMP,070000.001");
    payload.until(7.5);
    let minutes: Vec<f64> = payload
        .heard()
        .iter()
        .filter(|line| line.starts_with("$BFPLN"))
        .filter_map(|line| line.split(',').nth(6)?.strip_prefix("42")?.parse().ok())
        .collect();
    // A minute of latitude is some 1851 m here. The line goes from 20 m less 200 m to 400 m and 200 m; the insert has
    // 50 m before and after it.
    let expected = [17.9028, 18.3241, 18.0730, 18.2270];
    for (minutes, expected) in minutes.iter().zip(expected) {
        assert!((minutes - expected).abs() < 0.0005, "{minutes} {expected}");
    }
    assert_eq!(minutes.len(), 5);
}

/// SPI 7.5: "0=new behavior runs after current (default)".
#[test]
fn the_interrupt_code_has_a_default() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(5.0);
    for (id, end) in [(11, ",0,"), (12, ",0")] {
        payload.say(&format!(
            "$BPRTK,070000.000,{id},4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5{end}"
        ));
        assert_eq!(payload.heard(), [format!("$BFACK,080005.000,RTK,070000.000,{id},2,0,")]);
    }
    payload.say("$BPRTC,070000.000,13,4218.1,N,07054.0,W,40,1,0,10,1.5,0,,");
    assert_eq!(payload.heard(), ["$BFACK,080005.000,RTC,070000.000,13,2,0,"]);
}

/// SPI 6.12: BFERC "is only provided on vehicles with tailcones": a vehicle without one does not wait for it to stop.
#[test]
fn a_hovering_vehicle_has_no_spinning_tailcone() {
    let mut payload = Payload::connected(HARBOUR, 1, &["ACK"]);
    payload.until(5.0);
    payload.say("$BPSIL,070000.000,1");
    payload.until(8.0);
    let heard = payload.heard();
    assert!(
        heard[0].ends_with(",SIL,070000.000,0,3,0,") && heard[1].contains(",SIL,070000.000,0,2,0,"),
        "{heard:?}"
    );
    assert!(payload.mvc.truth().speed_mps > 0.1, "its thrusters go on");
}

#[test]
fn a_fault_of_an_unknown_command_is_refused() {
    let text = format!("{CALM}\n[[faults.fault]]\nat_s = 1\nfor_s = 1\nkind = \"acks_lost\"\ncommand = \"ZZZ\"\n");
    let fault = WorldFile::from_toml(&text)
        .expect_err("there is no such command")
        .to_string();
    assert_eq!(
        fault,
        "fault 1: command is \"ZZZ\", expected a command of the interface, RMB or BPRMB"
    );
}

/// The vehicle logs what it does not answer, in one line a second at most.
#[test]
fn bytes_that_are_no_sentence_are_counted_in_the_log() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(1.0);
    payload.log();
    payload.bytes(ME, b"$BPMSG,070000.000,x*00\r\n$BPMSG ,070000.000,x\r\nnoise\r\n");
    payload.bytes(ME, b"$BPMSG,070000.000,x*00\r\n");
    let told =
        |log: Vec<String>| -> Vec<String> { log.into_iter().filter(|line| line.contains("invalid input")).collect() };
    assert_eq!(
        told(payload.log()),
        [
            "1.000 s: client 1 sent invalid input: 1 with a wrong checksum (`backseat spi decode` names the right one); \
          1 without a name; 5 bytes outside of a sentence (it begins with a dollar sign)"
        ]
    );
    payload.until(2.0);
    payload.bytes(ME, b"$BPMSG,070000.000,x*00\r\n");
    assert_eq!(
        told(payload.log()),
        ["2.000 s: client 1 sent invalid input: 2 with a wrong checksum (`backseat spi decode` names the right one)"]
    );
}
