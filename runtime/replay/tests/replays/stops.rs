//! Calls of plugins that a wall clock ended in the recorded run, and failures of plugins.

use std::cell::RefCell;

use backseat_core::plugin::PluginId;
use backseat_replay::Difference;
use backseat_test_support::workspace;

use crate::flight::{Flight, unchanged};

/// A plugin that fails by itself is restarted as it was: from its snapshot, with as many lost steps.
#[test]
fn a_plugin_that_traps_is_restarted_as_it_was() {
    let folder = crate::flight::copied(&workspace().join("tests/suite/missions/steady"));
    let file = folder.path().join("mission.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let bad = "[[plugin]]\nname = \"bad\"\ncomponent = \"faulty\"\ngrants = [\"modify\"]\n[plugin.config]\n\
               fault = \"trap\"\nafter_s = 30\n";
    std::fs::write(&file, format!("{text}\n{bad}")).unwrap();
    let report = Flight::of(folder.path()).seconds(300).log().replay();
    assert_eq!(report.identical, Some(true), "{:#?}", report.first_difference);
    let bad = report.plugins.iter().find(|plugin| plugin.name == "bad").unwrap();
    assert!(bad.failures >= 3 && bad.restarts >= 3, "{bad:?}");
}

/// Another plugin may stand in for one in a simulation. Its component is not in the log, but core's part is replayed, and
/// so is the plugin afterwards.
#[test]
fn a_plugin_for_which_another_stood_in_is_replayed_before_and_after() {
    let done = RefCell::new(0);
    let log = Flight::of(backseat_test_support::mission("isobath"))
        .seconds(300)
        .log_with(&mut |simulation| {
            let now = simulation.now().as_secs_f64();
            let mut done = done.borrow_mut();
            if *done == 0 && now > 100.0 {
                *done = 1;
                simulation.substitute(PluginId(0), Some(stand_in()));
            } else if *done == 1 && now > 150.0 {
                *done = 2;
                simulation.substitute(PluginId(0), None);
            }
        });
    let report = log.replay();
    assert_eq!(report.identical, Some(true), "{:#?}", report.first_difference);
    let plugin = &report.plugins[0];
    assert!(plugin.unplayed > 40 && plugin.steps > 300, "{plugin:?}");
}

fn stand_in() -> backseat_plugin_host::Plugin {
    use backseat_plugin_loader::Components;
    let layers = backseat_mission::Layers::default();
    let mission = backseat_mission::Mission::load(&backseat_test_support::mission("isobath"), &layers).unwrap();
    let host = crate::flight::host();
    let mut components = Components::new();
    components
        .insert(&host, "isobath", &crate::flight::given("isobath", "isobath").bytes)
        .unwrap();
    components
        .start_one("isobath", &mission.file.plugins[0], &mission)
        .unwrap()
}

/// A deployed run ends a step by its clock. The recorded return then has the fault `deadline` with the whole budget, and
/// the instance is lost. Here a log is changed as if that had happened in its last step: what comes after is left out.
#[test]
fn a_step_that_the_clock_ended_is_ended_again() {
    let log = Flight::of(backseat_test_support::mission("isobath")).seconds(120).log();
    let budget = 20_000_000;
    let stopped = |text: &str, fuel: u64| {
        let fault = format!(r#""result":"err","result_err":{{"kind":"deadline","text":"{text}"}}"#);
        format!(r#"{{"input":"returned","plugin":0,"returned":{{"fuel":{fuel},"log":[],{fault}}}}}"#)
    };
    for (text, fuel, same) in [
        ("ran past its deadline", budget, true),
        // Not the fault that a clock leaves.
        ("ran past its deadline", budget - 1, false),
    ] {
        let mut over = false;
        let report = log
            .replay_with(Vec::new(), backseat_replay::Configs::default(), &mut |mut message| {
                if over {
                    return Vec::new();
                }
                if message.now.as_secs_f64() > 60.0 && message.data.starts_with(br#"{"input":"returned""#) {
                    message.data = stopped(text, fuel).into_bytes();
                    over = true;
                }
                unchanged(message)
            })
            .unwrap();
        assert_eq!(report.stops_played, 1);
        let plugin = &report.plugins[0];
        assert_eq!(plugin.different == 0, same, "{plugin:#?}");
        if !same {
            assert!(
                matches!(&report.first_difference, Some(Difference::Step(step)) if step.differs == ["fuel"]),
                "{:#?}",
                report.first_difference
            );
        }
    }
}
