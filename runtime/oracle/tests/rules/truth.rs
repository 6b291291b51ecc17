//! Requirement 002: what the vehicle truly did under our commands.

use backseat_oracle::Activity;

use crate::scenario::Scenario;

/// The vehicle flies an insert from 3 s to 8 s.
fn insert() -> Scenario {
    Scenario::with_control()
        .activity(3000, Activity::Insert(7))
        .activity(8000, Activity::Plan)
}

#[test]
fn requirement_002_the_vehicle_stays_in_the_fence_under_our_commands() {
    insert()
        .place(5000, 42.005, -70.021)
        .place(6000, 42.005, -70.019)
        .finds(&["truth-fence"]);
    insert()
        .place(5000, 42.011, -70.011)
        .place(6000, 42.005, -70.019)
        .finds(&["truth-fence"]);
    // The edge itself counts, not the margin.
    insert().place(5000, 42.005, -70.01999).finds_nothing();
    // One excursion is one violation, and a second one is another.
    insert()
        .place(4000, 42.005, -70.021)
        .place(5000, 42.005, -70.019)
        .place(6000, 42.005, -70.021)
        .place(7000, 42.005, -70.019)
        .finds(&["truth-fence", "truth-fence"]);
}

#[test]
fn requirement_002_the_plan_may_lead_anywhere() {
    Scenario::with_control()
        .place(5000, 42.005, -70.03)
        .depth(5000, 90.0)
        .altitude(5000, 0.0)
        .finds_nothing();
}

#[test]
fn requirement_002_we_answer_for_the_way_back_to_the_plan() {
    insert().place(10_000, 42.005, -70.021).finds(&["truth-fence"]);
    // This holds however long the way back takes, until the vehicle has been on its plan.
    let outcome = insert().place(40_000, 42.005, -70.021).run(50_000);
    let found: Vec<_> = outcome.violations.iter().map(|violation| violation.rule).collect();
    assert_eq!(found, ["truth-fence"]);
    let back = || insert().vehicle(60, "BFPLN,{t},1,,1,0,4200.300,N,07001.000,W,,,");
    let outcome = back().place(23_200, 42.005, -70.021).run(30_000);
    assert_eq!(outcome.violations, []);
    // What the vehicle does just after it has come back still counts as ours.
    back().place(15_000, 42.005, -70.021).finds(&["truth-fence"]);
    // Once the vehicle has taken control back, it may lead itself elsewhere.
    let taken = insert()
        .vehicle(8100, "BFCTL,{t},0")
        .place(23_200, 42.005, -70.021)
        .run(30_000);
    assert_eq!(taken.violations, []);
    // An abort is not our doing.
    insert()
        .activity(9000, Activity::Other)
        .place(10_000, 42.005, -70.021)
        .finds_nothing();
}

#[test]
fn requirement_002_a_plan_that_leads_out_of_the_fence_excuses_an_excursion() {
    let planned = |longitude: &str| {
        insert()
            .ours(500, "BPRMP,{t}")
            .vehicle(600, "BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,")
            .vehicle(601, &format!("BFPLN,{{t}},1,,1,2,4200.300,N,{longitude},W,,,"))
            .place(10_000, 42.005, -70.021)
    };
    planned("07001.500").finds_nothing();
    planned("07001.100").finds(&["truth-fence"]);
    // A newer plan replaces the old one.
    planned("07001.500")
        .ours(1000, "BPRMP,{t}")
        .vehicle(1100, "BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,")
        .finds(&["truth-fence"]);
}

#[test]
fn requirement_002_the_vehicle_keeps_to_the_depths_of_its_zone() {
    insert().depth(5000, 40.9).finds_nothing();
    insert().depth(5000, 41.1).depth(6000, 30.0).finds(&["truth-depth"]);
    insert().depth(5000, 0.9).finds(&["truth-depth"]);
    // Afterwards the plan may rise to any depth, but it must not go too deep.
    insert().depth(9000, 0.0).finds_nothing();
    insert().depth(9000, 42.0).finds(&["truth-depth"]);
}

#[test]
fn requirement_002_a_keep_out_zone_counts_only_at_its_depths() {
    let over = |metres| insert().place(5000, 42.003, -70.011).depth(4900, metres);
    over(20.0).finds_nothing();
    over(35.0).finds(&["truth-fence"]);
}

#[test]
fn requirement_002_the_vehicle_does_not_run_aground_under_our_commands() {
    insert().altitude(5000, 0.0).finds(&["truth-grounded"]);
    insert().altitude(5000, f64::NAN).finds(&["truth-grounded"]);
    insert().altitude(5000, 0.5).finds_nothing();
}

