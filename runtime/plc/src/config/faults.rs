use core::time::Duration;

use backseat_s7k::plc::FailureCause;
use backseat_units::Timestamp;
use serde::{Deserialize, Serialize};

use super::PlcConfig;
use crate::error::PlcError;
use crate::faults::{Fault, FaultKind, FaultPlan};
use crate::sonar::SensorKind;

/// The most faults that a plan may have.
const FAULTS_MAX: usize = 100_000;

/// The longest time in a plan, seconds: ten years.
const LONGEST_S: f64 = 315_360_000.0;

/// One fault as it is written: `[[plc.fault]]`. Its kind decides which keys it needs and may have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultEntry {
    /// When it begins, seconds after the start.
    pub at_s: f64,
    /// How long it lasts, seconds. `link_closed` without it is instantaneous; every other kind needs it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
    /// What goes wrong.
    pub kind: FaultName,
    /// Faults of a sensor: which one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<SensorKind>,
    /// `pings_dropped` and `checksums_wrong`: the chance for each ping or record, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chance: Option<f64>,
    /// `sensor_unhealthy`: the cause in alarm 4, 0 to 4; 0 without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cause: Option<i32>,
    /// `sensor_unhealthy`: the sensor's own code in alarm 4; -1 without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<i32>,
    /// `flood`: how many records a second each client gets, 1 to 100000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub records_per_s: Option<f64>,
    /// `garbage`: how many bytes a second each client gets, 1 to 10000000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes_per_s: Option<f64>,
}

/// The name of a [`FaultKind`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "FaultKind documents them")]
pub enum FaultName {
    SensorDies,
    SensorUnhealthy,
    PingsDropped,
    StartFails,
    ShutdownFails,
    DataMissing,
    TimeRefused,
    CommandsRefused,
    ResetRefused,
    DiskFull,
    Stall,
    Flood,
    Garbage,
    ChecksumsWrong,
    LinkClosed,
    KeyMissing,
}

impl PlcConfig {
    /// The faults as a plan.
    ///
    /// # Errors
    /// [`PlcError::Fault`] with the fault's number, the key, and what was expected.
    pub fn plan(&self) -> Result<FaultPlan, PlcError> {
        if self.fault.len() > FAULTS_MAX {
            return Err(PlcError::Value {
                key: "plc.fault".to_owned(),
                value: format!("{} faults", self.fault.len()),
                expected: format!("at most {FAULTS_MAX}"),
            });
        }
        let numbered = (1..).zip(&self.fault);
        let faults = numbered.map(|(number, entry)| entry.fault().map_err(|fault| PlcError::Fault { number, fault }));
        Ok(FaultPlan {
            faults: faults.collect::<Result<_, _>>()?,
        })
    }
}

impl FaultEntry {
    /// The fault as it is written.
    #[must_use]
    pub fn of(fault: &Fault) -> Self {
        let mut entry = Self {
            at_s: fault.at.as_secs_f64(),
            for_s: Some(fault.lasts.as_secs_f64()),
            kind: fault.kind.name(),
            sensor: fault.kind.sensor(),
            chance: None,
            cause: None,
            code: None,
            records_per_s: None,
            bytes_per_s: None,
        };
        match fault.kind {
            FaultKind::SensorUnhealthy { cause, code, .. } => {
                (entry.cause, entry.code) = (Some(cause.code()), Some(code));
            }
            FaultKind::PingsDropped { chance, .. } | FaultKind::ChecksumsWrong { chance } => {
                entry.chance = Some(chance);
            }
            FaultKind::Flood { records_per_s } => entry.records_per_s = Some(records_per_s),
            FaultKind::Garbage { bytes_per_s } => entry.bytes_per_s = Some(bytes_per_s),
            FaultKind::SensorDies(_)
            | FaultKind::StartFails(_)
            | FaultKind::ShutdownFails(_)
            | FaultKind::DataMissing(_)
            | FaultKind::TimeRefused(_)
            | FaultKind::CommandsRefused(_)
            | FaultKind::ResetRefused(_)
            | FaultKind::DiskFull
            | FaultKind::Stall
            | FaultKind::LinkClosed
            | FaultKind::KeyMissing => {}
        }
        entry
    }

