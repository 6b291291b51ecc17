//! Pings for plugins, and the achieved swath.

use std::time::Duration;

use backseat_s7k::record::{
    Channel, ChannelHeader, ChannelSide, HeaderLayout, Imagery, ImageryHeader, Polarity, RangeKind, SampleFormat,
    SideScanHeader,
};
use backseat_s7k::{Chars, DeviceId, FrameHeader, FrameWriter, Reserved, Time7k};
use backseat_sonar::{
    AltitudeSource, CHANNELS_MAX, ChecksumPolicy, Decimation, Event, ExpectedLayout, Input, PingGrant, PingTime,
    SonarConfig, Swath, VehicleSoundSpeed,
};

use crate::controller::{enclosed, record};
use crate::trial::{START, Trial, config, navigation, utc};

/// A sidescan ping with two channels of 16 bits.
pub(crate) struct Ping {
    pub(crate) number: u32,
    pub(crate) time: Time7k,
    pub(crate) device: u32,
    pub(crate) record_type: u32,
    pub(crate) layout: HeaderLayout,
    pub(crate) range_m: f32,
    pub(crate) range_kind: RangeKind,
    pub(crate) channels: Vec<Vec<u16>>,
    pub(crate) bytes_per_sample: u8,
    pub(crate) weighting: Option<i16>,
}

impl Default for Ping {
    fn default() -> Self {
        Self {
            number: 1,
            time: Time7k::NONE,
            device: 11_001,
            record_type: 3000,
            layout: HeaderLayout::Spec,
            range_m: 100.0,
            range_kind: RangeKind::Slant,
            channels: vec![seabed(1000, 300), seabed(1000, 320)],
            bytes_per_sample: 2,
            weighting: None,
        }
    }
}

/// Samples of a side whose seabed begins at one of them: the transmission, water, seabed.
pub(crate) fn seabed(samples: u16, bottom: u16) -> Vec<u16> {
    (0..samples)
        .map(|index| match index {
            0..10 => 20_000,
            _ if index < bottom => 50,
            _ => 4000 + index % 7,
        })
        .collect()
}

impl Ping {
    pub(crate) fn record(&self) -> Vec<u8> {
        let samples: Vec<Vec<u8>> = self
            .channels
            .iter()
            .map(|channel| channel.iter().flat_map(|sample| sample.to_le_bytes()).collect())
            .collect();
        let channels: Vec<Channel<'_>> = (0..)
            .zip(&samples)
            .map(|(number, bytes)| Channel {
                header: ChannelHeader {
                    number,
                    side: ChannelSide::from(number),
                    range_kind: self.range_kind,
                    polarity: Polarity::Unipolar,
                    bytes_per_sample: self.bytes_per_sample,
                    reserved_1: Reserved::default(),
                    samples: u32::try_from(bytes.len()).unwrap() / u32::from(self.bytes_per_sample),
                    start_us: 0,
                    sample_interval_us: 133,
                    range_m: self.range_m,
                    full_scale_v: -1.0,
                    name: Chars::default(),
                    reserved_2: Reserved::default(),
                },
                bytes,
            })
            .collect();
        let header = ImageryHeader {
            time_ms: 0,
            ping: self.number,
            channels: 0,
            channel_bytes: 0,
            data_format: SampleFormat::Envelope,
        };
        let frame = FrameHeader::new(self.record_type, DeviceId(self.device)).at(self.time);
        let mut out = Vec::new();
        let mut writer = FrameWriter::begin(frame, &mut out);
        Imagery::compose(header, self.layout, &channels, 0, writer.bytes()).unwrap();
        if let Some(weighting) = self.weighting {
            writer.begin_optional(SideScanHeader::OPTIONAL_ID);
            for _ in &self.channels {
                let mut header = [0; SideScanHeader::SIZE];
                header[24..26].copy_from_slice(&weighting.to_le_bytes());
                writer.bytes().extend_from_slice(&header);
            }
        }
        writer.finish(64 << 20).unwrap();
        out
    }
}

pub(crate) fn grant(samples: u16, decimation: Decimation) -> PingGrant {
    PingGrant {
        sensor: 0,
        samples,
        decimation,
    }
}

fn ready(grants: Vec<PingGrant>) -> Trial {
    Trial::with(config(), grants).until_ready()
}

fn send(trial: &mut Trial, ping: &Ping) {
    trial.send(enclosed(&ping.record()));
    trial.run_s(0.1);
}

