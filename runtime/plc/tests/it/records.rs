//! The records of the sonars, byte for byte where the specification says so.

use backseat_s7k::plc::{Command, Generic};
use backseat_s7k::record::{
    ChannelSide, Correlated, EdgeTechFormat, HeaderLayout, Polarity, Record, SampleFormat, TriggerSource,
};
use backseat_s7k::{NetworkHeader, SensorIndex};

use crate::rig::{A, LOW, Rig, SUB_BOTTOM, enclosed, frame, navigation_record};

/// A record of a sonar, with the vehicle's navigation known before.
fn record(table: &str, sensor: SensorIndex, record_type: u32) -> Vec<u8> {
    let mut rig = Rig::ready(table);
    rig.push(A, &enclosed(&navigation_record()));
    rig.tell(A, Command::Subscribe { sensor, record_type });
    for command in [
        Generic::RxGain { gain: 7 },
        Generic::TxPower { percent: 62.0 },
        Generic::Ping { on: true },
    ] {
        rig.generic(A, sensor, &command);
    }
    rig.bytes.clear();
    rig.run(1.0);
    rig.records[&A][1].clone()
}

#[test]
fn a_sidescan_record_has_both_sides_and_edgetechs_headers() {
    let bytes = record("", LOW, 3000);
    let record = frame(&bytes);
    let header = record.header();
    assert_eq!(
        (header.version, header.device.0, header.record_count, header.optional_id),
        (4, 11_001, 1, 1)
    );
    let Ok(Record::SideScan(imagery)) = Record::read(&record) else {
        panic!()
    };
    assert_eq!(imagery.layout(), HeaderLayout::Spec);
    assert_eq!((imagery.header.ping, imagery.header.channels), (2, 2));
    assert_eq!(imagery.header.data_format, SampleFormat::Envelope);
    // 200 m of way at 1500 m/s, every 40 us.
    let samples = 3334;
    assert_eq!(imagery.header.channel_bytes as usize, 2 * (64 + 2 * samples) + 2 * 80);
    let channels: Vec<_> = imagery.channels().collect();
    for (channel, (side, name)) in channels
        .iter()
        .zip([(ChannelSide::Port, "port"), (ChannelSide::Starboard, "starboard")])
    {
        let header = channel.header;
        assert_eq!(
            (header.side, &*header.name.text(), header.samples as usize),
            (side, name, samples)
        );
        assert_eq!((header.bytes_per_sample, header.polarity), (2, Polarity::Unipolar));
        assert_eq!((header.start_us, header.sample_interval_us), (0, 40));
        assert_eq!((header.range_m, header.full_scale_v), (100.0, -1.0));
        assert!(header.faults().is_empty());
    }
    // What the sonar gave too much is cut, and what it gave too little is zero.
    let mut port = Vec::new();
    imagery.samples(&channels[0]).amplitudes(&mut port);
    assert_eq!(
        (port.len(), port[999], port[1000], port[3333]),
        (samples, 999.0, 0.0, 333.0)
    );
    let mut starboard = Vec::new();
    imagery.samples(&channels[1]).amplitudes(&mut starboard);
    assert_eq!((starboard[0], starboard[1]), (2.0, 0.0));
    let headers: Vec<_> = imagery.side_scan_headers().collect();
    assert_eq!(headers.len(), 2);
    for (number, header) in (0..).zip(&headers) {
        assert_eq!(
            (header.subsystem, header.channel, header.ping, header.packet),
            (20, number, 2, 1)
        );
        assert_eq!((header.samples, header.sample_interval_ns), (3334, 40_000));
        assert_eq!(
            (header.weighting_factor, header.adc_gain, header.range_dm),
            (12, 7, 1000)
        );
        assert_eq!(
            (header.trigger, header.data_format),
            (TriggerSource::Internal, EdgeTechFormat::Envelope)
        );
        // 14:00:05.150, day 327.
        assert_eq!(
            (header.year, header.day, header.hour, header.minute, header.second),
            (2026, 327, 14, 0, 5)
        );
        assert_eq!(header.day_ms, 14 * 3_600_000 + 5_150);
        assert_eq!((header.heading_arcmin, header.yaw_arcmin), (5400, 5400));
        // -0.1 rad and 0.2 rad.
        assert_eq!(
            (header.pitch_arcmin, header.roll_arcmin, header.depth_cm),
            (-343, 687, 1234)
        );
        assert!(header.faults().is_empty());
    }
    assert_eq!((headers[0].adc_max, headers[1].adc_max), (999, 2));
}

