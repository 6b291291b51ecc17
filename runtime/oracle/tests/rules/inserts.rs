//! Requirements 002, 009, 010 and 019: which inserts are allowed.

use backseat_oracle::Activity;

use crate::scenario::{MODIFY, Scenario};

/// A trackline at 42 degrees N and these minutes, from `west` to `east`, which are minutes west of 70 degrees W.
fn trackline(identifier: u32, minutes: f64, west: f64, east: f64, rest: &str) -> String {
    format!("BPRTK,{{t}},{identifier},42{minutes:09.6},N,070{west:09.6},W,42{minutes:09.6},N,070{east:09.6},W,{rest}")
}

fn good(identifier: u32) -> String {
    trackline(identifier, 0.3, 0.9, 0.8, "0,10,1.5,0,0")
}

fn interrupting(identifier: u32) -> String {
    trackline(identifier, 0.3, 0.9, 0.8, "0,10,1.5,0,4")
}

fn ack(identifier: u32, status: u32) -> String {
    format!("BFACK,{{t}},RTK,000000.000,{identifier},{status},0,text")
}

fn circle(radius: f64, minutes: f64, rest: &str) -> String {
    format!("BPRTC,{{t}},8,42{minutes:09.6},N,07000.300000,W,{radius},2,{rest}")
}

#[test]
fn an_insert_inside_the_fence_is_no_violation() {
    let outcome = Scenario::with_control()
        .ours(2000, &good(7))
        .vehicle(2100, &ack(7, 3))
        .vehicle(2200, &ack(7, 2))
        .vehicle(3000, "BFMBS,{t},,,7,trackline")
        .activity(3000, Activity::Insert(7))
        .vehicle(8000, "BFMBE,{t},,,7,trackline")
        .activity(8000, Activity::Plan)
        .finds_nothing();
    let statistics = outcome.statistics;
    assert_eq!(
        (
            statistics.inserts_sent,
            statistics.inserts_accepted,
            statistics.inserts_begun
        ),
        (1, 1, 1)
    );
    assert!((statistics.truth_insert_s - 5.0).abs() < 1e-9, "{statistics:?}");
}

#[test]
fn requirement_002_a_line_keeps_its_margin_to_the_edge() {
    // A minute of longitude is 1379.9 m here, so 0.0145 minutes are 20.01 m.
    let line = |west| Scenario::with_control().ours(2000, &trackline(7, 0.3, west, 0.8, "0,10,1.5,0,0"));
    line(1.2 - 0.0146).finds_nothing();
    line(1.2 - 0.0143).finds(&["request-fence"]);
    line(1.25).finds(&["request-fence"]);
    // This line is entirely outside the fence.
    Scenario::with_control()
        .ours(2000, &trackline(7, 3.0, 1.3, 1.4, "0,10,1.5,0,0"))
        .finds(&["request-fence"]);
}

#[test]
fn requirement_002_a_line_keeps_clear_of_keep_out_zones() {
    // Through the mooring, and past its south edge at 30 m; a minute of latitude is 1851.0 m.
    let line = |minutes| Scenario::with_control().ours(2000, &trackline(7, minutes, 0.9, 0.3, "0,10,1.5,0,0"));
    line(0.66).finds(&["request-fence"]);
    line(0.6 - 0.0161).finds(&["request-fence"]);
    line(0.6 - 0.0163).finds_nothing();
    // This line is entirely inside the mooring.
    Scenario::with_control()
        .ours(2000, &trackline(7, 0.66, 0.66, 0.659, "0,10,1.5,0,0"))
        .finds(&["request-fence"]);
    // The wreck is deeper than this line.
    line(0.18).finds_nothing();
    Scenario::with_control()
        .ours(2000, &trackline(7, 0.18, 0.9, 0.3, "0,35,1.5,0,0"))
        .finds(&["request-fence"]);
}

#[test]
fn requirement_002_a_circle_keeps_its_whole_rim_inside() {
    // 414 m from the east edge, 555 m from the south one.
    let circle = |radius| Scenario::with_control().ours(2000, &circle(radius, 0.3, "0,10,1.5,0,0,0"));
    circle(380.0).finds_nothing();
    circle(393.7).finds_nothing();
    circle(394.5).finds(&["request-fence"]);
    circle(500.0).finds(&["request-fence"]);
    circle(90_000.0).finds(&["request-fence"]);
    // A rim around the whole zone is not inside it.
    circle(9_000.0).finds(&["request-fence"]);
}

