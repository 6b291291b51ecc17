//! Rules of a script, and the orders of an operator, as a client sees them.

use backseat_mvc::{ControlOrder, Mvc, MvcError, Order, OrderError, Script, WorldFile};

use crate::files::CALM;
use crate::payload::{ME, Payload, course, line};

const RMB: &str = "$BPRMB,070000.000,90,3,0,1.5,1,0";

fn script(text: &str) -> Script {
    Script::from_toml(text).expect("the test's script is right")
}

/// A payload of a vehicle with a script, with these messages on.
fn with(world: &str, rules: &str, messages: &[&str]) -> Payload {
    let file = WorldFile::from_toml(world).expect("the test's file is right");
    let mut mvc = Mvc::new(&file, 1).expect("the test's world is possible");
    mvc.set_script(script(rules)).expect("the vehicle has its dives");
    let mut payload = Payload::of(mvc);
    payload.connect(ME);
    for message in messages {
        payload.say(&format!("$BPLOG,{message},ON"));
    }
    payload.heard();
    payload
}

fn of_rules(payload: &mut Payload) -> Vec<String> {
    let mut log = payload.log();
    log.retain(|line| line.contains(": rule "));
    log
}

#[test]
fn control_is_taken_3_s_after_the_first_modify() {
    let rules = "[[rule]]\nwhen = { received = \"BPRMB\" }\nafter_s = 3\ndo = { control = \"take\" }";
    let mut payload = with(CALM, rules, &["CTL"]);
    payload.until(5.05);
    payload.heard();
    for second in 5..12 {
        payload.until(f64::from(second) + 0.05);
        payload.say(RMB);
    }
    payload.until(20.0);
    // The rule acts to the nanosecond, and control changes at the vehicle's next step.
    assert_eq!(
        of_rules(&mut payload),
        ["8.050 s: rule 1: control taken from the payload"]
    );
    assert_eq!(payload.heard(), ["$BFCTL,080008.100,0"]);
}

#[test]
fn a_fault_of_a_rule_acts_at_its_instant_and_ends_by_itself() {
    let rules = "[[rule]]\nwhen = { at_s = 4 }\nafter_s = 0.025\n\
                 do = { fault = { kind = \"acks_negative\", for_s = 1, command = \"RMB\", status = 0 } }";
    let mut payload = with(CALM, rules, &["ACK"]);
    let mut answer = |at: f64| {
        payload.until(at);
        payload.heard();
        payload.say(RMB);
        payload.heard().concat()
    };
    assert!(answer(4.024).contains("RMB,070000.000,0,2"));
    assert!(answer(4.026).contains("RMB,070000.000,0,0"));
    assert!(answer(5.024).contains("RMB,070000.000,0,0"));
    assert!(answer(5.026).contains("RMB,070000.000,0,2"));
}

#[test]
fn the_sentence_that_a_rule_waits_for_is_handled_before_it_acts() {
    let rules = "[[rule]]\nwhen = { received = \"RMB\" }\nnth = 2\n\
                 do = { fault = { kind = \"acks_lost\", for_s = 100 } }";
    let mut payload = with(CALM, rules, &["ACK"]);
    payload.until(5.0);
    // Three in one write, of which the second does not parse: it has arrived all the same.
    payload.bytes(ME, format!("{RMB}\r\n$BPRMB,070001.000,x\r\n{RMB}\r\n").as_bytes());
    let answers = payload.heard();
    assert_eq!(answers.len(), 2, "{answers:?}");
    assert!(answers[1].contains(",RMB,070001.000,0,0,"), "{answers:?}");
}

#[test]
fn messages_from_the_topside_come_when_clients_connect() {
    let rules = "[[rule]]\nwhen = \"connected\"\nnth = 2\nagain = true\nafter_s = 1\n\
                 do = { topside = { transport = \"acoustic-modem\", text = \"hello\" } }";
    let mut payload = with(CALM, rules, &[]);
    let others = [2, 3].map(backseat_mvc::ClientId);
    payload.until(2.0);
    payload.connect(others[0]);
    payload.until(4.5);
    payload.connect(others[1]);
    payload.until(9.0);
    let hello = |second: &str| format!("$BFTOP,08000{second}00,3,hello");
    assert_eq!(payload.heard(), [hello("3.0"), hello("5.5")]);
    assert_eq!(payload.heard_by(others[1])[1..], [hello("5.5")]);
}

