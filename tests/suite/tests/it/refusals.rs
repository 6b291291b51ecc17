//! Invalid input gives exit code 2, one line on standard error with file, key and what was expected, and no panic.

use std::net::TcpListener;

use backseat_suite::{Backseat, Mission};
use backseat_test_support::plugins;

/// The line with which `backseat sim` refuses a mission.
fn refusal(mission: &Mission) -> String {
    Backseat::new().args(["sim", "--json"]).mission(mission).run().refusal()
}

/// Requires that the line contains all of these.
#[track_caller]
fn names(line: &str, parts: &[&str]) {
    for part in parts {
        assert!(line.contains(part), "no `{part}` in `{line}`");
    }
}

#[test]
fn an_unknown_key_is_named_with_its_line_in_each_file() {
    let line = refusal(&Mission::steady().edit("mission.toml", "turn_rate_dps", "turn_rate"));
    names(
        &line,
        &[
            "mission.toml:9",
            "unknown field `turn_rate`: did you mean `turn_rate_dps`?",
        ],
    );
    let line = refusal(&Mission::steady().edit("world.toml", "heading_deg = 90", "bearing_deg = 90"));
    names(
        &line,
        &[
            "world.toml",
            "line 9",
            "unknown field `bearing_deg`: did you mean `heading_deg`?",
        ],
    );
    let line = refusal(&Mission::steady().edit("fence.geojson", "\"margin_m\"", "\"margin\""));
    names(
        &line,
        &["fence.geojson", "unknown key `margin`: did you mean `margin_m`?"],
    );
}

#[test]
fn a_wrong_value_is_named_with_what_was_expected() {
    let line = refusal(&Mission::steady().edit("mission.toml", "speed_max_mps = 2.0", "speed_max_mps = 0.5"));
    names(&line, &["mission.toml", "limits.speed_max_mps is 0.5", "expected"]);
    let line = refusal(&Mission::steady().edit("mission.toml", "speed_max_mps = 2.0", "speed_max_mps = nan"));
    names(&line, &["mission.toml", "limits.speed_max_mps", "expected"]);
    let line = refusal(&Mission::steady().edit("mission.toml", "[\"modify\"]", "[\"steer\"]"));
    names(&line, &["mission.toml:18", "`steer`", "expected"]);
    let line = refusal(&Mission::steady().edit("world.toml", "latitude_deg = 42.35", "latitude_deg = 95"));
    names(&line, &["world.toml", "latitude", "95"]);
    let line = refusal(&Mission::steady().write("mission.toml", b"\xff\xfe"));
    names(&line, &["mission.toml"]);
    let line = refusal(&Mission::steady().write("fence.geojson", "{"));
    names(&line, &["fence.geojson"]);
}

#[test]
fn what_is_not_there_is_named() {
    let line = Backseat::new().args(["sim", "no/such/mission"]).run().refusal();
    names(&line, &["no/such/mission", "no such folder"]);
    names(
        &refusal(&Mission::steady().without("mission.toml")),
        &["steady", "mission.toml"],
    );
    names(
        &refusal(&Mission::steady().without("fence.geojson")),
        &["no fence here", "fence.geojson, fence.plan and fence.kml"],
    );
    names(
        &refusal(&Mission::steady().without("world.toml")),
        &["world.toml", "needs this file"],
    );
    let mission = Mission::steady();
    let line = Backseat::new()
        .arg("sim")
        .arg(mission.path().join("mission.toml"))
        .run()
        .refusal();
    names(&line, &["mission.toml", "expected a folder"]);
}

#[test]
fn a_polygon_that_crosses_itself_is_refused() {
    let bow_tie =
        "[[-70.7182, 42.3428], [-70.6818, 42.3572], [-70.6818, 42.3428], [-70.7182, 42.3572], [-70.7182, 42.3428]]";
    let mission = Mission::steady().edit(
        "fence.geojson",
        "[[-70.7182, 42.3428], [-70.6818, 42.3428], [-70.6818, 42.3572], [-70.7182, 42.3572], [-70.7182, 42.3428]]",
        bow_tie,
    );
    names(&refusal(&mission), &["fence.geojson", "box", "cross"]);
}

#[test]
fn an_unknown_plugin_is_named_with_the_places_looked_at() {
    let line = refusal(&Mission::steady().edit("mission.toml", "component = \"faulty\"", "component = \"fautly\""));
    names(&line, &["pilot", "fautly.wasm", "cargo xtask plugins"]);
    let line = refusal(&Mission::steady().edit("mission.toml", "component = \"faulty\"", "component = \"./my.wasm\""));
    names(&line, &["pilot", "steady/./my.wasm"]);
}

