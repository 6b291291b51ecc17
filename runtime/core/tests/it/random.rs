//! Random vehicles, links, plugins and operators. The trial's judge compares every sentence with what the vehicle has
//! said. The tests here check what else must hold in every run.

use std::collections::BTreeMap;
use std::time::Duration;

use backseat_core::plugin::{
    DvlTriggerRequest, FaultKind, GpsHitRequest, ModifyRequest, PacketRequest, PositionRequest, Request, RequestState,
    SilentRequest, Topic, TopsideRequest, TrackcircleRequest, TracklineRequest, Transport, VerticalRequest,
};
use backseat_core::{
    Condition, ExternalBounds, ExternalId, ExternalSentence, ExternalSetup, FailAction, Grant, Input, Note, Operator,
    Order, PluginSetup, Policy, RequestKind, Settings,
};
use backseat_spi::{
    AckStatus, Acknowledgement, AdjustmentError, AdjustmentStatus, BackseatControl, BehaviorBegin, BehaviorEnd,
    BehaviorId, CommandName, DvlTriggering, EchoedTime, FrameSentStatus, FromVehicle, MediumAccess, MissionStatus,
    PacketSent, PlanElement, PlanElementKind, Text, TrimStatus,
};
use backseat_units::{EastNorth, Position, TimeOfDay, Timestamp};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use crate::course::{self, at};
use crate::trial::{Seen, Setup, Trial, short};
use crate::vehicle::Reply;

#[derive(Clone, Debug)]
enum Act {
    Wait(u64),
    Bytes(Vec<u8>),
    /// Several sentences in one read.
    Say(Vec<FromVehicle>),
    Control(bool),
    Status(&'static str),
    Begin(Option<u32>, Option<u32>),
    End(Option<u32>, Option<u32>),
    /// An acoustic window of this many seconds.
    Window(u64),
    Replies(&'static str, Reply),
    Navigates(bool),
    Frozen(bool),
    Jump(f64),
    Cut,
    Unreachable(bool),
    Replays(bool),
    Delay(u64),
    Stall(u64),
    Sleep(u64),
    ReadMax(usize),
    Ask(usize, Vec<Request>),
    /// An external source sends this line.
    Drive(String),
    Fail(usize, FaultKind),
    Hold,
    Release,
    Order(Order),
}

pub(crate) fn figure(usual: impl Strategy<Value = f64> + 'static) -> BoxedStrategy<f64> {
    prop_oneof![12 => usual, 1 => select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, 1e300, 91.0])]
        .boxed()
}

fn place() -> BoxedStrategy<PositionRequest> {
    let near = (-2100.0..2100.0, -2100.0..2100.0).prop_map(|(east_m, north_m)| at(east_m, north_m));
    let any = (figure(-90.0..90.0), figure(-180.0..180.0)).prop_map(|(latitude_deg, longitude_deg)| PositionRequest {
        latitude_deg,
        longitude_deg,
    });
    prop_oneof![8 => near, 1 => any].boxed()
}

fn vertical() -> BoxedStrategy<VerticalRequest> {
    prop_oneof![
        figure(0.0..65.0).prop_map(VerticalRequest::DepthM),
        figure(30.0..80.0).prop_map(VerticalRequest::AltitudeM),
    ]
    .boxed()
}

