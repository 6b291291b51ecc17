use crate::fields::{field, number, of, seconds};
use crate::files::CALM;
use crate::payload::Payload;

/// Windows from 10 s to 30 s of each minute. The vehicle holds still at 10 m until its mission starts.
fn with(acoustic: &str) -> String {
    CALM.replace("[start]", "[start]\ndepth_m = 10")
        .replace("starts_after_s = 1", "starts_after_s = 50000")
        .replace(
            "[spi]",
            &format!("[acoustic]\naddress = 7\nfirst_s = 10\nperiod_s = 60\n{acoustic}\n[spi]"),
        )
}

/// A peer 1500 m east, a second of sound away, at the vehicle's depth.
const PEER: &str = "[[acoustic.peers]]\naddress = 3\neast_m = 1500\nnorth_m = 0\ndepth_m = 10\n";

const TOPICS: &[&str] = &["ACK", "CMA", "CPS", "CPR"];

fn in_window(acoustic: &str, peers: &str) -> Payload {
    let mut payload = Payload::connected(&(with(acoustic) + peers), 1, TOPICS);
    payload.until(12.0);
    payload.heard();
    payload
}

// SPI 9.1: "notifies the payload of a timing window ... The message contains a timestamp signifying the end of the
// timing window." "By default, these status messages are *not* sent."
#[test]
fn windows_are_announced_when_they_begin() {
    let mut payload = Payload::connected(&with(""), 1, &["CMA"]);
    payload.until(9.9);
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.until(200.0);
    assert_eq!(
        payload.heard(),
        [
            "$BFCMA,080010.000,080030.000,7,WHOIPSK",
            "$BFCMA,080110.000,080130.000,7,WHOIPSK",
            "$BFCMA,080210.000,080230.000,7,WHOIPSK",
            "$BFCMA,080310.000,080330.000,7,WHOIPSK"
        ]
    );
    let mut payload = Payload::connected(&with("device = \"Sonardyne6G\"\nlength_s = 5"), 1, &[]);
    payload.until(70.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
    // "Registering to receive these messages will not automatically give the payload communications time windows."
    let mut payload = Payload::connected(CALM, 1, &["CMA"]);
    payload.until(150.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

// 9.4: "The payload can only send messages through the communications devices when provided a window with the $BFCMA.
// Any message sent to the vehicle outside of the provided windows will be ignored."
#[test]
fn a_packet_outside_of_a_window_is_ignored() {
    let mut payload = Payload::connected(&(with("") + PEER), 1, TOPICS);
    for (at_s, time, sent) in [
        (9.9, "080009.900", false),
        (10.0, "080010.000", true),
        (29.9, "080029.900", true),
    ] {
        payload.until(at_s);
        payload.say("$BPCPD,070000.000,41,3,1,0,1,00FF,,,,,,,");
        let heard = of(&payload.heard(), "BFACK");
        let outcome = if sent {
            "2,0,queued"
        } else {
            "1,0,outside of the payload's communication windows"
        };
        assert_eq!(heard, [format!("$BFACK,{time},CPD,070000.000,0,{outcome}")]);
        let ignored = payload
            .log()
            .iter()
            .any(|line| line.ends_with("packet 41 of client 1 ignored: outside a window"));
        assert_eq!(ignored, !sent);
        payload.until(at_s + 5.0_f64.min(30.0 - at_s) - 0.05);
    }
    payload.until(30.0);
    payload.heard();
    payload.say("$BPCPD,070000.000,42,3,1,0,1,00FF,,,,,,,");
    assert!(payload.heard()[0].contains(",1,0,outside of"));
    payload.until(60.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

// 9.2: "The message supplies the number of frames that were sent, followed by the status for each frame. The status for
// each frame will be either unset (if no frame was specified), unacknowledged (if no ack was requested), or acked".
#[test]
fn a_sent_packet_is_reported_with_its_own_identifier() {
    let mut payload = in_window("", PEER);
    payload.say("$BPCPD,070000.000,4711,3,1,0,2,48656C6C6F,00FF,,,,,,");
    payload.until(20.0);
    // The latency is half a second, and each frame takes a second.
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,080012.000,CPD,070000.000,0,2,0,queued",
            "$BFCPS,080014.500,080012.500,4711,2,1,1,0,0,0,0,0,0"
        ]
    );
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("packet 4711 sent to modem 3, heard"))
    );
}

// 9.4: "If the payload desires an ack'd response to the packet being sent, set the flag to 1, and the vehicle will wait
// to send the $BFCPS message until the ack has been received."
#[test]
fn an_acknowledged_packet_is_reported_once_the_acknowledgement_has_arrived() {
    let mut payload = in_window("", PEER);
    payload.say("$BPCPD,070000.000,5,3,1,1,1,0A,,,,,,,");
    payload.until(25.0);
    // The packet is sent by 13.5 s. Then the sound takes two seconds, the peer half a second to turn around, and the
    // acknowledgement one second.
    assert_eq!(payload.heard()[1], "$BFCPS,080017.000,080012.500,5,1,2,0,0,0,0,0,0,0");
    let unacked = |acoustic: &str, peers: &str, interpretation: &str| {
        let text = (with(acoustic) + peers).replace("[spi]", &format!("[interpretation]\n{interpretation}\n[spi]"));
        let mut payload = Payload::connected(&text, 1, TOPICS);
        payload.until(12.0);
        payload.say("$BPCPD,070000.000,5,3,1,1,1,0A,,,,,,,");
        payload.until(29.0);
        of(&payload.heard(), "BFCPS").pop().unwrap()
    };
    // Without an acknowledgement the report comes eight seconds after the packet: there is no peer, one that does not
    // answer, one that hears nothing, one that is too far away.
    let none = "$BFCPS,080021.500,080012.500,5,1,1,0,0,0,0,0,0,0";
    assert_eq!(unacked("", "", ""), none);
    assert_eq!(unacked("", &format!("{PEER}acknowledges = false\n"), ""), none);
    assert_eq!(unacked("loss_chance = 1", PEER, ""), none);
    assert_eq!(unacked("", &PEER.replace("1500", "9000"), ""), none);
    let failed = unacked("", "", "unacked_frames = \"failed\"");
    assert_eq!(failed, "$BFCPS,080021.500,080012.500,5,1,3,0,0,0,0,0,0,0");
}

#[test]
fn a_packet_that_does_not_fit_into_the_window_is_reported_as_not_sent() {
    let mut payload = in_window("", PEER);
    payload.until(28.0);
    // The first packet takes 1.5 s and fits; the second takes 2.5 s and does not.
    payload.say("$BPCPD,070000.000,1,3,1,0,1,0A,,,,,,,");
    payload.say("$BPCPD,070001.000,2,3,1,0,2,0A,0B,,,,,,");
    payload.until(40.0);
    let heard = of(&payload.heard(), "BFCPS");
    assert_eq!(
        heard,
        [
            "$BFCPS,080029.500,080028.500,1,1,1,0,0,0,0,0,0,0",
            "$BFCPS,080029.500,080029.500,2,2,3,3,0,0,0,0,0,0"
        ]
    );
}

// "Anywhere from one to eight frames can be provided to the vehicle if the currently used device supports multiple
// frames as specified through the telemetry mode."
#[test]
fn the_device_and_its_mode_limit_a_packet() {
    let long = "00".repeat(65);
    let eight = "0A,0A,0A,0A,0A,0A,0A,0A";
    for (device, packet, answer) in [
        ("WHOIPSK", "1,3,5,0,8,".to_owned() + eight, "2,0,queued"),
        (
            "WHOIPSK",
            "1,3,1,0,4,0A,0A,0A,0A,,,,".to_owned(),
            "0,0,frames: mode 1 has at most 3",
        ),
        (
            "WHOIPSK",
            format!("1,3,1,0,1,{long},,,,,,,"),
            "0,0,frames: mode 1 has at most 64 bytes a frame",
        ),
        (
            "WHOIPSK",
            "1,3,9,0,1,0A,,,,,,,".to_owned(),
            "0,0,mode 9: WHOIPSK has no such mode",
        ),
        (
            "WHOIPSK",
            "1,3,-1,0,1,0A,,,,,,,".to_owned(),
            "0,0,mode -1: WHOIPSK has no such mode",
        ),
        (
            "WHOIPSK",
            "1,7,0,0,1,0A,,,,,,,".to_owned(),
            "0,0,destination: the vehicle's own modem",
        ),
        ("WHOI", "1,3,0,0,1,0A,,,,,,,".to_owned(), "2,0,queued"),
        (
            "WHOI",
            "1,3,0,0,2,0A,0A,,,,,,".to_owned(),
            "0,0,frames: mode 0 has at most 1",
        ),
        (
            "WHOI",
            "1,3,1,0,1,0A,,,,,,,".to_owned(),
            "0,0,mode 1: WHOI has no such mode",
        ),
        ("Sonardyne6G", format!("1,3,7,0,1,{long},,,,,,,"), "2,0,queued"),
        (
            "Sonardyne6G",
            "1,3,0,0,2,0A,0A,,,,,,".to_owned(),
            "0,0,frames: mode 0 has at most 1",
        ),
    ] {
        let mut payload = in_window(&format!("device = \"{device}\""), PEER);
        payload.say(&format!("$BPCPD,070000.000,{packet}"));
        let expected = format!("$BFACK,080012.000,CPD,070000.000,0,{answer}");
        assert_eq!(payload.heard(), [expected], "{packet}");
    }
    let mut payload = in_window("", "");
    payload.say("$BPCPD,070000.000,1,3,1,0,9,0A");
    assert!(payload.heard()[0].starts_with("$BFACK,080012.000,CPD,070000.000,0,0,0,"));
}

#[test]
fn packets_are_refused_with_their_reason() {
    let send = "$BPCPD,070000.000,1,3,1,0,1,0A,,,,,,,";
    let mut payload = in_window("queue_max = 1", PEER);
    payload.say(send);
    payload.say(send);
    payload.until(12.2);
    payload.say("$BPCPD,070000.000,2,3,1,0,1,0A,,,,,,,");
    payload.say("$BPCPD,070000.000,3,3,1,0,1,0A,,,,,,,");
    let outcomes: Vec<String> = payload.heard().iter().map(|line| line[35..].to_owned()).collect();
    assert_eq!(
        outcomes,
        [
            "2,0,queued",
            "1,0,a packet with this identifier is being sent",
            "2,0,queued",
            "1,0,too many packets are waiting"
        ]
    );
    let mut payload = in_window("equipped = false", PEER);
    payload.say(send);
    assert!(payload.heard()[0].ends_with(",1,0,the payload has no access to an acoustic modem"));
}

// 7.22: "These devices include acoustic modems".
#[test]
fn a_silent_vehicle_sends_nothing() {
    let mut payload = in_window("queue_max = 4", PEER);
    for id in [1, 2] {
        payload.say(&format!("$BPCPD,070000.000,{id},3,1,0,3,0A,0A,0A,,,,,"));
    }
    payload.say("$BPSIL,070001.000,1");
    payload.say("$BPCPD,070002.000,3,3,1,0,1,0A,,,,,,,");
    assert!(payload.heard().last().unwrap().ends_with(",1,0,the vehicle is silent"));
    payload.until(80.0);
    let heard = payload.heard();
    // The packet under way is sent. The waiting one is not, and no other window begins.
    let sent = of(&heard, "BFCPS");
    assert_eq!(sent.len(), 2, "{heard:?}");
    assert!(sent[0].contains(",2,3,3,3,3,0"), "{sent:?}");
    assert!(sent[1].contains(",1,3,1,1,1,0"), "{sent:?}");
    assert!(of(&heard, "BFCMA").is_empty());
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("acoustic window skipped: the vehicle is silent"))
    );
}

