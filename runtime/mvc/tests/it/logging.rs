//! BPLOG, message by message (SPI 7.1, section 6).

use backseat_mvc::ClientId;

use crate::files::CALM;
use crate::payload::{ME, Payload};

/// Every status message of sections 6 and 9.
const STATUS: [&str; 27] = [
    "NVG", "NVR", "TEL", "SVS", "RCM", "RDP", "RVL", "RBS", "MBS", "MBE", "MIS", "ERC", "DVL", "DV2", "IMU", "CTD",
    "RNV", "PIT", "CNV", "PLN", "ACK", "TRM", "BOY", "CTL", "CMA", "CPS", "CPR",
];
/// Every command message of section 5.
const COMMANDS: [&str; 7] = ["MSC", "SHT", "BDL", "SDL", "TOP", "DVT", "VER"];

const DONE: &str = "$BFACK,080000.000,LOG,000000.000,0,2,0,";

fn names(lines: &[String]) -> Vec<&str> {
    let mut names: Vec<&str> = lines.iter().map(|line| &line[3..6]).collect();
    names.sort_unstable();
    names.dedup();
    names
}

#[test]
fn each_status_message_can_be_switched_on_and_off() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    for name in STATUS.into_iter().filter(|name| *name != "ACK") {
        for switch in ["ON", "OFF", "OFF"] {
            payload.say(&format!("$BPLOG,{name},{switch}"));
            assert_eq!(payload.heard(), [DONE], "{name} {switch}");
        }
    }
    // Once acknowledgements are off, the command that switches them off is not acknowledged either.
    payload.say("$BPLOG,ACK,OFF");
    assert_eq!(payload.heard(), Vec::<String>::new());
}

#[test]
fn command_messages_cannot_be_switched_off_and_unknown_names_are_refused() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    for name in COMMANDS {
        payload.say(&format!("$BPLOG,{name},ON"));
        assert_eq!(payload.heard(), [DONE], "{name}");
        payload.say(&format!("$BPLOG,{name},OFF"));
        let told = "$BFACK,080000.000,LOG,000000.000,0,1,0,command messages are always on";
        assert_eq!(payload.heard(), [told], "{name}");
    }
    // SPI 4.2: case matters. The name of the whole sentence is not valid either.
    for name in ["nvg", "BFNVG", "RMB", "all", ""] {
        payload.say(&format!("$BPLOG,{name},ON"));
        let heard = payload.heard();
        assert!(
            heard.len() == 1 && heard[0].contains(",LOG,000000.000,0,0,0,"),
            "{name}: {heard:?}"
        );
    }
    for switch in ["on", "1", "", "YES"] {
        payload.say(&format!("$BPLOG,NVG,{switch}"));
        let heard = payload.heard();
        assert!(
            heard.len() == 1 && heard[0].contains(",LOG,000000.000,0,0,0,"),
            "{switch}: {heard:?}"
        );
    }
}

#[test]
fn each_message_is_switched_on_and_off_by_itself() {
    let mut payload = Payload::connected(CALM, 1, &["NVR"]);
    payload.until(1.0);
    assert_eq!(names(&payload.heard()), ["NVR"]);
    payload.say("$BPLOG,NVG,ON");
    payload.say("$BPLOG,NVR,OFF");
    payload.until(2.0);
    assert_eq!(names(&payload.heard()), ["NVG"]);
}

