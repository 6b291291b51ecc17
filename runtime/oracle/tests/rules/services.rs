//! Requirements 011, 014, 016, 017, 018 and 019: everything but movement.

use crate::scenario::{END, MODIFY, Scenario};

const TRACKLINE: &str = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,0,10,1.5,0,0";
const PACKET: &str = "BPCPD,{t},1,2,0,1,1,AB,,,,,,,";

#[test]
fn requirement_011_nothing_new_leaves_after_the_shutdown_notice() {
    let shutdown = || Scenario::with_control().beats_until(14_000).vehicle(4000, "BFSHT,{t}");
    for body in [TRACKLINE, MODIFY, "BPSUS,{t}"] {
        let end = if body == MODIFY { END } else { "BPRES,{t}" };
        shutdown().ours(4200, body).ours(4210, end).finds_nothing();
        shutdown().ours(4300, body).ours(4310, end).finds(&["after-shutdown"]);
    }
    // A lease that exists may be ended in order.
    shutdown()
        .ours(3500, MODIFY)
        .ours(4500, MODIFY)
        .ours(5000, END)
        .finds_nothing();
}

#[test]
fn requirement_011_nothing_at_all_leaves_ten_seconds_after_the_notice() {
    let shutdown = || Scenario::with_control().beats_until(14_000).vehicle(4000, "BFSHT,{t}");
    shutdown().ours(14_700, "BPMSG,{t},bye").finds_nothing();
    shutdown()
        .ours(14_800, "BPMSG,{t},bye")
        .ours(14_900, "BPMSG,{t},still here")
        .finds(&["after-shutdown"]);
    // A new process has not received the notice.
    shutdown()
        .started(12_000)
        .ours(14_800, "BPMSG,{t},hello")
        .finds_nothing();
}

#[test]
fn requirement_011_a_stopped_runtime_receives_the_notice_when_it_goes_on() {
    let woken = || {
        Scenario::with_control()
            .beats_until(16_000)
            .stopped(1000)
            .vehicle(2000, "BFSHT,{t}")
            .continued(6000)
    };
    woken()
        .ours(6000, "BPMSG,{t},late")
        .ours(6010, TRACKLINE)
        .ours(16_700, "BPMSG,{t},bye")
        .finds_nothing();
    woken().ours(6300, TRACKLINE).finds(&["after-shutdown"]);
    woken()
        .ours(16_800, "BPMSG,{t},bye")
        .ours(16_900, "BPMSG,{t},still here")
        .finds(&["after-shutdown"]);
}

#[test]
fn requirement_011_a_notice_on_its_way_waits_for_a_stopped_runtime() {
    let stopped = |ms| {
        Scenario::with_control()
            .beats_until(16_000)
            .vehicle(2000, "BFSHT,{t}")
            .stopped(ms)
    };
    stopped(2001)
        .continued(6000)
        .ours(6010, TRACKLINE)
        .ours(16_700, "BPMSG,{t},bye")
        .finds_nothing();
    stopped(2001)
        .continued(6000)
        .ours(6300, TRACKLINE)
        .finds(&["after-shutdown"]);
    // Without an end of the stop in the record, the first write is the end.
    let written = |ms| stopped(2001).ours(6000, "BPMSG,{t},late").ours(ms, "BPMSG,{t},bye");
    written(16_700).finds_nothing();
    written(16_800).finds(&["after-shutdown"]);
    // It was certainly heard before the stop: neither the request nor the beats after 12.75 s may leave.
    stopped(2300)
        .continued(6000)
        .ours(6010, TRACKLINE)
        .finds(&["after-shutdown", "after-shutdown"]);
}

#[test]
fn requirement_011_a_notice_that_may_be_lost_with_the_link_does_not_count() {
    let lost = |ms| {
        Scenario::with_control()
            .beats_until(12_000)
            .vehicle(2000, "BFSHT,{t}")
            .reconnects(ms, 3000)
            .ours(13_000, "BPMSG,{t},still here")
    };
    lost(2200).finds_nothing();
    lost(2300).finds(&["after-shutdown"]);
}