// 9.2: "The message will also be sent for every packet that the vehicle has originated."
#[test]
fn the_vehicles_own_packets_are_reported_and_avoid_the_windows() {
    let mut payload = Payload::connected(&with("own_period_s = 15\nown_request_first = 900"), 1, &["CPS"]);
    payload.until(100.0);
    let heard = payload.heard();
    let ids: Vec<&str> = heard.iter().map(|line| field(line, 3)).collect();
    assert_eq!(ids, ["900", "901", "902", "903"], "{heard:?}");
    for line in &heard {
        let at = seconds(line) % 60.0;
        assert!(!(10.0..=30.0).contains(&at), "{line}");
    }
    // "In the event that the modem is not properly functioning, a status message may not be generated".
    let mut payload = Payload::connected(&with("own_period_s = 15\nstatus_lost_chance = 1"), 1, &["CPS"]);
    payload.until(100.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

fn sending(peer: &str, packet: &str) -> String {
    format!("{PEER}{peer}\n[[acoustic.peers.packets]]\n{packet}\n")
}

// 9.3: arrival time, source, destination ("may NOT be this vehicle"), telemetry mode, frames; "The remaining slots for
// frames will be blank for the data, and unset (0) for the status."
#[test]
fn packets_of_another_vehicle_arrive_after_their_travel_time() {
    let packet = "first_s = 20\nperiod_s = 30\nmode = 2\nframes = [\"48656C6C6F\", \"00ff\"]";
    let mut payload = Payload::connected(&(with("") + &sending("", packet)), 1, &["CPR"]);
    payload.until(60.0);
    // The sound takes a second, and the frames take two.
    assert_eq!(
        payload.heard(),
        [
            "$BFCPR,080023.000,080023.000,3,7,2,2,1,48656C6C6F,1,00FF,0,,0,,0,,0,,0,,0,",
            "$BFCPR,080053.000,080053.000,3,7,2,2,1,48656C6C6F,1,00FF,0,,0,,0,,0,,0,,0,"
        ]
    );
    // This packet goes to another vehicle, once, from 750 m: it arrives between two steps of the mock, and has its
    // exact time.
    let packet = "first_s = 20.03\ndestination = 4\nmode = -1\nframes = [\"0A\"]";
    let near = sending("", packet).replace("1500", "750");
    let mut payload = Payload::connected(&(with("") + &near), 1, &["CPR"]);
    payload.until(100.0);
    assert_eq!(
        payload.heard(),
        ["$BFCPR,080021.600,080021.530,3,4,-1,1,1,0A,0,,0,,0,,0,,0,,0,,0,"]
    );
}

#[test]
fn packets_of_a_peer_that_moves_away_arrive_later_and_later() {
    let packet = "first_s = 20\nperiod_s = 100\nframes = [\"0A\"]";
    let text = with("") + &sending("east_mps = 1.5\n", packet);
    let mut payload = Payload::connected(&text, 1, &["CPR"]);
    payload.until(400.0);
    let arrived: Vec<f64> = payload
        .heard()
        .iter()
        .map(|line| number(&field(line, 2)[4..], 0) + 60.0 * number(&field(line, 2)[2..4], 0))
        .collect();
    // 1500 m, and 1.5 m more each second: the sound takes a millisecond more each second.
    assert_eq!(arrived, [22.02, 122.12, 222.22, 322.32]);
}

#[test]
fn frames_are_corrupted_or_undecodable_and_packets_lost_by_chance() {
    let packet = "first_s = 2\nperiod_s = 2\nframes = [\"0A0B0C\", \"FF\"]";
    let chances = "corrupted_chance = 0.2\nundecodable_chance = 0.1\nloss_chance = 0.25";
    let text = with(chances) + &sending("", packet);
    let mut payload = Payload::connected(&text, 5, &["CPR"]);
    payload.until(8010.0);
    let heard = payload.heard();
    let share = heard.len() as f64 / 4000.0;
    assert!((share - 0.75).abs() < 0.03, "{share}");
    let frames: Vec<(&str, &str)> = heard.iter().map(|line| (field(line, 7), field(line, 8))).collect();
    let of_status = |status: &str| frames.iter().filter(|(of, _)| *of == status).count() as f64 / frames.len() as f64;
    assert!((of_status("6") - 0.2).abs() < 0.03 && (of_status("7") - 0.1).abs() < 0.02);
    for (status, data) in frames {
        match status {
            "1" => assert_eq!(data, "0A0B0C"),
            "6" => assert!(data.len() == 6 && data != "0A0B0C"),
            "7" => assert_eq!(data, ""),
            other => panic!("status {other}"),
        }
    }
    // The same seed gives the same losses.
    let mut again = Payload::connected(&text, 5, &["CPR"]);
    again.until(8010.0);
    assert_eq!(again.heard(), heard);
}

#[test]
fn a_packet_that_arrives_while_the_modem_sends_is_not_heard() {
    let packet = "first_s = 12.4\nframes = [\"0A\"]";
    let text = with("") + &sending("", packet);
    let mut payload = Payload::connected(&text, 1, &["CPR"]);
    payload.until(12.0);
    payload.say("$BPCPD,070000.000,1,3,1,0,3,0A,0A,0A,,,,,");
    payload.until(30.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("packet from modem 3 was not heard"))
    );
}
