use crate::files::CALM;
use crate::payload::{ME, Payload};

/// Sentences, and everything that the vehicle answers to each, five seconds into the mission.
const TABLE: &[(&str, &[&str])] = &[
    ("$BPVER,070000.000,1.12", &["$BFACK,080005.000,VER,070000.000,0,2,0,"]),
    (
        "$BPSTS,070000.000,1,all well",
        &["$BFACK,080005.000,STS,070000.000,0,2,0,"],
    ),
    ("$BPMSG,070000.000,hello", &["$BFACK,080005.000,MSG,070000.000,0,2,0,"]),
    ("$BPLOG,NVG,ON", &["$BFACK,080005.000,LOG,000000.000,0,2,0,"]),
    ("$BPLOG,NVG,OFF", &["$BFACK,080005.000,LOG,000000.000,0,2,0,"]),
    ("$BPLOG,ALL,OFF", &["$BFACK,080005.000,LOG,000000.000,0,2,0,"]),
    (
        "$BPLOG,XYZ,ON",
        &["$BFACK,080005.000,LOG,000000.000,0,0,0,message XYZ: expected a message of the vehicle or ALL"],
    ),
    (
        "$BPLOG,SHT,OFF",
        &["$BFACK,080005.000,LOG,000000.000,0,1,0,command messages are always on"],
    ),
    (
        "$BPRMB,070000.123,90,3,0,1.5,1,0",
        &["$BFACK,080005.000,RMB,070000.123,0,2,0,"],
    ),
    ("$BPRMB,070000.123,,,,,,", &["$BFACK,080005.000,RMB,070000.123,0,2,0,"]),
    (
        "$BPRMB,070000.123,,,,600,0,",
        &["$BFACK,080005.000,RMB,070000.123,0,2,0,"],
    ),
    (
        "$BPRMB,070000.123,,,,1.5,,",
        &["$BFACK,080005.000,RMB,070000.123,0,2,0,"],
    ),
    (
        "$BPRMB,070000.123,5,,,,,1",
        &["$BFACK,080005.000,RMB,070000.123,0,2,0,"],
    ),
    ("$BPEMB,070000.000", &["$BFACK,080005.000,EMB,070000.000,0,2,0,"]),
    (
        "$BPEMB,070000.000",
        &["$BFACK,080005.000,EMB,070000.000,0,2,0,no behavior was modified"],
    ),
    (
        "$BPRTK,070000.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0",
        &["$BFACK,080005.000,RTK,070000.000,11,2,0,"],
    ),
    (
        "$BPRTK,070000.001,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0",
        &["$BFACK,080005.000,RTK,070000.001,11,1,0,the identifier has been used in this mission"],
    ),
    (
        "$BPRTK,070000.000,12,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,900,1.5,0,0",
        &["$BFACK,080005.000,RTK,070000.000,12,1,0,depth or altitude 900 m is beyond the limits of the vehicle"],
    ),
    (
        "$BPRTK,070000.000,12,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,9,0,0",
        &["$BFACK,080005.000,RTK,070000.000,12,1,0,speed 9 m/s is beyond the limits of the vehicle"],
    ),
    (
        "$BPRTK,070000.000,12,4218.1,N,07054.0,W,4318.2,N,07054.0,W,0,10,1.5,0,0",
        &["$BFACK,080005.000,RTK,070000.000,12,1,0,the place is over 50 km from the origin"],
    ),
    (
        "$BPRTK,070000.000,12,4218.1,N,07054.0,W,4218.2,N,07054.0,W,7,10,1.5,0,0",
        &["$BFACK,080005.000,RTK,070000.000,12,0,0,vertical_mode 7: expected 0 or 1"],
    ),
    (
        "$BPRTC,070000.000,13,4218.1,N,07054.0,W,40,1,0,10,450,1,0,0",
        &["$BFACK,080005.000,RTC,070000.000,13,2,0,"],
    ),
    (
        "$BPRTC,070000.000,14,4218.1,N,07054.0,W,1,1,0,10,1.5,0,,0",
        &["$BFACK,080005.000,RTC,070000.000,14,1,0,the line is too short or the circle too small or too long"],
    ),
    (
        "$BPRTK,070000.000,0,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0",
        &["$BFACK,080005.000,RTK,070000.000,0,0,0,identifier 0: expected 1 or more"],
    ),
    ("$BPRCN,070000.000,13", &["$BFACK,080005.000,RCN,070000.000,13,2,0,"]),
    (
        "$BPRCN,070000.000,13",
        &["$BFACK,080005.000,RCN,070000.000,13,1,0,no such behavior is waiting"],
    ),
    (
        "$BPRCA,070000.000",
        &["$BFACK,080005.000,RCA,070000.000,0,2,0,1 cancelled"],
    ),
    (
        "$BPRCA,070000.000",
        &["$BFACK,080005.000,RCA,070000.000,0,2,0,0 cancelled"],
    ),
    (
        "$BPABT,070000.000,stop,7",
        &["$BFACK,080005.000,ABT,070000.000,0,0,0,reason 7: expected 0 or 1"],
    ),
    (
        "$BPXYZ,070000.000",
        &["$BFACK,080005.000,NAK,000000.000,0,0,0,BPXYZ is no command"],
    ),
    (
        "$BFNVG,070000.000",
        &["$BFACK,080005.000,NAK,000000.000,0,0,0,BFNVG is no command"],
    ),
    ("just noise", &[]),
    ("$BPEMB,070000.000*00", &[]),
];