#[test]
fn what_is_no_plugin_is_refused_by_what_it_is() {
    let with = |bytes: &[u8]| {
        refusal(
            &Mission::steady()
                .edit("mission.toml", "component = \"faulty\"", "component = \"my.wasm\"")
                .write("my.wasm", bytes),
        )
    };
    names(
        &with(b"\0asm\x01\0\0\0"),
        &["pilot", "my.wasm", "a core module, expected a component"],
    );
    names(
        &with(b"not WebAssembly"),
        &["pilot", "not WebAssembly", "expected a component"],
    );
    names(&with(b""), &["pilot", "the file is empty"]);
    let whole = std::fs::read(plugins().join("faulty.wasm")).unwrap();
    names(
        &with(&whole[..whole.len() / 2]),
        &["pilot", "my.wasm): not a valid component"],
    );
    let wasi = wat::parse_str(r#"(component (import "wasi:cli/environment@0.2.0" (instance)))"#).unwrap();
    names(&with(&wasi), &["pilot", "imports wasi:cli/environment@0.2.0"]);
}

#[test]
fn a_plugin_refuses_its_own_configuration() {
    let line = refusal(&Mission::steady().edit("mission.toml", "heading_deg = 90.0", "heading = 90.0"));
    names(
        &line,
        &["pilot", "unknown field `heading`: did you mean `heading_deg`?"],
    );
    let line = refusal(&Mission::copy("isobath").edit("mission.toml", "contour_m = 30.0", "contour_m = -30.0"));
    names(&line, &["isobath", "contour_m"]);
}

#[test]
fn bad_flags_are_refused() {
    let mission = Mission::steady();
    let sim = |arguments: &[&str]| Backseat::new().arg("sim").mission(&mission).args(arguments).run();
    names(
        &sim(&["--set", "nonsense"]).refusal(),
        &["--set nonsense", "expected KEY=VALUE"],
    );
    names(
        &sim(&["--set", "limits.speed=1"]).refusal(),
        &["--set limits.speed=1", "unknown field `speed`"],
    );
    names(
        &sim(&["--set", "limits.speed_max_mps=fast"]).refusal(),
        &["--set limits.speed_max_mps=fast", "fast"],
    );
    names(
        &sim(&["--set", "limits.speed_max_mps=0.1"]).refusal(),
        &["limits.speed_max_mps is 0.1", "expected"],
    );
    for speed in ["0", "-1", "nan", "inf", "fast", "1e-300", "1e300"] {
        let finished = sim(&[&format!("--speed={speed}")]).exit(2);
        names(
            &finished.stderr,
            &["--speed", speed, "expected a number from 0.001 to 1000000, or `max`"],
        );
        assert_eq!(finished.stdout, "");
    }
    for seed in ["-1", "seven", "18446744073709551616"] {
        let finished = sim(&[&format!("--seed={seed}")]).exit(2);
        names(
            &finished.stderr,
            &["--seed", seed, "expected one whole number from 0 to"],
        );
        let apart = sim(&["--seed", seed]).exit(2);
        names(&apart.stderr, &["--seed", seed, "expected one whole number from 0 to"]);
    }
}

#[test]
fn a_file_in_place_of_the_mission_s_folder_is_told_of() {
    let mission = Mission::steady();
    let file = mission.path().join("mission.toml");
    let line = Backseat::new().arg("sim").arg(&file).run().refusal();
    names(
        &line,
        &[
            "mission.toml: expected a folder with mission.toml and a fence, and this is a file: give ",
            &mission.path().display().to_string(),
        ],
    );
}

#[test]
fn a_folder_of_plugins_that_is_not_there_is_told_of() {
    for command in ["sim", "check", "run"] {
        let finished = Backseat::new()
            .arg(command)
            .mission(&Mission::steady())
            .args(["--plugins", "no/such/folder"])
            .run()
            .exit(2);
        names(
            &finished.stderr,
            &["--plugins <DIR>", "no/such/folder", "no such folder"],
        );
    }
}

#[test]
fn what_cannot_be_written_is_told_before_the_run() {
    let mission = Mission::steady();
    let nowhere = mission.beside("no/such/folder/file");
    for flag in ["--log", "--map"] {
        let line = Backseat::new()
            .arg("sim")
            .mission(&mission)
            .arg(flag)
            .arg(&nowhere)
            .run()
            .refusal();
        names(&line, &["no/such/folder/file", "No such file"]);
    }
    let line = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0"])
        .mission(&mission)
        .arg("--log")
        .arg(&nowhere);
    names(&line.run().refusal(), &["no/such/folder/file", "No such file"]);
    let file = mission.beside("file");
    std::fs::write(&file, "").unwrap();
    let line = Backseat::new()
        .arg("run")
        .mission(&mission)
        .arg("--log")
        .arg(file.join("logs"))
        .run()
        .refusal();
    names(&line, &["file/logs"]);
    let line = Backseat::new()
        .arg("run")
        .mission(&mission)
        .arg("--state")
        .arg(file.join("state"))
        .run()
        .refusal();
    names(&line, &["file/state"]);
}

#[test]
fn a_port_in_use_is_told() {
    let mission = Mission::steady();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let line = Backseat::new()
        .args(["mvc", "--listen", &address])
        .mission(&mission)
        .run()
        .refusal();
    names(&line, &[&address, "in use", "--listen"]);
}

#[test]
fn a_malformed_address_is_told() {
    let mission = Mission::steady();
    for address in ["nonsense", "127.0.0.1", "127.0.0.1:99999", ""] {
        let line = Backseat::new()
            .args(["mvc", "--listen", address])
            .mission(&mission)
            .run()
            .refusal();
        names(&line, &[address, "listen"]);
    }
    for address in ["nonsense", "127.0.0.1", "127.0.0.1:99999", "127.0.0.1:0", ":29500", ""] {
        let line = Backseat::new()
            .args(["run", "--connect", address])
            .mission(&mission)
            .run()
            .refusal();
        names(&line, &["--connect", address, "expected HOST:PORT"]);
    }
    let line = Backseat::new()
        .args(["run", "--set", "vehicle.address=nowhere"])
        .mission(&mission)
        .run()
        .refusal();
    names(&line, &["vehicle.address", "nowhere", "expected HOST:PORT"]);
}

#[test]
fn sr_009_the_state_is_the_vehicles_and_whose_it_is_must_be_plain() {
    let mission = Mission::steady();
    let state = mission.beside("state");
    let run = |mission: &Mission| {
        Backseat::new()
            .args(["run", "--connect", "127.0.0.1:1", "--first-identifier", "7", "--state"])
            .arg(&state)
            .mission(mission)
            .run()
            .refusal()
    };
    // A record in the former format.
    std::fs::create_dir(&state).unwrap();
    std::fs::write(state.join("identifiers"), "40 1 3 0\n").unwrap();
    let line = run(&mission);
    names(&line, &["does not name its vehicle", "echo steady >", "state/vehicle"]);
    // Another vehicle's record.
    std::fs::write(state.join("vehicle"), "other\n").unwrap();
    let line = run(&mission);
    names(&line, &["`other`", "`steady`", "vehicle.name"]);
    // A mission that does not name its vehicle.
    let nameless = Mission::steady().edit("mission.toml", "name = \"steady\"\n", "");
    let line = run(&nameless);
    names(&line, &["`other`", "set vehicle.name"]);
    let line = Backseat::new()
        .args(["run", "--connect", "127.0.0.1:1"])
        .mission(&nameless)
        .run()
        .refusal();
    names(&line, &["vehicle.name is missing", "--state DIR"]);
    for name in ["", "../x", ".hidden", "a b"] {
        let odd = Mission::steady().edit("mission.toml", "name = \"steady\"", &format!("name = \"{name}\""));
        let line = Backseat::new().arg("check").mission(&odd).run().refusal();
        names(&line, &["vehicle.name", "letters, digits"]);
    }
}

#[test]
fn a_record_of_identifiers_that_is_no_number_is_told() {
    let mission = Mission::steady();
    let state = mission.beside("state");
    std::fs::create_dir(&state).unwrap();
    std::fs::write(state.join("vehicle"), "steady\n").unwrap();
    std::fs::write(state.join("identifiers"), "many\n").unwrap();
    let line = Backseat::new()
        .arg("run")
        .mission(&mission)
        .arg("--state")
        .arg(&state)
        .run()
        .refusal();
    names(&line, &["state/identifiers", "expected a number", "many"]);
    std::fs::write(state.join("identifiers"), "40\n").unwrap();
    let line = Backseat::new()
        .args(["run", "--first-identifier", "1", "--state"])
        .arg(&state)
        .mission(&mission)
        .run();
    names(&line.refusal(), &["state/identifiers", "40"]);
}

#[test]
fn a_report_that_cannot_be_written_is_an_error_and_no_panic() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    for arguments in [
        ["check", "--set=limits.lead_max_m=30"],
        ["check", "--resolved"],
        ["sim", "--json"],
        ["sim", "--seed=2"],
    ] {
        let finished = Backseat::new()
            .args(arguments)
            .mission(&mission)
            .stdout_to("/dev/full")
            .run()
            .exit(2);
        let last = finished.stderr.trim_end().lines().last().unwrap_or("").to_owned();
        names(&last, &["error: ", "standard output", "No space left"]);
        assert!(!finished.stderr.contains("panicked"), "{finished}");
    }
}