fn request() -> BoxedStrategy<Request> {
    let tag = 0..6u64;
    let speed = || figure(1.0..2.0);
    prop_oneof![
        6 => (tag.clone(), figure(0.0..360.0), vertical(), speed(), 0..70u64).prop_map(
            |(tag, heading_deg, vertical, speed_mps, seconds)| Request::Modify(ModifyRequest {
                tag, heading_deg, vertical, speed_mps, duration: Duration::from_secs(seconds),
            })
        ),
        1 => Just(Request::EndModify),
        4 => (tag.clone(), place(), place(), vertical(), speed(), any::<bool>()).prop_map(
            |(tag, start, end, vertical, speed_mps, interrupt)| Request::Trackline(TracklineRequest {
                tag, start, end, vertical, speed_mps, interrupt,
            })
        ),
        2 => (tag.clone(), place(), figure(20.0..300.0), figure(-2.0..2.0), vertical(), speed(), any::<bool>()).prop_map(
            |(tag, centre, radius_m, orbits, vertical, speed_mps, interrupt)| {
                Request::Trackcircle(TrackcircleRequest {
                    tag, centre, radius_m, orbits, vertical, speed_mps, entry_angle_deg: None, interrupt,
                })
            }
        ),
        2 => tag.clone().prop_map(Request::Cancel),
        1 => (tag.clone(), place()).prop_map(|(tag, position)| Request::GpsHit(GpsHitRequest { tag, position })),
        1 => tag.clone().prop_map(Request::Trim),
        1 => tag.clone().prop_map(Request::Buoyancy),
        1 => ".{0,40}".prop_map(Request::Message),
        1 => (tag.clone(), ".{0,40}|[a-z ]{1,40}").prop_map(|(tag, text)| Request::Topside(TopsideRequest {
            tag, slowest: Transport::RadioModem, text,
        })),
        2 => (tag.clone(), any::<bool>()).prop_map(|(tag, silent)| Request::Silent(SilentRequest { tag, silent })),
        4 => (0..2u64, any::<bool>(), any::<bool>()).prop_map(|(tag, external, triggering)| {
            Request::DvlTrigger(DvlTriggerRequest { tag, external, triggering })
        }),
        2 => (tag.clone(), -1..5i32, vec(vec(any::<u8>(), 0..300), 0..10)).prop_map(|(tag, mode, frames)| {
            Request::Packet(PacketRequest { tag, destination: 3, mode, acknowledge: true, frames })
        }),
        1 => (tag, 0..2000u64).prop_map(|(id, ms)| Request::Timer { id, after: Duration::from_millis(ms) }),
    ]
    .boxed()
}

pub(crate) fn reply() -> BoxedStrategy<Reply> {
    let after = (0..6000u64).prop_map(Duration::from_millis);
    let status = select(vec![
        AckStatus::Succeeded,
        AckStatus::Failed,
        AckStatus::Invalid,
        AckStatus::Pending,
    ]);
    prop_oneof![
        4 => Just(Reply::Ok),
        1 => Just(Reply::Refuse),
        1 => Just(Reply::Silent),
        1 => Just(Reply::Nak),
        1 => Just(Reply::PendingForEver),
        2 => (after.clone(), status.clone()).prop_map(|(after, status)| Reply::Pending(after, status)),
        2 => (after, status).prop_map(|(after, status)| Reply::Late(after, status)),
    ]
    .boxed()
}

fn time() -> BoxedStrategy<TimeOfDay> {
    (0..86_401_000u64)
        .prop_map(|ms| TimeOfDay::from_nanos(ms * 1_000_000).unwrap())
        .boxed()
}

fn identifier() -> BoxedStrategy<Option<BehaviorId>> {
    proptest::option::of((1..8u32).prop_map(BehaviorId::new)).boxed()
}

