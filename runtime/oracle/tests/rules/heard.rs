//! Requirements 023 and 025: nothing that steers leaves to a vehicle that does not hear us, or on the plan of another
//! dive.

use crate::scenario::{END, MODIFY, Scenario, stamp};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";
const INTERRUPT: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,4";
const GPS_HIT: &str = "BPRGP,{t},7,4200.300,N,07000.900,W,,,0";

fn modified(run: Scenario, ms: u64) -> Scenario {
    run.ours(ms, MODIFY).ours(ms + 500, END)
}

#[test]
fn requirement_023_an_answer_counts_for_three_seconds_from_when_its_command_left() {
    // The last beat leaves at 3.055 s.
    let silent = || Scenario::with_control().without_answers().beats_until(4000);
    modified(silent(), 6054).finds_nothing();
    modified(silent(), 6055).finds(&["unheard"]);
    silent().ours(6100, TRACKLINE).finds(&["unheard"]);
    silent()
        .ours(6100, "BPSUS,{t}")
        .ours(6200, "BPRES,{t}")
        .finds(&["unheard"]);
    // An answer to any command shows that the vehicle hears us.
    let another = silent().ours(6000, "BPMSG,{t},well");
    let another = another.vehicle(6010, &format!("BFACK,{{t}},MSG,{},0,2,0,ok", stamp(6000)));
    modified(another, 6500).finds_nothing();
}

#[test]
fn requirement_023_only_an_answer_within_the_missions_time_and_on_this_connection_counts() {
    let slow = |ms| modified(Scenario::with_control().without_answers().beats_take(ms), 8000);
    slow(999).finds_nothing();
    slow(1001).finds(&["unheard"]);
    slow(1001)
        .limits(|limits| limits.answered_within_s = 1.5)
        .finds_nothing();
    let lost = Scenario::with_control()
        .without_answers()
        .reconnects(4500, 5000)
        .beats_until(5000);
    modified(lost, 5500).finds(&["unheard"]);
}

#[test]
fn requirement_023_an_answer_that_comes_twice_counts_once() {
    let run = Scenario::with_control().without_answers().beats_until(1000);
    let again = format!("BFACK,{{t}},STS,{},0,2,0,ok", stamp(55));
    modified(run.vehicle(4000, &again), 4100).finds(&["unheard"]);
}

#[test]
fn requirement_023_subscriptions_are_answered_in_their_order() {
    let logs = |answered_ms| {
        let run = Scenario::with_control().without_answers().beats_until(0);
        run.ours(200, "BPLOG,CTL,ON")
            .ours(300, "BPLOG,ACK,ON")
            .ours(5000, "BPLOG,ACK,ON")
            .vehicle(answered_ms, "BFACK,{t},LOG,000000.000,0,2,0,ok")
    };
    // This answers the BPLOG that left at 0.3 s, in time or not.
    modified(logs(310), 3200).finds_nothing();
    modified(logs(5010), 5100).finds(&["unheard"]);
    let both = logs(5010).vehicle(5020, "BFACK,{t},LOG,000000.000,0,2,0,ok");
    modified(both, 5100).finds_nothing();
}

#[test]
fn requirement_023_a_subscription_whose_answer_was_lost_is_not_waited_for_after_a_quick_answer() {
    // The BPLOG that left at 1 s has no answer.
    let run = |next_ms| {
        Scenario::with_control()
            .without_answers()
            .beats_until(0)
            .ours(200, "BPLOG,CTL,ON")
            .ours(300, "BPLOG,ACK,ON")
            .vehicle(310, "BFACK,{t},LOG,000000.000,0,2,0,ok")
            .ours(1000, "BPLOG,ACK,ON")
            .ours(next_ms, "BPLOG,ACK,ON")
            .vehicle(next_ms + 10, "BFACK,{t},LOG,000000.000,0,2,0,ok")
    };
    modified(run(2020), 4500).finds_nothing();
    modified(run(2000), 4500).finds(&["unheard"]);
}

#[test]
fn requirement_023_an_irrevocable_request_needs_an_answer_within_the_last_second() {
    // The last beat is of 3.055 s, and so is its answer; 250 ms may pass until the runtime reads it.
    let silent = || Scenario::with_control().beats_until(4000);
    for body in [INTERRUPT, GPS_HIT] {
        silent().ours(4305, body).finds_nothing();
        silent().ours(4306, body).finds(&["unheard"]);
    }
    silent().ours(4306, TRACKLINE).finds_nothing();
    // This is an answer within the last second, to a command that left long before.
    let slow = |ms| {
        Scenario::with_control()
            .limits(|limits| limits.answered_within_s = 2.5)
            .beats_until(1000)
            .beats_take(1500)
            .ours(ms, INTERRUPT)
    };
    slow(2055).finds_nothing();
    slow(2056).finds(&["unheard"]);
}

