//! Other plugins on the inputs of a recorded run.

use backseat_replay::{Config, Configs, Difference, ReplayError};
use backseat_test_support::mission;

use crate::flight::{Flight, given, unchanged};

#[test]
fn the_same_component_from_a_file_is_the_one_that_flew() {
    let log = Flight::of(mission("isobath")).seconds(300).log();
    let report = log
        .replay_with(vec![given("isobath", "isobath")], Configs::default(), &mut unchanged)
        .unwrap();
    assert_eq!(report.identical, Some(true));
    let component = &report.plugins[0].component;
    assert!(!component.other && component.sha256 == component.recorded_sha256);
}

#[test]
fn another_config_parts_where_it_first_asks_for_something_else() {
    let log = Flight::of(mission("isobath")).seconds(600).log();
    let configs = Configs {
        set: &["plugin.isobath.config.contour_m=31.0".to_owned()],
        whole: &[],
    };
    let report = log.replay_with(Vec::new(), configs, &mut unchanged).unwrap();
    assert_eq!(report.identical, Some(false));
    assert_eq!(
        report.outputs_different, 0,
        "core is replayed from the recorded returns"
    );
    let plugin = &report.plugins[0];
    assert!(plugin.component.other && plugin.component.config_changed);
    assert!(plugin.different > 100 && plugin.different < plugin.steps, "{plugin:?}");
    assert_eq!(plugin.different_steps.len(), 3);
    let Some(Difference::Step(first)) = &report.first_difference else {
        panic!("{:#?}", report.first_difference);
    };
    assert_eq!(first, &plugin.different_steps[0]);
    assert_eq!(first.differs, ["requests"]);
    assert!(
        first.changes.iter().any(|change| change.contains("heading_deg")),
        "{first:#?}"
    );
    assert!(first.judgement.iter().any(|line| line.contains("sent")), "{first:#?}");
    assert!(
        first.monitor.iter().any(|line| line.contains("clearance")),
        "{first:#?}"
    );
    assert!(!report.drawing.recorded.is_empty() && !report.drawing.now.is_empty());
    let text = report.lines().join("\n");
    for part in [
        "first difference: at ",
        "it knew: ",
        "recorded: modify ",
        "now: modify ",
        "not identical",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// A config of the template.
const OF_TEMPLATE: &str = "heading_deg = 90.0\ndepth_m = 8.0\nspeed_mps = 1.5\n";

fn config(text: &str) -> [Config; 1] {
    [Config {
        plugin: "isobath".to_owned(),
        file: "other.toml".to_owned(),
        text: text.to_owned(),
    }]
}

#[test]
fn another_plugin_with_its_own_config_is_compared_by_what_it_asks_for() {
    let log = Flight::of(mission("isobath")).seconds(300).log();
    let configs = Configs {
        set: &[],
        whole: &config(OF_TEMPLATE),
    };
    let report = log
        .replay_with(vec![given("isobath", "template")], configs, &mut unchanged)
        .unwrap();
    assert_eq!((report.identical, report.outputs_different), (Some(false), 0));
    let plugin = &report.plugins[0];
    assert!(
        plugin.component.other && plugin.different > 0 && plugin.requests_now > 0,
        "{plugin:?}"
    );
    assert!(plugin.different_steps.iter().all(|step| step.differs == ["requests"]));
    // Without the config it does not start, and that is one line.
    let error = log.replay_with(vec![given("isobath", "template")], Configs::default(), &mut unchanged);
    let text = error.err().unwrap().to_string();
    assert!(
        text.contains("template.wasm") && text.contains("cannot be started"),
        "{text}"
    );
}

/// A plugin that fails in each step goes on, and its failures are counted.
#[test]
fn another_plugin_that_fails_is_a_difference() {
    let log = Flight::of(mission("isobath")).seconds(200).log();
    let configs = Configs {
        set: &[],
        whole: &config("fault = \"trap\"\n"),
    };
    let report = log
        .replay_with(vec![given("isobath", "faulty")], configs, &mut unchanged)
        .unwrap();
    let plugin = &report.plugins[0];
    assert!(
        plugin.failures > 100 && plugin.different >= plugin.failures,
        "{plugin:?}"
    );
    assert!(plugin.different_steps[0].differs.contains(&"fault"));
}

#[test]
fn what_does_not_fit_the_run_is_refused() {
    let log = Flight::of(mission("isobath")).seconds(60).log();
    let refused = |given, set: &[String]| {
        let configs = Configs { set, whole: &[] };
        log.replay_with(given, configs, &mut unchanged)
            .err()
            .unwrap()
            .to_string()
    };
    let text = refused(vec![given("plume", "plume")], &[]);
    assert!(
        text.contains("the run had no plugin of this name; it had isobath"),
        "{text}"
    );
    let text = refused(vec![given("isobath", "isobath"), given("isobath", "isobath")], &[]);
    assert!(text.contains("given twice"), "{text}");
    for set in ["limits.speed_max_mps=1.0", "plugin.isobath.grants=[]"] {
        let text = refused(Vec::new(), &[set.to_owned()]);
        assert!(text.contains("expected plugin.NAME.config.KEY=VALUE"), "{text}");
    }
    let mut bad = given("isobath", "isobath");
    bad.bytes.truncate(100);
    let text = refused(vec![bad], &[]);
    assert!(
        text.contains("isobath.wasm") && text.contains("not a valid component"),
        "{text}"
    );
}

/// A component over 8 MiB is in the log by its hash alone.
#[test]
fn a_component_by_its_hash_alone_must_be_given() {
    let mut log = Flight::of(mission("isobath")).seconds(120).log();
    log.edit_attachment("components/isobath.wasm", |_| None);
    let error = log
        .replay_with(Vec::new(), Configs::default(), &mut unchanged)
        .err()
        .unwrap();
    assert!(matches!(error, ReplayError::ByHashAlone { .. }), "{error}");
    assert!(error.to_string().contains("--component FILE (SHA-256 "), "{error}");
    // The one that flew, and another one.
    let flown = log.replay_with(vec![given("isobath", "isobath")], Configs::default(), &mut unchanged);
    assert_eq!(flown.unwrap().identical, Some(true));
    let template = Configs {
        set: &[],
        whole: &config(OF_TEMPLATE),
    };
    let other = log.replay_with(vec![given("isobath", "template")], template, &mut unchanged);
    assert_eq!(other.unwrap().outputs_different, 0);

    // Without a description, core cannot know what the one that flew listened to.
    let mut log = Flight::of(mission("isobath")).seconds(120).of_earlier_version().log();
    log.edit_attachment("components/isobath.wasm", |_| None);
    let other = log.replay_with(vec![given("isobath", "template")], template, &mut unchanged);
    assert!(matches!(other, Err(ReplayError::Undescribed { .. })));
    let flown = log.replay_with(vec![given("isobath", "isobath")], Configs::default(), &mut unchanged);
    assert_eq!(flown.unwrap().identical, Some(true));
}
