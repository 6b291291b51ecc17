//! The table `[plc]` of `world.toml`.

mod faults;
mod sensors;

use backseat_s7k::BluefinChecksum;
use backseat_s7k::plc::PlcVersion;
use backseat_s7k::record::HeaderLayout;
use backseat_world::Span;
use serde::Deserialize;

use crate::error::{PlcError, check, within};
use crate::interpretation::InterpretationConfig;

pub use faults::{FaultEntry, FaultName};
pub(crate) use sensors::{PERIOD_MAX_MS, PERIOD_MIN_MS, is_name};
pub use sensors::{PulseConfig, SensorEntry, SonarConfig};

/// The table `[plc]`: the payload controller with its sensors.
///
/// The defaults are typical of a sidescan and sub-bottom package of this class; they are not the maker's.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlcConfig {
    /// The controller's version, of the form `X.YY.ZZ`.
    pub version: String,
    /// How many clients may be connected, 1 to 64.
    pub clients_max: u32,
    /// How many bytes may wait for a client that does not read, 65536 to 268435456. What does not fit is lost.
    pub send_buffer_bytes: u32,
    /// How many bytes of a client wait while the controller stalls, 4096 to 16777216. What does not fit is lost; a
    /// driver does not read them from its socket: see [`crate::Plc::reads`].
    pub receive_buffer_bytes: u32,
    /// The longest record that is accepted from a client, bytes, 1024 to 16777216.
    pub record_max_bytes: u32,
    /// The longest packet on the wire with its network frame, bytes, 37 to 16777216.
    pub packet_size_bytes: u32,
    /// The protocol version of frames, 4 or 5. Version 4 is that of Volume III 0.53.
    pub protocol_version: u16,
    /// The layout of the record type header of records 3000 and 3001.
    pub header_layout: LayoutName,
    /// How the checksum of a Bluefin frame is computed. A wrong one is counted, and the frame is used.
    pub bluefin_checksum: BluefinChecksumName,
    /// How far the controller's clock is ahead of UTC at the start, seconds, within 86400.
    pub clock_offset_s: Span,
    /// How fast the controller's clock gains, parts in a million, within 1000.
    pub clock_drift_ppm: Span,
    /// How late a time is when the command "time sync" sets it, seconds, 0 to 10.
    pub sync_delay_s: Span,
    /// Whether the controller sends time messages (record 7400) from the start.
    pub time_messages: bool,
    /// The time from one time message to the next, seconds, 1 to 3600.
    pub time_message_period_s: f64,
    /// Whether logging and pinging begin at the start, unless the stored settings say otherwise.
    pub auto_start: bool,
    /// The period of the health check from the start, seconds, 0.1 to 86400. `None`: there is none until a client asks
    /// for it.
    pub health_period_s: Option<f64>,
    /// The time in which a sensor answers, seconds, 0 to 60.
    pub reply_s: Span,
    /// How long a sensor is silent before alarm 2, seconds, 0.1 to 3600.
    pub silent_after_s: f64,
    /// How long a sensor gives no data before alarm 8, seconds, 0.1 to 3600.
    pub no_data_after_s: f64,
    /// The time from the status "shutdown" to the end of the connections, seconds, 0 to 60.
    pub shutdown_s: f64,
    /// The time from alarm 15 to the end of the controller, seconds, 0 to 86400.
    pub key_grace_s: f64,
    /// The speed of sound until a record 3100 has one, m/s, 1300 to 1700.
    pub sound_speed_mps: f64,
    /// The controller's disk.
    pub disk: DiskConfig,
    /// Logging.
    pub logging: LoggingConfig,
    /// The run list at the start, unless a stored one is given. Default: one sensor of each kind.
    pub sensor: Vec<SensorEntry>,
    /// The sub-bottom profiler.
    #[serde(deserialize_with = "sensors::sub_bottom")]
    pub sub_bottom: SonarConfig,
    /// The sidescan's low frequency.
    #[serde(deserialize_with = "sensors::sidescan_low")]
    pub sidescan_low: SonarConfig,
    /// The sidescan's high frequency.
    #[serde(deserialize_with = "sensors::sidescan_high")]
    pub sidescan_high: SonarConfig,
    /// How the controller reads what the specification leaves open.
    pub interpretation: InterpretationConfig,
    /// What goes wrong, and when.
    pub fault: Vec<FaultEntry>,
}