#[test]
fn each_command_has_its_answer() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(5.0);
    for (said, answers) in TABLE {
        payload.say(said);
        assert_eq!(&payload.heard(), answers, "{said}");
    }
}

#[test]
fn a_command_that_does_not_parse_keeps_its_name_and_names_the_field() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    for (said, name, field) in [
        ("$BPRMB,070000.000,north,3,0,1.5,1,0", "RMB", "horizontal"),
        ("$BPRTK,070000.000,11,4218.1,N,07054.0,W", "RTK", "end"),
        ("$BPSTS,070000.000,2,x", "STS", "ok"),
        ("$BPEMB,no time", "EMB", "created"),
        ("$BPLOG,NVG", "LOG", "on"),
    ] {
        payload.say(said);
        let heard = payload.heard();
        let time = if said.contains("070000.000") {
            "070000.000"
        } else {
            "000000.000"
        };
        let answer = format!("$BFACK,080000.000,{name},{time},0,0,0,");
        assert!(
            heard.len() == 1 && heard[0].starts_with(&answer) && heard[0].contains(field),
            "{said}: {heard:?}"
        );
    }
}

#[test]
fn the_formats_of_real_clients_are_understood() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(5.0);
    // LF alone, no checksum, lower-case and unpadded checksums, two at once, one in pieces.
    payload.bytes(ME, b"$BPMSG,070000.000,a\n");
    payload.bytes(ME, b"$BPMSG,070000.000,a*33\n$BPEMB,070000.000\r\n\n$BPMS");
    payload.bytes(ME, b"G,070000.000,b\r");
    assert_eq!(payload.heard().len(), 3);
    payload.bytes(ME, b"\n");
    assert_eq!(payload.heard(), ["$BFACK,080005.000,MSG,070000.000,0,2,0,"]);
}

#[test]
fn nothing_is_answered_until_acknowledgements_are_on() {
    let mut payload = Payload::connected(CALM, 1, &[]);
    payload.until(5.0);
    for (said, _) in TABLE.iter().filter(|(said, _)| !said.contains(",ON")) {
        payload.say(said);
    }
    assert_eq!(payload.heard(), Vec::<String>::new());
    // ALL does not include BFACK (SPI 7.1). The subscription of BFACK by its name is itself acknowledged.
    payload.say("$BPLOG,ALL,ON");
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.say("$BPLOG,ACK,ON");
    assert_eq!(payload.heard(), ["$BFACK,080005.000,LOG,000000.000,0,2,0,"]);
}
