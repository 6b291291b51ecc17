use super::*;
use crate::EchoedTime;
use crate::{EncodeError, Fault, MAX_LINE, Sentence};

fn decode(line: &str) -> FromVehicle {
    FromVehicle::decode(&Sentence::parse(line).unwrap()).unwrap()
}

fn navigation(line: &str) -> Navigation {
    let FromVehicle::Navigation(navigation) = decode(line) else {
        panic!("another message")
    };
    navigation
}

#[test]
fn the_example_of_section_6_1_is_read() {
    // The specification misprints its checksum as 5b.
    let navigation =
        navigation("$BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E");
    assert_eq!(
        navigation.created,
        TimeOfDay::from_hms_nano(8, 10, 25, 987_000_000).unwrap()
    );
    assert!((navigation.position.latitude.as_deg() - 42.363_515_333_333).abs() < 1e-12);
    assert!((navigation.position.longitude.as_deg() + 71.114_100_5).abs() < 1e-12);
    assert_eq!(navigation.quality, PositionQuality::Gps);
    assert_eq!(navigation.altitude.map(Altitude::as_m), Some(45.3));
    assert_eq!((navigation.depth.as_m(), navigation.heading.as_deg()), (20.1, 203.1));
    assert_eq!((navigation.roll_deg, navigation.pitch_deg), (-3.4, 4.5));
    assert_eq!(
        navigation.solution,
        TimeOfDay::from_hms_nano(8, 10, 25, 980_000_000).unwrap()
    );
}

#[test]
fn acknowledgements_of_real_vehicles_are_read() {
    let ack = |line: &str| {
        let FromVehicle::Acknowledgement(ack) = decode(line) else {
            panic!("another message")
        };
        ack
    };
    let log = ack("$BFACK,081025.987,BPLOG,000000.000,0,2,0,log set");
    assert_eq!(log.command, CommandName::new("LOG").unwrap());
    assert_eq!((log.command_created, log.behavior), (EchoedTime::NONE, None));
    assert_eq!((log.status, log.text.as_str()), (AckStatus::Succeeded, "log set"));
    // BPLOG has no time to echo: some vehicles write nothing.
    let log = ack("$BFACK,081025.987,LOG,,0,2,0,log set");
    assert_eq!((log.command_created, log.behavior), (EchoedTime::NONE, None));
    let insert = ack("$BFACK,081025.987,RTK,081020.125,1001,3,0,,");
    assert_eq!(
        (insert.behavior, insert.status),
        (Some(BehaviorId::new(1001)), AckStatus::Pending)
    );
    assert_eq!(ack("$BFACK,081025.987,RMB,081020.125,,1,0").text, "");
    assert_eq!(
        ack("$BFACK,081025.987,NAK,000000.000,,0,0,what").command,
        CommandName::NAK
    );
}

#[test]
fn only_running_is_running() {
    let running = |status: &str| {
        let FromVehicle::MissionStatus(status) = decode(&format!("$BFMIS,081025.987,a.dive,{status},")) else {
            panic!("another message")
        };
        status.is_running()
    };
    assert!(running("Running") && running("Running /logs/12"));
    for other in ["", " ", "Ready", "running", "WrappingUp", "Not Running", " Running"] {
        assert!(!running(other), "{other:?}");
    }
}

#[test]
fn a_status_is_not_lost_to_characters_of_other_alphabets() {
    let FromVehicle::MissionStatus(status) = decode("$BFMIS,081025.987,levé.dive,Aborting,\u{7}") else {
        panic!("another message");
    };
    assert_eq!(
        (
            status.dive_file.as_str(),
            status.status.as_str(),
            status.details.as_str()
        ),
        ("lev .dive", "Aborting", " ")
    );
}

#[test]
fn errors_name_message_field_and_fault() {
    let error = |line: &str| FromVehicle::decode(&Sentence::parse(line).unwrap()).unwrap_err();
    assert_eq!(
        error("$BFNVG,081025.987,4221.8,N,07106.8,W,1,45.3,deep,").to_string(),
        "BFNVG field 8 (depth) \"deep\": expected a plain decimal number of at most 1e9, without exponent"
    );
    assert_eq!(
        error("$BFNVG,081025.987,4221.8,N,07106.8,W,1,45.3,20000,").to_string(),
        "BFNVG field 8 (depth) \"20000\": depth 20000 m is not within -100 to 12000"
    );
    assert_eq!(
        error("$BFCTL,081025.987").to_string(),
        "BFCTL field 2 (granted) \"\": the field is missing"
    );
    assert_eq!(
        error("$BFCPR,081025.987,081025.987,3,7,-1,2,1,0").to_string(),
        "BFCPR field 8 (data) \"0\": expected an even number of hexadecimal digits"
    );
    assert_eq!(error(&format!("$BFCTL,{}", "é".repeat(100))).found.chars().count(), 32);
}

#[test]
fn a_message_that_cannot_be_written_leaves_no_byte() {
    let mut out = b"before".to_vec();
    let good = navigation("$BFNVG,081025.987,4221.8,N,07106.8,W,1,45.3,20,203.1,-3.4,4.5,081025.980");
    let bad = FromVehicle::from(Navigation {
        pitch_deg: f64::NAN,
        ..good
    });
    let error = bad.encode(&mut out).unwrap_err();
    assert!(matches!(
        error,
        EncodeError::Field {
            message: "BFNVG",
            field: "pitch_deg",
            fault: Fault::Malformed { .. }
        }
    ));
    let long = FromVehicle::from(MissionCommand {
        created: TimeOfDay::MIDNIGHT,
        text: Text::cleaned(&"a".repeat(MAX_LINE)),
    });
    assert!(matches!(
        long.encode(&mut out),
        Err(EncodeError::TooLong { length, .. }) if length == MAX_LINE + 23
    ));
    let forged = crate::UnknownMessage::new("BFCTL", &["081025.987", "1"]).unwrap();
    assert!(matches!(
        FromVehicle::Unknown(forged).encode(&mut out),
        Err(EncodeError::Known { .. })
    ));
    assert_eq!(out, b"before");
}

#[test]
fn messages_of_the_payload_are_unknown_here() {
    let message = decode("$BPRMB,081025.987,90,3,0,1.5,1,0");
    let FromVehicle::Unknown(unknown) = &message else {
        panic!("{message:?}")
    };
    assert_eq!(
        (unknown.name(), unknown.fields().count(), message.created()),
        ("BPRMB", 7, None)
    );
    let mut out = Vec::new();
    message.encode(&mut out).unwrap();
    assert_eq!(out, b"$BPRMB,081025.987,90,3,0,1.5,1,0*54\r\n");
}
