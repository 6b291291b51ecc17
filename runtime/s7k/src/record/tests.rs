use backseat_units::Utc;

use super::*;
use crate::checksum::BluefinChecksum;
use crate::frame::{FRAME_LIMIT, FrameHeader, FrameWriter};
use crate::plc::{Command, CommandId, Order};
use crate::{Chars, DeviceId, Reserved, SensorIndex, Time7k};

fn channel_header(samples: u32, bytes_per_sample: u8, side: ChannelSide) -> ChannelHeader {
    ChannelHeader {
        number: side.code(),
        side,
        range_kind: RangeKind::Slant,
        polarity: Polarity::Unipolar,
        bytes_per_sample,
        reserved_1: Reserved::default(),
        samples,
        start_us: 0,
        sample_interval_us: 50,
        range_m: 75.0,
        full_scale_v: -1.0,
        name: Chars::new("HF port").unwrap(),
        reserved_2: Reserved::default(),
    }
}

const fn imagery_header(data_format: SampleFormat) -> ImageryHeader {
    ImageryHeader {
        time_ms: 7,
        ping: 42,
        channels: 0,
        channel_bytes: 0,
        data_format,
    }
}

/// A sidescan record of two channels with samples 0, 1, 2 …, and EdgeTech's headers.
fn sidescan(layout: HeaderLayout, samples: u32) -> Vec<u8> {
    let bytes: Vec<u8> = (0..samples)
        .flat_map(|sample| u16::try_from(sample % 65_536).unwrap().to_le_bytes())
        .collect();
    let channel = |side| Channel {
        header: channel_header(samples, 2, side),
        bytes: &bytes,
    };
    let channels = [channel(ChannelSide::Port), channel(ChannelSide::Starboard)];
    let header = SideScanHeader::read(&[0; SideScanHeader::SIZE]).unwrap();
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(3000, DeviceId::SIDESCAN_HIGH), &mut out);
    Imagery::compose(
        imagery_header(SampleFormat::Envelope),
        layout,
        &channels,
        160,
        frame.bytes(),
    )
    .unwrap();
    frame.begin_optional(SideScanHeader::OPTIONAL_ID);
    for ping in [42, 43] {
        SideScanHeader {
            ping,
            samples,
            ..header
        }
        .write(frame.bytes());
    }
    frame.finish(FRAME_LIMIT).unwrap();
    out
}

/// A frame of a type with this body.
fn framed(record_type: u32, body: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(record_type, DeviceId::BLUEFIN), &mut out);
    frame.bytes().extend_from_slice(body);
    frame.finish(FRAME_LIMIT).unwrap();
    out
}

fn frame(bytes: &[u8]) -> Frame<'_> {
    Frame::read(bytes, FRAME_LIMIT).unwrap()
}

/// Reads a record and writes it again: the same bytes.
fn check_rewrite(bytes: &[u8]) {
    let frame = frame(bytes);
    let mut out = Vec::new();
    Record::read(&frame).unwrap().write(&mut out);
    assert_eq!(out, frame.body().unwrap());
}

#[test]
fn sidescan_is_read_in_both_layouts_of_its_header() {
    for layout in [HeaderLayout::Spec, HeaderLayout::Padded] {
        let bytes = sidescan(layout, 455);
        check_rewrite(&bytes);
        let frame = frame(&bytes);
        let Record::SideScan(imagery) = Record::read(&frame).unwrap() else {
            panic!()
        };
        assert_eq!(
            (imagery.layout(), imagery.header.channels, imagery.header.ping),
            (layout, 2, 42)
        );
        assert_eq!(imagery.header.channel_bytes, 2 * (64 + 910) + 160);
        let channels: Vec<Channel<'_>> = imagery.channels().collect();
        assert_eq!(channels.len(), 2);
        assert_eq!(channels[1].header.side, ChannelSide::Starboard);
        let samples = imagery.samples(&channels[1]);
        let mut amplitudes = Vec::new();
        samples.amplitudes(&mut amplitudes);
        assert_eq!((samples.len(), amplitudes.len(), amplitudes[454]), (455, 455, 454.0));
        let pings: Vec<u32> = imagery.side_scan_headers().map(|header| header.ping).collect();
        assert_eq!((pings, imagery.segy_headers().count()), (vec![42, 43], 0));
        // The samples are the record's own bytes.
        assert!(bytes.as_ptr_range().contains(&channels[0].bytes.as_ptr()));
    }
}

