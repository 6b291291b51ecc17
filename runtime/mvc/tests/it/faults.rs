use std::time::Duration;

use backseat_mvc::{ClientId, FaultPlan, Mvc, WorldFile};
use backseat_units::Timestamp;

use crate::files::CALM;
use crate::payload::{ME, Payload};

const RMB: &str = "$BPRMB,070000.000,90,15,0,1.5,1,0";
const RTK: &str = "$BPRTK,070000.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0";

/// The calm world with these faults, each in a section of its own. A `; ` in a fault begins a new line.
fn with(faults: &[&str]) -> String {
    let sections: Vec<String> = faults
        .iter()
        .map(|fault| format!("[[faults.fault]]\n{}\n", fault.replace("; ", "\n")))
        .collect();
    format!("{CALM}\n{}", sections.concat())
}

fn connected(faults: &[&str], messages: &[&str]) -> Payload {
    Payload::connected(&with(faults), 1, messages)
}

fn fields(line: &str) -> Vec<&str> {
    line.split(',').collect()
}

/// The BFNVG sentences among these.
fn navigation(lines: &[String]) -> Vec<&String> {
    lines.iter().filter(|line| line.starts_with("$BFNVG")).collect()
}

#[test]
fn each_begin_and_end_of_a_fault_is_logged_at_its_time() {
    let mut payload = connected(
        &[
            "kind = \"stall\"; at_s = 2.345; for_s = 1; client = 7; direction = \"to_vehicle\"",
            "kind = \"acks_late\"; at_s = 2.345; for_s = 0.111; command = \"RMB\"; delay_s = 1",
            "kind = \"link_cut\"; at_s = 3",
        ],
        &[],
    );
    payload.log();
    payload.until(2.344);
    let of_faults = |payload: &mut Payload| -> Vec<String> {
        let log = payload.log();
        log.into_iter().filter(|line| line.contains(": fault ")).collect()
    };
    assert_eq!(of_faults(&mut payload), Vec::<String>::new());
    payload.until(10.0);
    assert_eq!(
        of_faults(&mut payload),
        [
            "2.345 s: fault 1 begins: stall on the link to the vehicle for client 7",
            "2.345 s: fault 2 begins: acknowledgements of RMB 1 s late",
            "2.456 s: fault 2 ends: acknowledgements of RMB 1 s late",
            "3.000 s: fault 3 begins: link cut for all clients",
            "3.000 s: fault 3 ends: link cut for all clients",
            "3.345 s: fault 1 ends: stall on the link to the vehicle for client 7",
        ]
    );
}

// SPI 6.21: an acknowledgement for each command, if it was subscribed.
#[test]
fn acknowledgements_are_lost_from_the_begin_of_a_fault_up_to_its_end() {
    let mut payload = connected(
        &["kind = \"acks_lost\"; at_s = 5; for_s = 2; command = \"BPRMB\""],
        &["ACK"],
    );
    payload.heard();
    let mut answers = |at_s: f64, sentence: &str| {
        payload.until(at_s);
        payload.say(sentence);
        (payload.heard().len(), payload.mvc.truth().control)
    };
    assert_eq!(answers(4.999, RMB), (1, true));
    assert_eq!(answers(5.0, RMB), (0, true));
    assert_eq!(answers(5.1, "$BPEMB,070000.000"), (1, true));
    assert_eq!(answers(6.999, RMB), (0, true));
    assert_eq!(answers(7.0, RMB), (1, true));
}

#[test]
fn a_command_whose_acknowledgement_is_lost_is_carried_out() {
    let mut payload = connected(&["kind = \"acks_lost\"; at_s = 5; for_s = 2"], &["ACK"]);
    payload.until(5.0);
    payload.say(RMB);
    assert!(payload.heard().is_empty());
    assert!(payload.log().iter().any(|line| line.contains("modifies the behavior")));
}

// SPI 6.21: first "pending", "at some later time (generally within 2 seconds)" the outcome.
#[test]
fn one_stage_of_the_acknowledgements_may_be_lost() {
    for (stage, expected) in [("pending", ["2"].as_slice()), ("outcome", &["3"]), ("all", &[])] {
        let fault = format!("kind = \"acks_lost\"; at_s = 5; for_s = 10; stage = \"{stage}\"");
        let text = with(&[&fault]).replace("acknowledge = \"immediate\"", "");
        let mut payload = Payload::connected(&text, 1, &["ACK"]);
        payload.until(6.0);
        payload.heard();
        payload.say(RTK);
        payload.until(9.0);
        let heard = payload.heard();
        let statuses: Vec<&str> = heard.iter().map(|line| fields(line)[5]).collect();
        assert_eq!(statuses, expected, "{stage}");
    }
}