/// The table `[plc.disk]`. A megabyte is 1,000,000 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DiskConfig {
    /// The size of the disk, megabytes, 1 to 1e9.
    pub capacity_mb: f64,
    /// How much of it is used at the start, megabytes, 0 to the capacity.
    pub used_mb: f64,
    /// Alarm 1 is active while this much or less is free, percent of the capacity, 0 to 100.
    pub critical_percent: f64,
}

/// The table `[plc.logging]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoggingConfig {
    /// The folder of log files, as the controller writes it: 1 to 200 printable characters.
    pub folder: String,
    /// The size at which the next file begins, megabytes, 1 to 4096.
    pub file_size_mb: u32,
    /// How many records of a file the next one repeats, 0 to 1000.
    pub overlap_records: u32,
}

/// The name of a [`HeaderLayout`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayoutName {
    /// 20 bytes, as in Volume III.
    #[default]
    Spec,
    /// 32 bytes, as the best-known public reader expects.
    Padded,
}

/// The name of a [`BluefinChecksum`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BluefinChecksumName {
    /// Over the whole packet with the checksum's own bytes as zeros.
    #[default]
    WholePacket,
    /// Over the data only.
    DataOnly,
    /// None is checked.
    None,
}

impl LayoutName {
    pub(crate) const fn layout(self) -> HeaderLayout {
        match self {
            Self::Spec => HeaderLayout::Spec,
            Self::Padded => HeaderLayout::Padded,
        }
    }
}

impl BluefinChecksumName {
    pub(crate) const fn checksum(self) -> BluefinChecksum {
        match self {
            Self::WholePacket => BluefinChecksum::WholePacket,
            Self::DataOnly => BluefinChecksum::DataOnly,
            Self::None => BluefinChecksum::None,
        }
    }
}

impl Default for PlcConfig {
    fn default() -> Self {
        Self {
            version: "1.02.03".to_owned(),
            clients_max: 8,
            send_buffer_bytes: 4 << 20,
            receive_buffer_bytes: 256 << 10,
            record_max_bytes: 1 << 20,
            packet_size_bytes: 60_000,
            protocol_version: 4,
            header_layout: LayoutName::Spec,
            bluefin_checksum: BluefinChecksumName::WholePacket,
            clock_offset_s: Span::fixed(0.0),
            clock_drift_ppm: Span::fixed(0.0),
            sync_delay_s: Span::fixed(0.0),
            time_messages: false,
            time_message_period_s: 60.0,
            auto_start: false,
            health_period_s: None,
            reply_s: Span::between(0.01, 0.1),
            silent_after_s: 5.0,
            no_data_after_s: 5.0,
            shutdown_s: 1.0,
            key_grace_s: 60.0,
            sound_speed_mps: 1500.0,
            disk: DiskConfig::default(),
            logging: LoggingConfig::default(),
            sensor: SensorEntry::defaults(),
            sub_bottom: SonarConfig::sub_bottom(),
            sidescan_low: SonarConfig::sidescan_low(),
            sidescan_high: SonarConfig::sidescan_high(),
            interpretation: InterpretationConfig::default(),
            fault: Vec::new(),
        }
    }
}

impl Default for DiskConfig {
    fn default() -> Self {
        Self {
            capacity_mb: 80_000.0,
            used_mb: 8_000.0,
            critical_percent: 10.0,
        }
    }
}

impl Default for LoggingConfig {
    fn default() -> Self {
        Self {
            folder: "D:\\data".to_owned(),
            file_size_mb: 100,
            overlap_records: 0,
        }
    }
}

/// The least and greatest size of a log file, megabytes, and the greatest overlap, records: also for command 26.
pub(crate) const FILE_SIZE_MB: core::ops::RangeInclusive<u32> = 1..=4096;
pub(crate) const OVERLAP_MAX: u32 = 1000;