fn sentence() -> BoxedStrategy<FromVehicle> {
    let text = |text: &str| Text::cleaned(text);
    prop_oneof![
        (time(), any::<bool>()).prop_map(|(created, granted)| BackseatControl { created, granted }.into()),
        (time(), select(vec!["Running", "Running /x", " ", "Ready", "Aborting"])).prop_map(move |(created, status)| {
            MissionStatus {
                created,
                dive_file: text(""),
                status: text(status),
                details: text(""),
            }
            .into()
        }),
        (time(), proptest::option::of(0..5u32), identifier()).prop_map(move |(created, number, identifier)| {
            BehaviorBegin {
                created,
                dive_file: text(""),
                number,
                identifier,
                kind: text("waypoint"),
            }
            .into()
        }),
        (time(), proptest::option::of(0..5u32), identifier()).prop_map(move |(created, number, identifier)| {
            BehaviorEnd {
                created,
                dive_file: text(""),
                number,
                identifier,
                kind: text("trim"),
            }
            .into()
        }),
        (time(), select(vec![0, 1, 1, 2, 3, 9])).prop_map(move |(created, status)| {
            TrimStatus {
                created,
                status: AdjustmentStatus::from_code(status),
                error: AdjustmentError::None,
                text: text(""),
                pitch_deg: 0.0,
                roll_deg: 0.0,
            }
            .into()
        }),
        (
            time(),
            select(vec![
                "LOG", "RMB", "RTK", "RTC", "RGP", "RCN", "RMP", "EMB", "TRM", "ABT", "SEM", "NAK", "XYZ", "TOP",
                "SIL", "DVR", "CPD",
            ]),
            prop_oneof![Just(TimeOfDay::MIDNIGHT), time()],
            identifier(),
            select(vec![AckStatus::Succeeded, AckStatus::Failed, AckStatus::Pending]),
        )
            .prop_map(move |(created, name, command_created, behavior, status)| {
                let command = CommandName::new(name).unwrap();
                Acknowledgement {
                    created,
                    command,
                    command_created: EchoedTime::of(command_created),
                    behavior,
                    status,
                    text: text(""),
                }
                .into()
            }),
        (time(), any::<bool>()).prop_map(|(created, begin)| DvlTriggering { created, begin }.into()),
        (time(), 0..20u32, 1..=8u32, -1..5i32).prop_map(|(created, request, frames, status)| {
            PacketSent {
                created,
                sent: created,
                request,
                frames,
                statuses: [FrameSentStatus::from_code(status); 8],
            }
            .into()
        }),
        (
            time(),
            proptest::option::of(0..5u32),
            identifier(),
            41.9..42.1,
            -70.1..-69.9
        )
            .prop_map(|(created, number, identifier, latitude, longitude)| {
                let position = Position::from_deg(latitude, longitude).unwrap();
                let element = PlanElementKind::Waypoint;
                PlanElement {
                    created,
                    number,
                    identifier,
                    index: 0,
                    element,
                    position,
                }
                .into()
            }),
    ]
    .boxed()
}

/// A line of an external source. A measurement in it is from the minute in which the dive starts.
fn drive() -> BoxedStrategy<Act> {
    let lines = prop_oneof![
        figure(-60.0..60.0).prop_map(|offset| format!("BPRBO,081025.987,{offset}")),
        (figure(-60.0..60.0), figure(-60.0..60.0)).prop_map(|(x, y)| format!("BPRNS,081025.987,{x},{y},90")),
        (figure(0.0..5e4), 0..60u32).prop_map(|(c, s)| format!("BPCTD,081025.987,{c},10,300,2213{s:02}.5")),
        (select(vec!["4200.0", "4200.2", "4300.0"]), 0..2u32, 0..60u32).prop_map(|(latitude, force, s)| format!(
            "BPNPU,081025.987,{latitude},N,07000.0,W,10,20,{force},2213{s:02}.5"
        )),
        Just("BPTMR,081025.987,3,hello".to_owned()),
        ".{0,40}".prop_map(|text| text),
    ];
    lines.prop_map(|line| Act::Drive(format!("${line}\n"))).boxed()
}