#[test]
fn samples_have_the_type_that_the_header_says() {
    let view = |format, bytes_per_sample, polarity, bytes: &[u8]| {
        let samples = u32::try_from(bytes.len()).unwrap() / u32::from(bytes_per_sample);
        let mut header = channel_header(samples, bytes_per_sample, ChannelSide::Port);
        header.polarity = polarity;
        let mut body = Vec::new();
        let channel = Channel { header, bytes };
        Imagery::compose(imagery_header(format), HeaderLayout::Spec, &[channel], 0, &mut body).unwrap();
        let record = framed(3001, &body);
        let frame = frame(&record);
        let Record::SubBottom(imagery) = Record::read(&frame).unwrap() else {
            panic!()
        };
        let channel = imagery.channels().next().unwrap();
        let mut amplitudes = Vec::new();
        let samples = imagery.samples(&channel);
        samples.amplitudes(&mut amplitudes);
        (amplitudes, samples.complex().collect::<Vec<_>>())
    };
    use Polarity::{Bipolar, Unipolar};
    use SampleFormat::{Complex, Envelope};
    assert_eq!(view(Envelope, 1, Unipolar, &[200]).0, [200.0]);
    assert_eq!(view(Envelope, 1, Bipolar, &[200]).0, [56.0]);
    assert_eq!(view(Envelope, 2, Unipolar, &[0xFF, 0xFF]).0, [65_535.0]);
    assert_eq!(view(Envelope, 2, Bipolar, &[0xFF, 0xFF]).0, [1.0]);
    assert_eq!(view(Envelope, 4, Unipolar, &[0, 0, 0, 0x80]).0, [2_147_483_648.0]);
    assert_eq!(view(Envelope, 4, Bipolar, &[0, 0, 0, 0x80]).0, [2_147_483_648.0]);
    assert_eq!(
        view(Complex, 4, Bipolar, &[3, 0, 0xFC, 0xFF]),
        (vec![5.0], vec![[3, -4]])
    );
    assert_eq!(view(Complex, 8, Bipolar, &[1; 8]), (vec![], vec![]));
    assert_eq!(view(Envelope, 3, Bipolar, &[1; 6]), (vec![], vec![]));
}

#[test]
fn channels_that_do_not_fit_name_the_channel_and_the_field() {
    let good = sidescan(HeaderLayout::Spec, 100);
    let error = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        Record::read(&frame(&bytes))
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    // The second channel's header begins at 64 + 20 + 64 + 200; its number of samples 8 bytes later.
    assert_eq!(
        error(64 + 20 + 64 + 200 + 8, 101).unwrap_err(),
        "record 3000 at byte 284 of its body: channel 1 field samples: 101 samples of 2 bytes do not fit, 200 bytes remain"
    );
    let few = error(64 + 8, 1).unwrap_err();
    assert!(few.contains("264 bytes follow the last channel"), "{few}");
    let many = error(64 + 8, 1_000_000).unwrap_err();
    assert!(
        many.contains("ChannelHeader field number: the record ends at byte 0 of 64"),
        "{many}"
    );
    assert!(error(64 + 20 + 8, u32::MAX).is_err());
}

#[test]
fn a_record_without_channels_is_read() {
    for (layout, length) in [(HeaderLayout::Spec, 20), (HeaderLayout::Padded, 32)] {
        let mut body = Vec::new();
        Imagery::compose(imagery_header(SampleFormat::Envelope), layout, &[], 0, &mut body).unwrap();
        assert_eq!(body.len(), length);
        let record = framed(3000, &body);
        check_rewrite(&record);
        let frame = frame(&record);
        let Record::SideScan(imagery) = Record::read(&frame).unwrap() else {
            panic!()
        };
        assert_eq!((imagery.layout(), imagery.channels().count()), (layout, 0));
    }
}