impl PlcConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`PlcError`] names the key, what was found and what was expected.
    pub fn validate(&self) -> Result<(), PlcError> {
        parse_version(&self.version)?;
        let mib = f64::from(16_u32 << 20);
        for (key, value, least, most, unit) in [
            ("plc.clients_max", f64::from(self.clients_max), 1.0, 64.0, ""),
            (
                "plc.send_buffer_bytes",
                f64::from(self.send_buffer_bytes),
                65_536.0,
                16.0 * mib,
                "bytes",
            ),
            (
                "plc.receive_buffer_bytes",
                f64::from(self.receive_buffer_bytes),
                4096.0,
                mib,
                "bytes",
            ),
            (
                "plc.record_max_bytes",
                f64::from(self.record_max_bytes),
                1024.0,
                mib,
                "bytes",
            ),
            (
                "plc.packet_size_bytes",
                f64::from(self.packet_size_bytes),
                37.0,
                mib,
                "bytes",
            ),
            ("plc.protocol_version", f64::from(self.protocol_version), 4.0, 5.0, ""),
            (
                "plc.time_message_period_s",
                self.time_message_period_s,
                1.0,
                3600.0,
                "s",
            ),
            (
                "plc.health_period_s",
                self.health_period_s.unwrap_or(1.0),
                0.1,
                86_400.0,
                "s",
            ),
            ("plc.silent_after_s", self.silent_after_s, 0.1, 3600.0, "s"),
            ("plc.no_data_after_s", self.no_data_after_s, 0.1, 3600.0, "s"),
            ("plc.shutdown_s", self.shutdown_s, 0.0, 60.0, "s"),
            ("plc.key_grace_s", self.key_grace_s, 0.0, 86_400.0, "s"),
            ("plc.sound_speed_mps", self.sound_speed_mps, 1300.0, 1700.0, "m/s"),
            ("plc.disk.capacity_mb", self.disk.capacity_mb, 1.0, 1e9, "MB"),
            ("plc.disk.used_mb", self.disk.used_mb, 0.0, self.disk.capacity_mb, "MB"),
            ("plc.disk.critical_percent", self.disk.critical_percent, 0.0, 100.0, "%"),
            (
                "plc.logging.file_size_mb",
                f64::from(self.logging.file_size_mb),
                f64::from(*FILE_SIZE_MB.start()),
                f64::from(*FILE_SIZE_MB.end()),
                "MB",
            ),
            (
                "plc.logging.overlap_records",
                f64::from(self.logging.overlap_records),
                0.0,
                f64::from(OVERLAP_MAX),
                "records",
            ),
        ] {
            within(value, least, most, key, unit)?;
        }
        for (key, value, least, most, unit) in [
            ("plc.clock_offset_s", self.clock_offset_s, -86_400.0, 86_400.0, "s"),
            ("plc.clock_drift_ppm", self.clock_drift_ppm, -1000.0, 1000.0, "ppm"),
            ("plc.sync_delay_s", self.sync_delay_s, 0.0, 10.0, "s"),
            ("plc.reply_s", self.reply_s, 0.0, 60.0, "s"),
        ] {
            span_within(value, least, most, key, unit)?;
        }
        let folder = &self.logging.folder;
        check(
            is_plain_text(folder),
            "plc.logging.folder",
            format!("{folder:?}"),
            "1 to 200 printable characters without spaces at the ends",
        )?;
        sensors::validate(&self.sensor)?;
        self.sub_bottom.validate("sub_bottom")?;
        self.sidescan_low.validate("sidescan_low")?;
        self.sidescan_high.validate("sidescan_high")?;
        self.plan().map(drop)
    }
}

/// A range of a key whose bounds both lie inside the key's own, in order.
pub(crate) fn span_within(span: Span, least: f64, most: f64, key: &str, unit: &str) -> Result<(), PlcError> {
    within(span.least(), least, most, key, unit)?;
    within(span.most(), span.least(), most, key, unit)
}

/// Whether a text of a configuration or a client can stand in a status: short, printable, no space at its ends.
pub(crate) fn is_plain_text(text: &str) -> bool {
    (1..=200).contains(&text.len()) && !text.contains(char::is_control) && text.trim() == text
}

/// A version of the form `1.02.03`.
pub(crate) fn parse_version(text: &str) -> Result<PlcVersion, PlcError> {
    let version = || {
        let mut parts = text.split('.');
        let version = PlcVersion {
            major: parts.next()?.parse().ok()?,
            minor: parts.next()?.parse().ok()?,
            maintenance: parts.next()?.parse().ok()?,
        };
        let fine = parts.next().is_none() && version.minor <= 99 && version.maintenance <= 99;
        fine.then_some(version)
    };
    version().ok_or_else(|| PlcError::Value {
        key: "plc.version".to_owned(),
        value: format!("{text:?}"),
        expected: "a version of the form \"1.02.03\"".to_owned(),
    })
}