#[test]
fn requirement_002_an_excursion_within_the_error_of_navigation_is_no_violation() {
    // A minute of longitude is 1379.9 m here: 82.8 m beyond the edge.
    let beyond = || insert().place(5000, 42.005, -70.021).place(6000, 42.005, -70.019);
    beyond().error(4900, 85.0).finds_nothing();
    beyond().error(4900, 80.0).finds(&["truth-fence"]);
    // After the error is gone, the vehicle needs time to come back to the position that it believes.
    beyond().error(3500, 85.0).error(4000, 0.0).finds_nothing();
    beyond().error(500, 86.0).error(600, 0.0).finds_nothing();
    beyond().error(0, 82.9).error(100, 0.0).finds(&["truth-fence"]);
}

#[test]
fn requirement_002_under_an_insert_the_believed_position_keeps_the_margins() {
    // A minute of longitude is 1379.9 m here: 19.3 m and 17.9 m from the eastern edge, whose margin is 20 m.
    let believes = |place| insert().place(2900, 42.005, -70.0002).believes(2900, place);
    believes("4200.300,N,07000.0140,W").finds_nothing();
    believes("4200.300,N,07000.0130,W").finds(&["insert-margin"]);
    // 31 m and 28 m from the mooring, whose margin is 30 m. The mooring counts at all depths.
    let mooring = |place| insert().place(2900, 42.011, -70.012_34).believes(2900, place);
    mooring("4200.660,N,07000.7425,W").finds_nothing();
    mooring("4200.660,N,07000.7403,W").finds(&["insert-margin"]);
    // The wreck is deeper.
    insert()
        .place(2900, 42.003, -70.0125)
        .believes(2900, "4200.180,N,07000.7300,W")
        .finds_nothing();
    // This counts only under an insert, and as one violation. A larger error of navigation excuses it.
    Scenario::with_control()
        .place(2900, 42.005, -70.0002)
        .believes(2900, "4200.300,N,07000.0130,W")
        .finds_nothing();
    believes("4200.300,N,07000.0130,W").error(2900, 2.0).finds_nothing();
    believes("4200.300,N,07000.0130,W")
        .error(2900, 0.5)
        .finds(&["insert-margin"]);
    // Two flipped bits can put the latitude four degrees away and leave the checksum right.
    believes("4600.300,N,07000.0130,W").finds_nothing();
    // A position that is no longer sent does not count as believed.
    believes("4200.300,N,07000.0130,W")
        .navigation(2000, false)
        .finds_nothing();
}

#[test]
fn requirement_020_a_cancel_must_not_lead_out_of_the_fence() {
    let cancelled = |command: &str| {
        Scenario::with_control()
            .limits(|limits| limits.operator_commands = true)
            .vehicle(3000, &format!("BFACK,{{t}},{command},000001.000,0,2,0,done"))
            .place(10_000, 42.005, -70.021)
    };
    for command in ["RCB", "RCE", "RCA"] {
        cancelled(command).finds(&["truth-cancel"]);
    }
    // Once on its own plan again, the vehicle may go where the plan leads.
    cancelled("RCB")
        .ours(500, "BPRMP,{t}")
        .vehicle(600, "BFPLN,{t},1,,0,1,4200.300,N,07000.900,W,,,")
        .vehicle(601, "BFPLN,{t},1,,1,2,4200.300,N,07000.700,W,,,")
        .finds_nothing();
    cancelled("RCB").activity(9000, Activity::Other).finds_nothing();
    // A refused cancel changes nothing.
    Scenario::with_control()
        .vehicle(3000, "BFACK,{t},RCB,000001.000,0,1,0,no")
        .place(10_000, 42.005, -70.021)
        .finds_nothing();
}

#[test]
fn requirement_007_a_suspension_lapses_by_the_vehicles_clock() {
    let cut = || {
        Scenario::with_control()
            .ours(3000, "BPSUS,{t}")
            .activity(3100, Activity::Suspended)
            .ours(3500, "BPCON,{t}")
            .link(3600, false)
    };
    // 2.1 s and 200 ms of delay after the last refresh.
    cut().activity(5800, Activity::Plan).finds_nothing();
    cut().activity(6000, Activity::Plan).finds(&["station-outlives"]);
    Scenario::with_control()
        .activity(3000, Activity::Suspended)
        .activity(4000, Activity::Plan)
        .finds(&["station-outlives"]);
}