#[test]
fn what_is_wrong_with_a_script_is_one_line() {
    let mission = Mission::steady().write(
        "script.toml",
        "# Three lines.\n[[rule]]\nwen = \"connected\"\ndo = \"abort\"\n",
    );
    let with = |command: &[&str], script: &str| {
        let script = mission.path().join(script);
        let run = Backseat::new()
            .args(command.iter().copied())
            .mission(&mission)
            .arg("--script");
        run.arg(script).run().refusal()
    };
    let mvc = ["mvc", "--listen", "127.0.0.1:0"];
    for command in [&mvc[..], &["sim"], &["fly"]] {
        names(
            &with(command, "script.toml"),
            &["script.toml", "line 3", "unknown field `wen`: did you mean `when`?"],
        );
    }
    names(&with(&mvc, "nothing.toml"), &["nothing.toml", "No such file"]);
    let mission = Mission::steady().write(
        "script.toml",
        "[[rule]]\nwhen = \"connected\"\ndo = { fault = { kind = \"stal\", for_s = 1 } }\n\
         [[rule]]\nwhen = \"connected\"\ndo = { load = \"other.dive\" }\n",
    );
    let refused = |mission: &Mission| {
        let run = Backseat::new().args(mvc).mission(mission).arg("--script");
        run.arg(mission.path().join("script.toml")).run().refusal()
    };
    names(
        &refused(&mission),
        &["script.toml", "line 3", "unknown variant `stal`: did you mean `stall`?"],
    );
    let mission = mission.edit("script.toml", "stal\"", "stall\"");
    names(
        &refused(&mission),
        &["script.toml: line 4: rule 2: no dive is named `other.dive`, expected one of `steady.dive`"],
    );
}