fn act() -> BoxedStrategy<Act> {
    let own = proptest::option::of(1..6u32);
    let number = proptest::option::of(1..5u32);
    let kinds = vec![
        FaultKind::Trap,
        FaultKind::Error,
        FaultKind::OutOfFuel,
        FaultKind::Start,
        FaultKind::Overflow,
    ];
    prop_oneof![
        20 => (0..3000u64).prop_map(Act::Wait),
        2 => vec(any::<u8>(), 0..200).prop_map(Act::Bytes),
        2 => "(\\$?BF(NVG|CTL|ACK|MIS|MBS),[0-9.,NEWS-]{0,60}(\\*[0-9A-F]{2})?\r?\n){1,4}"
            .prop_map(|text| Act::Bytes(text.into_bytes())),
        4 => vec(sentence(), 1..5).prop_map(Act::Say),
        2 => any::<bool>().prop_map(Act::Control),
        2 => select(vec!["Running", "Running", "Ready", "Completed", ""]).prop_map(Act::Status),
        3 => (number.clone(), own.clone()).prop_map(|(number, own)| Act::Begin(number, own)),
        3 => (number, own).prop_map(|(number, own)| Act::End(number, own)),
        5 => (select(vec![
            "LOG", "RMB", "RTK", "RTC", "RGP", "RCN", "RMP", "EMB", "TRM", "BOY", "ABT", "KIL", "SEM", "RCA", "RCB",
            "TOP", "SIL", "DVR", "CPD",
        ]), reply())
            .prop_map(|(name, reply)| Act::Replies(name, reply)),
        2 => (0..4000u64).prop_map(Act::Window),
        1 => any::<bool>().prop_map(Act::Navigates),
        1 => any::<bool>().prop_map(Act::Frozen),
        1 => (-100.0..100.0).prop_map(Act::Jump),
        2 => Just(Act::Cut),
        1 => any::<bool>().prop_map(Act::Unreachable),
        1 => any::<bool>().prop_map(Act::Replays),
        2 => (0..40u64).prop_map(Act::Delay),
        1 => (0..5000u64).prop_map(Act::Stall),
        1 => (0..4000u64).prop_map(Act::Sleep),
        1 => (1..400usize).prop_map(Act::ReadMax),
        20 => (0..2usize, vec(request(), 0..6)).prop_map(|(plugin, requests)| Act::Ask(plugin, requests)),
        2 => (0..2usize, select(kinds)).prop_map(|(plugin, kind)| Act::Fail(plugin, kind)),
        4 => drive(),
        1 => Just(Act::Hold),
        2 => Just(Act::Release),
    ]
    .boxed()
}

/// The commands that only the operator may order.
const ORDERED: [&str; 6] = ["ABT", "KIL", "SEM", "RCA", "RCB", "RCE"];

fn order() -> BoxedStrategy<Order> {
    prop_oneof![
        Just(Order::Hold),
        Just(Order::Release),
        Just(Order::CancelAll),
        Just(Order::CancelCurrent),
        Just(Order::CancelElement),
        (".{0,20}", any::<bool>()).prop_map(|(text, errors)| Order::Abort { text, errors }),
        ".{0,20}".prop_map(|text| Order::Kill { text }),
        any::<u32>().prop_map(|duration_s| Order::StartEmptyMission { duration_s }),
    ]
    .boxed()
}

/// A plugin with every grant that the acts use.
fn plugin(name: &str) -> PluginSetup {
    let mut setup = course::plugin(name);
    setup.grants.extend([
        Grant::Surface,
        Grant::Trim,
        Grant::Buoyancy,
        Grant::Topside,
        Grant::Silent,
        Grant::Dvl,
        Grant::Acoustic,
    ]);
    setup.description.topics.push(Topic::Acoustic);
    setup
}

/// An external source that may send every sentence, at a high rate.
fn every_external() -> ExternalSetup {
    ExternalSetup {
        name: "pod".to_owned(),
        sends: vec![
            ExternalSentence::Relay,
            ExternalSentence::PayloadCtd,
            ExternalSentence::PositionFix,
            ExternalSentence::RelativeReset,
            ExternalSentence::BearingOffset,
        ],
        bounds: ExternalBounds {
            rate_max_hz: 10.0,
            measured_age_max_s: 60.0,
            fix_force: true,
            ..ExternalBounds::default()
        },
    }
}

fn start() -> Trial {
    start_with(Vec::new())
}

