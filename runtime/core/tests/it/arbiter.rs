//! Several plugins beside each other: their priority, and each one's share of what the mission allows to all.

use std::time::Duration;

use backseat_core::plugin::Rule;
use backseat_core::plugin::{Event, Request, RequestState};
use backseat_core::{Limits, PluginLimits};

use crate::course::{good_line, limits, line, modify, modify_for};
use crate::trial::{Setup, Trial, shorts};

fn limited(of_first: PluginLimits) -> Trial {
    let mut setup = Setup::default();
    setup.plugins[0].limits = of_first;
    Trial::with_under_way(setup)
}

#[test]
fn sr_019_a_plugins_own_cap_on_inserts_does_not_limit_the_other_plugins() {
    let mut trial = limited(PluginLimits {
        inserts_open_max: Some(1),
        inserts_total_max: Some(2),
        ..PluginLimits::default()
    });
    trial.ask(0, [good_line(1), good_line(2)]);
    trial.ask(1, [good_line(3), good_line(4)]);
    trial.run_for(0.5);
    assert!(
        trial
            .rejection(2)
            .contains("cap: open inserts of the plugin is 2; expected at most 1")
    );
    for tag in [1, 3, 4] {
        assert_eq!(shorts(&trial.states(tag)), ["sent", "accepted"], "{tag}");
    }
    for tag in [5, 6] {
        trial.ask(0, [Request::Cancel(if tag == 5 { 1 } else { 5 })]);
        trial.run_for(0.3);
        trial.ask(0, [good_line(tag)]);
        trial.run_for(0.3);
    }
    assert_eq!(shorts(&trial.states(5)), ["sent", "accepted", "cancelled"]);
    assert!(
        trial
            .rejection(6)
            .contains("inserts of the plugin is 3; expected at most 2"),
        "{}",
        trial.rejection(6)
    );
    // A rejected request does not count.
    assert_eq!(trial.commands("RTK").len(), 4);
}

#[test]
fn sr_019_the_duration_of_a_plugins_own_inserts_is_capped() {
    let mut trial = limited(PluginLimits {
        inserts_duration_max_s: Some(1500.0),
        ..PluginLimits::default()
    });
    let long = |tag| Request::Trackline(line(tag, (-300.0, 500.0), (600.0, 500.0)));
    trial.ask(0, [long(1), long(2)]);
    trial.ask(1, [long(3)]);
    trial.run_for(0.5);
    assert_eq!(
        shorts(&trial.states(1)),
        ["rejected"],
        "900 m and the way there take over 1500 s at 1.2 m/s"
    );
    assert!(trial.rejection(2).contains("(plugin.limits.inserts_duration_max_s)"));
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"]);
}

#[test]
fn sr_019_a_plugins_steering_time_is_capped_and_only_used_time_counts() {
    let mut trial = limited(PluginLimits {
        steering_max_s: Some(60.0),
        ..PluginLimits::default()
    });
    trial.ask(0, [modify_for(1, Duration::from_secs(61))]);
    trial.run_for(0.2);
    assert_eq!(shorts(&trial.states(1)), ["rejected"]);
    // The plugin asks for thirty seconds, renews after ten and ends after twenty: it has used twenty.
    trial.ask(0, [modify_for(2, Duration::from_secs(30))]);
    trial.run_for(10.0);
    trial.ask(0, [modify_for(2, Duration::from_secs(30))]);
    trial.run_for(10.0);
    trial.ask(0, [Request::EndModify]);
    trial.run_for(5.0);
    trial.ask(0, [modify_for(3, Duration::from_secs(45))]);
    trial.run_for(0.3);
    assert!(
        trial
            .rejection(3)
            .starts_with("cap: time that the plugin steers is 65; expected at most 60 s"),
        "{}",
        trial.rejection(3)
    );
    trial.ask(0, [modify_for(4, Duration::from_secs(35))]);
    trial.run_for(36.0);
    assert_eq!(shorts(&trial.states(4)), ["sent", "accepted", "ended"]);
    // The first plugin has no time left; the second one has its own.
    trial.ask(0, [modify_for(5, Duration::from_secs(10))]);
    trial.ask(1, [modify_for(6, Duration::from_secs(60))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(5)), ["rejected"]);
    assert_eq!(shorts(&trial.states(6)), ["sent", "accepted"]);
}

#[test]
fn sr_019_steering_time_also_counts_if_another_plugin_takes_over() {
    let mut setup = Setup::default();
    setup.plugins[1].limits.steering_max_s = Some(40.0);
    let mut trial = Trial::with_under_way(setup);
    trial.ask(1, [modify_for(1, Duration::from_secs(30))]);
    trial.run_for(15.0);
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(1.0);
    trial.ask(0, [Request::EndModify]);
    trial.run_for(1.0);
    trial.ask(1, [modify_for(3, Duration::from_secs(30))]);
    trial.run_for(0.3);
    assert!(
        trial
            .rejection(3)
            .starts_with("cap: time that the plugin steers is 45; expected at most 40 s"),
        "{}",
        trial.rejection(3)
    );
}

#[test]
fn sr_019_the_lower_of_the_missions_and_the_plugins_own_rate_applies() {
    let rejected = |own: Option<u32>| {
        let mut trial = limited(PluginLimits {
            requests_per_s: own,
            ..PluginLimits::default()
        });
        // These cancel unknown tags: while the rate allows it, each is taken and rejected for its own reason.
        trial.ask(0, (0..30).map(|tag| Request::Cancel(tag + 100)));
        trial.run_for(0.3);
        // The log has only a count of these; the plugin learns each one.
        let over = |event: &&Event| match event {
            Event::Outcome {
                state: RequestState::Rejected(refusal),
                ..
            } => refusal.rule() == Rule::Rate,
            _ => false,
        };
        trial.events(0).iter().filter(over).count()
    };
    assert_eq!((rejected(None), rejected(Some(5)), rejected(Some(500))), (10, 25, 10));
}

#[test]
fn sr_006_sr_019_the_refused_requests_of_a_flooding_plugin_cost_the_others_nothing() {
    let setup = Setup {
        limits: Limits {
            inserts_total_max: 3,
            ..limits()
        },
        ..Setup::default()
    };
    let mut trial = Trial::with_under_way(setup);
    // In each step the first plugin asks for a thousand lines that leave the box.
    trial.script(0, |_| {
        let bad = (0..1000).map(|tag| Request::Trackline(line(1000 + tag, (0.0, 0.0), (9000.0, 0.0))));
        (Duration::from_millis(1), Ok(bad.collect()))
    });
    trial.run_for(5.0);
    trial.ask(
        1,
        [good_line(1), good_line(2), good_line(3), Request::Modify(modify(4))],
    );
    trial.run_for(10.0);
    for tag in 1..=4 {
        assert!(
            shorts(&trial.states(tag)).starts_with(&["sent", "accepted"]),
            "{tag}: {:?}",
            trial.states(tag)
        );
    }
    let sent = trial.sent("RMB");
    assert!(
        sent.windows(2)
            .all(|pair| pair[1].since(pair[0]) == Duration::from_secs(1))
    );
    assert!(trial.lease_ends().is_empty());
}