fn swaths(trial: &Trial) -> Vec<Swath> {
    let swath = |event: &Event| match event {
        Event::Swath(swath) => Some(*swath),
        _ => None,
    };
    trial.events.iter().filter_map(|(_, event)| swath(event)).collect()
}

#[test]
fn imagery_that_nobody_wants_is_named_once_with_what_was_expected() {
    let mut trial = Trial::ready();
    for device in [11_002, 11_002, 11_003] {
        let ping = Ping {
            device,
            ..Ping::default()
        };
        send(&mut trial, &ping);
    }
    let told = trial.log();
    let told = told.iter().filter(|line| line.contains("not used: records"));
    assert_eq!(
        told.collect::<Vec<_>>(),
        ["not used: records 3000 of device 11002; expected 3000 of device 11001, 3001 of device 11000"]
    );
}

#[test]
fn each_grant_gets_the_ping_at_its_own_resolution() {
    let mut trial = ready(vec![grant(10, Decimation::Maximum), grant(4, Decimation::Mean)]);
    let mut ping = Ping {
        number: 42,
        weighting: Some(3),
        ..Ping::default()
    };
    ping.channels = vec![(0..20).collect(), (100..112).collect()];
    send(&mut trial, &ping);

    let [fine, coarse] = &trial.pings[..] else {
        panic!("{:?}", trial.pings)
    };
    assert_eq!(
        (fine.grant, fine.ping, fine.sensor.0, fine.device.0),
        (0, 42, 0, 11_001)
    );
    assert_eq!((fine.sub_bottom, fine.decimation), (false, Decimation::Maximum));
    let [port, starboard] = &fine.channels[..] else {
        panic!("{fine:?}")
    };
    assert_eq!(port.side, ChannelSide::Port);
    assert_eq!(port.samples, [1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0, 17.0, 19.0]);
    assert_eq!((port.recorded, port.bin_us, port.range_m), (20, 266.0, 100.0));
    assert_eq!(port.volts_per_step, Some(0.125));
    assert_eq!((starboard.side, starboard.recorded), (ChannelSide::Starboard, 12));
    assert_eq!(coarse.channels[1].samples, [101.0, 104.0, 107.0, 110.0]);
    assert_eq!((coarse.grant, coarse.decimation), (1, Decimation::Mean));
}

#[test]
fn both_layouts_are_read_and_the_other_one_is_counted() {
    let settings = SonarConfig {
        header_layout: ExpectedLayout::Spec,
        ..config()
    };
    let mut trial = Trial::with(settings, vec![grant(8, Decimation::Maximum)]).until_ready();
    for layout in [HeaderLayout::Spec, HeaderLayout::Padded] {
        let ping = Ping {
            layout,
            ..Ping::default()
        };
        send(&mut trial, &ping);
    }
    assert_eq!(trial.pings.len(), 2);
    assert_eq!(trial.sonar.counts().other_layouts, 1);
}

#[test]
fn sub_bottom_profiles_are_told_apart() {
    let mut trial = ready(vec![PingGrant {
        sensor: 1,
        samples: 8,
        decimation: Decimation::Maximum,
    }]);
    let ping = Ping {
        device: 11_000,
        record_type: 3001,
        channels: vec![seabed(500, 200)],
        ..Ping::default()
    };
    send(&mut trial, &ping);
    assert!(trial.pings[0].sub_bottom && trial.pings[0].sensor.0 == 1);
    assert!(swaths(&trial).is_empty(), "a profile has no swath");
}

#[test]
fn what_is_not_subscribed_to_is_counted_and_dropped() {
    let mut trial = ready(vec![grant(8, Decimation::Maximum)]);
    for (device, record_type) in [(11_002, 3000), (11_001, 3001), (11_000, 3000)] {
        let ping = Ping {
            device,
            record_type,
            ..Ping::default()
        };
        send(&mut trial, &ping);
    }
    trial.send(enclosed(&record(FrameHeader::new(7000, DeviceId(7001)), &[1; 100])));
    trial.run_s(11.0);
    assert!(trial.pings.is_empty());
    assert_eq!(trial.sonar.counts().unsubscribed, 4);
    assert!(trial.has("not used: 4 unsubscribed"));
}

