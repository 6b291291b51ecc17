use std::time::Duration;

use backseat_spi::{Entry, EntryField, FromVehicle, catalogue};
use serde_json::{Map, Value};

use super::link::name;
use super::{Batch, Moment, Topic};
use crate::decimation::Decimation;
use crate::schema::Fields;

/// The sentences that are measurements or states, and nothing but that.
const SENSORS: [&str; 16] = [
    "BFTEL", "BFSVS", "BFRCM", "BFRDP", "BFRVL", "BFRBS", "BFERC", "BFDVL", "BFDV2", "BFIMU", "BFCTD", "BFRNV",
    "BFPIT", "BFCNV", "BFTRM", "BFBOY",
];
/// Compasses and batteries have numbers. Each number has its own second; all numbers from this one on share one.
const NUMBERS: usize = 16;

/// A sentence of [`SENSORS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sensor(usize);

impl Sensor {
    /// How many there are.
    pub(crate) const COUNT: usize = SENSORS.len();

    pub(crate) fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT).map(Self)
    }

    fn of(line: &[u8]) -> Option<Self> {
        let name = name(line);
        if !name.starts_with(b"BF") || name.starts_with(b"BFNV") {
            // Nine of ten lines.
            return None;
        }
        SENSORS.iter().position(|sensor| sensor.as_bytes() == name).map(Self)
    }

    pub(crate) const fn place(self) -> usize {
        self.0
    }

    pub(crate) const fn name(self) -> &'static str {
        SENSORS[self.0]
    }

    fn entry(self) -> &'static Entry {
        let entry = catalogue().iter().find(|entry| entry.name == self.name());
        entry.expect("the catalogue has every sentence of the vehicle")
    }

    pub(crate) fn schema(self) -> Value {
        let entry = self.entry();
        let fields = entry.fields.iter().fold(Fields::new(), with_field);
        let what = format!("SPI {}, {}.", entry.section, entry.title);
        fields.into_message(&what, &[])
    }

    /// Compass or battery, by the number in the line; 0 for other sensors.
    fn number(self, line: &[u8]) -> usize {
        if !matches!(self.name(), "BFRCM" | "BFRBS") {
            return 0;
        }
        let number = line.split(|byte| *byte == b',').nth(2);
        let number = number.and_then(|digits| std::str::from_utf8(digits).ok()?.trim().parse().ok());
        number.unwrap_or(0).min(NUMBERS - 1)
    }
}

/// The properties of one value of a message. Several numbers are numbered from 1, because one of them may be absent.
fn with_field(fields: Fields, field: &EntryField) -> Fields {
    let (name, unit) = (field.name, field.unit);
    match unit {
        "UTC" | "code" | "text" => fields.text(name, unit),
        "flag" => fields.boolean(name, unit),
        "count" | "identifier" | "address" => fields.integer(name, unit),
        _ if field.formats.len() > 1 => {
            (1..=field.formats.len()).fold(fields, |fields, place| fields.number(&format!("{name}_{place}"), unit))
        }
        _ => fields.number(name, unit),
    }
}

/// `/sensors/NAME`: what the vehicle measures and what state it is in, decoded.
pub(super) struct Sensors {
    due: [[Decimation; NUMBERS]; Sensor::COUNT],
}

impl Sensors {
    pub(super) fn new(period: Duration) -> Self {
        Self {
            due: [const { [const { Decimation::new(Duration::ZERO) }; NUMBERS] }; Sensor::COUNT]
                .map(|numbers| numbers.map(|_| Decimation::new(period))),
        }
    }

    pub(super) fn wants(&self, moment: Moment, line: &[u8]) -> bool {
        Sensor::of(line).is_some_and(|sensor| self.due[sensor.0][sensor.number(line)].is_due(moment.now))
    }

    pub(super) fn heard(&mut self, moment: Moment, line: &[u8], message: &FromVehicle, batch: &mut Batch) {
        let Some(sensor) = Sensor::of(line) else { return };
        if !self.due[sensor.0][sensor.number(line)].take(moment.now) {
            return;
        }
        if let Ok(Value::Object(values)) = serde_json::to_value(message) {
            batch.add(Topic::Sensor(sensor), |out| {
                serde_json::to_writer(out, &flat(values)).expect("a Vec takes every value");
            });
        }
    }
}

/// The values with one type each.
fn flat(values: Map<String, Value>) -> Map<String, Value> {
    let mut flat = Map::new();
    for (name, value) in values {
        match value {
            Value::Null => {}
            Value::Array(values) => {
                for (place, value) in values.into_iter().enumerate().filter(|(_, value)| !value.is_null()) {
                    flat.insert(format!("{name}_{}", place + 1), value);
                }
            }
            // A code that SPI does not name.
            Value::Object(code) => {
                let other = code.get("other").map(|number| format!("other-{number}"));
                flat.extend(other.map(|other| (name, other.into())));
            }
            Value::Bool(_) | Value::Number(_) | Value::String(_) => {
                flat.insert(name, value);
            }
        }
    }
    flat
}
