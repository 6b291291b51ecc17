//! A plugin whose requests lead across the fence: they are refused with a reason, and never sent.

use backseat_recorder::{Record, read};
use backseat_suite::{Backseat, Mission};

#[test]
fn what_crosses_the_fence_is_rejected_with_edge_and_metres_and_never_sent() {
    // 60 m from the northern edge's margin; the target is beyond it.
    let mission = Mission::steady()
        .edit("world.toml", "north_m = 0\ndepth_m", "north_m = 700\ndepth_m")
        .edit(
            "world.toml",
            "start = { east_m = -600, north_m = 0 }",
            "start = { east_m = -600, north_m = 700 }",
        )
        .edit(
            "world.toml",
            "end = { east_m = 600, north_m = 0 }",
            "end = { east_m = 600, north_m = 700 }",
        )
        .edit(
            "mission.toml",
            "[\"modify\"]",
            "[\"modify\", \"insert\", \"interrupt\"]",
        )
        .edit(
            "mission.toml",
            "fault = \"none\"",
            "fault = \"cross_fence\"\ntarget_east_m = 0\ntarget_north_m = 2000",
        );
    let path = mission.beside("run.mcap");
    let report = Backseat::new()
        .args(["sim", "--json", "--log"])
        .arg(&path)
        .mission(&mission)
        .run()
        .exit(0)
        .json();
    let rejections: Vec<&str> = report["rejections"]
        .as_array()
        .unwrap()
        .iter()
        .map(|text| text.as_str().unwrap())
        .collect();
    let of_the_fence = |text: &str| text.contains("box") && text.contains("edge") && text.contains(" m");
    assert!(rejections.iter().any(|text| of_the_fence(text)), "{rejections:#?}");
    assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");

    let log = read(&path).unwrap();
    let notes: Vec<&str> = log.notes().map(|(_, text)| text).collect();
    let rejected = |kind: &str| {
        let of = |note: &&&str| note.starts_with(kind) && note.contains("rejected: ") && of_the_fence(note);
        notes.iter().filter(of).count()
    };
    assert!(
        rejected("Trackline") > 100,
        "each of its tracklines is rejected: {}",
        rejected("Trackline")
    );
    assert!(
        rejected("Modify") > 10,
        "a modify towards the fence is rejected near it: {}",
        rejected("Modify")
    );
    assert!(
        notes.iter().any(|note| note.contains("says: the fence says")),
        "the plugin could have known by asking"
    );

    let sent: String = log
        .link()
        .filter(|(_, from, _)| !from)
        .map(|(_, _, bytes)| String::from_utf8_lossy(bytes))
        .collect();
    assert_eq!(
        sent.matches("$BPRTK").count() + sent.matches("$BPRTC").count(),
        0,
        "none has been sent"
    );
    let farthest = log.entries.iter().filter_map(|entry| {
        let Record::Truth(truth) = &entry.record else {
            return None;
        };
        truth["local"]["north_m"].as_f64()
    });
    let farthest = farthest.fold(f64::MIN, f64::max);
    assert!(
        (690.0..=780.0).contains(&farthest),
        "the vehicle stays inside of the margin: {farthest} m north"
    );
}
