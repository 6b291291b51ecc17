//! A mission that is read again from what the log of its run has.

use std::fs;

use backseat_mission::{Layers, Mission, RecordedParts};

const MISSION: &str = "[limits]\nspeed_min_mps = 1.0\nspeed_max_mps = 2.0\nturn_rate_dps = 8.0\ncurrent_max_mps = 0.2\n\
                       [vehicle]\nname = \"nemo\"\ntrackcircle_entry_angle = true\n\
                       [session]\nhold_text = \"stop it\"\n[recovery]\noutside_for_s = 3.25\n\
                       [[policy]]\nwhen = \"plugin-quarantined\"\norder = \"hold\"\n\
                       [[plugin]]\nname = \"isobath\"\ncomponent = \"isobath\"\ngrants = [\"modify\"]\n\
                       [plugin.config]\ndeep = { er = 0.1 }\n";
const FENCE: &str = r#"{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "box", "kind": "keep-in", "margin_m": 10, "depth_max_m": 30,
        "altitude_min_m": 3, "surfacing": true},
     "geometry": {"type": "Polygon", "coordinates":
        [[[-70.0, 42.0], [-69.9, 42.0], [-69.9, 42.05], [-70.0, 42.05], [-70.0, 42.0]]]}},
    {"type": "Feature", "properties": {"name": "wreck", "kind": "keep-out", "margin_m": 0, "radius_m": 200},
     "geometry": {"type": "Point", "coordinates": [-69.95, 42.03]}}]}"#;
const PLAN: &str = "[origin]\nlatitude_deg = 42.02\nlongitude_deg = -69.97\n\n[[plan]]\nkind = \"waypoint\"\n\
                    at = { east_m = 0, north_m = 100 }\ndepth_m = 8\nspeed_mps = 1.5\n";

#[test]
fn a_mission_is_the_same_when_it_is_read_from_its_log() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("mission.toml", &format!("{MISSION}\n[plan]\nfile = \"dive.toml\"\n"));
    write("fence.geojson", FENCE);
    write("dive.toml", PLAN);
    let layers = Layers {
        set: vec!["limits.current_max_mps=0.3".to_owned()],
        environment: false,
    };
    let mission = Mission::load(folder.path(), &layers).unwrap();
    let fence = mission.other_fence().unwrap();
    assert_eq!(fence, ("fence.geojson", FENCE));
    let plan = mission.plan.as_ref().map(|plan| plan.text.as_str());
    let parts = RecordedParts {
        name: &mission.name,
        mission: &mission.resolved,
        fence,
        plan,
        set: &[],
    };
    let again = Mission::recorded(&parts).unwrap();
    assert_eq!(
        again.file, mission.file,
        "with everything that the other files add to it"
    );
    assert!(again.file.session.expected_plan.is_some());
    assert_eq!((&again.resolved, &again.name), (&mission.resolved, &mission.name));
    let points = |mission: &Mission| -> Vec<[u64; 2]> {
        let fence = mission.envelope.fence();
        let points = fence
            .zones()
            .flat_map(|zone| zone.rings().flat_map(|ring| ring.points.to_vec()));
        points
            .map(|point| [point.east_m.to_bits(), point.north_m.to_bits()])
            .collect()
    };
    assert_eq!(points(&again), points(&mission), "to the last bit");

    let error = Mission::recorded(&RecordedParts { plan: None, ..parts }).err().unwrap();
    assert!(error.to_string().contains("the log does not have this file"), "{error}");
    let set = ["plugin.isobath.config.deep.er=0.5".to_owned()];
    let other = Mission::recorded(&RecordedParts { set: &set, ..parts }).unwrap();
    assert_eq!(other.file.plugins[0].config["deep"]["er"].as_float(), Some(0.5));
}
