//! The table of mission.toml.

use backseat_s7k::BluefinChecksum;
use backseat_sonar::{
    ChecksumPolicy, Decimation, ExpectedLayout, NavigationTimes, PingGrant, SensorConfig, ShutdownKind, Sonar,
    SonarConfig,
};

use crate::trial::{config, start};

#[test]
fn an_empty_table_has_the_defaults() {
    let settings: SonarConfig = toml::from_str("").unwrap();
    assert_eq!(settings, SonarConfig::default());
    assert_eq!((settings.port, settings.shutdown), (7000, ShutdownKind::Controller));
    settings.check().unwrap();
}

#[test]
fn every_key_is_read() {
    let text = r#"
        host = "192.168.1.20"
        port = 7001
        verbose = false
        time_sync = false
        time_messages = false
        shutdown = "system"
        logging = { file_size = 200, overlap = 5 }
        vehicle_data = false
        route_to = 1
        navigation_times = "day"
        bluefin_checksum = "data_only"
        checksum = "refuse"
        header_layout = "padded"
        reconnect_min_s = 0.5
        reconnect_max_s = 30
        command_timeout_s = 2
        command_attempts = 2
        health_period_s = 5
        frame_limit_bytes = 1000000

        [[sensor]]
        index = 0
        device = 11002
        records = [3000]
    "#;
    let settings: SonarConfig = toml::from_str(text).unwrap();
    settings.check().unwrap();
    let sensor = SensorConfig {
        index: 0,
        device: 11_002,
        records: vec![3000],
        ..SensorConfig::default()
    };
    assert_eq!(settings.sensor, [sensor]);
    assert_eq!(settings.bluefin_checksum, BluefinChecksum::DataOnly);
    assert_eq!(settings.checksum, ChecksumPolicy::Refuse);
    assert_eq!(settings.header_layout, ExpectedLayout::Padded);
    assert_eq!(settings.navigation_times, NavigationTimes::Day);
    // What is written is read as the same.
    let again: SonarConfig = toml::from_str(&toml::to_string(&settings).unwrap()).unwrap();
    assert_eq!(again, settings);
}

#[test]
fn an_unknown_key_is_refused() {
    let error = |text: &str| toml::from_str::<SonarConfig>(text).unwrap_err().to_string();
    assert!(error("port = 70000").contains("invalid value: integer `70000`, expected 1 to 65535"));
    assert!(error("prot = 7000").contains("unknown field `prot`"));
    assert!(error("[[sensor]]\nindex = 0\ndevice = 1\nrecords = [1]\nname = \"x\"").contains("unknown field `name`"));
    assert!(error("logging = { file_size = 1, overlap = 1, folder = \"x\" }").contains("unknown field `folder`"));
}

#[test]
fn a_value_outside_its_range_is_named() {
    let fault = |change: fn(&mut SonarConfig)| {
        let mut settings = config();
        change(&mut settings);
        settings.check().unwrap_err().to_string()
    };
    assert_eq!(
        fault(|settings| settings.command_timeout_s = 0.1),
        "sonar setting command_timeout_s: 0.1 is not within 0.2 to 30"
    );
    assert_eq!(
        fault(|settings| settings.reconnect_max_s = 0.5),
        "sonar setting reconnect_max_s: 0.5 is not within 1 to 600"
    );
    assert!(fault(|settings| settings.health_period_s = f64::NAN).contains("NaN is not within 1 to 600"));
    assert!(fault(|settings| settings.port = 0).contains("port"));
    assert!(fault(|settings| settings.host.clear()).contains("host"));
    assert!(fault(|settings| settings.command_attempts = 0).contains("command_attempts"));
    assert!(fault(|settings| settings.frame_limit_bytes = 1000).contains("frame_limit_bytes"));
    assert!(fault(|settings| settings.route_to = Some(-1)).contains("route_to"));
    assert!(fault(|settings| settings.sensor[1].index = -1).contains("sensor[1].index"));
    assert!(fault(|settings| settings.sensor[1].index = 0).contains("an index that no other sensor has"));
    assert!(fault(|settings| settings.sensor[1].device = 11_001).contains("a device that no other sensor has"));
    assert_eq!(
        fault(|settings| settings.sensor[1].range_m = Some(0.0)),
        "sonar setting sensor[1].range_m: Range = 0.00 is not allowed: the range must be over 0 m"
    );
    assert!(fault(|settings| settings.sensor[0].power_percent = Some(101.0)).contains("within 0 to 100 %"));
    assert!(fault(|settings| settings.sensor[0].pulse = Some("\n".to_owned())).contains("sensor[0].pulse"));
    assert!(fault(|settings| settings.sensor[1].records.clear()).contains("1 to 8 record types"));
    assert!(fault(|settings| settings.sensor = vec![settings.sensor[0].clone(); 17]).contains("at most 16 sensors"));
}

#[test]
fn a_grant_outside_its_range_is_named() {
    let fault = |sensor: i32, samples: u16| {
        let grant = PingGrant {
            sensor,
            samples,
            decimation: Decimation::Mean,
        };
        Sonar::new(config(), start(vec![grant])).unwrap_err().to_string()
    };
    assert_eq!(
        fault(0, 0),
        "sonar setting grants[0].samples: 0 is not within 1 to 4096"
    );
    assert_eq!(
        fault(9, 1),
        "sonar setting grants[0].sensor: 9 is not the index of a configured sensor"
    );
}

#[test]
fn the_page_has_every_key() {
    let page = include_str!("../../../docs/sonar.md");
    let settings = SonarConfig {
        logging: Some(backseat_sonar::LoggingSetup {
            file_size: 1,
            overlap: 0,
        }),
        route_to: Some(0),
        ..config()
    };
    let table: toml::Table = toml::from_str(&toml::to_string(&settings).unwrap()).unwrap();
    assert_eq!(table.len(), 21);
    for key in table.keys() {
        let row = if key == "sensor" {
            "| `[[sensor]]` |".to_owned()
        } else {
            format!("| `{key}` |")
        };
        assert!(page.contains(&row), "{key}");
    }
}