#[test]
fn a_rule_waits_for_an_insert_to_begin() {
    let rules = "[[rule]]\nwhen = { began = \"insert\" }\nafter_s = 10\ndo = \"abort\"";
    let mut payload = with(CALM, rules, &["MBS", "MBE", "MIS"]);
    payload.until(5.0);
    payload.say(&line(41, 10, 4));
    payload.until(30.0);
    let heard = payload.heard();
    assert_eq!(course(&heard), ["+1", "-1", "+i41", "-i41"]);
    let aborted = heard
        .iter()
        .find(|line| line.contains("Aborted"))
        .expect("it is aborted");
    assert!(aborted.ends_with("aborted by the operator"), "{aborted}");
    assert_eq!(of_rules(&mut payload), ["15.000 s: rule 1: dive aborted"]);
}

#[test]
fn the_operator_takes_gives_and_leaves_control() {
    // In an element without dynamic requests, and then in one with them.
    let world = CALM.replacen("dynamic = true", "dynamic = false", 1);
    let mut payload = Payload::connected(&world, 1, &["CTL"]);
    let mut order = |at: f64, order: ControlOrder| {
        payload.until(at);
        payload.heard();
        payload
            .operate(|mvc, now| mvc.order(now, Order::Control(order)))
            .expect("nothing prevents it");
        payload.until(at + 0.5);
        payload.heard().concat()
    };
    // Before the mission nobody has control.
    assert_eq!(order(0.2, ControlOrder::Give), "");
    assert_eq!(order(5.0, ControlOrder::Take), "$BFCTL,080005.100,0");
    assert_eq!(order(6.0, ControlOrder::Give), "$BFCTL,080006.100,1");
    assert_eq!(order(7.0, ControlOrder::Plan), "$BFCTL,080007.100,0");
    assert_eq!(order(8.0, ControlOrder::Plan), "");
}

#[test]
fn dives_are_loaded_and_started_by_rules() {
    let dives = "[[dive]]\nfile = \"first.dive\"\n[[dive]]\nfile = \"second.dive\"\n";
    let world = format!("{CALM}{dives}").replace("starts_after_s = 1\n", "");
    let rules = "[[rule]]\nwhen = { at_s = 2 }\ndo = { load = \"second.dive\" }\n\
                 [[rule]]\nwhen = { at_s = 3 }\ndo = \"start\"\n\
                 [[rule]]\nwhen = { at_s = 9 }\ndo = \"start\"\n\
                 [[rule]]\nwhen = { began = \"any\" }\nafter_s = 10\ndo = \"end\"";
    let mut payload = with(&world, rules, &["MIS"]);
    payload.until(20.0);
    let statuses: Vec<String> = payload.heard().iter().map(|line| line[7..].to_owned()).collect();
    assert_eq!(
        statuses,
        [
            "080002.000,second.dive,Ready,",
            "080003.000,second.dive,Running /logs/survey,",
            "080013.000,second.dive,Completed,ended by the operator"
        ]
    );
    let log = of_rules(&mut payload);
    assert_eq!(
        log[2..4],
        [
            "9.000 s: rule 3: dive started",
            "9.000 s: rule 3: not done: a mission is running: end or abort it first"
        ]
    );
}

#[test]
fn a_dive_that_the_vehicle_does_not_have_is_refused_with_its_line() {
    let file = WorldFile::from_toml(CALM).expect("the test's file is right");
    let mut mvc = Mvc::new(&file, 1).expect("the test's world is possible");
    let rules = script("# One rule.\n\n[[rule]]\nwhen = \"connected\"\ndo = { load = \"other.dive\" }");
    let error = mvc.set_script(rules).expect_err("there is no such dive");
    assert_eq!(
        error.to_string(),
        "line 3: rule 1: no dive is named `other.dive`, expected one of `survey.dive`"
    );
}