#[test]
fn a_late_acknowledgement_has_the_time_at_which_it_is_sent() {
    let mut payload = connected(
        &["kind = \"acks_late\"; at_s = 5; for_s = 2; command = \"RMB\"; delay_s = 2.5"],
        &["ACK"],
    );
    payload.until(5.04);
    payload.say(RMB);
    payload.say("$BPEMB,070000.001");
    assert_eq!(payload.heard(), ["$BFACK,080005.040,EMB,070000.001,0,2,0,"]);
    payload.until(7.539);
    assert!(payload.heard().is_empty());
    payload.until(7.54);
    assert_eq!(payload.heard(), ["$BFACK,080007.540,RMB,070000.000,0,2,0,"]);
}

#[test]
fn two_delays_add_up_and_a_new_connection_receives_nothing_of_the_old_one() {
    let late = "kind = \"acks_late\"; at_s = 5; for_s = 2; delay_s = 1";
    let mut payload = connected(&[late, late], &["ACK"]);
    payload.until(5.0);
    payload.say(RMB);
    payload.until(6.999);
    assert!(payload.heard().is_empty());
    payload.until(7.0);
    assert_eq!(payload.heard().len(), 1);

    let mut payload = connected(&[late, late], &["ACK"]);
    payload.until(5.0);
    payload.say(RMB);
    payload.mvc.disconnect(payload.now, ME);
    payload.connect(ME);
    payload.heard();
    payload.until(20.0);
    assert!(payload.heard().is_empty());
}

// SPI 6.21: status 0 is invalid, 1 unsuccessfully processed.
#[test]
fn a_refused_command_is_not_carried_out() {
    for (status, expected) in [
        (
            "0",
            "$BFACK,080005.000,RTK,070000.000,11,0,0,the vehicle cannot do it now",
        ),
        (
            "1",
            "$BFACK,080005.000,RTK,070000.000,11,1,0,the vehicle cannot do it now",
        ),
    ] {
        let fault = format!("kind = \"acks_negative\"; at_s = 5; for_s = 1; command = \"RTK\"; status = {status}");
        let mut payload = connected(&[&fault], &["ACK"]);
        payload.until(5.0);
        payload.heard();
        payload.say(RTK);
        assert_eq!(payload.heard(), [expected]);
        assert!(!payload.log().iter().any(|line| line.contains("added")));
        // The refused command has not used up the identifier.
        payload.until(6.0);
        payload.say(RTK);
        assert_eq!(payload.heard(), ["$BFACK,080006.000,RTK,070000.000,11,2,0,"]);
    }
}

#[test]
fn a_refused_command_may_be_carried_out_all_the_same() {
    let mut payload = connected(
        &["kind = \"acks_negative\"; at_s = 5; for_s = 1; command = \"RMB\"; done = true"],
        &["ACK"],
    );
    payload.until(5.0);
    payload.say(RMB);
    assert_eq!(payload.heard(), ["$BFACK,080005.000,RMB,070000.000,0,1,0,"]);
    assert!(payload.log().iter().any(|line| line.contains("modifies the behavior")));
}

// SPI 6.24: BFCTL says whether the vehicle accepts dynamic requests.
#[test]
fn control_is_taken_and_given_back_although_the_plan_allows_it() {
    let mut payload = connected(&["kind = \"control_taken\"; at_s = 5.05; for_s = 3"], &["CTL", "ACK"]);
    payload.until(5.0);
    assert_eq!(payload.heard(), ["$BFCTL,080001.000,1"]);
    payload.say(RMB);
    payload.heard();
    payload.until(5.1);
    assert_eq!(payload.heard(), ["$BFCTL,080005.100,0"]);
    payload.say(RMB);
    assert_eq!(fields(&payload.heard()[0])[5], "1");
    payload.until(8.1);
    assert_eq!(payload.heard(), ["$BFCTL,080008.100,1"]);
    payload.say(RMB);
    assert_eq!(fields(&payload.heard()[0])[5], "2");
    let log = payload.log();
    let ended = log.iter().find(|line| line.contains("modify ended")).unwrap();
    assert_eq!(ended, "5.100 s: modify ended: control was taken back");
}

#[test]
fn overlapping_faults_of_one_kind_end_with_the_last_of_them() {
    let mut payload = connected(
        &[
            "kind = \"control_taken\"; at_s = 5; for_s = 10",
            "kind = \"control_taken\"; at_s = 6; for_s = 2",
            "kind = \"control_taken\"; at_s = 12; for_s = 6",
        ],
        &["CTL"],
    );
    payload.until(25.0);
    assert_eq!(
        payload.heard(),
        ["$BFCTL,080001.000,1", "$BFCTL,080005.000,0", "$BFCTL,080018.000,1"]
    );
}

