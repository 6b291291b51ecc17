//! Which messages are sent for whom, in every state that core can be in.

use std::sync::Arc;

use backseat_fence::Fence;
use backseat_spi::{
    AckStatus, Acknowledgement, BackseatControl, CommandName, Direction, EchoedTime, FromVehicle, MissionStatus,
    Navigation, PositionQuality, Sentence, Text, ToVehicle, VelocityAndRates, catalogue,
};
use backseat_units::{Depth, Heading, Position, Timestamp, Utc};

use super::Core;
use crate::io::{Identifiers, Input, Operator, Start};
use crate::monitor::envelope::Envelope;
use crate::monitor::limits::tests::limits;
use crate::order::Order;
use crate::owner::{ExternalId, Owner};
use crate::plugin::PluginId;
use crate::settings::Settings;

const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature",
    "properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":60,"altitude_min_m":2},
    "geometry":{"type":"Polygon","coordinates":[
        [[-70.01,41.99],[-69.99,41.99],[-69.99,42.01],[-70.01,42.01],[-70.01,41.99]]]}}]}"#;

fn hear(core: &mut Core, message: impl Into<FromVehicle>) {
    let mut bytes = Vec::new();
    message.into().encode(&mut bytes).unwrap();
    core.handle(core.cx.now, Input::Received(&bytes));
}

fn hear_control(core: &mut Core, granted: bool) {
    let created = core.cx.utc().time_of_day();
    hear(core, BackseatControl { created, granted });
}

/// A core after one second of a connection, on which the vehicle has sent navigation and this mission status.
fn connected(armed: bool, status: &str) -> Core {
    let mut core = unconnected(armed);
    core.handle(Timestamp::ZERO, Input::LinkUp);
    let created = core.cx.utc().time_of_day();
    let text = |text: &str| Text::cleaned(text);
    let mission = MissionStatus {
        created,
        dive_file: text(""),
        status: text(status),
        details: text(""),
    };
    // The first BPSTS is answered at once.
    let answer = Acknowledgement {
        created,
        command: CommandName::new("STS").unwrap(),
        command_created: EchoedTime::of(created.truncated_to_millis()),
        behavior: None,
        status: AckStatus::Succeeded,
        text: text(""),
    };
    hear(&mut core, answer);
    hear(&mut core, mission);
    hear_control(&mut core, true);
    for tenths in 0..10u64 {
        core.cx.now = Timestamp::from_millis(100 * tenths);
        let created = core.cx.utc().time_of_day();
        let navigation = Navigation {
            created,
            position: Position::from_deg(42.0, -70.0).unwrap(),
            quality: PositionQuality::NoGps,
            altitude: None,
            depth: Depth::from_m(20.0).unwrap(),
            heading: Heading::from_deg(90.0).unwrap().to_grid(0.0),
            roll_deg: 0.0,
            pitch_deg: 0.0,
            solution: created,
        };
        hear(&mut core, navigation);
        let rates = VelocityAndRates {
            created,
            east_mps: 1.5,
            north_mps: 0.0,
            down_mps: 0.0,
            pitch_rate_dps: 0.0,
            roll_rate_dps: 0.0,
            yaw_rate_dps: 0.0,
        };
        hear(&mut core, rates);
    }
    core
}

fn unconnected(armed: bool) -> Core {
    let envelope = Envelope::new(Fence::from_geojson(FENCE).unwrap(), limits());
    let start = Start {
        utc: Utc::from_unix_nanos(1_700_000_000_000_000_000),
        identifiers: Some(Identifiers {
            next: 1,
            reserved: 1,
            first: 1,
            ..Identifiers::default()
        }),
        armed,
        held: false,
        jitter: 7,
    };
    Core::new(Settings::default(), Arc::new(envelope), Vec::new(), start)
}

/// A state of the vehicle, the operator and the link.
struct Situation {
    name: &'static str,
    core: Core,
    link: bool,
    armed: bool,
    control: bool,
    /// An empty mission may be started.
    idle: bool,
}

fn situations() -> Vec<Situation> {
    let situation = |name, core: Core, control, idle| {
        let armed = core.cx.control.armed;
        let link = core.cx.link.is_up();
        Situation {
            name,
            core,
            link,
            armed,
            control,
            idle,
        }
    };
    let with = |name, act: fn(&mut Core)| {
        let mut core = connected(true, "Running");
        act(&mut core);
        situation(name, core, false, false)
    };
    vec![
        situation("control", connected(true, "Running"), true, false),
        situation("unarmed", connected(false, "Running"), false, false),
        situation("no mission", connected(true, "Ready"), false, true),
        situation("no mission, unarmed", connected(false, "Ready"), false, false),
        situation("no link yet", unconnected(true), false, false),
        with("the vehicle has control", |core| hear_control(core, false)),
        with("held", |core| core.handle(core.cx.now, Input::Operator(Operator::Hold))),
        with("held, no mission", |core| {
            *core = connected(true, "Ready");
            core.handle(core.cx.now, Input::Operator(Operator::Hold));
        }),
        with("ending", |core| {
            core.handle(core.cx.now, Input::Operator(Operator::Stop))
        }),
        with("stale navigation", |core| {
            core.cx.now = core.cx.now + std::time::Duration::from_secs(2)
        }),
        with("link lost", |core| core.handle(core.cx.now, Input::LinkDown)),
        with("link back, nothing heard", |core| {
            core.handle(core.cx.now, Input::LinkDown);
            core.handle(core.cx.now, Input::LinkUp);
        }),
        with("aborted", |core| {
            let text = String::new();
            let order = Order::Abort { text, errors: true };
            core.handle(core.cx.now, Input::Operator(Operator::Order(order)));
        }),
    ]
}