#[test]
fn a_place_without_a_world_is_one_line() {
    let mission = Mission::steady();
    let mission_file = mission.path().join("mission.toml");
    for command in ["mvc", "plc"] {
        let refused = |place: &std::path::Path| {
            let run = Backseat::new().args([command, "--listen", "127.0.0.1:0"]).arg(place);
            run.run().refusal()
        };
        let expected = "expected a folder with world.toml, or the path of a world.toml";
        names(
            &refused(std::path::Path::new("no/such/place")),
            &["no/such/place: nothing there", expected],
        );
        names(&refused(&mission_file), &["mission.toml: a mission's file", expected]);
    }
    let bad = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0", "--truth", "no/such/folder/truth.csv"])
        .mission(&mission)
        .run()
        .refusal();
    names(&bad, &["no/such/folder/truth.csv"]);
    let many = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0", "--wait", "17"])
        .mission(&mission)
        .run()
        .refusal();
    names(
        &many,
        &[
            "--wait 17",
            "world.toml lets only 16 clients connect",
            "[spi] clients_max",
        ],
    );
}

#[test]
fn a_console_beyond_this_computer_needs_a_certificate_and_a_key() {
    let mission = Mission::steady();
    let tried = |more: &[&str]| {
        let run = Backseat::new()
            .args(["run", "--console=0.0.0.0:0"])
            .args(more.iter().copied());
        run.mission(&mission).run()
    };
    let refused = |more: &[&str]| tried(more).refusal();
    names(
        &refused(&[]),
        &["0.0.0.0:0", "listens on this computer alone", "--console-cert"],
    );
    let none = [
        "--console-cert",
        "/nonexistent.crt",
        "--console-key",
        "/nonexistent.key",
    ];
    names(&refused(&none), &["/nonexistent.crt: No such file"]);
    names(&tried(&none[..2]).exit(2).stderr, &["--console-key"]);
}

/// Opening a pipe waits for its other end, so none is opened.
#[test]
fn a_pipe_is_no_component_and_no_log() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let pipe = mission.beside("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo");
    let path = pipe.to_str().unwrap();
    let of_pilot = format!("pilot={path}");
    let log = mission.beside("run.mcap");
    let _ = Backseat::new().args(["sim", "--log"]).arg(&log).mission(&mission).run();
    let of_mission = mission.path().to_str().unwrap();
    let state = mission.beside("state");
    for arguments in [
        &["plugin", "inspect", path][..],
        &["replay", path],
        &["log", "show", path],
        &["log", "report", path],
        &["replay", log.to_str().unwrap(), "--plugin", &of_pilot],
        &["replay", log.to_str().unwrap(), "--component", path],
        &["replay", log.to_str().unwrap(), "--config", &of_pilot],
        &["swap", of_mission, &of_pilot, "--sha256", "0123456789ab"],
        &[
            "run",
            of_mission,
            "--connect",
            "127.0.0.1:9",
            "--state",
            state.to_str().unwrap(),
            "--shadow",
            &of_pilot,
        ],
    ] {
        let line = Backseat::new().args(arguments).run().refusal();
        names(&line, &["pipe", "not a regular file"]);
    }
    let line = refusal(&mission.edit(
        "mission.toml",
        "component = \"faulty\"",
        &format!("component = \"{path}\""),
    ));
    names(&line, &["pipe (which is not a regular file)"]);
}