#[test]
fn requirement_002_setpoints_keep_to_the_limits_of_depth_altitude_and_speed() {
    let line = |rest| Scenario::with_control().ours(2000, &trackline(7, 0.3, 0.9, 0.8, rest));
    line("0,40,1.5,0,0").finds_nothing();
    line("0,40.1,1.5,0,0").finds(&["request-vertical"]);
    line("0,1.9,1.5,0,0").finds(&["request-vertical"]);
    line("1,3,1.5,0,0").finds_nothing();
    line("1,2.9,1.5,0,0").finds(&["request-vertical"]);
    line("0,10,2.6,0,0").finds(&["request-speed"]);
    line("0,10,0.4,0,0").finds(&["request-speed"]);
    let rim = |rest| Scenario::with_control().ours(2000, &circle(100.0, 0.3, rest));
    rim("0,41,1.5,0,0,0").finds(&["request-vertical"]);
    rim("0,10,3,0,0,0").finds(&["request-speed"]);
}

#[test]
fn requirement_002_nothing_is_inserted_into_an_unknown_plan() {
    Scenario::with_control()
        .ours(2000, &good(7))
        .vehicle(2100, &ack(7, 1))
        .started(3500)
        .link(3000, false)
        .link(4000, true)
        .vehicle(4100, "BFMIS,{t},a.dive,Running,")
        .vehicle(4100, "BFCTL,{t},1")
        .vehicle(4100, "BFMBS,{t},,1,,trackline")
        .ours(5000, &good(8))
        .finds(&["plan-unknown"]);
}

#[test]
fn requirement_002_nothing_is_inserted_before_the_current_behavior_is_known() {
    let again = || {
        Scenario::with_control()
            .link(3000, false)
            .link(4000, true)
            .vehicle(4100, "BFMIS,{t},a.dive,Running,")
            .vehicle(4100, "BFCTL,{t},1")
            .vehicle(4200, "BFPLN,{t},1,,0,0,4200.300,N,07000.900,W,,,")
    };
    again().ours(5000, &good(8)).finds(&["begin-unheard"]);
    // An adjustment runs beside the current behavior, and says nothing about it.
    let beside = again().vehicle(4300, "BFMBS,{t},,,,trim");
    beside.ours(5000, &good(8)).finds(&["begin-unheard"]);
    for begun in ["2,,trackline", ",6,trackline"] {
        let begun = again().vehicle(4300, &format!("BFMBS,{{t}},,{begun}"));
        begun.ours(5000, &good(8)).finds_nothing();
    }
}

#[test]
fn requirement_009_identifiers_never_repeat_even_after_a_reconnect() {
    Scenario::with_control()
        .ours(2000, &good(7))
        .link(3000, false)
        .link(4000, true)
        .vehicle(4100, "BFMIS,{t},a.dive,Running,")
        .vehicle(4100, "BFCTL,{t},1")
        .vehicle(4100, "BFMBS,{t},,1,,trackline")
        .vehicle(4200, &ack(7, 1))
        .ours(5000, &good(7))
        .finds(&["identifier-repeated"]);
    Scenario::with_control()
        .ours(2000, &good(7))
        .ours(3000, &good(8))
        .finds_nothing();
}

#[test]
fn requirement_009_no_insert_is_sent_while_another_is_in_doubt() {
    let lost = || Scenario::with_control().ours(2000, &good(7)).reconnects(3000, 4000);
    lost().ours(6000, &good(8)).finds(&["insert-in-doubt"]);
    for words in [
        &ack(7, 2),
        "BFMBS,{t},,,7,trackline",
        "BFMBE,{t},,,7,trackline",
        "BFPLN,{t},,7,0,1,4200.300,N,07000.900,W,,,",
    ] {
        lost().vehicle(5000, words).ours(6000, &good(8)).finds_nothing();
    }
    // A whole plan without the insert settles it too, if the plan was requested after it.
    let told = lost()
        .ours(5000, "BPRMP,{t}")
        .vehicle(5100, "BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,");
    told.clone().ours(6000, &good(8)).finds(&["insert-in-doubt"]);
    told.vehicle(5200, "BFACK,{t},RMP,000004.000,,2,0,text")
        .ours(6000, &good(8))
        .finds_nothing();
    // A new process cannot know of the insert, but it may not use the identifier either.
    lost().started(3500).ours(6000, &good(8)).finds_nothing();
    lost()
        .started(3500)
        .ours(6000, &good(7))
        .finds(&["identifier-repeated"]);
}

#[test]
fn requirement_019_the_number_of_inserts_counts_across_all_processes() {
    Scenario::with_control()
        .limits(|limits| limits.inserts_total_max = 1)
        .ours(2000, &good(7))
        .started(3500)
        .reconnects(3000, 4000)
        .ours(6000, &good(8))
        .finds(&["inserts-total"]);
    // An insert of the old process that the plan names counts as open.
    inherited()
        .vehicle(5000, "BFPLN,{t},,7,0,1,4200.300,N,07000.900,W,,,")
        .ours(6000, &good(8))
        .vehicle(6100, &ack(8, 2))
        .finds(&["inserts-open"]);
}