#[test]
fn all_leaves_acknowledgements_as_they_are() {
    // SPI 7.1: ALL turns everything on or off except the acknowledgements, which a client subscribes by name.
    let mut payload = Payload::connected(CALM, 1, &["ALL"]);
    payload.say("$BPMSG,070000.000,x");
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.say("$BPLOG,ACK,ON");
    payload.say("$BPLOG,ALL,OFF");
    payload.say("$BPMSG,070000.000,x");
    let told: Vec<bool> = payload.heard().iter().map(|line| line.starts_with("$BFACK")).collect();
    assert_eq!(told, [true; 3]);
    payload.until(20.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

#[test]
fn a_single_message_may_be_switched_off_after_all() {
    let mut payload = Payload::connected(CALM, 1, &["ALL"]);
    payload.say("$BPLOG,NVG,OFF");
    payload.until(20.0);
    let heard = payload.heard();
    let names = names(&heard);
    assert!(
        names.contains(&"NVR") && names.contains(&"CTL") && !names.contains(&"NVG"),
        "{names:?}"
    );
}

#[test]
fn command_messages_come_without_a_subscription() {
    let text = CALM.replace(
        "[mission]",
        "[mission]\nshutdown_after_s = 70\ncommands = [{ at_s = 3, text = \"ping\" }]",
    );
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.say("$BPLOG,ALL,OFF");
    payload.until(15.0);
    assert_eq!(payload.heard(), ["$BFMSC,080004.000,ping", "$BFSHT,080010.000"]);
}

/// A client that takes control from BFCTL must know first that the mission runs. The vehicle sends the two in this
/// order, and replays them in it.
#[test]
fn a_replay_sends_the_mission_status_before_control() {
    let text = format!("{CALM}\n[interpretation]\ncontrol_replay = true");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(10.0);
    payload.say("$BPLOG,ALL,ON");
    assert_eq!(
        payload.heard(),
        [
            "$BFMIS,080010.000,survey.dive,Running /logs/survey,",
            "$BFCTL,080010.000,1"
        ]
    );
    // The vehicle replays only what was switched on, and only to the client that asked. Switching off replays nothing.
    let other = ClientId(2);
    payload.connect(other);
    payload.say_as(other, "$BPLOG,CTL,ON");
    payload.say_as(other, "$BPLOG,CTL,OFF");
    assert_eq!(
        payload.heard_by(other),
        ["$BFVER,080010.000,1.12", "$BFCTL,080010.000,1"]
    );
    assert_eq!(payload.heard(), Vec::<String>::new());
}

/// On vehicles in the field BFCTL and BFMIS are on from the start, and come only on a transition.
#[test]
fn a_field_vehicle_announces_control_only_on_a_transition() {
    let field = CALM.replace("[spi]", "[spi]\nprofile = \"field\"");
    let mut payload = Payload::new(&field, 1);
    payload.until(10.0);
    payload.connect(ME);
    payload.say("$BPLOG,CTL,ON");
    payload.say("$BPLOG,NVG,ON");
    payload.until(20.0);
    // The client connected after the vehicle had granted control, and does not learn of that.
    assert_eq!(names(&payload.heard()), ["NVG", "VER"]);
    // The end of control is a transition again.
    payload.say("$BPLOG,NVG,OFF");
    payload.until(600.0);
    assert_eq!(names(&payload.heard()), ["CTL", "MIS"]);
}

/// Sentences as real clients write them: LF alone, checksums in lower case, of one digit or absent, blank lines.
#[test]
fn the_sentences_of_a_field_client_are_understood() {
    let sum = |body: &str| body.bytes().fold(0u8, |sum, byte| sum ^ byte);
    let mut payload = Payload::connected(&CALM.replace("[spi]", "[spi]\nprofile = \"field\""), 1, &["ACK"]);
    let bodies: Vec<String> = (0..900)
        .map(|count| format!("BPMSG,070000.000,{count}{}", &"Pq#~"[..count % 5]))
        .collect();
    let lower = bodies
        .iter()
        .find(|body| format!("{:02x}", sum(body)).bytes().any(|b| b.is_ascii_lowercase()));
    let single = bodies.iter().find(|body| sum(body) < 16);
    let (lower, single) = (lower.unwrap(), single.unwrap());
    for line in [
        format!("${lower}\n"),
        format!("${lower}*{:02x}\n", sum(lower)),
        format!("${single}*{:x}\n", sum(single)),
        format!("${single}*{:02X}\r\n\n", sum(single)),
        format!("\n\r\n\n${lower}\r\n\n"),
    ] {
        payload.bytes(ME, line.as_bytes());
        let heard = payload.heard();
        assert!(
            heard.len() == 1 && heard[0].contains(",MSG,0700"),
            "{line:?}: {heard:?}"
        );
    }
    // A line with a wrong checksum is not a sentence.
    payload.bytes(ME, format!("${lower}*{:02x}\n", sum(lower) ^ 1).as_bytes());
    assert_eq!(payload.heard(), Vec::<String>::new());
}