#[test]
fn vehicle_data_are_written_and_read_frame_by_frame() {
    let time = Time7k::from_utc(Utc::from_unix_nanos(1_700_000_000_250_000_000));
    let navigation = NavigationFrame {
        quality: NavigationQuality::default()
            .with(NavigationField::Latitude)
            .with(NavigationField::Depth),
        latitude_rad: 0.73,
        depth_m: 20.5,
        ..NavigationFrame::default()
    };
    let mut body = Vec::new();
    let frames = vec![(time, navigation); 25];
    BluefinRecord::compose_navigation(9, &frames, BluefinChecksum::WholePacket, &mut body).unwrap();
    assert_eq!(body.len(), 32 + 25 * 128);
    let record = framed(3100, &body);
    check_rewrite(&record);
    let read = frame(&record);
    let Record::Bluefin(read) = Record::read(&read).unwrap() else {
        panic!()
    };
    assert_eq!(
        (read.header.frames, read.header.frame_size, read.header.data_format),
        (25, 128, BluefinFormat::Navigation)
    );
    let back: Vec<BluefinFrame<'_>> = read.frames().collect();
    assert_eq!(back.len(), 25);
    assert_eq!(
        (back[24].data, back[24].header.time),
        (BluefinData::Navigation(navigation), time)
    );
    assert_eq!(back[0].header.data_type, BluefinDataType::Navigation);
    assert_eq!(back[0].checksum_matches(BluefinChecksum::WholePacket), Some(true));
    assert_eq!(back[0].checksum_matches(BluefinChecksum::DataOnly), Some(false));
    assert_eq!(back[0].checksum_matches(BluefinChecksum::None), None);
    let json = serde_json::to_value(navigation).unwrap();
    assert_eq!(json["quality"], serde_json::json!(["latitude", "depth"]));

    let environment = EnvironmentFrame {
        quality: EnvironmentQuality::default().with(EnvironmentField::SoundSpeed),
        sound_speed_mps: 1490.0,
        reserved: Reserved::default(),
    };
    body.clear();
    BluefinRecord::compose_environment(9, &[(time, environment)], BluefinChecksum::DataOnly, &mut body).unwrap();
    let record = framed(3100, &body);
    let read = frame(&record);
    let Record::Bluefin(read) = Record::read(&read).unwrap() else {
        panic!()
    };
    let back = read.frames().next().unwrap();
    assert_eq!(back.data, BluefinData::Environment(environment));
    assert_eq!(back.checksum_matches(BluefinChecksum::DataOnly), Some(true));
}

#[test]
fn a_reader_that_holds_25_frames_never_gets_more() {
    let frames = vec![(Time7k::NONE, NavigationFrame::default()); 26];
    let mut body = Vec::new();
    let error = BluefinRecord::compose_navigation(0, &frames, BluefinChecksum::None, &mut body).unwrap_err();
    assert_eq!(
        (error.to_string().as_str(), body.len()),
        (
            "frames: 26 of 128 bytes each do not fit, there is room for 3200 bytes",
            0
        )
    );
}

