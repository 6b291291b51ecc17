//! A plugin with many requests at the edge of what is allowed: nothing unsafe is sent.

use backseat_suite::{Backseat, Mission};

const CONFIG: &str = "east_min_m = -1600.0\neast_max_m = 1600.0\nnorth_min_m = -900.0\nnorth_max_m = 900.0\n\
    depth_m = [4.0, 30.0]\naltitude_m = [8.0, 25.0]\nspeed_mps = [1.0, 2.0]";

/// This plugin alone, over ground that is as flat as the mission's limits say.
fn restless(seed: u64) -> Mission {
    Mission::steady()
        .edit(
            "world.toml",
            "[seabed]\ndepth_m = 50",
            "[seabed]\ndepth_m = 50\nslope = 0.0\nmeander_slope = 0.0",
        )
        .edit("mission.toml", "component = \"faulty\"", "component = \"prober\"")
        .edit(
            "mission.toml",
            "[\"modify\"]",
            "[\"modify\", \"insert\", \"interrupt\", \"message\", \"topside\", \"dvl\", \"silent\", \"trim\", \"acoustic\"]",
        )
        .edit("mission.toml", "[vehicle]", "[vehicle]\ntrackcircle_entry_angle = true")
        .cut("mission.toml", "fault = \"none\"")
        .append("mission.toml", &format!("seed = {seed}\n{CONFIG}"))
}

#[test]
fn what_a_restless_plugin_asks_for_is_flown_or_rejected_and_nothing_unsafe_is_sent() {
    for seed in 1..=4 {
        let report = Backseat::new()
            .args(["sim", "--json", "--seed", &seed.to_string()])
            .mission(&restless(seed))
            .run()
            .exit(0)
            .json();
        assert_eq!(report["violations"].as_array().map(Vec::len), Some(0), "{report}");
        let failures = report["plugin_failures"].as_object().map(serde_json::Map::len);
        assert_eq!(failures, Some(0), "{report}");
        let seen = |key: &str| report["seen"][key].as_u64().unwrap();
        assert!(
            seen("leases") >= 1 && seen("inserts_accepted") >= 1,
            "seed {seed}: {report}"
        );
        // By the fence, by a limit, and by a wrong time.
        let rejections = report["rejections"].to_string();
        for rule in ["keep-in: ", "limit: ", "window: "] {
            assert!(rejections.contains(rule), "seed {seed}, no {rule}: {rejections}");
        }
    }
}
