//! Whether the simulated payload controller can do what the mission's `[sonar]` wants, and what the document of the
//! format allows. A setting that the controller rejects shows in the log only, and a record that no sensor sends shows
//! nowhere.

use backseat_mission::Mission;
use backseat_plc::{PlcConfig, SensorKind, SonarConfig};
use backseat_scenario::Scenario;
use backseat_sonar::SensorConfig;

/// What the controller will reject or never send, one line each.
pub(crate) fn beyond_sonar(mission: &Mission, scenario: &Scenario) -> Vec<String> {
    let Some(sonar) = &mission.file.sonar else {
        return Vec::new();
    };
    let Some(plc) = &scenario.plc else {
        return vec![
            "sonar: mission.toml has [sonar], and world.toml has no [plc]: the simulation has no payload controller; \
             add [plc] to world.toml"
                .to_owned(),
        ];
    };
    let sensors = sonar.sensor.iter();
    sensors.flat_map(|sensor| of_sensor(sensor, plc)).collect()
}

fn of_sensor(sensor: &SensorConfig, plc: &PlcConfig) -> Vec<String> {
    let index = sensor.index;
    let loaded: Vec<SensorKind> = plc.sensor.iter().map(|entry| entry.kind).collect();
    let entry = usize::try_from(index).ok().and_then(|index| loaded.get(index));
    let Some(kind) = entry.copied() else {
        return vec![format!(
            "sonar: sensor.index is {index}, and the run list of [plc] in world.toml has {} sensors, counted from 0",
            loaded.len()
        )];
    };
    let mut lines = Vec::new();
    let mut warn = |key: &str, value: &str, expected: &str| {
        lines.push(format!("sonar: sensor {index}: {key} is {value}, {expected}"));
    };
    let device = kind.device().0;
    if sensor.device != device {
        let expected = format!("and sensor {index} of [plc] in world.toml is {kind}, device {device}");
        warn("device", &sensor.device.to_string(), &expected);
    }
    for record in sensor.records.iter().filter(|record| **record != kind.record_type()) {
        let expected = format!("and {kind} sends {}", kind.record_type());
        warn("records", &record.to_string(), &expected);
    }
    if let Some(can) = sonar_of(plc, kind) {
        beyond_sonar_of(sensor, can, &mut warn);
    }
    lines
}

fn sonar_of(plc: &PlcConfig, kind: SensorKind) -> Option<&SonarConfig> {
    match kind {
        SensorKind::SubBottom => Some(&plc.sub_bottom),
        SensorKind::SidescanLow => Some(&plc.sidescan_low),
        SensorKind::SidescanHigh => Some(&plc.sidescan_high),
        SensorKind::Bluefin => None,
    }
}

/// The limits that the mock keeps; those of power and period are the mission's own check and Table 19's.
fn beyond_sonar_of(sensor: &SensorConfig, can: &SonarConfig, warn: &mut impl FnMut(&str, &str, &str)) {
    if let Some(range_m) = sensor.range_m
        && !(can.range_min_m..=can.range_max_m).contains(&range_m)
    {
        let expected = format!(
            "and the sonar of world.toml takes {} to {} m",
            can.range_min_m, can.range_max_m
        );
        warn("range_m", &range_m.to_string(), &expected);
    }
    if let Some(pulse) = &sensor.pulse
        && !can.pulses.iter().any(|own| own.name == *pulse)
    {
        let names: Vec<String> = can.pulses.iter().map(|own| format!("{:?}", own.name)).collect();
        let expected = format!("and the sonar of world.toml has {}", names.join(", "));
        warn("pulse", &format!("{pulse:?}"), &expected);
    }
    if let Some(gain) = sensor.gain
        && !(0..=can.gain_max_steps).contains(&gain)
    {
        let expected = format!("and the sonar of world.toml takes 0 to {}", can.gain_max_steps);
        warn("gain", &gain.to_string(), &expected);
    }
    if let Some(period_ms) = sensor.period_ms
        && !(10.0..=60_000.0).contains(&period_ms)
    {
        warn(
            "period_ms",
            &period_ms.to_string(),
            "and the sonar of world.toml takes 10 to 60000 ms",
        );
    }
    if let Some(power) = sensor.power_percent
        && !(0.0..=100.0).contains(&power)
    {
        warn("power_percent", &power.to_string(), "and a sonar takes 0 to 100 %");
    }
}