#[test]
fn frames_of_vehicle_data_that_lie_about_their_size_are_errors_or_kept_whole() {
    let mut body = Vec::new();
    let frames = [(Time7k::NONE, NavigationFrame::default()); 2];
    BluefinRecord::compose_navigation(0, &frames, BluefinChecksum::None, &mut body).unwrap();
    let read = |at: usize, value: u32| {
        let mut body = body.clone();
        body[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let record = framed(3100, &body);
        let frame = frame(&record);
        match Record::read(&frame) {
            Ok(Record::Bluefin(record)) => Ok(record
                .frames()
                .map(|frame| matches!(frame.data, BluefinData::Other(_)))
                .collect::<Vec<_>>()),
            Ok(_) => unreachable!(),
            Err(error) => Err(error.to_string()),
        }
    };
    assert_eq!(
        read(4, 3).unwrap_err(),
        "record 3100 at byte 4 of its body: frames: 3 of 128 bytes each do not fit, there is room for 256 bytes"
    );
    assert!(read(4, u32::MAX).is_err() && read(8, u32::MAX).is_err() && read(8, 31).is_err() && read(8, 0).is_err());
    // Data size of the first frame, and its offset.
    assert_eq!(read(32 + 12, 95), Ok(vec![true, false]));
    assert_eq!(read(32 + 4, 0xFFFF_0001), Ok(vec![true, false]));
    assert_eq!(read(4, 0), Ok(vec![]));
}

#[test]
fn commands_acknowledgements_and_messages_are_read() {
    let order = Order::Do(Command::Subscribe {
        sensor: SensorIndex(0),
        record_type: 3000,
    });
    let mut text = String::new();
    order.write(&mut text).unwrap();
    for closing in [&b""[..], b"\0"] {
        let mut body = Vec::new();
        let bytes = u32::try_from(text.len() + closing.len()).unwrap();
        CommandHeader {
            sensor: SensorIndex::PLC,
            command: order.command(),
            action: order.action(),
            bytes,
        }
        .write(&mut body);
        body.extend_from_slice(text.as_bytes());
        body.extend_from_slice(closing);
        assert_eq!(body[..8], [0xFF, 0xFF, 0xFF, 0xFF, 7, 0, 0, 0]);
        let record = framed(11_000, &body);
        check_rewrite(&record);
        let frame = frame(&record);
        let Record::Command(command) = Record::read(&frame).unwrap() else {
            panic!()
        };
        let read = Order::read(command.header.command, command.header.action, &command.text()).unwrap();
        assert_eq!((&read, command.header.sensor), (&order, SensorIndex::PLC));
    }
    let mut body = Vec::new();
    Acknowledge {
        command: CommandId::Subscribe,
        sensor: SensorIndex(0),
        status: CommandStatus::Accepted,
    }
    .write(&mut body);
    body.push(9);
    check_rewrite(&framed(11_001, &body));
    body.clear();
    MessageHeader {
        message: MessageType::Alarm,
        mode: AlarmMode::Unspecified,
        id: 3,
        bytes: 9,
    }
    .write(&mut body);
    body.extend_from_slice(b"0, 200, -1");
    let record = framed(11_002, &body);
    check_rewrite(&record);
    let frame = frame(&record);
    let Record::Message(message) = Record::read(&frame).unwrap() else {
        panic!()
    };
    assert_eq!((message.text().as_ref(), message.header.mode.code()), ("0, 200, -", -1));
}

#[test]
fn a_text_longer_than_its_record_is_an_error() {
    let mut body = Vec::new();
    CommandHeader {
        sensor: SensorIndex::PLC,
        command: CommandId::Path,
        action: Action::Set,
        bytes: 5,
    }
    .write(&mut body);
    body.extend_from_slice(b"D:\\s");
    let error = Record::read(&frame(&framed(11_000, &body))).unwrap_err();
    assert_eq!(
        error.to_string(),
        "record 11000 at byte 12 of its body: text: 5 of 1 bytes each do not fit, there is room for 4 bytes"
    );
}

#[test]
fn a_record_of_another_type_passes_byte_for_byte() {
    let record = framed(7028, b"whatever it is");
    check_rewrite(&record);
    assert_eq!(Record::read(&frame(&record)).unwrap(), Record::Other(b"whatever it is"));
}

#[test]
fn every_type_cut_at_every_byte_is_an_error_or_a_shorter_record() {
    let imagery = sidescan(HeaderLayout::Padded, 5);
    let mut navigation = Vec::new();
    BluefinRecord::compose_navigation(
        0,
        &[(Time7k::NONE, NavigationFrame::default())],
        BluefinChecksum::None,
        &mut navigation,
    )
    .unwrap();
    let zeros = [0; 400];
    let bodies: [(u32, &[u8]); 9] = [
        (3000, frame(&imagery).body().unwrap()),
        (3001, frame(&imagery).body().unwrap()),
        (3100, &navigation),
        (7200, &zeros),
        (7300, &zeros),
        (7400, &zeros),
        (11_000, &zeros),
        (11_001, &zeros),
        (11_002, &zeros),
    ];
    assert_eq!(
        bodies.map(|(number, _)| number),
        RECORD_TYPES.iter().map(|row| row.number).collect::<Vec<_>>()[..]
    );
    for (record_type, body) in bodies {
        assert!(
            Record::read(&frame(&framed(record_type, body))).is_ok(),
            "{record_type}"
        );
        for end in 0..body.len() {
            let record = framed(record_type, &body[..end]);
            let frame = frame(&record);
            if let Ok(read) = Record::read(&frame) {
                let mut out = Vec::new();
                read.write(&mut out);
                assert_eq!(out, &body[..end], "{record_type} cut at {end}");
            }
        }
    }
}

#[test]
fn vehicle_data_are_checked_before_they_are_passed_on() {
    let time = Time7k::from_utc(Utc::from_unix_nanos(1_700_000_000_250_000_000));
    let quality = NavigationQuality::default()
        .with(NavigationField::Latitude)
        .with(NavigationField::Longitude)
        .with(NavigationField::Depth);
    let good = NavigationFrame {
        quality,
        latitude_rad: -core::f64::consts::FRAC_PI_2,
        longitude_rad: core::f64::consts::PI,
        ..NavigationFrame::default()
    };
    let body = |frames: &[(Time7k, NavigationFrame)]| {
        let mut body = Vec::new();
        BluefinRecord::compose_navigation(9, frames, BluefinChecksum::WholePacket, &mut body).unwrap();
        body
    };
    let check = |body: &[u8]| {
        let record = framed(3100, body);
        let frame = frame(&record);
        let Record::Bluefin(read) = Record::read(&frame).unwrap() else {
            panic!("{frame:?}")
        };
        read.check()
    };
    for frames in [0, 1, 25] {
        assert_eq!(check(&body(&vec![(time, good); frames])), Ok(()));
    }
    let said = |at: usize, bytes: &[u8]| {
        let mut body = body(&[(time, good); 2]);
        body[at..at + bytes.len()].copy_from_slice(bytes);
        check(&body).unwrap_err().to_string()
    };
    // In the record's header, and in that of the second frame.
    assert_eq!(said(12, &[2]), "field data_format: 2 is neither 0 nor 1");
    assert_eq!(said(4, &[1]), "128 bytes follow the last frame");
    let second = 32 + 128;
    assert_eq!(said(12, &[1]), "frame 0 field data_type: 1, expected 2");
    assert_eq!(said(second, &[64]), "frame 1 field packet_size: 64, expected 128");
    assert_eq!(said(second + 6, &[40]), "frame 1 field offset: 40, expected 32");
    assert_eq!(said(second + 8, &[3]), "frame 1 field data_type: 3, expected 1");
    assert_eq!(said(second + 12, &[95]), "frame 1 field data_size: 95, expected 96");
    assert_eq!(said(second + 16, &[0; 10]), "frame 1 field time: this is no time");
    assert_eq!(said(second + 16, &[0xFF; 10]), "frame 1 field time: this is no time");
    let mut many = body(&[(time, good); 13]);
    many.extend_from_within(32..);
    many[4] = 26;
    assert_eq!(check(&many).unwrap_err(), BluefinFault::Frames { frames: 26 });
    let mut odd = body(&[(time, good)]);
    odd[8] = 127;
    assert_eq!(check(&odd).unwrap_err(), BluefinFault::FrameSize { size: 127 });
    // Values that are valid are numbers, and positions are on the earth; the others may be anything.
    let value = |change: fn(&mut NavigationFrame)| {
        let mut frame = good;
        change(&mut frame);
        check(&body(&[(time, frame)]))
    };
    for change in [
        (|frame| frame.latitude_rad = 1.58) as fn(&mut NavigationFrame),
        |frame| frame.latitude_rad = f64::NAN,
        |frame| frame.longitude_rad = -3.15,
        |frame| frame.depth_m = f64::INFINITY,
    ] {
        assert!(matches!(value(change), Err(BluefinFault::Value { frame: 0, .. })));
    }
    assert_eq!(value(|frame| frame.altitude_m = f64::NAN), Ok(()));
    assert_eq!(
        value(|frame| {
            frame.quality = NavigationQuality::default();
            frame.latitude_rad = 5.0;
        }),
        Ok(())
    );
}

#[test]
fn a_command_that_cannot_be_read_still_names_itself() {
    let record = framed(11_000, &[0xFF, 0xFF, 0xFF, 0xFF, 4, 0, 0, 0, 1]);
    assert!(Record::read(&frame(&record)).is_err());
    let addressed = CommandRecord::addressed(&frame(&record));
    assert_eq!(addressed, Some((CommandId::Version, SensorIndex::PLC)));
    let short = framed(11_000, &[0; 7]);
    assert_eq!(CommandRecord::addressed(&frame(&short)), None);
}