#[test]
fn channels_that_cannot_be_read_are_counted() {
    let mut trial = ready(vec![grant(8, Decimation::Maximum)]);
    let ping = Ping {
        channels: vec![vec![1; 12]; 6],
        ..Ping::default()
    };
    send(&mut trial, &ping);
    assert_eq!(trial.pings[0].channels.len(), CHANNELS_MAX);
    assert_eq!(trial.sonar.counts().unread_channels, 2);
    let ping = Ping {
        bytes_per_sample: 3,
        channels: vec![vec![1; 12]; 2],
        ..Ping::default()
    };
    send(&mut trial, &ping);
    assert_eq!(trial.pings.len(), 1);
    assert_eq!(trial.sonar.counts().unread_channels, 4);
}

#[test]
fn a_wrong_checksum_is_counted_and_the_setting_says_what_else() {
    for (policy, pings, wrong) in [
        (ChecksumPolicy::Count, 1, 1),
        (ChecksumPolicy::Refuse, 0, 1),
        (ChecksumPolicy::Ignore, 1, 0),
    ] {
        let settings = SonarConfig {
            checksum: policy,
            ..config()
        };
        let mut trial = Trial::with(settings, vec![grant(8, Decimation::Maximum)]).until_ready();
        let mut record = Ping::default().record();
        record[500] ^= 1;
        trial.send(enclosed(&record));
        trial.run_s(0.1);
        assert_eq!(
            (trial.pings.len(), trial.sonar.counts().wrong_checksums),
            (pings, wrong)
        );
    }
}

#[test]
fn a_ping_has_our_time_and_the_navigation_before_it() {
    let settings = SonarConfig {
        time_sync: false,
        ..config()
    };
    let mut trial = Trial::with(settings, vec![grant(8, Decimation::Maximum)]);
    trial.controller.offset_nanos = 3_600_000_000_000;
    let mut trial = trial.until_ready();
    let begin = trial.now;
    for _ in 0..20 {
        let sample = navigation(trial.now);
        trial.handle(Input::Navigation(sample));
        trial.run_s(0.1);
    }
    // A ping of 0.55 s after the begin, an hour ahead by the controller's clock, arrives late.
    let at = utc(begin) + Duration::from_millis(550);
    let time = trial.controller.time(at);
    let ping = |time| Ping {
        time,
        ..Ping::default()
    };
    send(&mut trial, &ping(time));
    send(&mut trial, &ping(Time7k::NONE));
    let [measured, arrival] = &trial.pings[..] else {
        panic!("{:?}", trial.pings)
    };
    assert_eq!(measured.time_source, PingTime::Measured);
    assert!(measured.time.as_unix_nanos().abs_diff(at.as_unix_nanos()) < 100_000);
    let known = measured.navigation.unwrap().solution;
    assert_eq!(known, utc(begin) + Duration::from_millis(500));
    assert_eq!(arrival.time_source, PingTime::Arrival);
    assert_eq!(arrival.time, utc(arrival.arrived));
    assert_eq!(
        arrival.navigation.unwrap().solution,
        utc(begin) + Duration::from_millis(1900)
    );
    // Before everything that is known.
    let time = trial.controller.time(START);
    send(&mut trial, &ping(time));
    assert_eq!(trial.pings[2].navigation, None);
}

#[test]
fn without_a_measured_clock_the_controllers_time_is_taken_as_it_is() {
    let settings = SonarConfig {
        time_sync: false,
        ..config()
    };
    let mut trial = Trial::with(settings, vec![grant(8, Decimation::Maximum)]);
    trial.controller.always.insert(11, crate::controller::Answer::Nothing);
    trial.run_s(0.1);
    let time = Time7k::from_utc(START);
    send(
        &mut trial,
        &Ping {
            time,
            ..Ping::default()
        },
    );
    assert_eq!(
        (trial.pings[0].time_source, trial.pings[0].time),
        (PingTime::Controller, START)
    );
}

#[test]
fn the_swath_comes_from_bottom_lock_and_range() {
    let mut trial = ready(Vec::new());
    let sample = navigation(trial.now);
    trial.handle(Input::Navigation(sample));
    send(&mut trial, &Ping::default());
    let swath = swaths(&trial)[0];
    let reach_m = (100.0_f64 * 100.0 - 45.3 * 45.3).sqrt();
    assert_eq!((swath.port_m, swath.starboard_m), (reach_m, reach_m));
    assert_eq!(
        (swath.altitude_m, swath.source),
        (Some(45.3), AltitudeSource::BottomLock)
    );
    // Above its range, the sonar sees nothing of the seabed.
    trial.run_s(1.0);
    let sample = navigation(trial.now);
    trial.handle(Input::Navigation(sample));
    send(
        &mut trial,
        &Ping {
            range_m: 40.0,
            ..Ping::default()
        },
    );
    assert_eq!((swaths(&trial)[1].port_m, swaths(&trial)[1].starboard_m), (0.0, 0.0));
}

