//! Former keys of a mission.
#![expect(clippy::unwrap_used, reason = "a failed unwrap in a test shows where")]

use backseat_mission::{Layers, Mission};

const MISSION: &str = "
[limits]
speed_min_mps = 1.0
speed_max_mps = 2.0
turn_rate_dps = 8.0
current_max_mps = 0.3
";

fn fault(mission: &str, set: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.toml"), mission).unwrap();
    let layers = Layers {
        set: set.iter().map(|set| (*set).to_owned()).collect(),
        environment: false,
    };
    Mission::load(folder.path(), &layers).err().unwrap().to_string()
}

#[test]
fn a_former_key_is_refused_with_its_present_name() {
    for (old, new) in [
        (
            "[[driver]]\nname = \"usbl\"\nsends = [\"BPNPU\"]",
            "`driver` is called `external` now",
        ),
        ("[limits.hull]\nspeed_max_mps = 0.5", "`hull` is called `station` now"),
        (
            "[limits.station]\nspeed_max_mps = 0.5\nhold_term_max_s = 30.0",
            "`hold_term_max_s` is called `term_max_s` now",
        ),
        (
            "[[plugin]]\nname = \"a\"\ncomponent = \"a\"\ngrants = [\"hull\"]",
            "`hull` is called `station` now",
        ),
    ] {
        let error = fault(&format!("{MISSION}\n{old}\n"), &[]);
        assert!(error.contains("mission.toml:") && error.contains(new), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
    let error = fault(MISSION, &["limits.hull.speed_max_mps=0.5"]);
    let new = "`hull` is called `station` now";
    assert!(error.contains("--set limits.hull") && error.contains(new), "{error}");
}