/// What the safety requirements say, message by message.
fn expected(name: &str, owner: Option<Owner>, situation: &Situation, own_insert: bool) -> bool {
    let operator = owner == Some(Owner::Operator);
    let external = owner == Some(Owner::External(ExternalId(0)));
    let Situation {
        link,
        armed,
        control,
        idle,
        ..
    } = *situation;
    link && match name {
        // 014: without control too.
        "BPVER" | "BPLOG" | "BPSTS" | "BPMSG" | "BPRMP" | "BPEMB" => true,
        // Only to end station keeping, and there is none.
        "BPRES" => false,
        "BPRCN" => own_insert,
        "BPTMR" => external && armed,
        // 012
        "BPABT" | "BPKIL" => operator && armed,
        "BPSEM" => operator && idle,
        "BPRCA" | "BPRCB" | "BPRCE" => operator && control,
        "BPNPU" | "BPCTD" | "BPRNS" | "BPRBO" => (operator || external) && control,
        // 016: no window is open.
        "BPCPD" => false,
        "BPXYZ" => false,
        // 001
        "BPTOP" | "BPDVR" | "BPRTK" | "BPRTC" | "BPRGP" | "BPRMB" | "BPSIL" | "BPTRM" | "BPBOY" | "BPSUS" | "BPCON"
        | "BPSPD" | "BPSAN" | "BPGHP" | "BPGBP" | "BPPTZ" | "BPLIT" => control && !external,
        other => panic!("{other} is not in the table"),
    }
}

#[test]
fn sr_001_sr_012_sr_014_sr_016_each_message_is_sent_only_for_the_owners_and_in_the_states_that_allow_it() {
    let example = |name| catalogue().iter().find(|entry| entry.name == name).unwrap().example;
    let examples = catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::ToVehicle)
        .map(|entry| entry.example)
        .chain(["$BPXYZ,1"]);
    let messages: Vec<ToVehicle> = examples
        .map(|text| ToVehicle::decode(&Sentence::parse(text).unwrap()).unwrap())
        .collect();
    assert_eq!(messages.len(), 38);
    let ToVehicle::CancelBehavior(cancel) = ToVehicle::decode(&Sentence::parse(example("BPRCN")).unwrap()).unwrap()
    else {
        panic!("no BPRCN")
    };
    let owners = [
        None,
        Some(Owner::Plugin(PluginId(0))),
        Some(Owner::Operator),
        Some(Owner::External(ExternalId(0))),
    ];
    let mut left = 0;
    for mut situation in situations() {
        assert_eq!(
            situation.core.cx.lost_because().is_none() && situation.armed,
            situation.control,
            "{}",
            situation.name
        );
        for own_insert in [false, true] {
            if own_insert {
                situation.core.cx.identifiers.sent(cancel.identifier, false);
            }
            for message in &messages {
                for owner in owners {
                    let expected = expected(message.name(), owner, &situation, own_insert);
                    let sent = situation.core.cx.pass(owner, message, None);
                    assert_eq!(
                        sent,
                        expected,
                        "{} for {owner:?} in `{}`",
                        message.name(),
                        situation.name
                    );
                    left += u32::from(sent);
                }
            }
        }
    }
    assert!(left > 500, "{left}");
}

#[test]
fn sr_017_beginning_to_trigger_the_dvl_needs_control_and_ending_it_does_not() {
    for mut situation in situations() {
        for (text, ends) in [("$BPDVR,081025.987,0,0", true), ("$BPDVR,081025.987,1,0", false)] {
            let message = ToVehicle::decode(&Sentence::parse(text).unwrap()).unwrap();
            let expected = situation.link && (ends || situation.control);
            assert_eq!(
                situation.core.cx.pass(Some(Owner::Plugin(PluginId(0))), &message, None),
                expected,
                "{text} in `{}`",
                situation.name
            );
        }
        for text in ["$BPDVR,081025.987,0,1", "$BPDVR,081025.987,1,1"] {
            let message = ToVehicle::decode(&Sentence::parse(text).unwrap()).unwrap();
            for permitted in [false, true] {
                situation.core.cx.monitor.permits.may_trigger = permitted;
                assert_eq!(
                    situation.core.cx.pass(Some(Owner::Plugin(PluginId(0))), &message, None),
                    permitted && situation.link && situation.control,
                    "{text} in `{}`, permitted: {permitted}",
                    situation.name
                );
            }
        }
    }
}

#[test]
fn a_message_that_cannot_be_encoded_is_not_sent() {
    let mut core = connected(true, "Running");
    let mut message = ToVehicle::decode(&Sentence::parse("$BPRMB,081025.987,90,3,0,1.5,1,0").unwrap()).unwrap();
    assert!(core.cx.pass(None, &message, None));
    if let ToVehicle::ModifyBehavior(modify) = &mut message {
        modify.horizontal = Some(f64::NAN);
    }
    assert!(!core.cx.pass(None, &message, None));
}
