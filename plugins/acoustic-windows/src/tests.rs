use backseat_sdk::{EndKind, Ended, Navigation, Outcome, ReceivedFrame, Refusal};

use super::*;

fn config() -> Config {
    Config {
        ship: 3,
        mode: 1,
        frames: 3,
        frame_bytes: 64,
        report_s: 5.0,
        depth_m: [5.0, 30.0],
        heading_deg: 90.0,
        speed_mps: 1.5,
    }
}

fn plugin() -> AcousticWindows {
    AcousticWindows::new(config()).unwrap()
}

fn input(seconds: u64, events: Vec<Event>) -> StepInput {
    StepInput {
        now_ns: seconds * SECOND_NS,
        control: true,
        navigation: Some(Navigation {
            depth: 10.0,
            ..Navigation::default()
        }),
        events,
        ..StepInput::default()
    }
}

fn ctd() -> Event {
    Event::Ctd(Ctd {
        age_ns: 0,
        conductivity: 40_000.0,
        temperature: 12.35,
        pressure: 200.0,
    })
}

fn window(until_s: u64) -> Event {
    Event::Window(Window {
        until_ns: until_s * SECOND_NS,
        address: 1,
        device: "WHOIPSK".into(),
    })
}

fn outcome(tag: u64, state: Fate) -> Event {
    Event::Outcome(Outcome { tag, state })
}

fn frames(frames: Vec<FrameOutcome>) -> Fate {
    Fate::Ended(Ended {
        frames,
        ..Ended::new(EndKind::Done, "reported")
    })
}

/// A plugin with twelve reports, which are more than one frame holds.
fn with_reports() -> AcousticWindows {
    let mut plugin = plugin();
    for number in 0..12 {
        assert_eq!(plugin.step(&input(5 * number, vec![ctd()])).unwrap(), []);
    }
    plugin
}

fn packet_of(requests: &[Request]) -> &Packet {
    match requests {
        [Request::Packet(packet)] => packet,
        other => panic!("{other:?}"),
    }
}

#[test]
fn reports_wait_for_a_window_and_fill_its_frames() {
    let mut plugin = with_reports();
    assert_eq!(plugin.step(&input(60, vec![])).unwrap(), []);
    let sent = plugin.step(&input(61, vec![window(80)])).unwrap();
    let packet = packet_of(&sent);
    assert_eq!(
        packet.frames.iter().map(Vec::len).collect::<Vec<_>>(),
        [10 * Report::BYTES, 2 * Report::BYTES]
    );
    assert_eq!(packet.frames[0][..6], [0, 1, 0, 100, 4, 211]);
    // The modem has one packet at a time, and none after the window.
    assert_eq!(plugin.step(&input(62, vec![])).unwrap(), []);
    let late = plugin
        .step(&input(81, vec![outcome(1, frames(vec![FrameOutcome::Acked; 2]))]))
        .unwrap();
    assert_eq!(late, []);
    assert_eq!(plugin.state.waiting.len(), 0);
}

#[test]
fn what_is_not_acknowledged_is_sent_again() {
    for (fate, left) in [
        (frames(vec![FrameOutcome::Unacknowledged, FrameOutcome::Acked]), 10),
        (frames(vec![FrameOutcome::Unacknowledged; 2]), 12),
        (Fate::TimedOut, 12),
        (
            Fate::Rejected(Refusal::new(Rule::Window, "no acoustic window is open")),
            12,
        ),
    ] {
        let mut plugin = with_reports();
        plugin.step(&input(61, vec![window(80)])).unwrap();
        plugin.step(&input(90, vec![outcome(1, fate)])).unwrap();
        assert_eq!(plugin.state.waiting.len(), left);
        let again = plugin.step(&input(121, vec![window(140)])).unwrap();
        let first = packet_of(&again).frames[0].len() / Report::BYTES;
        assert_eq!(first, left.min(10));
    }
}

#[test]
fn a_window_has_one_packet_unless_a_frame_was_lost_or_a_whole_one_waits() {
    for (fate, more, again) in [
        (FrameOutcome::Acked, 1, false),
        (FrameOutcome::Unacknowledged, 1, true),
        (FrameOutcome::Acked, 10, true),
    ] {
        let mut plugin = with_reports();
        plugin.step(&input(61, vec![window(600)])).unwrap();
        for number in 0..more {
            plugin.step(&input(65 + 5 * number, vec![ctd()])).unwrap();
        }
        let next = plugin
            .step(&input(130, vec![outcome(1, frames(vec![fate; 2]))]))
            .unwrap();
        assert_eq!(!next.is_empty(), again, "{fate:?}, {more} more");
    }
}