fn start_with(policies: Vec<Policy>) -> Trial {
    let mut second = plugin("second");
    second.on_failure = FailAction::Cancel;
    let mut limits = course::limits();
    // Short enough that a silence is over before the run is.
    limits.silent_term_s = 20.0;
    let mut trial = Trial::with(Setup {
        fence: course::harbour(),
        limits,
        plugins: vec![plugin("first"), second],
        settings: Settings {
            policies,
            externals: vec![every_external()],
            ..Settings::default()
        },
        ..Setup::default()
    });
    trial.run_for(1.0);
    trial
}

fn play(trial: &mut Trial, acts: Vec<Act>) {
    for act in acts {
        let now = trial.now;
        match act {
            Act::Wait(ms) => trial.run_for(ms as f64 / 1e3),
            Act::Bytes(bytes) => trial.hear_bytes(&bytes),
            Act::Say(messages) => trial.hear_now(messages),
            Act::Control(granted) => trial.vehicle.set_control(now, granted),
            Act::Status(status) => trial.vehicle.set_status(now, status),
            Act::Begin(number, own) => trial.vehicle.begin(now, number, own),
            Act::End(number, own) => trial.vehicle.end(now, number, own),
            Act::Replies(name, reply) => {
                trial.vehicle.replies.insert(name, reply);
            }
            Act::Window(seconds) => {
                let (created, until) = (
                    trial.vehicle.clock(now),
                    trial.vehicle.clock(now + Duration::from_secs(seconds)),
                );
                let window = MediumAccess {
                    created,
                    until,
                    address: 7,
                    device: Text::cleaned("WHOI"),
                };
                trial.vehicle.say(now, window);
            }
            Act::Navigates(navigates) => trial.vehicle.navigates = navigates,
            Act::Frozen(frozen) => trial.vehicle.frozen = frozen.then_some(now),
            Act::Jump(metres) => trial.vehicle.jump = EastNorth::new(metres, 0.0),
            Act::Cut => trial.cut(),
            Act::Unreachable(unreachable) => trial.unreachable = unreachable,
            Act::Replays(replays) => trial.vehicle.replays = replays,
            Act::Delay(ms) => trial.delay = Duration::from_millis(ms),
            Act::Stall(ms) => trial.stalled_until = now + Duration::from_millis(ms),
            Act::Sleep(ms) => trial.asleep_until = now + Duration::from_millis(ms),
            Act::ReadMax(bytes) => trial.read_max = bytes,
            Act::Ask(plugin, requests) => trial.ask(plugin, requests),
            Act::Drive(line) => trial.feed(Input::External(ExternalId(0), line.as_bytes())),
            Act::Fail(plugin, kind) => trial.fail(plugin, kind),
            Act::Hold => trial.operator(Operator::Hold),
            Act::Release => trial.operator(Operator::Release),
            Act::Order(order) => trial.operator(Operator::Order(order)),
        }
    }
}

fn kind_of(name: &str) -> RequestKind {
    match name {
        "SEM" => RequestKind::StartEmptyMission,
        "RCA" => RequestKind::CancelAll,
        "RCB" => RequestKind::CancelCurrent,
        _ => RequestKind::CancelElement,
    }
}

/// Checks that each request ends at most once, and that the counts agree with the log.
pub(crate) fn ledger_is_consistent(trial: &Trial) {
    let mut last: BTreeMap<u64, &'static str> = BTreeMap::new();
    let (mut ended, mut rejected, mut sent) = (0, 0, 0);
    for (at, note) in trial.notes() {
        let Note::Request(transition) = note else { continue };
        let state = short(&transition.state);
        if let Some(before) = last.insert(transition.request, state) {
            let over = ["rejected", "failed", "timed out", "ended", "cancelled"].contains(&before);
            assert!(
                !over,
                "request {} went from {before} to {state} at {at}",
                transition.request
            );
        }
        match &transition.state {
            RequestState::Rejected(_) => (ended, rejected) = (ended + 1, rejected + 1),
            RequestState::Sent => sent += 1,
            RequestState::Failed(_) | RequestState::TimedOut | RequestState::Ended(_) | RequestState::Cancelled => {
                ended += 1;
            }
            RequestState::Pending | RequestState::Accepted | RequestState::Unknown | RequestState::Started => {}
        }
    }
    let counts = trial.core.request_counts();
    // The ledger counts the requests over a rate, and the log has only numbers of them: each beat logs the number since
    // the last beat.
    let told: u64 = trial
        .notes()
        .iter()
        .filter_map(|(_, note)| match note {
            Note::Text { text } if text.contains("over its rate") => text.split(' ').next()?.parse::<u64>().ok(),
            _ => None,
        })
        .sum();
    let untold = counts.rejected.checked_sub(rejected + told);
    assert!(
        untold.is_some(),
        "{} rejected, {rejected} and {told} told",
        counts.rejected
    );
    assert_eq!(counts.sent, sent);
    let uncounted = counts.rejected - rejected;
    assert_eq!(counts.proposed, ended + uncounted + trial.core.open_requests() as u64);
}

