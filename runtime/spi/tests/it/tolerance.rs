use backseat_spi::{
    AbortReason, AckStatus, CommandName, EncodeError, Fault, FrameData, FrameReceivedStatus, FrameSentStatus,
    FromVehicle, MAX_LINE, Packet, PacketReceived, ReceivedFrame, Sentence, Text, ToVehicle, TopsideText, Transport,
};
use backseat_units::TimeOfDay;

fn from_vehicle(line: &str) -> FromVehicle {
    FromVehicle::decode(&Sentence::parse(line).unwrap()).unwrap()
}

fn to_vehicle(line: &str) -> ToVehicle {
    ToVehicle::decode(&Sentence::parse(line).unwrap()).unwrap()
}

fn refused(line: &str) -> (&'static str, Fault) {
    let error = ToVehicle::decode(&Sentence::parse(line).unwrap()).unwrap_err();
    (error.field, error.fault)
}

/// SPI 7.16: without a reason, an abort is one with errors.
#[test]
fn an_abort_without_a_reason_counts_as_one_with_errors() {
    for line in [
        "$BPABT,081025.987,leak",
        "$BPABT,081025.987,leak,",
        "$BPABT,081025.987,leak, ,",
        "$BPABT,081025.987,leak,1",
    ] {
        let ToVehicle::Abort(abort) = to_vehicle(line) else {
            panic!("another message")
        };
        assert_eq!(
            (abort.text.as_str(), abort.reason),
            ("leak", AbortReason::Errors),
            "{line}"
        );
    }
    let ToVehicle::Abort(bare) = to_vehicle("$BPABT,081025.987") else {
        panic!("another message")
    };
    assert_eq!((bare.text.as_str(), bare.reason), ("", AbortReason::Errors));
    let ToVehicle::Abort(success) = to_vehicle("$BPABT,081025.987,,0") else {
        panic!("another message")
    };
    assert_eq!(success.reason, AbortReason::Successful);
    assert_eq!(refused("$BPABT,081025.987,leak,x").0, "reason");
}

#[test]
fn reserved_fields_may_be_left_out_empty_or_zero() {
    for tail in ["", ",", ",0", ",7,8"] {
        assert_eq!(
            to_vehicle(&format!("$BPRCB,081025.987{tail}")),
            to_vehicle("$BPRCB,081025.987,0")
        );
        assert_eq!(
            to_vehicle(&format!("$BPRCE,081025.987{tail}")),
            to_vehicle("$BPRCE,081025.987,0")
        );
        assert_eq!(
            to_vehicle(&format!("$BPTOP,081025.987,3,hello{tail}")),
            to_vehicle("$BPTOP,081025.987,3,hello,0")
        );
    }
}

#[test]
fn the_misprinted_comma_at_the_end_does_not_count_as_a_field() {
    assert_eq!(
        from_vehicle("$BFCMA,081025.987,081055.987,7,WHOIPSK,"),
        from_vehicle("$BFCMA,081025.987,081055.987,7,WHOIPSK")
    );
    assert_eq!(
        from_vehicle("$BFACK,081025.987,RTK,081025.950,1001,3,0,,"),
        from_vehicle("$BFACK,081025.987,BPRTK,081025.950,1001,3,0")
    );
}

#[test]
fn a_missing_reading_is_none_and_not_zero() {
    let FromVehicle::Dvl(dvl) = from_vehicle("$BFDVL,081025.987,,,,45.1,, ,45,,081025.900") else {
        panic!("another message")
    };
    assert_eq!(dvl.velocity_mps, [None; 3]);
    assert_eq!(dvl.ranges_m, [Some(45.1), None, None, Some(45.0)]);
    assert_eq!(dvl.temperature_c, None);
    for line in ["$BFRBS,081025.987,2,29.5", "$BFRBS,081025.987,2,29.5,,,,,"] {
        let FromVehicle::Battery(battery) = from_vehicle(line) else {
            panic!("another message")
        };
        assert_eq!(
            (battery.number, battery.voltage_v, battery.charge_percent),
            (2, Some(29.5), None)
        );
    }
    let FromVehicle::VehicleSpeed(speed) = from_vehicle("$BFRVL,081025.987,250") else {
        panic!("another message")
    };
    assert_eq!((speed.thruster_rpm, speed.water_speed_mps), (250.0, None));
    let missing = FromVehicle::decode(&Sentence::parse("$BFSVS,081025.987,").unwrap()).unwrap_err();
    assert_eq!((missing.field, missing.fault), ("sound_velocity_mps", Fault::Empty));
}

