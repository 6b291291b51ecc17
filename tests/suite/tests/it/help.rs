//! The program as seen by someone who has never used it.

use backseat_suite::{Backseat, Mission};
use backseat_test_support::workspace;

#[test]
fn help_names_every_command_and_what_it_does() {
    let help = Backseat::new().arg("--help").run().exit(0);
    assert_eq!(help.stderr, "");
    for command in [
        "sim", "run", "fly", "mvc", "plc", "check", "replay", "log", "plugin", "spi", "s7k", "explain",
    ] {
        assert!(
            help.stdout.lines().any(|line| line.trim_start().starts_with(command)),
            "{command}: {help}"
        );
    }
    let version = Backseat::new().arg("--version").run().exit(0);
    assert_eq!(version.stdout, format!("backseat {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_command_explains_its_flags() {
    for (command, flags) in [
        (
            "sim",
            [
                "--seed",
                "--faults",
                "--script",
                "--log",
                "--map",
                "--open",
                "--speed",
                "--json",
                "--plugins",
                "--no-cache",
            ]
            .as_slice(),
        ),
        ("run", &["--connect", "--arm", "--log", "--state", "--first-identifier"]),
        (
            "replay",
            &[
                "--plugin",
                "--config",
                "--set",
                "--steps",
                "--map",
                "--open",
                "--no-cache",
                "--json",
            ],
        ),
        (
            "fly",
            &[
                "--speed",
                "--profile",
                "--control",
                "--faults",
                "--script",
                "--seed",
                "--log",
                "--map",
                "--open",
                "--state",
                "--duration",
            ],
        ),
        (
            "mvc",
            &[
                "--listen",
                "--speed",
                "--profile",
                "--iprole",
                "--faults",
                "--seed",
                "--log",
                "--duration",
                "--with-plc",
                "--plc-folder",
                "--wait",
                "--control",
                "--script",
                "--map",
                "--truth",
                "control take",
            ],
        ),
        ("plc", &["--listen", "--folder", "--seed", "--log", "--duration"]),
        ("check", &["--resolved", "--set", "--no-cache"]),
    ] {
        let help = Backseat::new().args([command, "--help"]).run().exit(0);
        let argument = match command {
            "mvc" | "plc" => "<MISSION|WORLD.toml>",
            "replay" => "<DIVE.mcap>",
            _ => "<MISSION>",
        };
        assert!(help.stdout.contains(argument), "{help}");
        for flag in flags {
            assert!(help.stdout.contains(flag), "{command} {flag}: {help}");
        }
    }
}

#[test]
fn the_tools_for_plugins_explain_themselves() {
    for (command, parts) in [
        ("new", ["<NAME>", "BACKSEAT_KIT"].as_slice()),
        ("build", &["[DIR]", "NAME.wasm"]),
        ("test", &["[DIR]", "--seeds <N>", "Exit code"]),
        ("inspect", &["[FILE.wasm|DIR]", "--json", "Exit code"]),
        (
            "check",
            &[
                "[DIR|FILE.wasm]",
                "--mission",
                "--plugin <NAME>",
                "--plugins <DIR>",
                "--seeds <N>",
                "--set",
                "--json",
                "Exit code",
            ],
        ),
    ] {
        let help = Backseat::new().args(["plugin", command, "--help"]).run().exit(0);
        for part in parts {
            assert!(help.stdout.contains(part), "{command} {part}: {help}");
        }
    }
}

#[test]
fn wrong_usage_says_what_is_right() {
    let wrong = Backseat::new().arg("simulate").run().exit(2);
    assert!(wrong.stderr.contains("unrecognized subcommand 'simulate'"), "{wrong}");
    assert!(wrong.stderr.contains("--help"), "{wrong}");
    let nothing = Backseat::new().run().exit(2);
    assert!(nothing.stderr.contains("Usage:"), "{nothing}");
    let missing = Backseat::new().arg("sim").run().exit(2);
    assert!(missing.stderr.contains("<MISSION>"), "{missing}");
    let flag = Backseat::new().args(["sim", "x", "--sed", "7"]).run().exit(2);
    assert!(
        flag.stderr.contains("'--sed'") && flag.stderr.contains("'--seed'"),
        "{flag}"
    );
}

#[test]
fn a_mission_may_be_named_from_anywhere() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let fly = |folder: &std::path::Path, path: &str| {
        let report = Backseat::new()
            .args(["sim", "--json", path])
            .in_folder(folder)
            .run()
            .exit(0)
            .json();
        (report["mission"].clone(), report["digest"].clone())
    };
    let beside = mission.beside("");
    let plain = fly(&beside, "steady");
    assert_eq!(plain.0, "steady");
    assert_eq!(fly(&beside, "steady/"), plain, "with a slash at its end");
    assert_eq!(fly(&beside, "./steady/."), plain);
    assert_eq!(fly(mission.path(), "."), plain, "from inside");
    assert_eq!(
        fly(workspace(), mission.path().to_str().unwrap()),
        plain,
        "from elsewhere, whole"
    );
}

#[test]
fn what_is_said_to_a_file_has_no_colours() {
    let mission = Mission::steady();
    let vehicle = backseat_suite::Vehicle::start(&mission);
    let said = vehicle.process.stderr();
    assert!(!said.contains('\u{1b}'), "{said:?}");
}

#[test]
fn check_says_whether_a_mission_is_ready() {
    let mission = Mission::steady();
    let good = Backseat::new().arg("check").mission(&mission).run().exit(0);
    assert!(
        good.stdout.trim_end().ends_with("ready") && good.stdout.contains("plugin pilot"),
        "{good}"
    );
    let outside = mission.edit("world.toml", "end = { east_m = 600", "end = { east_m = 1600");
    let bad = Backseat::new().arg("check").mission(&outside).run().exit(1);
    assert!(
        bad.stdout.contains("plan element 1: ") && bad.stdout.trim_end().ends_with("not ready"),
        "{bad}"
    );
    let resolved = Backseat::new()
        .args(["check", "--resolved", "--set", "limits.speed_max_mps=1.7"])
        .mission(&outside);
    let resolved = resolved.env("BACKSEAT__LIMITS__LEAD_MAX_M", "33").run().exit(0);
    assert!(resolved.stdout.contains("speed_max_mps = 1.7"), "{resolved}");
    assert!(resolved.stdout.contains("lead_max_m = 33"), "{resolved}");
}

#[test]
fn a_wrong_key_is_reported_with_the_layers_that_may_have_it_and_no_others() {
    let mission = Mission::steady();
    let check = || {
        let check = Backseat::new().args(["check", "--set", "limits.turn_rate_dsp=3"]);
        check.mission(&mission)
    };
    let plain = check().run().refusal();
    assert!(
        plain.contains("mission.toml with --set limits.turn_rate_dsp=3: unknown field `turn_rate_dsp`: did you mean `turn_rate_dps`?"),
        "{plain}"
    );
    let layered = check().env("BACKSEAT__LIMITS__LEAD_MAX_M", "33").run().refusal();
    assert!(
        layered.contains("mission.toml with BACKSEAT__LIMITS__LEAD_MAX_M with --set "),
        "{layered}"
    );
}