    fn fault(&self) -> Result<Fault, String> {
        use FaultName as Name;
        let at = seconds("at_s", self.at_s)?;
        let lasts = match (self.for_s, self.kind) {
            (Some(for_s), _) => seconds("for_s", for_s)?,
            (None, Name::LinkClosed) => Duration::ZERO,
            (None, _) => return Err(format!("{} needs `for_s`", self.written())),
        };
        let kind = match self.kind {
            Name::SensorDies => FaultKind::SensorDies(self.of_sensor(&[])?),
            Name::SensorUnhealthy => FaultKind::SensorUnhealthy {
                sensor: self.of_sensor(&["cause", "code"])?,
                cause: self.cause()?,
                code: self.code.unwrap_or(-1),
            },
            Name::PingsDropped => FaultKind::PingsDropped {
                sensor: self.of_sonar(&["chance"])?,
                chance: self.chance()?,
            },
            Name::StartFails => FaultKind::StartFails(self.of_sensor(&[])?),
            Name::ShutdownFails => FaultKind::ShutdownFails(self.of_sensor(&[])?),
            Name::DataMissing => FaultKind::DataMissing(self.of_sonar(&[])?),
            Name::TimeRefused => FaultKind::TimeRefused(self.of_sensor(&[])?),
            Name::CommandsRefused => FaultKind::CommandsRefused(self.of_sensor(&[])?),
            Name::ResetRefused => FaultKind::ResetRefused(self.of_sensor(&[])?),
            Name::DiskFull => self.plain(FaultKind::DiskFull)?,
            Name::Stall => self.plain(FaultKind::Stall)?,
            Name::LinkClosed => self.plain(FaultKind::LinkClosed)?,
            Name::KeyMissing => self.plain(FaultKind::KeyMissing)?,
            Name::Flood => {
                self.only(&["records_per_s"])?;
                let records_per_s = ranged("records_per_s", self.records_per_s, 1.0, 100_000.0)?;
                FaultKind::Flood { records_per_s }
            }
            Name::Garbage => {
                self.only(&["bytes_per_s"])?;
                let bytes_per_s = ranged("bytes_per_s", self.bytes_per_s, 1.0, 10_000_000.0)?;
                FaultKind::Garbage { bytes_per_s }
            }
            Name::ChecksumsWrong => {
                self.only(&["chance"])?;
                FaultKind::ChecksumsWrong { chance: self.chance()? }
            }
        };
        Ok(Fault {
            at: Timestamp::ZERO + at,
            lasts,
            kind,
        })
    }

    fn written(&self) -> String {
        self.kind.to_string()
    }

    fn plain(&self, kind: FaultKind) -> Result<FaultKind, String> {
        self.only(&[])?;
        Ok(kind)
    }

    fn of_sensor(&self, keys: &[&str]) -> Result<SensorKind, String> {
        self.only(&[keys, &["sensor"]].concat())?;
        self.sensor.ok_or_else(|| format!("{} needs `sensor`", self.written()))
    }

    fn of_sonar(&self, keys: &[&str]) -> Result<SensorKind, String> {
        let sensor = self.of_sensor(keys)?;
        if sensor.is_sonar() {
            Ok(sensor)
        } else {
            Err(format!("sensor is {sensor}, expected a sonar: only sonars ping"))
        }
    }

    fn chance(&self) -> Result<f64, String> {
        ranged("chance", self.chance, 0.0, 1.0)
    }

    fn cause(&self) -> Result<FailureCause, String> {
        let cause = self.cause.unwrap_or(0);
        let named = FailureCause::NAMED.into_iter().find(|named| named.code() == cause);
        named.ok_or_else(|| format!("cause is {cause}, expected 0 to 4"))
    }

    /// An error for a key that this kind does not have.
    fn only(&self, keys: &[&str]) -> Result<(), String> {
        for (key, given) in [
            ("sensor", self.sensor.is_some()),
            ("chance", self.chance.is_some()),
            ("cause", self.cause.is_some()),
            ("code", self.code.is_some()),
            ("records_per_s", self.records_per_s.is_some()),
            ("bytes_per_s", self.bytes_per_s.is_some()),
        ] {
            if given && !keys.contains(&key) {
                return Err(format!("{} has no `{key}`", self.written()));
            }
        }
        Ok(())
    }
}

impl core::fmt::Display for FaultName {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        // The name in a file.
        self.serialize(f)
    }
}

fn seconds(key: &str, value: f64) -> Result<Duration, String> {
    ranged(key, Some(value), 0.0, LONGEST_S).map(Duration::from_secs_f64)
}

fn ranged(key: &str, value: Option<f64>, least: f64, most: f64) -> Result<f64, String> {
    let value = value.ok_or_else(|| format!("`{key}` is missing"))?;
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{key} is {value}, expected {least} to {most}"))
    }
}
