//! Status messages of the payload controller (Table 17).

use super::form::{
    Each, Flag, Form as _, Int, Item, Last, LastButOne, PlcVersion, Sensor, Thousandths, Unsigned, Version, Word,
};
use super::table::texts;
use super::text::{Reader, TextError, TextFault, Writer, without_prefix};
use crate::SensorIndex;

texts! {
    /// A status of the payload controller.
    pub enum Status of Status;

    /// The controller's version.
    0 Version "" {
        /// The version.
        version: PlcVersion as Version, "X.YYZZ";
    }
    "1.0203"

    /// The sensor modules that the controller supports.
    1 Modules "Modules: " {
        /// The modules.
        modules: Vec<ModuleEntry> as Each<ModuleEntry>, "list";
    }
    "Modules: 2, Module = 1, EdgeTechSBP.dll, 1.0100, Module = 2, EdgeTechSS.dll, 1.0203"

    /// The active run list.
    2 RunList "Sensors: " {
        /// The sensors.
        sensors: Vec<RunListEntry> as Each<RunListEntry>, "list";
    }
    "Sensors: 1, Sensor = 0, 11002, 1, 5, 0, 21, HF sidescan"

    /// The state of logging.
    3 FileDetails "Logging = " {
        /// On or off.
        on: bool as Flag, "flag";
        /// The whole path of the file, if logging is on.
        file: Box<str> as LastButOne, "file name";
        /// The file's size.
        size_mb: f64 as Thousandths, "megabytes";
    }
    "Logging = 1, D:\\survey\\line 3, south.s7k, 12.345"

    /// The pulses that a sensor knows.
    4 SensorReply "PulseFiles: " {
        /// Their names.
        pulses: Vec<PulseName> as Each<PulseName>, "list";
    }
    "PulseFiles: 2, FM 4-24 kHz 10 ms, FM 2-12 kHz 20 ms"

    /// Size and overlap of log files.
    5 LoggingSetup "LoggingSetup = " {
        /// The size at which the next file begins.
        file_size: u32 as Unsigned, "megabytes";
        /// How many records of a file the next one repeats.
        overlap: u32 as Unsigned, "records";
        /// The folder of logged data. The specification does not say what the third parameter is.
        folder: Box<str> as Last, "folder";
    }
    "LoggingSetup = 100, 10, D:\\survey"

    /// The health of the sensors.
    6 Health "Sensors: " {
        /// The sensors.
        sensors: Vec<HealthEntry> as Each<HealthEntry>, "list";
    }
    "Sensors: 2, 0, 1, 1, 0"

    /// The controller is shutting down.
    7 Shutdown "" {}
    ""
}

impl Status {
    /// Reads the text of a status; `None` if Table 17 has no status of this number.
    ///
    /// # Errors
    /// In it, [`TextError`] names the status and the parameter.
    #[must_use]
    pub fn read(id: i32, text: &str) -> Option<Result<Self, TextError>> {
        // Some senders leave file and size out if logging is off.
        if id == 3 && without_prefix(text, "Logging = ").is_some_and(|rest| rest.trim() == "0") {
            return Some(Ok(Self::FileDetails {
                on: false,
                file: Box::from(""),
                size_mb: 0.0,
            }));
        }
        Self::read_row(id, text)
    }
}

/// A sensor module.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ModuleEntry {
    /// Its number, for the command "add".
    pub module: i32,
    /// Its file.
    pub file: Box<str>,
    /// Its version.
    pub version: PlcVersion,
}

impl Item for ModuleEntry {
    const FORMAT: &'static str = "%d N x (, Module = %d, %s, %0.4f)";