#[test]
fn a_sub_bottom_record_is_complex_with_a_segy_header() {
    let bytes = record("", SUB_BOTTOM, 3001);
    let record = frame(&bytes);
    assert_eq!((record.header().device.0, record.header().optional_id), (11_000, 2));
    let Ok(Record::SubBottom(imagery)) = Record::read(&record) else {
        panic!()
    };
    assert_eq!(
        (imagery.header.channels, imagery.header.data_format),
        (1, SampleFormat::Complex)
    );
    let channel = imagery.channels().next().expect("a channel");
    assert_eq!(
        (channel.header.bytes_per_sample, channel.header.polarity),
        (4, Polarity::Bipolar)
    );
    let samples: Vec<[i16; 2]> = imagery.samples(&channel).complex().collect();
    assert_eq!((samples.len(), samples[0], samples[199]), (2501, [0, -2], [99, -2]));
    let header = imagery.segy_headers().next().expect("a header");
    assert!(header.faults().is_empty(), "{:?}", header.faults());
    assert_eq!(
        (header.ping, header.samples, header.sample_interval_ns),
        (2, 2501, 40_000)
    );
    assert_eq!(
        (header.pulse_power_percent, header.adc_gain, header.adc_max),
        (62, 7, 99)
    );
    assert_eq!(
        (header.start_frequency_dahz, header.end_frequency_dahz, header.sweep_ms),
        (400, 2400, 10)
    );
    assert_eq!((header.alias_frequency, header.correlated), (12_500, Correlated::Yes));
    assert_eq!((header.source_x, header.source_y), (-252_000, 151_200));
    assert_eq!((header.group_x, header.group_y), (-42_000_000, 25_200_000));
    assert_eq!((header.heading_cdeg, header.pitch, header.roll), (9000, -573, 1146));
}

#[test]
fn without_navigation_the_headers_have_zeros() {
    let mut rig = Rig::ready("");
    rig.tell(
        A,
        Command::Subscribe {
            sensor: LOW,
            record_type: 3000,
        },
    );
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(1.0);
    let Ok(Record::SideScan(imagery)) = Record::read(&frame(&rig.records[&A][0])) else {
        panic!()
    };
    let header = imagery.side_scan_headers().next().expect("a header");
    assert_eq!((header.heading_arcmin, header.depth_cm), (0, 0));
}

#[test]
fn the_padded_layout_has_twelve_bytes_more() {
    let bytes = record("header_layout = \"padded\"", LOW, 3000);
    let Ok(Record::SideScan(imagery)) = Record::read(&frame(&bytes)) else {
        panic!()
    };
    assert_eq!(
        (imagery.layout(), imagery.channels().count()),
        (HeaderLayout::Padded, 2)
    );
    assert_eq!(bytes.len(), record("", LOW, 3000).len() + 12);
}

#[test]
fn version_5_is_in_both_frames() {
    let mut rig = Rig::ready("protocol_version = 5");
    rig.bytes.clear();
    rig.tell(A, Command::Version {});
    let header = NetworkHeader::check(&rig.bytes, 1 << 20).expect("a network frame");
    assert_eq!(header.version, 5);
    let record = frame(&rig.bytes[36..]);
    assert_eq!((record.header().version, record.header().record_version), (5, 1));
    assert_eq!(rig.take(A).len(), 2);
}

