//! The run list in the controller's file 6046.sav. The specification does not describe the file; this is the mock's own.

use super::Suite;
use crate::config::{SensorEntry, is_name};
use crate::error::PlcError;
use crate::sonar::SensorKind;
use crate::suite::kind_of;

/// The file's first line.
const TITLE: &str = "6046 run list 1";

impl Suite {
    /// The run list as a file: a title, then a line a sensor with what the command "add" takes.
    pub(crate) fn saved(&self) -> String {
        let mut text = format!("{TITLE}\n");
        for sensor in &self.sensors {
            let (module, subsystem) = (sensor.kind.module(), sensor.kind.subsystem());
            text.push_str(&format!("{module}, {subsystem}, {}, {}\n", sensor.port, sensor.name));
        }
        text
    }
}

/// Reads a saved run list.
pub(crate) fn parse(text: &str) -> Result<Vec<SensorEntry>, PlcError> {
    let fail = |line: usize, fault: &str| PlcError::Stored {
        file: "6046.sav",
        line,
        fault: fault.to_owned(),
    };
    let mut lines = (1..).zip(text.lines());
    if lines.next().map(|(_, line)| line) != Some(TITLE) {
        return Err(fail(1, "expected the title \"6046 run list 1\""));
    }
    let mut sensors: Vec<SensorEntry> = Vec::new();
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let entry = entry(line).ok_or_else(|| fail(number, "expected module, subsystem, port and name of a sensor"))?;
        if sensors.iter().any(|sensor| sensor.kind == entry.kind) {
            return Err(fail(number, "expected each subsystem once"));
        }
        sensors.push(entry);
    }
    Ok(sensors)
}

fn entry(line: &str) -> Option<SensorEntry> {
    let mut parts = line.splitn(4, ',').map(str::trim);
    let kind: SensorKind = kind_of(parts.next()?.parse().ok()?, parts.next()?.parse().ok()?)?;
    let port = parts.next()?.parse().ok()?;
    let name = parts.next().filter(|name| is_name(name))?.to_owned();
    Some(SensorEntry { kind, name, port })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_list_that_cannot_be_read_names_its_line() {
        let fault = |text: &str| parse(text).unwrap_err().to_string();
        assert!(fault("").starts_with("6046.sav, line 1: expected the title"));
        assert!(fault("6046 run list 1\n2, 22, 1, x").starts_with("6046.sav, line 2: expected module"));
        assert!(fault("6046 run list 1\n2, 20, 1, x\n\n2, 20, 2, y").starts_with("6046.sav, line 4: expected each"));
        let read = parse("6046 run list 1\n2, 21, 5, HF sidescan\n").unwrap();
        assert_eq!(
            (read[0].kind, read[0].port, read[0].name.as_str()),
            (SensorKind::SidescanHigh, 5, "HF sidescan")
        );
    }
}