/// One insert may be open, and a previous run has left one that was accepted.
fn inherited() -> Scenario {
    Scenario::with_control()
        .limits(|limits| limits.inserts_open_max = 1)
        .ours(2000, &good(7))
        .vehicle(2100, &ack(7, 2))
        .started(3500)
        .reconnects(3000, 4000)
}

/// A second process has inherited the insert, and asks for the plan twice before the first answer. The first plan has
/// the insert.
fn inherited_and_asked_twice() -> Scenario {
    inherited()
        .ours(5000, "BPRMP,{t}")
        .ours(5010, "BPRMP,{t}")
        .vehicle(5100, "BFPLN,{t},,7,0,1,4200.300,N,07000.900,W,,,")
        .vehicle(5200, "BFACK,{t},RMP,000004.000,,2,0,text")
}

#[test]
fn requirement_019_each_received_plan_says_which_inserts_wait() {
    let again = |run: Scenario| run.ours(6000, &good(8)).vehicle(6100, &ack(8, 2));
    again(inherited_and_asked_twice()).finds(&["inserts-open"]);
    // The vehicle has dropped the insert meanwhile: the second plan does not have it.
    let whole = |answer: &str| {
        let second = inherited_and_asked_twice().vehicle(5300, "BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,");
        again(second.vehicle(5400, answer))
    };
    whole("BFACK,{t},RMP,000004.010,,2,0,text").finds_nothing();
    // If the end of the first plan is not heard, the second begins when its first element comes again.
    let unanswered = |first: &str| {
        let elements = "BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,";
        let told = inherited()
            .ours(5000, "BPRMP,{t}")
            .vehicle(5100, elements)
            .vehicle(5100, "BFPLN,{t},,7,0,1,4200.300,N,07000.900,W,,,")
            .ours(5200, "BPRMP,{t}")
            .vehicle(5300, first)
            .vehicle(5400, "BFACK,{t},RMP,000004.200,,2,0,text");
        again(told)
    };
    unanswered("BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,").finds_nothing();
    unanswered("BFPLN,{t},1,,1,1,4200.300,N,07000.900,W,,,").finds(&["inserts-open"]);
    // The second plan does not count if it was not sent to its end, or if its answer is the first one's again.
    whole("BFACK,{t},RMP,000004.010,,1,0,text").finds(&["inserts-open"]);
    whole("BFACK,{t},RMP,000004.000,,2,0,text").finds(&["inserts-open"]);
}

#[test]
fn requirement_009_timestamps_never_repeat_under_one_name() {
    Scenario::with_control()
        .ours(2000, "BPMSG,{t},one")
        .ours(2000, "BPSTS,{t},1,ok")
        .finds_nothing();
    Scenario::with_control()
        .ours(2000, "BPMSG,{t},one")
        .ours(2000, "BPMSG,{t},two")
        .finds(&["stamp-repeated"]);
    // A difference of 0.1 ms does not count, because the wire does not carry it.
    Scenario::with_control()
        .ours(2000, "BPMSG,000100.0001,one")
        .ours(3000, "BPMSG,000100.0002,two")
        .finds(&["stamp-repeated"]);
}

#[test]
fn requirement_010_an_interrupting_insert_is_not_interrupted() {
    let run = Scenario::with_control()
        .ours(2000, &interrupting(7))
        .vehicle(2200, &ack(7, 2));
    run.clone()
        .ours(5000, &interrupting(8))
        .finds(&["interrupt-of-interrupt"]);
    run.clone().ours(5000, &good(8)).finds_nothing();
    run.clone()
        .vehicle(4000, "BFMBE,{t},,,7,trackline")
        .ours(5000, &interrupting(8))
        .finds_nothing();
    Scenario::with_control()
        .ours(2000, &interrupting(7))
        .vehicle(2200, &ack(7, 1))
        .ours(5000, &interrupting(8))
        .finds_nothing();
    // The end was lost, and the plan goes on.
    run.clone()
        .vehicle(2500, "BFMBS,{t},,,7,trackline")
        .vehicle(4000, "BFMBS,{t},a.dive,2,,trackline")
        .ours(5000, &interrupting(8))
        .finds_nothing();
    run.clone()
        .vehicle(2500, "BFMBS,{t},,,7,trackline")
        .activity(2500, Activity::Insert(7))
        .vehicle(4000, "BFMBS,{t},,,,trim")
        .ours(5000, &interrupting(8))
        .finds(&["interrupt-of-interrupt"]);
    // The end was lost with the link, but the truth shows it.
    let ends_unheard = |flown: Scenario, cut_ms| {
        flown
            .link(cut_ms, false)
            .activity(4000, Activity::Plan)
            .link(4500, true)
            .vehicle(4600, "BFMIS,{t},a.dive,Running,")
            .vehicle(4600, "BFCTL,{t},1")
            .vehicle(4600, "BFMBS,{t},,1,,trackline")
            .ours(6000, &interrupting(8))
            .finds_nothing();
    };
    ends_unheard(run.clone().activity(2500, Activity::Insert(7)), 3000);
    // The insert was modified from its begin on.
    let modified = run
        .vehicle(2400, "BFMBS,{t},,,7,trackline")
        .ours(2400, MODIFY)
        .activity(2400, Activity::Modified);
    ends_unheard(modified, 2450);
}

