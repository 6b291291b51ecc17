//! The table `[plc]`: what it refuses, and how it says so.

use backseat_plc::{PlcConfig, SensorKind};

fn fault(table: &str) -> String {
    match toml::from_str::<PlcConfig>(table) {
        Ok(config) => config.validate().expect_err("it is wrong").to_string(),
        Err(error) => error.message().to_owned(),
    }
}

#[test]
fn the_defaults_are_allowed() {
    assert_eq!(PlcConfig::default().validate(), Ok(()));
    assert_eq!(toml::from_str::<PlcConfig>(""), Ok(PlcConfig::default()));
}

#[test]
fn a_wrong_value_names_its_key_and_what_is_allowed() {
    for (table, message) in [
        (
            "version = \"1.2\"",
            "plc.version is \"1.2\", expected a version of the form \"1.02.03\"",
        ),
        ("clients_max = 65", "plc.clients_max is 65, expected 1 to 64"),
        (
            "packet_size_bytes = 36",
            "plc.packet_size_bytes is 36, expected 37 to 16777216 bytes",
        ),
        ("protocol_version = 3", "plc.protocol_version is 3, expected 4 to 5"),
        (
            "clock_drift_ppm = [5, 2000]",
            "plc.clock_drift_ppm is 2000, expected 5 to 1000 ppm",
        ),
        ("reply_s = nan", "expected a finite number"),
        ("shutdown_s = nan", "plc.shutdown_s is NaN, expected 0 to 60 s"),
        (
            "disk = { used_mb = 90000 }",
            "plc.disk.used_mb is 90000, expected 0 to 80000 MB",
        ),
        (
            "logging = { file_size_mb = 0 }",
            "plc.logging.file_size_mb is 0, expected 1 to 4096 MB",
        ),
        (
            "logging = { folder = \" x\" }",
            "plc.logging.folder is \" x\", expected 1 to 200 printable characters without spaces at the ends",
        ),
        (
            "sub_bottom = { range_m = 400 }",
            "plc.sub_bottom.range_m is 400, expected 5 to 300 m",
        ),
        (
            "sidescan_high = { pulses = [] }",
            "plc.sidescan_high.pulses is 0, expected 1 to 32 pulses",
        ),
        (
            "sensor = [{ kind = \"bluefin\", name = \"a\" }, { kind = \"bluefin\", name = \"b\" }]",
            "plc.sensor.kind is Bluefin vehicle, expected one sensor of each kind",
        ),
        (
            "sensor = [{ kind = \"bluefin\", name = \"a,b\" }]",
            "plc.sensor.name is \"a,b\", expected 1 to 64 printable characters without comma",
        ),
        (
            "[[fault]]\nat_s = 1\nkind = \"stall\"",
            "plc fault 1: stall needs `for_s`",
        ),
    ] {
        assert!(fault(table).starts_with(message), "{table}: {}", fault(table));
    }
}

#[test]
fn an_unknown_key_is_refused() {
    for table in [
        "speed = 1",
        "disk = { size = 1 }",
        "sub_bottom = { range = 1 }",
        "interpretation = { ack = \"first\" }",
        "[[fault]]\nat_s = 1\nkind = \"stall\"\nfor_s = 1\nwhy = 1",
        "[[sensor]]\nkind = \"bluefin\"\nname = \"x\"\nindex = 3",
    ] {
        assert!(fault(table).contains("unknown field"), "{table}: {}", fault(table));
    }
}

#[test]
fn a_sonar_keeps_its_own_defaults_beside_what_is_given() {
    let config: PlcConfig = toml::from_str("sidescan_high = { range_m = 60 }").expect("a table");
    assert_eq!(
        (config.sidescan_high.range_m, config.sidescan_high.range_max_m),
        (60.0, 150.0)
    );
    assert_eq!(config.sidescan_high.sample_interval_us, 20);
    assert_eq!(config.sidescan_low, PlcConfig::default().sidescan_low);
    let kinds: Vec<SensorKind> = config.sensor.iter().map(|sensor| sensor.kind).collect();
    assert_eq!(kinds, SensorKind::ALL);
}