// SPI 6.1: BFNVG ends with the time of its solution.
#[test]
fn frozen_navigation_repeats_values_and_solution_time() {
    let mut payload = connected(&["kind = \"navigation_frozen\"; at_s = 5; for_s = 2"], &["NVG", "NVR"]);
    payload.until(4.95);
    let before = payload.heard();
    let last = fields(navigation(&before).last().unwrap())[2..].join(",");
    payload.until(6.95);
    let frozen = payload.heard();
    assert_eq!(frozen.len(), 40);
    for (step, line) in navigation(&frozen).into_iter().enumerate() {
        let fields = fields(line);
        assert_eq!(fields[1], format!("08000{:.3}", 5.0 + 0.1 * step as f64));
        assert_eq!(fields[2..].join(","), last);
    }
    payload.until(7.0);
    let after = payload.heard();
    let after = fields(&after[0]);
    assert_eq!(after[1], *after.last().unwrap());
}

#[test]
fn the_fault_navigation_missing_removes_only_navigation() {
    let mut payload = connected(
        &["kind = \"navigation_missing\"; at_s = 5; for_s = 2"],
        &["NVG", "NVR", "CTD"],
    );
    payload.until(4.95);
    payload.heard();
    payload.until(6.95);
    let heard = payload.heard();
    assert!(!heard.is_empty() && heard.iter().all(|line| line.starts_with("$BFCTD")));
    payload.until(7.0);
    assert_eq!(navigation(&payload.heard()).len(), 1);
}

#[test]
fn navigation_jumps_and_jumps_back_when_a_lasting_fault_ends() {
    let north_minutes = |payload: &mut Payload| -> f64 {
        let heard = payload.heard();
        let latitude = fields(heard.last().unwrap())[2].to_owned();
        latitude[2..].parse().unwrap()
    };
    for lasts in ["", "; for_s = 3"] {
        let fault = format!("kind = \"navigation_jump\"; at_s = 2; east_m = 0; north_m = 185.2{lasts}");
        let mut payload = connected(&[&fault], &["NVG"]);
        payload.until(1.95);
        let before = north_minutes(&mut payload);
        payload.until(2.0);
        let jumped = north_minutes(&mut payload);
        // A minute of latitude is 1852 m; in 0.1 s the vehicle itself moves less than 0.3 m.
        assert!((jumped - before - 0.1).abs() < 0.001, "{before} {jumped}");
        payload.until(4.95);
        let before = north_minutes(&mut payload);
        payload.until(5.0);
        let after = north_minutes(&mut payload);
        let back = if lasts.is_empty() { 0.0 } else { -0.1 };
        assert!((after - before - back).abs() < 0.001, "{before} {after}");
    }
}

// SPI 6.11: BFMIS is sent when the status changes. Control ends with the mission (6.24).
#[test]
fn the_vehicle_aborts_its_mission() {
    let mut payload = connected(&["kind = \"mission_abort\"; at_s = 5"], &["MIS", "CTL"]);
    payload.until(4.95);
    payload.heard();
    payload.until(5.2);
    let heard = payload.heard();
    assert!(heard.contains(&"$BFCTL,080005.000,0".to_owned()), "{heard:?}");
    assert!(
        heard.contains(&"$BFMIS,080005.000,survey.dive,Aborted,aborted by the vehicle".to_owned()),
        "{heard:?}"
    );
    assert!(payload.mvc.mission_over());
}

// SPI 6.1: without bottom lock the altitude is 0.000.
#[test]
fn sensors_drop_out_one_by_one() {
    let mut payload = connected(
        &[
            "kind = \"sensor_dropout\"; at_s = 5; for_s = 2; sensor = \"dvl\"",
            "kind = \"sensor_dropout\"; at_s = 9; for_s = 2; sensor = \"ctd\"",
        ],
        &["NVG", "CTD"],
    );
    let altitudes = |lines: &[String]| -> Vec<bool> {
        let lines = navigation(lines);
        lines.into_iter().map(|line| fields(line)[7] == "0.000").collect()
    };
    payload.until(4.95);
    assert!(altitudes(&payload.heard()).iter().all(|none| !none));
    payload.until(6.95);
    let heard = payload.heard();
    assert!(altitudes(&heard).iter().all(|none| *none), "{heard:?}");
    assert!(heard.iter().any(|line| line.starts_with("$BFCTD")));
    payload.until(8.95);
    assert!(altitudes(&payload.heard()).iter().all(|none| !none));
    payload.until(10.95);
    assert!(!payload.heard().iter().any(|line| line.starts_with("$BFCTD")));
    payload.until(13.0);
    assert!(payload.heard().iter().any(|line| line.starts_with("$BFCTD")));
}

