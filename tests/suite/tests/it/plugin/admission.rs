//! `inspect` and `check`.

use std::fs;
use std::path::Path;

use backseat_suite::{Finished, Mission};
use serde_json::{Value, json};

use super::{built, plugin};

/// `backseat plugin check` of a component of this project with a mission.
fn check(name: &str, mission: &Mission, arguments: &[&str]) -> Finished {
    let mut all = vec!["check"];
    let component = built(name);
    all.push(component.to_str().unwrap());
    all.extend(["--mission", mission.path().to_str().unwrap()]);
    all.extend(arguments);
    plugin(Path::new("/"), &all).run()
}

/// The report on the faulty plugin with this fault half a minute after the start.
fn faulty(mission: &Mission, fault: &str) -> (Value, Finished) {
    let fault = format!("plugin.pilot.config.fault={fault}");
    let arguments = [
        "--seeds",
        "2",
        "--json",
        "--set",
        "plugin.pilot.config.after_s=30",
        "--set",
        &fault,
    ];
    let checked = check("faulty", mission, &arguments).exit(1);
    (checked.json(), checked)
}

/// The objections of a report in one text.
fn objections(report: &Value) -> String {
    assert_eq!(report["passed"], false);
    let objections = report["objections"].as_array().unwrap();
    objections
        .iter()
        .map(|one| one.as_str().unwrap())
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn an_inspection_says_what_a_component_is() {
    let file = built("isobath");
    let inspect = |arguments: &[&str]| {
        let all = [&["inspect", file.to_str().unwrap()], arguments].concat();
        plugin(Path::new("/"), &all).run().exit(0)
    };
    let object = inspect(&["--json"]).json();
    assert_eq!(object["bytes"], fs::metadata(&file).unwrap().len());
    let interface = object["interface"].as_array().unwrap();
    assert!(
        interface.len() == 1 && interface[0].as_str().unwrap().starts_with("backseat:plugin@"),
        "{object}"
    );
    assert_eq!(object["needs"], json!(["modify"]));
    assert_eq!(object["wasi"], json!([]));
    assert_eq!(object["description"]["name"], "isobath");
    assert!(
        object["description"]["step_period_ms"].as_f64().unwrap() >= 20.0,
        "{object}"
    );
    assert_eq!(
        object["exports"],
        json!(["describe", "init", "step", "snapshot", "restore"])
    );
    let imports: Vec<&str> = object["imports"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(Value::as_str)
        .collect();
    assert!(
        imports.iter().any(|import| import.starts_with("backseat:plugin/log@")),
        "{imports:?}"
    );
    assert!(
        imports.iter().all(|import| import.starts_with("backseat:plugin/")),
        "{imports:?}"
    );
    let page = inspect(&[]).stdout;
    let hash = object["sha256"].as_str().unwrap();
    assert!(
        hash.len() == 64 && page.contains(hash) && page.contains("WASI       none"),
        "{page}"
    );
}

#[test]
fn what_is_no_plugin_is_refused_in_a_line() {
    let place = tempfile::tempdir().unwrap();
    let whole = fs::read(built("template")).unwrap();
    let file = |name: &str, bytes: &[u8]| fs::write(place.path().join(name), bytes).unwrap();
    file("damaged.wasm", &whole[..whole.len() / 2]);
    file("core.wasm", &wat::parse_str("(module)").unwrap());
    file("empty.wasm", b"");
    file("text.wasm", b"hello");
    let huge = fs::File::create(place.path().join("huge.wasm")).unwrap();
    huge.set_len(80 << 20).unwrap();
    let mission = Mission::copy("template");
    for (name, why) in [
        ("damaged.wasm", "damaged.wasm: not a valid component: "),
        (
            "core.wasm",
            "a core module, expected a component: `backseat plugin build` or",
        ),
        ("empty.wasm", "the file is empty"),
        ("text.wasm", "not WebAssembly"),
        ("huge.wasm", "83886080 bytes, expected at most 33554432"),
        ("missing.wasm", "missing.wasm: No such file"),
    ] {
        for command in [
            vec!["inspect"],
            vec!["check", "--mission", mission.path().to_str().unwrap()],
        ] {
            let line = plugin(place.path(), &[&command[..], &[name]].concat()).run().refusal();
            assert!(line.contains(why), "{line}");
        }
    }
}

#[test]
fn a_component_of_another_world_is_shown_and_not_admitted() {
    let place = tempfile::tempdir().unwrap();
    let mission = Mission::copy("template");
    for (text, import, why) in [
        (
            r#"(component (import "wasi:cli/environment@0.2.0" (instance)))"#,
            json!(["wasi:cli/environment@0.2.0"]),
            "imports wasi:cli/environment@0.2.0",
        ),
        ("(component)", json!([]), "does not export describe"),
    ] {
        fs::write(place.path().join("other.wasm"), wat::parse_str(text).unwrap()).unwrap();
        let shown = plugin(place.path(), &["inspect", "other.wasm", "--json"])
            .run()
            .exit(1)
            .json();
        assert_eq!((&shown["imports"], &shown["wasi"]), (&import, &import));
        assert_eq!(shown["description"], Value::Null);
        assert!(shown["refusal"].as_str().unwrap().contains(why), "{shown}");
        let page = plugin(place.path(), &["inspect", "other.wasm"]).run().exit(1);
        assert!(
            page.stdout
                .contains("no plugin that this program can run: other.wasm: "),
            "{page}"
        );
        let check = ["check", "other.wasm", "--mission", mission.path().to_str().unwrap()];
        let line = plugin(place.path(), &check).run().refusal();
        assert!(line.contains(why), "{line}");
    }
}

#[test]
fn a_good_plugin_has_a_report_without_objections() {
    let mission = Mission::copy("template").edit("mission.toml", "[\"modify\"]", "[\"modify\", \"message\"]");
    let report = check("template", &mission, &["--seeds", "3", "--json"]).exit(0).json();
    assert_eq!(report["passed"], true);
    assert_eq!(report["trials"]["outcomes"], json!({"completed": 3}));
    assert_eq!(report["mission"]["grants"], json!(["modify", "message"]));
    assert_eq!(report["needs"], json!(["modify"]));
    assert_eq!(report["grants_used"], json!(["modify"]));
    assert_eq!(report["grants_unused"], json!(["message"]));
    assert_eq!(report["grants_lacked"], json!({}));
    let modify = &report["requests"]["modify"];
    let ends: u64 = modify["ends"]
        .as_object()
        .unwrap()
        .values()
        .filter_map(Value::as_u64)
        .sum();
    assert_eq!(modify["made"], ends);
    assert_eq!(modify["made"], 1440, "three times the 480 of write-a-plugin.md");
    let headroom = &report["headroom"];
    for part in ["step_fuel", "snapshot_fuel", "memory_bytes", "step_seconds"] {
        let used = |key: &str| headroom[part][key].as_f64().unwrap();
        assert!(used("most") > 0.0 && used("most") < used("limit"), "{part}: {headroom}");
    }
    assert!(report["compile_seconds"]["most"].as_f64().unwrap() > 0.0);
    let page = check("template", &mission, &["--seeds", "1"]).exit(0).stdout;
    for part in [
        report["sha256"].as_str().unwrap(),
        "WASI: none",
        "480 made",
        "grants: used: modify; given and not used: message; asked for and not given: none",
        "no fault, no log line dropped, no violation of the safety rules",
        "remark: it never used the grant message",
    ] {
        assert!(page.contains(part), "{part}:\n{page}");
    }
    assert!(
        page.trim_end().ends_with("no objection to template with this mission"),
        "{page}"
    );
    assert!(page.lines().count() < 50, "one page\n{page}");
}

#[test]
fn a_report_objects_to_faults_and_says_how_they_happened() {
    let mission = Mission::steady();
    let (report, shown) = faulty(&mission, "trap");
    let fault = &report["faults"][0];
    assert_eq!((&fault["kind"], &fault["seed"]), (&json!("trap"), &json!(1)));
    assert!(
        fault["count"].as_u64().unwrap() > 1 && fault["text"].as_str().unwrap().contains("panicked"),
        "{shown}"
    );
    assert!((30.0..40.0).contains(&fault["at_s"].as_f64().unwrap()), "{fault}");
    assert!(
        objections(&report).contains("(trap), first with seed 1 at 3"),
        "{shown}"
    );

    let (report, shown) = faulty(&mission, "loop");
    assert_eq!(report["faults"][0]["kind"], "out-of-fuel");
    let fuel = &report["headroom"]["step_fuel"];
    assert_eq!(fuel["limit"], 20_000_000);
    assert!(fuel["most"].as_u64().unwrap() > 19_999_000, "{shown}");
    let remarks = report["remarks"].to_string();
    assert!(remarks.contains("a step used 100 % of its fuel"), "{remarks}");

    let (report, shown) = faulty(&mission, "grow");
    assert_eq!(report["faults"][0]["kind"], "memory");
    let memory = &report["headroom"]["memory_bytes"];
    assert!(
        memory["most"].as_u64().unwrap() > 60 << 20 && memory["limit"] == 64 << 20,
        "{shown}"
    );

    let (report, _) = faulty(&mission, "log_flood");
    assert!(report["log_lines_dropped"].as_u64().unwrap() > 1000);
    assert!(objections(&report).contains("log lines were dropped"), "{report}");
}

#[test]
fn a_report_counts_refusals_and_the_grants_that_a_plugin_lacks() {
    let mission = Mission::steady();
    let (report, shown) = faulty(&mission, "cross_fence");
    let trackline = &report["requests"]["trackline"];
    let made = trackline["made"].as_u64().unwrap();
    assert!(made > 100, "{shown}");
    assert_eq!(trackline["ends"], json!({"refused before it was sent": made}));
    assert_eq!(report["grants_lacked"], json!({"insert": made, "interrupt": made}));
    let refused = &trackline["refusals"][0];
    assert_eq!((&refused["count"], &refused["rule"]), (&json!(made), &json!("grant")));
    assert!(objections(&report).contains("it lacks the grant insert"), "{shown}");

    // With the grants, the fence refuses them: that is no objection to the plugin.
    let granted = mission.edit("mission.toml", "\"modify\"]", "\"modify\", \"insert\", \"interrupt\"]");
    let arguments = [
        "--seeds",
        "1",
        "--json",
        "--set",
        "plugin.pilot.config.fault=cross_fence",
    ];
    let report = check("faulty", &granted, &arguments).exit(0).json();
    assert_eq!(report["grants_lacked"], json!({}));
    let refusals = report["requests"]["trackline"]["refusals"].as_array().unwrap();
    assert!(
        refusals.iter().any(|refused| refused["rule"] == "keep-in"),
        "{refusals:?}"
    );

    // The log has only some of the refusals for a rate; the report has all.
    let limited = granted.append("mission.toml", "[plugin.limits]\nrequests_per_s = 1");
    let report = check("faulty", &limited, &arguments).json();
    for (kind, tally) in report["requests"].as_object().unwrap() {
        let ends: u64 = tally["ends"]
            .as_object()
            .unwrap()
            .values()
            .filter_map(Value::as_u64)
            .sum();
        assert_eq!(tally["made"], ends, "{kind}: {tally}");
    }
}

#[test]
fn a_plugin_that_says_it_needs_a_grant_is_refused_without_it() {
    let mission = Mission::copy("template").edit("mission.toml", "[\"modify\"]", "[\"message\"]");
    let line = check("template", &mission, &[]).refusal();
    assert!(line.contains("needs the grant modify: add it to `grants`"), "{line}");
}

#[test]
fn a_plugin_for_an_older_interface_is_checked_too() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("components/isobath-0.1.0.wasm");
    let inspect = ["inspect", file.to_str().unwrap(), "--json"];
    let shown = plugin(Path::new("/"), &inspect).run().exit(0).json();
    assert_eq!(
        (&shown["interface"], &shown["needs"]),
        (&json!(["backseat:plugin@0.1.0"]), &json!([]))
    );
    let mission = Mission::copy("isobath");
    let check = [
        "check",
        file.to_str().unwrap(),
        "--mission",
        mission.path().to_str().unwrap(),
        "--seeds",
        "1",
        "--json",
    ];
    let report = plugin(Path::new("/"), &check).run().exit(0).json();
    assert!(
        report["requests"]["modify"]["accepted"].as_u64().unwrap() > 100,
        "{report}"
    );
}

#[test]
fn a_report_objects_to_expectations_that_are_not_met() {
    let mission = Mission::copy("template").edit("world.toml", "min_accepted = 10", "min_accepted = 100000");
    let report = check("template", &mission, &["--seeds", "2", "--json"]).exit(1).json();
    assert_eq!(report["trials"]["unmet"].as_array().map(Vec::len), Some(2));
    assert!(
        objections(&report).contains("expectation not met: seed 1: "),
        "{report}"
    );
}

#[test]
fn the_plugin_of_a_mission_must_be_clear() {
    let second = "[[plugin]]\nname = \"second\"\ncomponent = \"template\"\ngrants = [\"modify\"]\n\n[plugin.config]\n\
                  heading_deg = 80.0\ndepth_m = 10.0\nspeed_mps = 1.5";
    let mission = Mission::copy("template").append("mission.toml", second);
    let ask = |arguments: &[&str]| check("template", &mission, &[&["--seeds", "1"], arguments].concat());
    let line = ask(&[]).refusal();
    assert!(line.contains("template, second") && line.contains("--plugin"), "{line}");
    let line = ask(&["--plugin", "third"]).refusal();
    assert!(
        line.contains("no plugin `third`; its plugins are: template, second"),
        "{line}"
    );
    let report = ask(&["--plugin", "second", "--json"]);
    assert_eq!(report.json()["mission"]["plugin"], "second", "{report}");

    let beside = tempfile::tempdir().unwrap();
    fs::copy(built("template"), beside.path().join("alone.wasm")).unwrap();
    let line = plugin(beside.path(), &["check", "alone.wasm"]).run().refusal();
    assert_eq!(line, "error: mission: no mission beside it: give one with --mission");
}
