use backseat_core::plugin::Request;
use backseat_mvc::Activity;
use backseat_pair::{Dive, Setup, circle, line, modify};

#[test]
fn a_modify_is_flown_and_ends_at_its_term() {
    let mut dive = Dive::under_way(Setup::default());
    dive.ask(Request::Modify(modify(1, 45.0, 20)));
    dive.run_for(15.0);
    let truth = dive.mvc.truth();
    assert!(
        matches!(truth.activity, Activity::Modified { number: Some(1), .. }),
        "{truth:?}"
    );
    assert!((truth.heading_deg - 45.0).abs() < 5.0, "{truth:?}");
    dive.run_for(10.0);
    assert_eq!(dive.states(1), ["sent", "accepted", "ended"]);
    assert_eq!(dive.mvc.truth().activity, Activity::Plan { number: 1 });
    assert_eq!(dive.count("$BPEMB"), 1);
}

#[test]
fn a_modify_lapses_five_seconds_after_the_link_was_cut() {
    let mut dive = Dive::under_way(Setup::default());
    dive.ask(Request::Modify(modify(1, 45.0, 60)));
    dive.run_for(10.0);
    dive.unreachable = true;
    dive.cut();
    let last = dive
        .sent
        .iter()
        .rfind(|(_, line)| line.starts_with("$BPRMB"))
        .unwrap()
        .0;
    dive.run_for(3.0);
    assert!(matches!(dive.mvc.truth().activity, Activity::Modified { .. }));
    dive.run_for(3.0);
    let lapsed = dive
        .log
        .iter()
        .find(|event| event.to_string().contains("modify ended"))
        .unwrap();
    let since = lapsed.at.since(last).as_secs_f64();
    assert!((4.99..=5.02).contains(&since), "{since}");
    assert_eq!(dive.states(1).last(), Some(&"ended"));
}

#[test]
fn inserts_are_flown_to_their_end() {
    let mut dive = Dive::under_way(Setup::default());
    dive.ask(Request::Trackline(line(1, (-500.0, 100.0), (-400.0, 100.0), true)));
    dive.ask(Request::Trackcircle(circle(2, (-300.0, 100.0), 40.0)));
    assert!(
        dive.run_until(900.0, |dive| dive.states(1).last() == Some(&"ended")),
        "{:?}",
        dive.states(1)
    );
    assert_eq!(dive.states(1), ["sent", "pending", "accepted", "started", "ended"]);
    // It would have interrupted an insert that interrupts.
    assert_eq!(dive.states(2), ["rejected"]);
    assert_eq!(dive.core.open_requests(), 0);
}

#[test]
fn an_insert_in_doubt_after_a_cut_is_settled_by_the_vehicles_plan() {
    let mut dive = Dive::under_way(Setup::default());
    dive.ask(Request::Trackline(line(1, (-300.0, 100.0), (-200.0, 100.0), false)));
    assert!(dive.run_until(2.0, |dive| dive.states(1) == ["sent"]));
    dive.run_for(0.006);
    dive.cut();
    dive.run_for(30.0);
    assert!(dive.states(1).starts_with(&["sent", "unknown"]), "{:?}", dive.states(1));
    assert_eq!(dive.count("$BPRTK"), 1);
}