/// Ends all faults. Checks that control is back within a minute, and that no request is open when the mission is over.
pub(crate) fn it_recovers(trial: &mut Trial) {
    trial.vehicle.replies.clear();
    (trial.vehicle.navigates, trial.vehicle.frozen, trial.vehicle.replays) = (true, None, true);
    (trial.vehicle.control, trial.vehicle.status) = (true, "Running");
    trial.unreachable = false;
    trial.read_max = usize::MAX;
    trial.delay = Duration::from_millis(5);
    trial.operator(Operator::Release);
    trial.run_for(5.0);
    trial.cut();
    trial.run_for(50.0);
    // A policy may have ordered a hold while navigation was gone.
    trial.operator(Operator::Release);
    trial.run_for(5.0);
    assert!(
        trial.core.has_control(),
        "control is not back: {:?}",
        trial.notes().last()
    );
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(20.0);
    assert_eq!(trial.core.open_requests(), 0);
    assert!(!trial.core.is_steering());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sr_001_sr_009_sr_013_whatever_happens_nothing_steers_without_control_and_every_request_has_one_end(
        acts in vec(act(), 1..80)
    ) {
        let mut trial = start();
        play(&mut trial, acts);
        ledger_is_consistent(&trial);
        it_recovers(&mut trial);
        ledger_is_consistent(&trial);
        // Safety requirement 012: nobody has ordered any of these.
        for name in ORDERED {
            prop_assert!(trial.commands(name).is_empty(), "{name}");
        }
    }

    #[test]
    fn sr_009_sr_012_what_only_the_operator_may_order_leaves_only_by_order_and_every_order_has_one_end(
        acts in vec(prop_oneof![4 => act(), 1 => order().prop_map(Act::Order)], 1..60),
        stale in (1.0..5.0, order()),
        quarantined in order(),
    ) {
        // The judge of the trial does not see a policy's release.
        let no_release = |order| if order == Order::Release { Order::Hold } else { order };
        let policies = vec![
            Policy { when: Condition::NavigationStaleForS(stale.0), order: no_release(stale.1) },
            Policy { when: Condition::PluginQuarantined, order: no_release(quarantined) },
        ];
        let mut trial = start_with(policies);
        play(&mut trial, acts);
        ledger_is_consistent(&trial);
        it_recovers(&mut trial);
        ledger_is_consistent(&trial);
        let notes = trial.notes();
        for name in ["SEM", "RCA", "RCB", "RCE"] {
            let sent = trial.commands(name).len();
            let ordered = notes.iter().filter(|(_, note)| match note {
                Note::Request(transition) => transition.state == RequestState::Sent && kind_of(name) == transition.kind,
                _ => false,
            });
            prop_assert_eq!(sent, ordered.count(), "{}", name);
        }
    }

    #[test]
    fn the_same_inputs_give_the_same_outputs(acts in vec(act(), 1..40)) {
        let run = |acts: Vec<Act>| -> Vec<(Timestamp, Seen)> {
            let mut trial = start();
            play(&mut trial, acts);
            trial.seen
        };
        let once = run(acts.clone());
        prop_assert_eq!(once, run(acts));
    }
}