// SPI 5.2: BFSHT at least a minute before the payload's power goes off.
#[test]
fn a_shutdown_is_announced_a_minute_before() {
    let mut payload = connected(&["kind = \"shutdown\"; at_s = 5.03"], &[]);
    payload.until(5.03);
    assert_eq!(payload.heard(), ["$BFSHT,080005.030"]);
    payload.until(65.02);
    assert!(payload.cut_off.is_empty());
    payload.until(65.03);
    assert_eq!(payload.cut_off, [ME]);
    assert!(payload.heard().is_empty());
}

#[test]
fn the_vehicles_clock_is_set_and_set_back() {
    let mut payload = connected(
        &["kind = \"clock_step\"; at_s = 5; for_s = 2; by_s = -28800.5"],
        &["NVG"],
    );
    let stamp = |payload: &mut Payload| fields(payload.heard().last().unwrap())[1].to_owned();
    payload.until(4.9);
    assert_eq!(stamp(&mut payload), "080004.900");
    payload.until(5.0);
    // Eight hours and half a second back: the clock passes midnight backwards.
    assert_eq!(stamp(&mut payload), "000004.500");
    payload.until(7.0);
    assert_eq!(stamp(&mut payload), "080007.000");
}

#[test]
fn a_fault_plan_may_come_during_the_run_and_replace_another() {
    let mut payload = connected(&["kind = \"control_taken\"; at_s = 5; for_s = 100"], &["CTL"]);
    payload.until(10.0);
    let plan = FaultPlan::from_toml(
        "[[fault]]\nkind = \"acks_lost\"\nat_s = 1\nfor_s = 5\n[[fault]]\nkind = \"navigation_frozen\"\nat_s = 1\nfor_s = 20",
    );
    payload.log();
    payload.mvc.set_faults(plan.unwrap());
    payload.until(30.0);
    assert_eq!(
        payload.heard(),
        ["$BFCTL,080001.000,1", "$BFCTL,080005.000,0", "$BFCTL,080010.100,1"]
    );
    let log = payload.log();
    let faults: Vec<&String> = log.iter().filter(|line| line.contains(": fault ")).collect();
    // The first fault of the new plan is already over; the second acts from now on.
    assert_eq!(
        faults,
        [
            "10.000 s: fault 1 ends: control taken back",
            "10.000 s: fault 2 begins: navigation frozen",
            "21.000 s: fault 2 ends: navigation frozen",
        ]
    );
}

#[test]
fn an_injected_fault_begins_at_once_and_is_numbered_after_the_plan() {
    let plan = |text: &str| FaultPlan::from_toml(&text.replace("; ", "\n")).unwrap();
    let mut payload = connected(&["kind = \"navigation_frozen\"; at_s = 12; for_s = 3"], &["CTL"]);
    payload.until(10.0);
    payload.log();
    for fault in plan(
        "[[fault]]\nkind = \"control_taken\"; at_s = 1; for_s = 4\n[[fault]]\nkind = \"clock_step\"; at_s = 99; by_s = 5",
    )
    .faults
    {
        payload.mvc.inject(payload.now, fault);
    }
    payload.until(30.0);
    assert_eq!(
        payload.heard(),
        ["$BFCTL,080001.000,1", "$BFCTL,080015.100,0", "$BFCTL,080019.000,1"]
    );
    let log = payload.log();
    let faults: Vec<&String> = log.iter().filter(|line| line.contains(": fault ")).collect();
    assert_eq!(
        faults,
        [
            "10.000 s: fault 2 begins: control taken back",
            "10.000 s: fault 3 begins: vehicle clock moved by 5 s",
            "10.000 s: fault 3 ends: vehicle clock moved by 5 s",
            "12.000 s: fault 1 begins: navigation frozen",
            "14.000 s: fault 2 ends: control taken back",
            "15.000 s: fault 1 ends: navigation frozen",
        ]
    );
}

#[test]
fn a_plan_without_an_active_fault_changes_nothing() {
    let run = |text: &str| {
        let mut mvc = Mvc::new(&WorldFile::from_toml(text).unwrap(), 5).unwrap();
        mvc.connect(Timestamp::ZERO, ClientId(1));
        mvc.receive(Timestamp::ZERO, ClientId(1), b"$BPLOG,ALL,ON\r\n");
        let (mut bytes, mut out) = (Vec::new(), Vec::new());
        let mut now = Timestamp::ZERO;
        while now < Timestamp::ZERO + Duration::from_secs(30) {
            now = mvc.poll_timeout().unwrap();
            mvc.handle_timeout(now);
            while mvc.poll_transmit(&mut out).is_some() {
                bytes.extend_from_slice(&out);
            }
        }
        bytes
    };
    let far = with(&["kind = \"navigation_frozen\"; at_s = 1000; for_s = 5"]);
    assert!(run(CALM) == run(&far));
}