#[test]
fn without_bottom_lock_the_first_return_tells_the_altitude() {
    let mut trial = ready(Vec::new());
    // Port begins at 30 m, starboard at 32 m; the resolution is 100 m / 256.
    send(&mut trial, &Ping::default());
    let swath = swaths(&trial)[0];
    assert_eq!(swath.source, AltitudeSource::FirstReturn);
    let altitude_m = swath.altitude_m.unwrap();
    assert!((altitude_m - 30.0).abs() < 0.4, "{altitude_m}");
    assert!((swath.port_m - 95.4).abs() < 0.2, "{swath:?}");

    // One strong sample in the water is no seabed.
    trial.run_s(1.0);
    let mut ping = Ping::default();
    ping.channels[0][150] = 9000;
    send(&mut trial, &ping);
    assert!((swaths(&trial)[1].altitude_m.unwrap() - 30.0).abs() < 0.4);

    // Water alone, and nothing at all.
    trial.run_s(1.0);
    let ping = Ping {
        channels: vec![vec![0; 1000], vec![0; 1000]],
        ..Ping::default()
    };
    send(&mut trial, &ping);
    let ping = Ping {
        channels: vec![Vec::new(), Vec::new()],
        ..Ping::default()
    };
    send(&mut trial, &ping);
    assert_eq!(swaths(&trial).len(), 2);
}

#[test]
fn ground_range_is_the_swath() {
    let mut trial = ready(Vec::new());
    let ping = Ping {
        range_kind: RangeKind::Ground,
        ..Ping::default()
    };
    send(&mut trial, &ping);
    let swath = swaths(&trial)[0];
    assert_eq!(
        (swath.port_m, swath.starboard_m, swath.altitude_m),
        (100.0, 100.0, None)
    );
    assert_eq!(swath.source, AltitudeSource::GroundRange);
}

#[test]
fn a_missing_range_follows_from_the_travel_time_of_sound() {
    let mut trial = ready(vec![grant(8, Decimation::Maximum)]);
    for range_m in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let ping = Ping {
            range_m,
            ..Ping::default()
        };
        send(&mut trial, &ping);
        assert_eq!(trial.pings.pop().unwrap().channels[0].range_m, 1000.0 * 133e-6 * 750.0);
    }
    let time = utc(trial.now);
    trial.handle(Input::SoundSpeed(VehicleSoundSpeed {
        time,
        sound_speed_mps: 1450.0,
    }));
    let ping = Ping {
        range_m: 0.0,
        ..Ping::default()
    };
    send(&mut trial, &ping);
    assert_eq!(trial.pings[0].channels[0].range_m, 1000.0 * 133e-6 * 725.0);
}

#[test]
fn the_swath_is_reported_once_a_second() {
    let mut trial = ready(Vec::new());
    for number in 0..50 {
        let ping = Ping {
            number,
            ..Ping::default()
        };
        send(&mut trial, &ping);
    }
    assert!((4..=6).contains(&swaths(&trial).len()), "{}", swaths(&trial).len());
}

#[test]
fn after_a_clock_was_set_its_old_offset_does_not_count() {
    let ping = |trial: &mut Trial| {
        let time = trial.controller.time(utc(trial.now));
        send(
            trial,
            &Ping {
                time,
                ..Ping::default()
            },
        );
        trial.pings.pop().unwrap().time_source
    };
    // The controller is an hour wrong until the client sets its clock; the next acknowledgement takes a while.
    let mut trial = Trial::with(config(), vec![grant(8, Decimation::Maximum)]);
    trial.controller.offset_nanos = 3_600_000_000_000;
    trial
        .controller
        .always
        .insert(28, crate::controller::Answer::After(1000));
    trial.run_s(0.1);
    assert_eq!(ping(&mut trial), PingTime::Controller);
    trial.run_s(3.0);
    assert_eq!(ping(&mut trial), PingTime::Measured);
    // Our own clock is set.
    trial.handle(Input::UtcSet(60_000_000_000));
    assert_eq!(ping(&mut trial), PingTime::Controller);
    trial.run_s(10.0);
    assert_eq!(ping(&mut trial), PingTime::Measured);
}
