//! The program for sea, and `world.toml`, which only simulation needs.

use backseat_suite::{Backseat, Finished, Mission};

const NOT_LOOKED_AT: &str = "this program was built for sea, without the simulation: of world.toml it reads the plan, if [plan] names it, and nothing else";
const GARBAGE: &str = "nonsense\n";

fn check(mission: &Mission, arguments: &[&str]) -> Finished {
    Backseat::new()
        .for_sea()
        .arg("check")
        .mission(mission)
        .args(arguments)
        .run()
}

/// A plan this far north, with its own origin.
fn plan(north_m: u32) -> String {
    format!(
        "[origin]\nlatitude_deg = 42.35\nlongitude_deg = -70.70\n\n[[plan]]\nkind = \"waypoint\"\n\
         at = {{ east_m = 0, north_m = {north_m} }}\ndepth_m = 8\nspeed_mps = 1.5\n"
    )
}

#[test]
fn the_program_for_sea_has_no_commands_of_the_simulation() {
    let help = |arguments: &[&str]| Backseat::new().for_sea().args(arguments).run().exit(0).stdout;
    let commands = |help: &str| -> Vec<String> {
        let listed = help.split("Commands:\n").nth(1).unwrap_or_default();
        let names = listed.lines().take_while(|line| line.starts_with("  "));
        names
            .filter_map(|line| line.split_whitespace().next().map(str::to_owned))
            .collect()
    };
    assert_eq!(
        commands(&help(&["--help"])),
        [
            "run", "check", "doctor", "replay", "log", "spi", "s7k", "swap", "key", "explain", "help"
        ]
    );
    assert_eq!(
        commands(&help(&["log", "--help"])),
        ["info", "show", "report", "join", "view", "help"]
    );
    let sim = Backseat::new().for_sea().args(["sim", "x"]).run().exit(2);
    assert!(sim.stderr.contains("unrecognized subcommand 'sim'"), "{sim}");
}

#[test]
fn a_check_for_sea_judges_the_missions_plan_or_a_files() {
    for world in [Some(GARBAGE), None] {
        let mission = match world {
            Some(world) => Mission::steady().write("world.toml", world),
            None => Mission::steady().without("world.toml"),
        };
        let said = check(&mission, &[]).exit(0).stdout;
        assert!(said.contains(NOT_LOOKED_AT), "{said}");
        assert!(said.contains("no plan of the front seat"), "{said}");
        assert!(said.ends_with("\nready\n"), "{said}");

        let file = mission.beside("plan.toml");
        std::fs::write(&file, plan(900)).expect("the mission's folder can be written");
        let said = check(&mission, &["--plan", &file.display().to_string()]).exit(1).stdout;
        assert!(said.contains("plan element 1: ") && said.contains("box"), "{said}");

        let named = mission
            .append("mission.toml", "[plan]\nfile = \"plan.toml\"")
            .write("plan.toml", plan(100));
        let said = check(&named, &[]).exit(0).stdout;
        assert!(
            said.contains("plan: its first position, its behavior and the path to it lie inside the fence"),
            "{said}"
        );
        let outside = named.write("plan.toml", plan(900));
        let said = check(&outside, &[]).exit(1).stdout;
        assert!(said.contains("plan element 1: "), "{said}");
    }
}

#[test]
fn whoever_needs_the_world_is_told_what_is_wrong_with_it() {
    let mission = Mission::steady().write("world.toml", GARBAGE);
    for command in [
        ["sim", "--json"].as_slice(),
        &["mvc", "--listen", "127.0.0.1:0"],
        &["check"],
    ] {
        let line = Backseat::new().args(command).mission(&mission).run().refusal();
        assert!(line.contains("world.toml: line 1, column "), "{command:?}: {line}");
    }
}

#[test]
fn log_info_tells_what_a_log_is_of() {
    let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
    let log = mission.beside("run.mcap");
    let _ = Backseat::new()
        .args(["sim", "--seed", "7", "--log"])
        .arg(&log)
        .mission(&mission)
        .run();
    for program in [Backseat::new(), Backseat::new().for_sea()] {
        let told = program.args(["log", "info", "--json"]).arg(&log).run().exit(0).json();
        assert_eq!(
            (&told["mission"], &told["seed"]),
            (&"steady".into(), &7.into()),
            "{told}"
        );
        assert!(told["origin"]["latitude_deg"].is_f64(), "{told}");
        assert_eq!(told["utc_at_start"], "2026-06-01T08:00:00Z", "{told}");
        assert_eq!((&told["complete"], &told["gaps"]), (&true.into(), &0.into()), "{told}");
        assert!(told["bytes_to_vehicle"].as_u64() > Some(100), "{told}");
        assert_eq!(told["attached"][2], "world.toml", "{told}");
    }
    let text = Backseat::new().args(["log", "info"]).arg(&log).run().exit(0);
    assert!(text.stdout.contains("attached: mission.toml, "), "{text}");
    assert!(text.stdout.ends_with("the log is complete\n"), "{text}");
    let none = Backseat::new()
        .args(["log", "info"])
        .arg(mission.path().join("mission.toml"))
        .run()
        .refusal();
    assert!(none.contains("expected the log of a run"), "{none}");
}
