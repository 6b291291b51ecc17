use backseat_mvc::{Mvc, WorldFile};

/// The mock must accept the files that people copy from the page.
#[test]
fn the_mock_accepts_the_files_of_the_documentation() {
    let text = include_str!("../../../docs/mock.md");
    let files: Vec<&str> = text
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert_eq!(files.len(), 3);
    for file in files {
        let world = WorldFile::from_toml(file).unwrap_or_else(|error| panic!("{error}"));
        for seed in 0..3 {
            Mvc::new(&world, seed).unwrap_or_else(|error| panic!("{error}"));
        }
    }
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