#[test]
fn a_battery_charge_over_100_percent_is_read_but_not_written() {
    let message = from_vehicle("$BFRBS,081025.987,0,29.85,3.71,3.75,18.5,3.2,100.4");
    let error = message.encode(&mut Vec::new()).unwrap_err();
    assert!(
        matches!(
            error,
            EncodeError::Field {
                field: "charge_percent",
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn numbers_that_the_specification_does_not_define_are_kept() {
    let FromVehicle::Acknowledgement(ack) = from_vehicle("$BFACK,081025.987,RMB,081025.950,0,9,0,later") else {
        panic!("another message")
    };
    assert_eq!(
        (ack.command, ack.status),
        (CommandName::new("RMB").unwrap(), AckStatus::Other(9))
    );
    for line in [
        "$BFTOP,081025.987,-4,hello",
        "$BFTRM,081025.987,7,-7,text,0.5,0.5",
        "$BFCPS,081025.987,081024.500,1,1,9,-1,0,0,0,0,0,0",
        "$BPRGP,081025.987,1,4221.810920,N,07106.846030,W,,,9",
    ] {
        let (name, rest) = line.split_at(6);
        let mut out = Vec::new();
        if name.starts_with("$BF") {
            from_vehicle(line).encode(&mut out).unwrap();
        } else {
            to_vehicle(line).encode(&mut out).unwrap();
        }
        assert!(
            String::from_utf8(out).unwrap().starts_with(&format!("{name}{rest}*")),
            "{line}"
        );
    }
}

#[test]
fn a_camera_light_or_bottom_position_out_of_its_range_is_refused() {
    assert_eq!(refused("$BPPTZ,081025.987,0,10,0").0, "tilt");
    assert_eq!(refused("$BPPTZ,081025.987,-9,9,-10").0, "zoom");
    assert_eq!(refused("$BPLIT,081025.987,0,2").0, "on");
    assert_eq!(refused("$BPGBP,081025.987,1,2,d,3").0, "reference");
    assert_eq!(
        refused("$BPNPU,081025.987,9000.1,N,07106.8,W,1,2,0,081025.987").0,
        "position"
    );
}

#[test]
fn packets_keep_their_frames_in_their_places() {
    let FromVehicle::PacketSent(sent) = from_vehicle("$BFCPS,081025.987,081024.500,4711,2,2,3") else {
        panic!("another message")
    };
    assert_eq!((sent.request, sent.frames), (4711, 2));
    assert_eq!(
        sent.statuses[..3],
        [
            FrameSentStatus::Acked,
            FrameSentStatus::FailedToSend,
            FrameSentStatus::Unset
        ]
    );
    let FromVehicle::PacketReceived(received) = from_vehicle("$BFCPR,081025.987,081025.500,3,7,-1,2,1,48656c6C6F,6,")
    else {
        panic!("another message")
    };
    assert_eq!(
        (received.source, received.destination, received.mode, received.frames),
        (3, 7, -1, 2)
    );
    assert_eq!(*received.data[0].data, *b"Hello");
    assert_eq!(
        (received.data[1].status, received.data[1].data.len()),
        (FrameReceivedStatus::Corrupted, 0)
    );
    assert_eq!(received.data[7], ReceivedFrame::default());
    assert_eq!(refused("$BPCPD,081025.987,4711,3,1,1,2,48656C6C6F").0, "frames");
    assert_eq!(
        refused("$BPCPD,081025.987,4711,3,1,1,9,00,00,00,00,00,00,00,00").0,
        "frames"
    );
}

/// Eight frames of 256 bytes are what the fastest modem sends.
#[test]
fn the_largest_packets_fit_into_a_line_and_larger_ones_are_not_written() {
    let received = |bytes: usize| PacketReceived {
        created: TimeOfDay::MIDNIGHT,
        arrived: TimeOfDay::MIDNIGHT,
        source: u32::MAX,
        destination: u32::MAX,
        mode: i32::MIN,
        frames: 8,
        data: [(); 8].map(|()| ReceivedFrame {
            status: FrameReceivedStatus::Other(i32::MIN),
            data: vec![0xff; bytes].into(),
        }),
    };
    let packet = |bytes: usize| Packet {
        created: TimeOfDay::MIDNIGHT,
        request: u32::MAX,
        destination: u32::MAX,
        mode: i32::MIN,
        ack: true,
        frames: FrameData::new(vec![vec![0xff; bytes]; 8]).unwrap(),
    };
    let mut out = Vec::new();
    FromVehicle::from(received(256)).encode(&mut out).unwrap();
    assert!(out.len() <= MAX_LINE);
    let line = String::from_utf8(out.clone()).unwrap();
    assert_eq!(from_vehicle(&line), received(256).into());
    out.clear();
    ToVehicle::from(packet(256)).encode(&mut out).unwrap();
    assert_eq!(to_vehicle(&String::from_utf8(out.clone()).unwrap()), packet(256).into());
    out.clear();
    let error = ToVehicle::from(packet(300)).encode(&mut out).unwrap_err();
    assert!(
        matches!(&error, EncodeError::TooLong { message, .. } if &**message == "BPCPD"),
        "{error}"
    );
    let text = TopsideText {
        created: TimeOfDay::MIDNIGHT,
        slowest: Transport::AcousticModem,
        text: Text::new(&"a".repeat(MAX_LINE)).unwrap(),
    };
    assert!(matches!(
        ToVehicle::from(text).encode(&mut out),
        Err(EncodeError::TooLong { .. })
    ));
    assert!(out.is_empty());
}