/// The plugin knows its modem's address outside of windows too.
#[test]
fn an_order_may_come_at_any_time() {
    let mut plugin = plugin();
    plugin.step(&input(0, vec![window(20)])).unwrap();
    let refused = Fate::Rejected(Refusal::new(Rule::Window, "no acoustic window is open"));
    plugin.state.sent = Some((7, vec![]));
    plugin.step(&input(25, vec![outcome(7, refused)])).unwrap();
    let order = Event::Packet(ReceivedPacket {
        age_ns: 0,
        source: 3,
        destination: 1,
        mode: Some(1),
        frames: vec![ReceivedFrame {
            good: true,
            data: b"D\x00\xc8".to_vec(),
        }],
    });
    assert_eq!(plugin.step(&input(30, vec![order])).unwrap().len(), 1);
}

#[test]
fn an_order_is_obeyed_only_if_it_is_whole_for_us_and_in_range() {
    let packet = |source, destination, good, data: &[u8]| {
        Event::Packet(ReceivedPacket {
            age_ns: 0,
            source,
            destination,
            mode: Some(1),
            frames: vec![ReceivedFrame {
                good,
                data: data.to_vec(),
            }],
        })
    };
    let depth = |event: Event| {
        let mut plugin = plugin();
        plugin.step(&input(0, vec![window(20)])).unwrap();
        match plugin.step(&input(1, vec![event])).unwrap().as_slice() {
            [Request::Modify(modify)] => Some(modify.vertical),
            other => {
                assert_eq!(other, []);
                None
            }
        }
    };
    assert_eq!(depth(packet(3, 1, true, b"D\x00\xc8")), Some(Vertical::Depth(20.0)));
    assert_eq!(depth(packet(3, 1, false, b"D\x00\xc8")), None);
    assert_eq!(depth(packet(3, 2, true, b"D\x00\xc8")), None);
    assert_eq!(depth(packet(4, 1, true, b"D\x00\xc8")), None);
    assert_eq!(depth(packet(3, 1, true, b"D\x01\xc8")), None);
    assert_eq!(depth(packet(3, 1, true, b"DIVE!")), None);
}

#[test]
fn a_refused_depth_is_given_up() {
    let mut plugin = plugin();
    plugin.state.ordered_m = Some(20.0);
    assert_eq!(plugin.step(&input(1, vec![])).unwrap().len(), 1);
    let refused = |rule| Fate::Rejected(Refusal::new(rule, "refused"));
    // What passes by itself is tried again.
    let steering = plugin.state.steering;
    let again = plugin
        .step(&input(4, vec![outcome(steering, refused(Rule::Navigation))]))
        .unwrap();
    assert_eq!(again.len(), 1);
    let steering = plugin.state.steering;
    let never = plugin
        .step(&input(8, vec![outcome(steering, refused(Rule::Depth))]))
        .unwrap();
    assert_eq!(never, []);
}

#[test]
fn the_oldest_reports_are_dropped_when_too_many_wait() {
    let mut plugin = plugin();
    for number in 0..300 {
        plugin.step(&input(5 * number, vec![ctd()])).unwrap();
    }
    assert_eq!((plugin.state.waiting.len(), plugin.state.dropped), (WAITING_MAX, 44));
    assert_eq!(plugin.state.waiting[0].number, 45);
}

#[test]
fn a_new_instance_sends_again_what_was_under_way() {
    let mut first = with_reports();
    first.step(&input(61, vec![window(80)])).unwrap();
    let mut second = plugin();
    second.restore(&first.snapshot()).unwrap();
    assert_eq!(second.state, first.state);
    let restored = Event::Restored(backseat_sdk::Restored {
        lost_steps: 1,
        open: vec![1],
    });
    let again = second.step(&input(62, vec![restored, window(80)])).unwrap();
    assert_eq!(packet_of(&again).frames.len(), 2);
    assert!(packet_of(&again).tag > 1);
    assert!(second.restore(&[255; 3]).is_err());
}

#[test]
fn invalid_settings_are_refused() {
    let refused = |config| AcousticWindows::new(config).unwrap_err();
    assert!(refused(Config { frames: 9, ..config() }).starts_with("frames"));
    assert!(
        refused(Config {
            frame_bytes: 5,
            ..config()
        })
        .starts_with("frame_bytes")
    );
    assert!(
        refused(Config {
            depth_m: [30.0, 5.0],
            ..config()
        })
        .starts_with("depth_m")
    );
}