#[test]
fn requirement_019_the_number_of_inserts_is_capped() {
    let two = || Scenario::with_control().limits(|limits| limits.inserts_total_max = 2);
    let run = two().ours(2000, &good(7)).ours(3000, &good(8)).ours(4000, &good(9));
    run.finds(&["inserts-total"]);
    two()
        .ours(2000, &good(7))
        .vehicle(2100, &ack(7, 0))
        .ours(3000, &good(8))
        .ours(4000, &good(9))
        .finds_nothing();
}

#[test]
fn requirement_019_the_open_inserts_are_capped() {
    let both = || {
        Scenario::with_control()
            .limits(|limits| limits.inserts_open_max = 1)
            .ours(2000, &good(7))
            .vehicle(2100, &ack(7, 2))
    };
    let second = |run: Scenario| run.ours(5000, &good(8)).vehicle(5100, &ack(8, 2));
    second(both()).finds(&["inserts-open"]);
    second(both().vehicle(4000, "BFMBE,{t},,,7,trackline")).finds_nothing();
    let cancelled = both()
        .ours(3000, "BPRCN,{t},7")
        .vehicle(3100, "BFACK,{t},RCN,000002.000,0,2,0,cancelled");
    assert_eq!(second(cancelled).finds_nothing().statistics.inserts_cancelled, 1);
    // A refused cancel leaves the insert open.
    let kept = both()
        .ours(3000, "BPRCN,{t},7")
        .vehicle(3100, "BFACK,{t},RCN,000002.000,0,1,0,it runs");
    second(kept).finds(&["inserts-open"]);
    let aborted = both()
        .vehicle(3000, "BFMIS,{t},a.dive,Stopped,")
        .vehicle(4000, "BFMIS,{t},a.dive,Running,");
    second(aborted).finds_nothing();
}

#[test]
fn requirement_010_an_insert_that_the_vehicle_could_not_read_is_not_flown() {
    let after = |answer: &str| {
        Scenario::with_control()
            .ours(2000, &interrupting(7))
            .vehicle(2100, &format!("BFACK,{{t}},{answer},0,text"))
            .ours(3000, &interrupting(8))
    };
    after("RTK,000000.000,0,0").finds_nothing();
    // The vehicle could not even read the name.
    after("NAK,000000.000,0,0").finds_nothing();
    // An answer to another command, an answer that names the time of its command, and a refusal of a sentence that was
    // read.
    after("RTC,000000.000,0,0").finds(&["interrupt-of-interrupt"]);
    after("RTK,000005.000,0,0").finds(&["interrupt-of-interrupt"]);
    after("RTK,000000.000,0,1").finds(&["interrupt-of-interrupt"]);
    // The sentence that could not be read was another one.
    let taken = Scenario::with_control()
        .ours(2000, &interrupting(7))
        .vehicle(2100, "BFACK,{t},RTK,000000.000,0,0,0,text")
        .vehicle(2200, &ack(7, 2))
        .ours(3000, &interrupting(8));
    taken.finds(&["interrupt-of-interrupt"]);
}

#[test]
fn requirement_019_an_insert_in_the_plan_counts_without_its_acknowledgement() {
    let run = Scenario::with_control()
        .limits(|limits| limits.inserts_open_max = 1)
        .ours(2000, &good(7))
        .vehicle(3000, "BFPLN,{t},,7,0,1,4200.300,N,07000.900,W,,,")
        .ours(5000, &good(8))
        .vehicle(5100, &ack(8, 2));
    run.finds(&["inserts-open"]);
}

#[test]
fn requirement_019_the_duration_of_open_inserts_is_capped() {
    // 138 m at 1.5 m/s are 92 s.
    let run = |cap: f64| {
        Scenario::with_control()
            .limits(|limits| limits.inserts_duration_max_s = cap)
            .ours(2000, &good(7))
            .vehicle(2100, &ack(7, 2))
            .ours(3000, &good(8))
            .vehicle(3100, &ack(8, 2))
    };
    run(185.0).finds_nothing();
    run(180.0).finds(&["inserts-duration"]);
}
