use backseat_sonar::{PingGrant, SonarConfig};

use crate::file::PluginTable;

/// How many `[[plugin.ping]]` tables all plugins may have together.
const PINGS_MAX: usize = 16;
/// The most samples of a channel that a ping may have.
const SAMPLES_MAX: u16 = 4096;

/// What is wrong with `[sonar]`, or with the first invalid `[[plugin.ping]]`, in one line.
pub(crate) fn check_sonar(sonar: Option<&SonarConfig>, plugins: &[PluginTable]) -> Result<(), String> {
    if let Some(sonar) = sonar {
        let is_wrong = |error: backseat_sonar::ConfigError| {
            format!("sonar.{} is {}: expected {}", error.key, error.found, error.expected)
        };
        sonar.check().map_err(is_wrong)?;
    }
    let count: usize = plugins.iter().map(|plugin| plugin.pings.len()).sum();
    if count > PINGS_MAX {
        return Err(format!(
            "the plugins have {count} [[plugin.ping]] tables: expected at most {PINGS_MAX}"
        ));
    }
    for plugin in plugins {
        for ping in &plugin.pings {
            check_ping(sonar, ping).map_err(|fault| format!("plugin `{}`: ping.{fault}", plugin.name))?;
        }
    }
    Ok(())
}

fn check_ping(sonar: Option<&SonarConfig>, ping: &PingGrant) -> Result<(), String> {
    let Some(sonar) = sonar else {
        return Err(format!(
            "sensor is {}, and the mission has no [sonar]: expected one with that [[sonar.sensor]]",
            ping.sensor
        ));
    };
    if !sonar.sensor.iter().any(|sensor| sensor.index == ping.sensor) {
        let known: Vec<String> = sonar.sensor.iter().map(|sensor| sensor.index.to_string()).collect();
        let known = if known.is_empty() {
            "there is none".to_owned()
        } else {
            known.join(", ")
        };
        return Err(format!(
            "sensor is {}: expected the index of a [[sonar.sensor]]: {known}",
            ping.sensor
        ));
    }
    if !(1..=SAMPLES_MAX).contains(&ping.samples) {
        return Err(format!("samples is {}: expected 1 to {SAMPLES_MAX}", ping.samples));
    }
    Ok(())
}