    fn read(reader: &mut Reader<'_>) -> Result<Self, TextFault> {
        Ok(Self {
            module: number_after(reader, "Module = ")?,
            file: Word::read(reader)?,
            version: Version::read(reader)?,
        })
    }

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        writer.push(format_args!("Module = {}", self.module));
        Word::write(&self.file, writer)?;
        Version::write(&self.version, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
        use proptest::strategy::Strategy as _;
        (Int::strategy(), Word::strategy(), Version::strategy())
            .prop_map(|(module, file, version)| Self { module, file, version })
            .boxed()
    }
}

/// A sensor of the run list.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct RunListEntry {
    /// Its index, for commands.
    pub sensor: SensorIndex,
    /// Its device identifier.
    pub id: i32,
    /// Its type.
    pub kind: i32,
    /// Its port.
    pub port: i32,
    /// Its medium.
    pub media: i32,
    /// Its subsystem.
    pub subsystem: i32,
    /// Its name.
    pub name: Box<str>,
}

impl Item for RunListEntry {
    const FORMAT: &'static str = "%d N x (, Sensor = %d, %d, %d, %d, %d, %d, %s)";

    fn read(reader: &mut Reader<'_>) -> Result<Self, TextFault> {
        Ok(Self {
            sensor: SensorIndex(number_after(reader, "Sensor = ")?),
            id: Int::read(reader)?,
            kind: Int::read(reader)?,
            port: Int::read(reader)?,
            media: Int::read(reader)?,
            subsystem: Int::read(reader)?,
            name: Word::read(reader)?,
        })
    }

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        writer.push(format_args!("Sensor = {}", self.sensor));
        for number in [self.id, self.kind, self.port, self.media, self.subsystem] {
            Int::write(&number, writer)?;
        }
        Word::write(&self.name, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
        use proptest::strategy::Strategy as _;
        let numbers = proptest::array::uniform6(proptest::num::i32::ANY);
        (numbers, Word::strategy())
            .prop_map(|([sensor, id, kind, port, media, subsystem], name)| Self {
                sensor: SensorIndex(sensor),
                id,
                kind,
                port,
                media,
                subsystem,
                name,
            })
            .boxed()
    }
}

/// A pulse's name.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(transparent)]
pub struct PulseName(pub Box<str>);

impl Item for PulseName {
    const FORMAT: &'static str = "%d, N x (, %s)";

    fn read(reader: &mut Reader<'_>) -> Result<Self, TextFault> {
        let name = Word::read(reader)?;
        // The format as it is printed has two commas before the first name.
        if name.is_empty() {
            Word::read(reader).map(Self)
        } else {
            Ok(Self(name))
        }
    }

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        if self.0.is_empty() {
            return Err(TextFault::Missing);
        }
        Word::write(&self.0, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
        use proptest::strategy::Strategy as _;
        Word::strategy().prop_map(Self).boxed()
    }
}

/// The health of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct HealthEntry {
    /// The sensor.
    pub sensor: SensorIndex,
    /// Whether it is healthy.
    pub healthy: bool,
}

impl Item for HealthEntry {
    const FORMAT: &'static str = "%lu N x (, %d, %d)";

    fn read(reader: &mut Reader<'_>) -> Result<Self, TextFault> {
        Ok(Self {
            sensor: Sensor::read(reader)?,
            healthy: Flag::read(reader)?,
        })
    }

    fn write(&self, writer: &mut Writer<'_>) -> Result<(), TextFault> {
        Sensor::write(&self.sensor, writer)?;
        Flag::write(&self.healthy, writer)
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
        use proptest::strategy::Strategy as _;
        (Sensor::strategy(), Flag::strategy())
            .prop_map(|(sensor, healthy)| Self { sensor, healthy })
            .boxed()
    }
}

/// A number whose parameter begins with a word.
fn number_after(reader: &mut Reader<'_>, prefix: &'static str) -> Result<i32, TextFault> {
    let text = reader.next()?;
    let number = without_prefix(text, prefix).and_then(|number| number.trim().parse().ok());
    number.ok_or_else(|| TextFault::expected("the entry's word and number, as in `Module = 1` or `Sensor = 0`", text))
}