#[test]
fn requirement_016_packets_keep_to_the_windows() {
    let window = || Scenario::with_control().vehicle(3000, "BFCMA,{t},000004.000,7,WHOIPSK");
    window().ours(3100, PACKET).ours(5000, PACKET).finds_nothing();
    // The run begins a second before midnight: the window ends at 5 s, and 250 ms are for the delays of the link.
    window().ours(5240, PACKET).finds_nothing();
    window().ours(5260, PACKET).finds(&["packet-window"]);
    window().ours(2500, PACKET).finds(&["packet-window"]);
    window()
        .reconnects(3500, 4000)
        .ours(4500, PACKET)
        .finds(&["packet-window"]);
    // Without a window no packet may leave.
    Scenario::with_control().ours(3100, PACKET).finds(&["packet-window"]);
}

#[test]
fn requirement_017_the_dvl_is_triggered_only_with_permission() {
    let asked = || Scenario::with_control().ours(2000, "BPDVR,{t},1,0");
    asked()
        .vehicle(3000, "BFDVT,{t},1")
        .ours(3100, "BPDVR,{t},1,1")
        .finds_nothing();
    asked().ours(3100, "BPDVR,{t},1,1").finds(&["trigger-without-leave"]);
    let ceased = || asked().vehicle(3000, "BFDVT,{t},1").vehicle(4000, "BFDVT,{t},0");
    ceased()
        .ours(4200, "BPDVR,{t},1,1")
        .ours(4300, "BPDVR,{t},0,0")
        .finds_nothing();
    ceased()
        .ours(4300, "BPDVR,{t},1,1")
        .ours(4400, "BPDVR,{t},0,0")
        .finds(&["trigger-without-leave"]);
}

#[test]
fn requirement_017_a_request_to_stop_must_be_answered() {
    let ceased = || {
        Scenario::with_control()
            .ours(2000, "BPDVR,{t},1,0")
            .vehicle(3000, "BFDVT,{t},1")
            .ours(3100, "BPDVR,{t},1,1")
            .vehicle(4000, "BFDVT,{t},0")
    };
    ceased().finds(&["trigger-not-ceased"]);
    ceased().ours(5490, "BPDVR,{t},1,0").finds_nothing();
    ceased().ours(5510, "BPDVR,{t},1,0").finds(&["trigger-not-ceased"]);
    // Also without control.
    ceased().vehicle(4100, "BFCTL,{t},0").finds(&["trigger-not-ceased"]);
    ceased().link(4500, false).finds_nothing();
    ceased().stopped(4500).finds_nothing();
    // The runtime continues, and has not yet heard of the end.
    let stopped = |ms| ceased().stopped(4001).continued(9000).ours(ms, "BPDVR,{t},1,1");
    stopped(9010).finds_nothing();
    stopped(9300).finds(&["trigger-without-leave"]);
}

#[test]
fn requirement_014_triggering_is_not_requested_without_control() {
    let lost = || {
        Scenario::with_control()
            .ours(2000, "BPDVR,{t},1,0")
            .vehicle(3000, "BFCTL,{t},0")
    };
    lost().ours(4000, "BPDVR,{t},0,0").finds_nothing();
    lost().ours(4000, "BPDVR,{t},1,0").finds_nothing();
    Scenario::without_control()
        .ours(4000, "BPDVR,{t},1,0")
        .finds(&["not-allowed-without-control"]);
}

#[test]
fn requirement_018_silence_is_not_requested_while_it_lasts() {
    let silent = || {
        Scenario::with_control()
            .limits(|limits| limits.caps.silent_term_s = 10.0)
            .ours(2000, "BPSIL,{t},1")
            .vehicle(2100, "BFACK,{t},SIL,000001.000,0,3,0,ok")
            .vehicle(3500, "BFACK,{t},SIL,000001.000,0,2,0,ok")
    };
    silent().ours(8000, "BPSIL,{t},1").finds(&["silence-repeated"]);
    silent().ours(11_500, "BPSIL,{t},1").finds_nothing();
    silent()
        .ours(8000, "BPSIL,{t},0")
        .ours(9000, "BPSIL,{t},1")
        .finds_nothing();
    // The vehicle did not enter silence.
    Scenario::with_control()
        .ours(2000, "BPSIL,{t},1")
        .vehicle(3500, "BFACK,{t},SIL,000001.000,0,1,0,it spins")
        .ours(8000, "BPSIL,{t},1")
        .finds_nothing();
    // A new process cannot know of the silence.
    silent().started(5000).ours(8000, "BPSIL,{t},1").finds_nothing();
}