#[test]
fn the_driver_gets_the_faults_of_links() {
    let rules = "[[rule]]\nwhen = { received = \"MSG\" }\n\
                 do = { fault = { kind = \"half_open\", for_s = 3, direction = \"from_vehicle\" } }";
    let mut payload = with(CALM, rules, &[]);
    payload.until(2.5);
    assert_eq!(payload.mvc.poll_link_fault(), None);
    payload.say("$BPMSG,070000.000,now");
    let fault = payload.mvc.poll_link_fault().expect("a fault of the link");
    assert_eq!((fault.at, fault.lasts.as_secs()), (payload.now, 3));
    assert_eq!(payload.mvc.poll_link_fault(), None);
    payload.until(9.0);
    let log = payload.log();
    let faults: Vec<&str> = log
        .iter()
        .filter(|line| line.contains("fault 1"))
        .map(|line| &line[..6])
        .collect();
    assert_eq!(faults, ["2.500 ", "5.500 "]);
}

#[test]
fn a_run_takes_so_many_faults_and_no_more() {
    let mut payload = Payload::new(CALM, 1);
    let script = script("[[rule]]\nwhen = \"connected\"\ndo = { fault = { kind = \"link_cut\" } }");
    let order = || script.rules[0].order.clone();
    for _ in 0..100_000 {
        payload.mvc.order(payload.now, order()).expect("there is room");
        let _played = payload.mvc.poll_link_fault();
        while payload.mvc.poll_event().is_some() {}
    }
    let refused = payload.mvc.order(payload.now, order());
    assert_eq!(refused, Err(OrderError::Faults(100_000)));
    assert_eq!(payload.mvc.poll_link_fault(), None);
}

#[test]
fn what_is_wrong_with_a_script_is_said_with_its_line() {
    for (rule, says) in [
        (
            "wen = \"connected\"\ndo = \"abort\"",
            "line 2, column 1: unknown field `wen`",
        ),
        (
            "when = \"conected\"\ndo = \"abort\"",
            "line 2, column 8: unknown variant `conected`",
        ),
        ("do = \"abort\"", "line 1, column 1: missing field `when`"),
        ("when = \"connected\"", "missing field `do`"),
        (
            "when = { received = \"BPXYZ\" }\ndo = \"abort\"",
            "line 1: rule 1: received is \"BPXYZ\", expected a sentence",
        ),
        (
            "when = { received = \"BFNVG\" }\ndo = \"abort\"",
            "received is \"BFNVG\"",
        ),
        (
            "when = { at_s = -1 }\ndo = \"abort\"",
            "at_s is -1, expected 0 to 315360000 s",
        ),
        (
            "when = { at_s = 1 }\nnth = 2\ndo = \"abort\"",
            "`nth` has no meaning with `at_s`",
        ),
        (
            "when = { at_s = 1 }\nagain = false\ndo = \"abort\"",
            "`again` has no meaning with `at_s`",
        ),
        (
            "when = \"connected\"\nnth = 0\ndo = \"abort\"",
            "nth is 0, expected 1 to 1000000",
        ),
        ("when = \"connected\"\nafter_s = nan\ndo = \"abort\"", "after_s is NaN"),
        (
            "when = { began = \"line\" }\ndo = \"abort\"",
            "unknown variant `line`, expected one of `any`",
        ),
        (
            "when = \"connected\"\ndo = { fault = { kind = \"stal\" } }",
            "line 3, column 25: unknown variant `stal`",
        ),
        (
            "when = \"connected\"\ndo = { fault = { kind = \"stall\", fors = 1 } }",
            "unknown field `fors`",
        ),
        (
            "when = \"connected\"\ndo = { fault = { kind = \"stall\" } }",
            "rule 1: a fault of kind stall needs `for_s`",
        ),
        (
            "when = \"connected\"\ndo = { control = \"tak\" }",
            "unknown variant `tak`",
        ),
        (
            "when = \"connected\"\ndo = { topside = { transport = \"wifi\", text = \"a,b\" } }",
            "text is \"a,b\", expected 1 to 200",
        ),
        (
            "when = \"connected\"\ndo = { topside = { transport = { other = 9 }, text = \"a\" } }",
            "transport is 9, expected",
        ),
        ("when = \"connected\"\ndo = { load = \"\" }", "load is \"\""),
    ] {
        let error = Script::from_toml(&format!("[[rule]]\n{rule}\n"))
            .expect_err(rule)
            .to_string();
        assert!(error.contains(says), "{rule}\n{error}");
        assert!(!error.contains('\n'), "{error}");
    }
    let many = "[[rule]]\nwhen = \"connected\"\ndo = \"abort\"\n".repeat(1001);
    assert!(matches!(
        Script::from_toml(&many),
        Err(MvcError::Value { key: "rule", .. })
    ));
}