#[test]
fn packets_are_no_longer_than_configured() {
    let mut rig = Rig::ready("packet_size_bytes = 1500");
    rig.tell(
        A,
        Command::Subscribe {
            sensor: LOW,
            record_type: 3000,
        },
    );
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.take(A);
    rig.bytes.clear();
    rig.run(1.0);
    assert!(rig.take(A).len() >= 6 && rig.skipped_bytes == 0);
    let mut rest = &rig.bytes[..];
    let mut transmissions = Vec::new();
    while !rest.is_empty() {
        let header = NetworkHeader::check(rest, 1 << 20).expect("a network frame");
        assert!(header.packet_size <= 1500 && header.source_device.0 == 11_001);
        assert_eq!(header.total_packets, 10, "13,692 bytes in parts of 1464");
        transmissions.push(header.transmission);
        rest = &rest[header.packet_size as usize..];
    }
    transmissions.dedup();
    assert!(transmissions.windows(2).all(|pair| pair[1] == pair[0] + 1));
}

#[test]
fn the_speed_of_sound_that_a_client_sends_is_used() {
    use backseat_s7k::record::{BluefinRecord, EnvironmentField, EnvironmentFrame, EnvironmentQuality};
    use backseat_s7k::{BluefinChecksum, DeviceId, FRAME_LIMIT, FrameHeader, FrameWriter, Reserved, Time7k};

    let mut rig = Rig::ready("");
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(1.0);
    for (speed, checksum) in [(1480.0, BluefinChecksum::WholePacket), (9.0, BluefinChecksum::DataOnly)] {
        let environment = EnvironmentFrame {
            quality: EnvironmentQuality::default().with(EnvironmentField::SoundSpeed),
            sound_speed_mps: speed,
            reserved: Reserved::default(),
        };
        let mut out = Vec::new();
        let mut writer = FrameWriter::begin(FrameHeader::new(3100, DeviceId::BLUEFIN), &mut out);
        let frames = [(Time7k::from_utc(crate::rig::START), environment)];
        BluefinRecord::compose_environment(0, &frames, checksum, writer.bytes()).expect("one frame");
        writer.finish(FRAME_LIMIT).expect("a short record");
        rig.push(A, &enclosed(&out));
    }
    rig.run(1.0);
    let speeds: Vec<f64> = rig.sonar.pings.iter().map(|(_, ping)| ping.sound_speed_mps).collect();
    assert_eq!((speeds[0], speeds.last()), (1500.0, Some(&1480.0)));
    assert_eq!(rig.plc.wrong_bluefin_checksums(), 1);
}

#[test]
fn a_ping_is_where_the_vehicle_is_when_it_leaves() {
    let mut rig = Rig::ready("");
    rig.pose();
    let posed_at = rig.now;
    rig.generic(A, LOW, &Generic::Ping { on: true });
    rig.run(0.9);
    assert!(rig.sonar.pings.len() >= 5);
    for (_, ping) in &rig.sonar.pings {
        let expected = 1.5 * ping.time.since(posed_at).as_secs_f64();
        assert!((ping.pose.at.north_m - expected).abs() < 1e-9 && ping.pose.depth_m == 12.0);
    }
}

#[test]
fn there_is_no_ping_before_the_first_pose() {
    let mut rig = Rig::new("auto_start = true");
    rig.run(20.0);
    assert_eq!(rig.sonar.pings.len(), 0);
    rig.pose();
    rig.run(1.0);
    assert!(rig.sonar.pings.len() > 10);
}

#[test]
fn a_driver_learns_what_clients_say_of_the_vehicle() {
    let mut rig = Rig::ready("");
    assert_eq!(rig.plc.reported(), None);
    rig.run(1.5);
    rig.push(A, &enclosed(&navigation_record()));
    let reported = rig.plc.reported().unwrap();
    assert_eq!(reported.received, rig.now);
    let position = reported.position.unwrap();
    assert!((position.latitude.as_deg() - 42.0).abs() < 1e-9 && (position.longitude.as_deg() + 70.0).abs() < 1e-9);
    assert_eq!(reported.depth_m, Some(12.34));
    for (value, expected) in [
        (reported.heading_deg, 90.0),
        (reported.pitch_deg, (-0.1_f64).to_degrees()),
        (reported.roll_deg, 0.2_f64.to_degrees()),
        (reported.north_mps, 0.0),
        (reported.east_mps, 0.0),
        (reported.down_mps, 0.0),
    ] {
        assert!((value.unwrap() - expected).abs() < 1e-5, "{reported:?}");
    }
}
