use backseat_test_support::{mission, workspace};

use crate::flight::Flight;

#[test]
fn simulated_runs_are_replayed_to_the_same_bytes() {
    let hovering = workspace().join("tests/suite/missions/hovering");
    for (folder, seconds) in [
        (mission("isobath"), 900),
        (mission("plume"), 3000),
        (mission("template"), 600),
        // With the sonars.
        (mission("coverage"), 600),
        (mission("reinspect"), 400),
        (hovering, 600),
    ] {
        let report = Flight::of(&folder).seed(3).seconds(seconds).log().replay();
        assert_eq!(
            report.identical,
            Some(true),
            "{}: {:#?}",
            folder.display(),
            report.first_difference
        );
        assert_eq!(report.first_difference, None);
        assert!(report.inputs > 1000 && report.outputs > 100, "{}", folder.display());
        for plugin in &report.plugins {
            assert!(plugin.steps > 100 && plugin.different == 0, "{plugin:?}");
            assert!(!plugin.component.other && plugin.component.file.is_none());
        }
        assert!(report.drawing.track.len() > 300, "{}", report.drawing.track.len());
    }
}

#[test]
fn the_log_of_an_earlier_version_is_replayed_as_well() {
    let log = Flight::of(mission("isobath")).seconds(300).of_earlier_version().log();
    assert_eq!(log.reader().description("isobath"), None);
    let report = log.replay();
    assert_eq!(report.identical, Some(true), "{:#?}", report.first_difference);
}

#[test]
fn a_log_that_was_cut_is_replayed_as_far_as_it_goes() {
    let mut log = Flight::of(mission("isobath")).seconds(600).log();
    let whole = log.replay();
    log.0.truncate(log.0.len() / 2);
    let report = log.replay();
    assert!(!report.complete && report.seconds < whole.seconds && report.outputs > 100);
    assert_eq!(report.identical, Some(true), "{:#?}", report.first_difference);
    assert!(report.lines()[0].contains("cut short"), "{:?}", report.lines());
}