#[test]
fn requirement_023_an_irrevocable_request_waits_for_the_answers_to_earlier_commands() {
    // The beat of 4.055 s has left, and its answer comes 300 ms later.
    let slow = |ms, body| Scenario::with_control().beats_take(300).ours(ms, body);
    for body in [INTERRUPT, GPS_HIT] {
        slow(4050, body).finds_nothing();
        slow(4060, body).finds(&["unheard"]);
        slow(4400, body).finds_nothing();
    }
    slow(4060, TRACKLINE).finds_nothing();
    // This vehicle does not answer BPSTS.
    let other = Scenario::with_control().beats_take(60_000).ours(3900, "BPMSG,{t},well");
    let other = other.vehicle(3910, &format!("BFACK,{{t}},MSG,{},0,2,0,ok", stamp(3900)));
    other.ours(4100, INTERRUPT).finds_nothing();
    // It refused one, or said what no version knows, which does not show that it answers BPSTS at other times.
    let once = |status: u8| {
        let run = Scenario::with_control().beats_take(60_000);
        let run = run.vehicle(2100, &format!("BFACK,{{t}},STS,{},0,{status},0,said", stamp(2055)));
        let run = run.ours(3900, "BPMSG,{t},well");
        let run = run.vehicle(3910, &format!("BFACK,{{t}},MSG,{},0,2,0,ok", stamp(3900)));
        run.ours(4100, INTERRUPT)
    };
    for refusal in [0, 1, 7] {
        once(refusal).finds_nothing();
    }
    for answer in [2, 3] {
        once(answer).finds(&["unheard"]);
    }
}

#[test]
fn requirement_023_an_answer_that_a_stopped_runtime_reads_late_does_not_count() {
    // The beat of 3.055 s is answered at once, while the runtime reads nothing.
    let stopped = |until| {
        Scenario::with_control()
            .without_answers()
            .beats_until(3100)
            .beats_take(20)
            .stopped(3060)
            .continued(until)
    };
    modified(stopped(3500), 6000).finds_nothing();
    modified(stopped(4100), 5060).finds(&["unheard"]);
}

#[test]
fn an_echo_with_two_decimals_counts_like_one_with_three() {
    let cut = |ms: u64| stamp(ms)[..9].to_owned();
    // 6.004 s is echoed as 6.00 s, and 6.006 s rounded as 6.01 s.
    for (made, echoed) in [(6004, cut(6004)), (6006, cut(6010))] {
        let run = Scenario::with_control().without_answers().beats_until(2000);
        let run = run.ours(made, "BPMSG,{t},well");
        let run = run.vehicle(6020, &format!("BFACK,{{t}},MSG,{echoed},0,2,0,ok"));
        modified(run, 6100).finds_nothing();
    }
    // A refusal with such an echo counts.
    let refused = |decimals: usize| {
        let run = Scenario::with_control().without_answers().ours(3456, MODIFY);
        let echo = &stamp(3456)[..decimals];
        run.vehicle(3500, &format!("BFACK,{{t}},RMB,{echo},0,1,0,no"))
            .ours(4400, END)
    };
    for decimals in [6, 8, 9, 10] {
        refused(decimals).finds(&["lease-outlives"]);
    }
}

#[test]
fn requirement_025_another_dive_needs_another_plan() {
    let named = |dive: &str| Scenario::with_control().vehicle(4000, &format!("BFMIS,{{t}},{dive},Running,"));
    modified(named("b.dive"), 4240).finds_nothing();
    modified(named("b.dive"), 4260).finds(&["another-dive"]);
    for same in ["a.dive", " a.dive ", "", " "] {
        modified(named(same), 5000).finds_nothing();
    }
    // BFMBS names the dive too, in a way of its own. Once one of the two messages has named another dive, the other one
    // may follow in its own way.
    let begins = |dive: &str| format!("BFMBS,{{t}},{dive},2,,trackline");
    let flown = |dives: [&str; 2]| {
        let run = Scenario::with_control().vehicle(3000, &begins(dives[0]));
        run.vehicle(4000, &begins(dives[1]))
    };
    modified(flown(["a", "b"]), 4240).finds_nothing();
    modified(flown(["a", "b"]), 4260).finds(&["another-dive"]);
    for same in [["a", "a"], ["a", " a "], ["a", ""], ["", "a"], ["b", "b"]] {
        modified(flown(same), 5000).finds_nothing();
    }
    let both = || flown(["a", "b"]).ours(4100, "BPRMP,{t}");
    let told = |asked: u64| format!("BFACK,{{t}},RMP,{},0,2,0,done", stamp(asked));
    let both = both().vehicle(4400, &told(4100));
    let followed = both.clone().vehicle(4500, "BFMIS,{t},b.dive,Running,");
    modified(both, 5000).finds_nothing();
    modified(followed.clone(), 5000).finds_nothing();
    let third = followed.vehicle(4600, "BFMIS,{t},c.dive,Running,");
    modified(third, 5000).finds(&["another-dive"]);
    // A plan that was asked for before may be the other dive's.
    let before = Scenario::with_control().ours(3900, "BPRMP,{t}");
    let before = before.vehicle(4000, "BFMIS,{t},b.dive,Running,");
    modified(before.vehicle(4100, &told(3900)), 5000).finds(&["another-dive"]);
    let asked = || named("b.dive").ours(4100, "BPRMP,{t}");
    let pending = format!("BFACK,{{t}},RMP,{},0,3,0,wait", stamp(4100));
    let told = format!("BFACK,{{t}},RMP,{},0,2,0,done", stamp(4100));
    let element = "BFPLN,{t},1,,0,0,4200.300,N,07000.900,W,,,";
    let series = asked().vehicle(4200, &pending).vehicle(4300, element);
    modified(series.clone(), 5000).finds(&["another-dive"]);
    modified(series.vehicle(4400, &told), 5000).finds_nothing();
}
