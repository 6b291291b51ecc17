use std::path::Path;

use backseat_core::Recovery;

use super::*;

const MISSION: &str = r#"
[limits]
speed_min_mps = 1.0
speed_max_mps = 2.0
turn_rate_dps = 8.0
current_max_mps = 0.3

[[plugin]]
name = "isobath"
component = "isobath"
grants = ["modify"]
config = { contour_m = 30.0 }
"#;
const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3},"geometry":{"type":"Polygon","coordinates":[[[-70.9,42.3],[-70.89,42.3],[-70.89,42.31],[-70.9,42.31],[-70.9,42.3]]]}}]}"#;

fn folder(mission: &str, fence: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.toml"), mission).unwrap();
    std::fs::write(folder.path().join("fence.geojson"), fence).unwrap();
    folder
}

fn load(mission: &str, fence: &str, set: &[&str]) -> Result<Mission, MissionError> {
    let folder = folder(mission, fence);
    let layers = Layers {
        set: set.iter().map(|set| (*set).to_owned()).collect(),
        environment: false,
    };
    Mission::load(folder.path(), &layers)
}

fn fault(mission: &str, set: &[&str]) -> String {
    let message = load(mission, FENCE, set).err().expect("a fault").to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

#[test]
fn flags_lie_over_the_file() {
    let mission = load(
        MISSION,
        FENCE,
        &["limits.speed_max_mps=1.8", "vehicle.address=10.0.0.1:29500"],
    )
    .unwrap();
    assert_eq!(mission.file.limits.speed_max_mps, 1.8);
    assert_eq!(mission.file.vehicle.address, "10.0.0.1:29500");
    assert_eq!(mission.file.plugins[0].config["contour_m"].as_float(), Some(30.0));
    assert!(
        mission.resolved.contains("navigation_age_max_s = 1.0"),
        "defaults are in the resolved mission"
    );
    assert_eq!(mission.hash().len(), 64);
}

#[test]
fn faults_name_file_line_and_what_was_expected() {
    let unknown = fault(&MISSION.replace("turn_rate_dps", "turn_rate"), &[]);
    assert!(
        unknown.contains("mission.toml:5: unknown field `turn_rate`: did you mean `turn_rate_dps`?"),
        "{unknown}"
    );
    let wrong = fault(&MISSION.replace("= 2.0", "= \"fast\""), &[]);
    assert!(
        wrong.contains("mission.toml:4:") && wrong.contains("expected a number"),
        "{wrong}"
    );
    let range = fault(&MISSION.replace("= 2.0", "= 0.5"), &[]);
    assert!(
        range.contains("limits.speed_max_mps is 0.5: expected at least speed_min_mps"),
        "{range}"
    );
    let flag = fault(MISSION, &["limits.speed=1"]);
    assert!(
        flag.contains("--set limits.speed=1") && flag.contains("unknown field"),
        "{flag}"
    );
    let world = fault(MISSION, &["current.speed_mps=0.3"]);
    assert!(
        world.ends_with("; a key of world.toml begins with `world.`: world.current.speed_mps=0.3"),
        "{world}"
    );
    assert!(fault(MISSION, &["nonsense"]).contains("expected KEY=VALUE"));
    let twice = fault(
        &format!("{MISSION}\n[[plugin]]\nname = \"isobath\"\ncomponent = \"x\"\ngrants = []\n"),
        &[],
    );
    assert!(twice.contains("not used twice"), "{twice}");
}

const POLICIES: &str = r#"
[[policy]]
when = { mission-command = "payload abort" }
order = { abort = { text = "the plan says so" } }

[[policy]]
when = "plugin-quarantined"
order = "hold"

[[policy]]
when = { navigation-stale-for-s = 60.0 }
order = { abort = { text = "blind", errors = false } }

[[policy]]
when = { topside-message = "start over" }
order = { start-empty-mission = { duration_s = 600 } }
"#;

#[test]
fn policies_are_read_in_order_and_are_the_sessions() {
    for set in [&[][..], &["limits.speed_max_mps=1.8"][..]] {
        let mission = load(&format!("{MISSION}{POLICIES}"), FENCE, set).unwrap();
        let policies = &mission.file.session.policies;
        assert_eq!(policies, &mission.file.policies);
        let expected = [
            (
                Condition::MissionCommand("payload abort".to_owned()),
                Order::Abort {
                    text: "the plan says so".to_owned(),
                    errors: true,
                },
            ),
            (Condition::PluginQuarantined, Order::Hold),
            (
                Condition::NavigationStaleForS(60.0),
                Order::Abort {
                    text: "blind".to_owned(),
                    errors: false,
                },
            ),
            (
                Condition::TopsideMessage("start over".to_owned()),
                Order::StartEmptyMission { duration_s: 600 },
            ),
        ]
        .map(|(when, order)| Policy { when, order });
        assert_eq!(policies[..], expected);
        // The resolved mission, which is hashed and logged, holds the policies and parses to the same value.
        let again = load(&mission.resolved, FENCE, &[]).unwrap();
        assert_eq!(again.file, mission.file);
    }
    assert!(load(MISSION, FENCE, &[]).unwrap().file.session.policies.is_empty());
}

#[test]
fn a_policy_that_makes_no_sense_is_named() {
    let with = |when: &str, order: &str| {
        fault(
            &format!("{MISSION}{POLICIES}\n[[policy]]\nwhen = {when}\norder = {order}\n"),
            &[],
        )
    };
    for (when, order, said) in [
        (
            r#"{ mission-command = "" }"#,
            r#""hold""#,
            "policy 5: when.mission-command is \"\"",
        ),
        (
            r#"{ topside-message = "a,b" }"#,
            r#""hold""#,
            "policy 5: when.topside-message is \"a,b\"",
        ),
        (
            r#"{ mission-command = " x" }"#,
            r#""hold""#,
            "leading or trailing spaces",
        ),
        (
            "{ navigation-stale-for-s = 0.0 }",
            r#""hold""#,
            "navigation-stale-for-s is 0",
        ),
        (
            "{ navigation-stale-for-s = nan }",
            r#""hold""#,
            "navigation-stale-for-s is NaN",
        ),
        (
            r#""plugin-quarantined""#,
            r#"{ abort = { text = "*" } }"#,
            "order.abort.text is \"*\"",
        ),
        (
            r#""plugin-quarantined""#,
            r#"{ kill = { text = "" } }"#,
            "order.kill.text is \"\"",
        ),
        (
            r#""plugin-quarantined""#,
            "{ start-empty-mission = { duration_s = 0 } }",
            "duration_s is 0",
        ),
        (r#""plugin-quarantined""#, r#""sink""#, "unknown variant `sink`"),
        (r#""plugin-gone""#, r#""hold""#, "unknown variant `plugin-gone`"),
        (
            r#""plugin-quarantined""#,
            r#"{ abort = { text = "x", why = 1 } }"#,
            "unexpected keys in table: why",
        ),
    ] {
        let message = with(when, order);
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn recovery_and_the_operators_texts_are_the_sessions_and_what_makes_no_sense_is_named() {
    assert_eq!(
        load(MISSION, FENCE, &[]).unwrap().file.session.recovery,
        Recovery::default()
    );
    let with = |tables: &str| format!("[session]\n{tables}\n{MISSION}");
    let whole = with(
        "hold_text = \"backseat hold\"\nrelease_text = \"backseat go\"\n[recovery]\ncancel_after_s = 3.0\nabort_after_s = 30.0",
    );
    let mission = load(&whole, FENCE, &[]).unwrap();
    let Settings {
        hold_text,
        release_text,
        recovery,
        ..
    } = &mission.file.session;
    assert_eq!(hold_text.as_deref(), Some("backseat hold"));
    assert_eq!(release_text.as_deref(), Some("backseat go"));
    assert_eq!((recovery.cancel_after_s, recovery.abort_after_s), (3.0, Some(30.0)));
    assert_eq!(recovery, &mission.file.recovery);
    // The resolved mission, which is hashed and logged, holds the texts and parses to the same value.
    assert_eq!(load(&mission.resolved, FENCE, &[]).unwrap().file, mission.file);
    for (tables, said) in [
        ("[recovery]\nouside_for_s = 1.0", "unknown field `ouside_for_s`"),
        (
            "[recovery]\ncancel_after_s = 1.0",
            "recovery.cancel_after_s is 1: expected at least outside_for_s",
        ),
        (
            "[recovery]\nback_by_m = nan",
            "recovery.back_by_m is NaN: expected within 0 to 1000 m",
        ),
        ("hold_text = \"\"", "session.hold_text is \"\": expected 1 to"),
        ("release_text = \"a,b\"", "session.release_text is \"a,b\""),
        (
            "hold_text = \"x\"\nrelease_text = \"x\"",
            "session.release_text equals session.hold_text",
        ),
        (
            "hold_text = \"x\"\n[[policy]]\nwhen = { mission-command = \"x\" }\norder = \"release\"",
            "policy 1 would release on the same condition on which session.hold_text would hold",
        ),
        (
            "[[policy]]\nwhen = \"plugin-quarantined\"\norder = \"hold\"\n\
             [[policy]]\nwhen = \"plugin-quarantined\"\norder = \"release\"",
            "policy 2 would release on the same condition on which policy 1 would hold",
        ),
    ] {
        let message = fault(&with(tables), &[]);
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn the_limits_of_a_plugin_stand_beside_its_grants() {
    let with = |table: &str| format!("{MISSION}\n[plugin.limits]\n{table}\n");
    let mission = load(&with("inserts_open_max = 1\nsteering_max_s = 600.0"), FENCE, &[]).unwrap();
    let limits = &mission.file.plugins[0].limits;
    assert_eq!((limits.inserts_open_max, limits.steering_max_s), (Some(1), Some(600.0)));
    assert_eq!(load(&mission.resolved, FENCE, &[]).unwrap().file, mission.file);
    for (table, said) in [
        ("inserts = 1", "unknown field `inserts`"),
        (
            "requests_per_s = 0",
            "plugin `isobath`: limits.requests_per_s is 0: expected at least 1",
        ),
        ("steering_max_s = -1.0", "plugin `isobath`: limits.steering_max_s is -1"),
    ] {
        let message = fault(&with(table), &[]);
        assert!(message.contains(said), "{message}");
    }
}

const EXTERNALS: &str = r#"
[[external]]
name = "usbl"
sends = ["BPNPU"]

[external.bounds]
fix_distance_max_m = 200.0

[[external]]
name = "pod"
sends = ["BPCTD", "BPTMR"]
listen = "127.0.0.1:29511"
bounds = { rate_max_hz = 10.0, conductivity_out = "S/m" }
"#;

#[test]
fn external_sources_are_read_and_are_the_sessions() {
    let mission = load(&format!("{MISSION}{EXTERNALS}"), FENCE, &[]).unwrap();
    let externals = &mission.file.externals;
    assert_eq!(externals[0].listen, "127.0.0.1:29510");
    assert_eq!(externals[0].bounds.fix_distance_max_m, 200.0);
    assert_eq!(
        (externals[0].bounds.rate_max_hz, externals[0].bounds.fix_force),
        (2.0, false)
    );
    assert_eq!(
        externals[1].sends,
        [
            backseat_core::ExternalSentence::PayloadCtd,
            backseat_core::ExternalSentence::Relay
        ]
    );
    let setups: Vec<_> = externals.iter().map(ExternalTable::setup).collect();
    assert_eq!(mission.file.session.externals, setups);
    // The resolved mission, which is hashed and logged, holds the sources and parses to the same value.
    assert!(mission.resolved.contains("conductivity_out = \"S/m\""));
    assert_eq!(load(&mission.resolved, FENCE, &[]).unwrap().file, mission.file);
}

#[test]
fn an_external_source_that_makes_no_sense_is_named() {
    let with = |from: &str, to: &str| {
        let externals = EXTERNALS.replace(from, to);
        assert_ne!(externals, EXTERNALS);
        fault(&format!("{MISSION}{externals}"), &[])
    };
    for (from, to, said) in [
        (
            "\"pod\"",
            "\"usbl\"",
            "external source name `usbl`: expected one that is not empty and not used twice",
        ),
        ("\"pod\"", "\"\"", "external source name ``"),
        (
            "[\"BPNPU\"]",
            "[]",
            "external source `usbl`: sends needs at least one sentence",
        ),
        (
            "\"BPTMR\"]",
            "\"BPCTD\"]",
            "external source `pod`: sends needs at least one sentence, and each only once",
        ),
        ("\"BPTMR\"]", "\"BPABT\"]", "unknown variant `BPABT`, expected one of"),
        ("127.0.0.1:29511", "", "external source `pod`: listen is \"\""),
        ("127.0.0.1:29511", "127.0.0.1:0", "expected an IP address and a port"),
        (
            "127.0.0.1:29511",
            "127.0.0.1:29510",
            "which another external source uses already",
        ),
        (
            "= 200.0",
            "= nan",
            "external source `usbl`: bounds.fix_distance_max_m is NaN: expected above 0",
        ),
        ("rate_max_hz = 10.0", "rate_max_hz = 0.0", "bounds.rate_max_hz is 0"),
        ("\"S/m\"", "\"mS/cm\"", "unknown variant `mS/cm`"),
        ("fix_distance_max_m", "fix_distance", "unknown field `fix_distance`"),
    ] {
        let message = with(from, to);
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn a_mission_that_is_not_there_is_named_with_the_one_that_was_meant() {
    let missions = tempfile::tempdir().unwrap();
    for name in ["isobath", "plume"] {
        std::fs::create_dir(missions.path().join(name)).unwrap();
        std::fs::write(missions.path().join(name).join("mission.toml"), "").unwrap();
    }
    let said = |place: &Path| Mission::load(place, &Layers::default()).err().unwrap().to_string();
    let meant = |name: &str| format!(": did you mean {}?", missions.path().join(name).display());
    let typo = said(&missions.path().join("isobat"));
    assert!(
        typo.contains("isobat: no such folder") && typo.ends_with(&meant("isobath")),
        "{typo}"
    );
    let other = said(&missions.path().join("zzz"));
    assert!(other.ends_with("zzz: no such folder"), "{other}");
    let above = said(missions.path());
    assert!(
        above.contains("no mission here") && above.ends_with(&meant("isobath")),
        "{above}"
    );
}

#[test]
fn a_missing_file_or_component_is_named() {
    let empty = tempfile::tempdir().unwrap();
    let error = Mission::load(empty.path(), &Layers::default())
        .err()
        .expect("the folder has no mission")
        .to_string();
    assert!(error.contains("expected a folder with mission.toml"), "{error}");
    std::fs::write(empty.path().join("mission.toml"), MISSION).unwrap();
    std::fs::create_dir(empty.path().join("fence.kml")).unwrap();
    let unreadable = Mission::load(empty.path(), &Layers::default())
        .err()
        .expect("a folder is not a fence")
        .to_string();
    assert!(
        unreadable.contains("fence.kml") && !unreadable.contains("no fence here"),
        "{unreadable}"
    );
    std::fs::remove_dir(empty.path().join("fence.kml")).unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(empty.path().join("fence.kml"))
        .status();
    assert!(made.unwrap().success());
    let pipe = Mission::load(empty.path(), &Layers::default())
        .err()
        .expect("a pipe is not a fence")
        .to_string();
    assert!(pipe.contains("fence.kml: expected a file, found a pipe"), "{pipe}");
    let broken = load(MISSION, "{", &[]).err().expect("the fence is broken").to_string();
    assert!(broken.contains("fence.geojson"), "{broken}");
    let error = find_component(empty.path(), "x", "nowhere", Some(empty.path()))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("nowhere.wasm") && error.contains("cargo xtask plugins"),
        "{error}"
    );
}

#[test]
fn a_value_of_the_wrong_type_is_told_with_its_key_and_what_a_file_has_there() {
    for (text, told) in [
        (
            "[limits]\nspeed_min_mps = \"fast\"",
            "speed_min_mps: invalid type: string \"fast\", expected a number",
        ),
        (
            "[limits]\ninserts_open_max = -1",
            "inserts_open_max: invalid value: integer `-1`, expected a whole number, 0 to",
        ),
        (
            "[recovery]\ntell_topside = 1",
            "tell_topside: invalid type: integer `1`, expected true or false",
        ),
        (
            "[session]\nstatus_failed_when = 1",
            "status_failed_when: invalid type: integer `1`, expected a list",
        ),
    ] {
        let error = MissionFile::from_toml("mission.toml", text).unwrap_err().to_string();
        assert!(error.starts_with("mission.toml:2: ") && error.contains(told), "{error}");
    }
}

const SONAR: &str = r#"
[[plugin.ping]]
sensor = 2
samples = 512
decimation = "mean"

[[plugin.ping]]
sensor = 0
samples = 4096
decimation = "maximum"

[sonar]
host = "192.168.1.20"

[[sonar.sensor]]
index = 0
device = 11000
records = [3001]

[[sonar.sensor]]
index = 2
device = 11002
records = [3000]
"#;

#[test]
fn the_payload_controller_and_the_pings_of_plugins_are_read_and_resolved() {
    let without = load(MISSION, FENCE, &[]).unwrap();
    assert!(without.file.sonar.is_none() && without.file.plugins[0].pings.is_empty());
    assert!(!without.resolved.contains("sonar") && !without.resolved.contains("ping"));
    let mission = load(&format!("{MISSION}{SONAR}"), FENCE, &["sonar.port=7001"]).unwrap();
    let sonar = mission.file.sonar.as_ref().unwrap();
    assert_eq!(
        (&*sonar.host, sonar.port, sonar.sensor.len()),
        ("192.168.1.20", 7001, 2)
    );
    let pings = &mission.file.plugins[0].pings;
    let read: Vec<(i32, u16)> = pings.iter().map(|ping| (ping.sensor, ping.samples)).collect();
    assert_eq!(read, [(2, 512), (0, 4096)]);
    // What a log has attached is read as the same.
    let again = MissionFile::from_toml("mission.toml", &mission.resolved).unwrap();
    assert_eq!((&again.sonar, &again.plugins[0].pings), (&mission.file.sonar, pings));
    // A table without keys is the defaults.
    let empty = load(&format!("{MISSION}[sonar]\n"), FENCE, &[]).unwrap();
    assert_eq!(empty.file.sonar, Some(backseat_sonar::SonarConfig::default()));
}

#[test]
fn a_payload_controller_that_makes_no_sense_is_named() {
    let whole = format!("{MISSION}{SONAR}");
    let with = |from: &str, to: &str| {
        assert!(whole.contains(from), "{from}");
        fault(&whole.replacen(from, to, 1), &[])
    };
    for (from, to, said) in [
        ("host =", "hosts =", "unknown field `hosts`"),
        ("device = 11000", "devices = 11000", "unknown field `devices`"),
        ("samples = 512", "sample = 512", "unknown field `sample`"),
        ("\"mean\"", "\"median\"", "unknown variant `median`"),
        ("decimation = \"mean\"", "", "missing field `decimation`"),
        (
            "host = \"192.168.1.20\"",
            "port = 0",
            "port: invalid value: integer `0`, expected 1 to 65535",
        ),
        (
            "host = \"192.168.1.20\"",
            "port = 70000",
            "port: invalid value: integer `70000`, expected 1 to 65535",
        ),
        (
            "[3001]",
            "[3001, -1]",
            "records: invalid value: integer `-1`, expected a whole number",
        ),
        (
            "index = 0",
            "index = 2",
            "sonar.sensor[1].index is 2: expected an index that no other sensor has",
        ),
        (
            "sensor = 2",
            "sensor = 1",
            "plugin `isobath`: ping.sensor is 1: expected the index of a [[sonar.sensor]]: 0, 2",
        ),
        (
            "samples = 4096",
            "samples = 4097",
            "plugin `isobath`: ping.samples is 4097: expected 1 to 4096",
        ),
        ("samples = 512", "samples = 0", "ping.samples is 0: expected 1 to 4096"),
    ] {
        let message = with(from, to);
        assert!(message.contains(said) && message.contains("mission.toml"), "{message}");
    }
    let (pings, _) = SONAR.split_once("[sonar]").unwrap();
    let message = fault(&format!("{MISSION}{pings}"), &[]);
    assert!(
        message.ends_with("ping.sensor is 2, and the mission has no [sonar]: expected one with that [[sonar.sensor]]"),
        "{message}"
    );
    let many = "[[plugin.ping]]\nsensor = 2\nsamples = 1\ndecimation = \"mean\"\n".repeat(15);
    let message = fault(&whole.replacen("\n[sonar]", &format!("{many}[sonar]"), 1), &[]);
    assert!(
        message.ends_with("the plugins have 17 [[plugin.ping]] tables: expected at most 16"),
        "{message}"
    );
}

#[test]
fn the_path_of_a_key_in_a_list_is_written_with_dots() {
    for (text, expected) in [
        (
            "unknown field `x` for key `plugin[0]limits`",
            "unknown field `x` for key `plugin[0].limits`",
        ),
        ("bad for key `plugin[0]ping[1]`", "bad for key `plugin[0].ping[1]`"),
        ("bad [0]a for key `limits`", "bad [0]a for key `limits`"),
        ("bad [0]a", "bad [0]a"),
    ] {
        assert_eq!(dotted(text), expected);
    }
}