#[test]
fn requirement_019_the_number_of_requests_that_outlive_us_is_capped() {
    let answered = |what: &str, status: u32, asked_s: [u32; 3]| {
        let mut run = Scenario::with_control().limits(|limits| {
            limits.caps.gps_hits_total_max = 2;
            limits.caps.adjustments_total_max = 2;
        });
        for (ms, asked_s) in [3000, 4000, 5000].into_iter().zip(asked_s) {
            let ack = format!("BFACK,{{t}},{what},00000{asked_s}.000,0,{status},0,text");
            run = run.vehicle(ms, &ack);
        }
        run
    };
    let taken = |what: &str, status: u32| answered(what, status, [1, 2, 3]);
    for what in ["RGP", "TRM", "BOY"] {
        taken(what, 2).finds(&["requests-total"]);
        taken(what, 1).finds_nothing();
        // A repeated answer belongs to one request.
        answered(what, 2, [1, 2, 2]).finds_nothing();
    }
    let run = Scenario::with_control().limits(|limits| limits.caps.silences_total_max = 1);
    let run = run
        .ours(2000, "BPSIL,{t},1")
        .vehicle(2100, "BFACK,{t},SIL,000001.000,0,2,0,ok")
        .vehicle(2200, "BFACK,{t},SIL,000001.000,0,2,0,ok")
        .ours(3000, "BPSIL,{t},0")
        .ours(4000, "BPSIL,{t},1");
    run.clone().finds_nothing();
    run.vehicle(4100, "BFACK,{t},SIL,000003.000,0,2,0,ok")
        .finds(&["requests-total"]);
}

#[test]
fn requirement_019_the_rate_of_texts_and_packets_is_limited() {
    let run = |count: u64, body: &str| {
        let mut run = Scenario::with_control()
            .limits(|limits| {
                limits.caps.topside_per_min = 2;
                limits.caps.packets_per_min = 2;
            })
            .vehicle(1000, "BFCMA,{t},000100.000,7,WHOIPSK");
        for index in 0..count {
            run = run.ours(2000 + index * 100, body);
        }
        run
    };
    for body in ["BPTOP,{t},3,text,0", PACKET] {
        run(5, body).finds_nothing();
        run(6, body).finds(&["requests-total"]);
    }
}

#[test]
fn requirement_002_the_vehicle_surfaces_only_where_a_zone_allows_it() {
    let hit = |longitude: &str| {
        let body = format!("BPRGP,{{t}},7,4200.300,N,{longitude},W,,,0");
        Scenario::with_control().ours(3000, &body)
    };
    hit("07000.900").finds_nothing();
    hit("07001.900").finds(&["request-surfacing"]);
}

#[test]
fn requirement_002_an_altitude_needs_a_known_seabed() {
    let at_altitude = |made_ms| {
        Scenario::with_control()
            .limits(|limits| limits.water_depth_known = false)
            .lock(4000, false)
            .ours(made_ms, "BPRMB,{t},90,20,1,1.5,1,0")
            .ours(made_ms + 10, END)
    };
    // The last lock is of 3.9 s, and 250 ms are for the link's delay.
    at_altitude(9100).finds_nothing();
    at_altitude(9200).finds(&["bottom-unknown"]);
    at_altitude(9200)
        .limits(|limits| limits.water_depth_known = true)
        .finds_nothing();
    let line = "BPRTK,{t},7,4200.300,N,07000.900,W,4200.300,N,07000.700,W,1,20,1.5,0,0";
    Scenario::with_control()
        .limits(|limits| limits.water_depth_known = false)
        .lock(0, false)
        .ours(3000, line)
        .finds(&["bottom-unknown"]);
    // The new connection has reported no bottom lock.
    Scenario::with_control()
        .limits(|limits| limits.water_depth_known = false)
        .reconnects(3500, 4000)
        .lock(3400, false)
        .ours(5000, line)
        .finds(&["bottom-unknown"]);
}

#[test]
fn requirement_019_the_number_of_log_lines_and_device_commands_a_second_is_limited() {
    let burst = |body: &str, count: u64| {
        (0..count).fold(
            Scenario::with_control().limits(|limits| {
                limits.caps.messages_per_s = 2;
                limits.caps.device_commands_per_s = 2;
            }),
            |run, index| run.ours(3000 + 100 * index, body),
        )
    };
    for body in ["BPMSG,{t},on the way", "BPLIT,{t},0,1"] {
        burst(body, 5).finds_nothing();
        burst(body, 6).finds(&["requests-total"]);
    }
}
