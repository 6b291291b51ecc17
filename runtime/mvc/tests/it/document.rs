use backseat_mvc::{Mvc, OperatorLine, Script, WorldFile};

/// The mock must accept the files that people copy from the page.
#[test]
fn the_mock_accepts_the_files_of_the_documentation() {
    let files = blocks("```toml\n").filter(|file| !file.contains("[[rule]]"));
    assert_eq!(files.clone().count(), 3);
    for file in files {
        let world = WorldFile::from_toml(file).unwrap_or_else(|error| panic!("{error}"));
        for seed in 0..3 {
            Mvc::new(&world, seed).unwrap_or_else(|error| panic!("{error}"));
        }
    }
}

/// What stands in the page's code blocks that begin with this line.
fn blocks(begin: &str) -> impl Iterator<Item = &'static str> + Clone {
    let text = include_str!("../../../docs/mock.md").split(begin).skip(1);
    text.filter_map(|rest| rest.split("```").next())
}

#[test]
fn the_script_and_the_operator_s_lines_of_the_documentation_are_right() {
    let scripts: Vec<&str> = blocks("```toml\n").filter(|file| file.contains("[[rule]]")).collect();
    let rules: usize = scripts
        .iter()
        .map(|script| {
            Script::from_toml(script)
                .unwrap_or_else(|error| panic!("{error}"))
                .rules
                .len()
        })
        .sum();
    assert_eq!(rules, 4);
    let typed: Vec<&str> = blocks("```text\n")
        .find(|block| block.starts_with("fault "))
        .expect("a block")
        .lines()
        .collect();
    for line in &typed {
        let command = line.split('#').next().unwrap_or("");
        let parsed = OperatorLine::parse(command);
        assert!(matches!(parsed, Ok(Some(_))), "{command}: {parsed:?}");
    }
    // Every row of the tables with what can be written.
    let rows = include_str!("../../../docs/mock.md").lines();
    let rows = rows.filter_map(|row| row.strip_prefix("| `")?.split("` |").next());
    let mut seen = 0;
    for row in rows.filter(|row| row.starts_with("{ ") || row.starts_with('"')) {
        for value in row.split("`, `").filter(|value| !value.contains("...")) {
            let texts = [
                format!("[[rule]]\nwhen = {value}\ndo = \"abort\""),
                format!("[[rule]]\nwhen = \"connected\"\ndo = {value}"),
            ];
            assert!(texts.iter().any(|text| Script::from_toml(text).is_ok()), "{value}");
            seen += 1;
        }
    }
    assert_eq!(seen, 10);
}

/// The longer file states the defaults.
#[test]
fn the_documented_defaults_are_the_defaults() {
    let text = include_str!("../../../docs/mock.md");
    let file = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let world = WorldFile::from_toml(file.expect("a file")).expect("it is read");
    assert_eq!(world.interpretation, backseat_mvc::InterpretationConfig::default());
    assert_eq!(world.vehicle, backseat_mvc::VehicleConfig::default());
    assert_eq!(world.silence, backseat_mvc::SilenceConfig::default());
    assert_eq!(world.adjustment, backseat_mvc::AdjustmentConfig::default());
    assert_eq!(world.power, backseat_mvc::PowerConfig::default());
    assert_eq!(world.dvl, backseat_mvc::DvlTriggerConfig::default());
    assert_eq!(world.sensors, backseat_mvc::SensorConfig::default());
    let spi = backseat_mvc::SpiConfig {
        roles: world.spi.roles.clone(),
        ..backseat_mvc::SpiConfig::default()
    };
    assert_eq!(world.spi, spi);
    let mission = backseat_mvc::MissionConfig {
        commands: world.mission.commands.clone(),
        ..backseat_mvc::MissionConfig::default()
    };
    assert_eq!(world.mission, mission);
}
