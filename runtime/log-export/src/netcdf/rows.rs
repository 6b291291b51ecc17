//! The rows of the file: one for each navigation solution, with what was measured nearest to it.

use std::collections::BTreeMap;

use backseat_units::math;
use serde_json::Value;

use super::salinity::practical_salinity;
use super::variables::{
    CONDUCTIVITY, CONTROL, CONTROLS, FILL_FLAG, Flag, GPS, MEASURED, MEASURES, NAVIGATION, PRESSURE, STEERING,
    TEMPERATURE, TRUTH,
};
use crate::contents::Message;
use crate::flatten::number;
use crate::map::Fix;

/// A measurement belongs to the nearest solution that is no further away than this, seconds.
const NEAR_S: f64 = 1.0;

/// The rows, column by column.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Seconds since 1970, each later than the one before.
    pub(super) times: Vec<f64>,
    /// The columns of [`MEASURED`], as far as they have values.
    measured: BTreeMap<usize, Vec<f64>>,
    /// Over the ground, m/s.
    speed: Vec<f64>,
    /// What plugins publish, by `PLUGIN/NAME`, with its unit.
    pub(super) published: BTreeMap<String, (String, Vec<f64>)>,
    gps: Vec<i32>,
    control: States,
    steering: States,
    /// Measurements since the last row.
    waiting: Vec<Waiting>,
    /// Solutions without a position, or not later than the one before.
    pub(super) rows_left_out: u64,
    /// Measurements before the last row without a row near them.
    pub(super) measurements_left_out: u64,
}

/// A state of the run.
#[derive(Debug, Default)]
struct States {
    /// Since when it is what, seconds since 1970.
    changes: Vec<(f64, i32)>,
    /// What it is in each row, at the end.
    rows: Vec<i32>,
}

impl States {
    fn change(&mut self, time_s: f64, state: i32) {
        if self.changes.last().is_none_or(|(_, last)| *last != state) {
            self.changes.push((time_s, state));
        }
    }

    /// Finds the state of each row. `before` is what it is before the first change.
    fn finish(&mut self, times: &[f64], before: i32) {
        self.changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut state, mut changes) = (before, self.changes.iter().peekable());
        self.rows = times
            .iter()
            .map(|time_s| {
                while let Some((_, next)) = changes.next_if(|(since_s, _)| since_s <= time_s) {
                    state = *next;
                }
                state
            })
            .collect();
    }
}

#[derive(Debug)]
struct Waiting {
    time_s: f64,
    to: To,
    value: f64,
}

#[derive(Clone, Debug)]
enum To {
    Measured(usize),
    Published(String),
}

impl Rows {
    /// Whether a channel has anything for the rows.
    pub(super) fn wants(topic: &str) -> bool {
        topic == CONTROL || topic.starts_with(MEASURES) || MEASURED.iter().any(|measured| measured.topic == topic)
    }

    pub(super) fn take(&mut self, message: &Message<'_>, start_ns: u64) {
        let start_s = start_ns as f64 / 1e9;
        let time_s = start_s + message.t_s;
        match message.topic {
            NAVIGATION => {
                // When the solution was computed; the message came later.
                let computed_s = message.value.get("time_s").and_then(number);
                self.navigation(message, start_s + computed_s.unwrap_or(message.t_s));
                return;
            }
            CONTROL => {
                if let Some(granted) = message.value.get("granted").and_then(Value::as_bool) {
                    self.control.change(time_s, granted.into());
                }
            }
            TRUTH => {
                let steering = message.value.get("steering").and_then(Value::as_str);
                self.steering
                    .change(time_s, steering.map_or(FILL_FLAG, |word| STEERING.number(word)));
            }
            _ => {}
        }
        if let Some(name) = message.topic.strip_prefix(MEASURES) {
            let unit = message.value.get("unit").and_then(Value::as_str).unwrap_or_default();
            let entry = self.published.entry(name.to_owned());
            entry.or_insert_with(|| (unit.to_owned(), Vec::new()));
            self.wait(time_s, To::Published(name.to_owned()), message.value.get("value"));
        }
        for (place, measured) in MEASURED.iter().enumerate() {
            if measured.topic == message.topic {
                self.wait(time_s, To::Measured(place), property(&message.value, measured.property));
            }
        }
    }

    fn wait(&mut self, time_s: f64, to: To, value: Option<&Value>) {
        if let Some(value) = value.and_then(number).filter(|value| value.is_finite()) {
            self.waiting.push(Waiting { time_s, to, value });
        }
    }

    fn navigation(&mut self, message: &Message<'_>, time_s: f64) {
        let is_later = self.times.last().is_none_or(|last| time_s > *last);
        // A row must have all coordinates.
        if Fix::of(message).is_none() || !time_s.is_finite() || !is_later {
            self.rows_left_out += 1;
            return;
        }
        let last = self.times.len().checked_sub(1);
        let row = self.times.len();
        self.times.push(time_s);
        for (place, measured) in MEASURED.iter().enumerate() {
            if measured.topic == NAVIGATION
                && let Some(value) = property(&message.value, measured.property).and_then(number)
            {
                self.set(&To::Measured(place), row, value);
            }
        }
        let velocity = |name: &str| message.value.get(name).and_then(number);
        self.speed.push(match (velocity("east_mps"), velocity("north_mps")) {
            (Some(east), Some(north)) => math::hypot(east, north),
            (Some(_) | None, _) => f64::NAN,
        });
        let gps = message.value.get("gps").and_then(Value::as_bool);
        self.gps.push(gps.map_or(FILL_FLAG, i32::from));
        for Waiting {
            time_s: at_s,
            to,
            value,
        } in std::mem::take(&mut self.waiting)
        {
            let apart = |row: usize| (self.times[row] - at_s).abs();
            let nearest = last.filter(|last| apart(*last) < apart(row)).unwrap_or(row);
            self.set_near(nearest, at_s, &to, value);
        }
    }

    /// Sets what was measured after the last solution, and the states. A log whose `has_control` is false does not say
    /// who may steer.
    pub(super) fn finish(&mut self, has_control: bool) {
        for Waiting { time_s, to, value } in std::mem::take(&mut self.waiting) {
            // The trajectory ends with its last solution, so what came long after it is not missing.
            if let Some(last) = self.times.len().checked_sub(1)
                && time_s - self.times[last] <= NEAR_S
            {
                self.set_near(last, time_s, &to, value);
            }
        }
        // There is no control until the vehicle grants it.
        let control = if has_control { 0 } else { FILL_FLAG };
        self.control.finish(&self.times, control);
        self.steering.finish(&self.times, FILL_FLAG);
        let length = self.times.len();
        let columns = self.measured.values_mut();
        let published = self.published.values_mut().map(|(_, values)| values);
        columns
            .chain(published)
            .for_each(|column| column.resize(length, f64::NAN));
    }

    fn set_near(&mut self, row: usize, time_s: f64, to: &To, value: f64) {
        if (self.times[row] - time_s).abs() <= NEAR_S {
            self.set(to, row, value);
        } else {
            self.measurements_left_out += 1;
        }
    }

    /// Of two measurements of one row the later one stays.
    fn set(&mut self, to: &To, row: usize, value: f64) {
        let column = match to {
            To::Measured(place) => self.measured.entry(*place).or_default(),
            To::Published(name) => &mut self.published.entry(name.clone()).or_default().1,
        };
        if column.len() <= row {
            column.resize(row + 1, f64::NAN);
        }
        column[row] = value;
    }

    /// The column of a variable in the log's unit; none if it has no value.
    pub(super) fn column(&self, place: usize) -> Option<&[f64]> {
        self.measured.get(&place).map(Vec::as_slice)
    }

    /// The speed over the ground, m/s.
    pub(super) fn speed(&self) -> Option<&[f64]> {
        some_value(&self.speed)
    }

    /// Practical salinity.
    pub(super) fn salinity(&self) -> Option<Vec<f64>> {
        let column = |name: &str| {
            let place = MEASURED.iter().position(|measured| measured.name == name)?;
            Some((self.column(place)?, MEASURED[place].per_unit))
        };
        let (conductivity, per_conductivity) = column(CONDUCTIVITY)?;
        let (temperature, _) = column(TEMPERATURE)?;
        let (pressure, per_pressure) = column(PRESSURE)?;
        let rows = conductivity.iter().zip(temperature).zip(pressure);
        let salinity = rows.map(|((conductivity, temperature), pressure)| {
            let salinity = practical_salinity(conductivity / per_conductivity, *temperature, pressure / per_pressure);
            salinity.unwrap_or(f64::NAN)
        });
        let salinity: Vec<f64> = salinity.collect();
        some_value(&salinity).is_some().then_some(salinity)
    }

    /// The flags that have a value.
    pub(super) fn flags(&self) -> impl Iterator<Item = (&'static Flag, &[i32])> {
        let flags = [
            (&GPS, &self.gps),
            (&CONTROLS, &self.control.rows),
            (&STEERING, &self.steering.rows),
        ];
        flags
            .into_iter()
            .filter(|(_, values)| values.iter().any(|value| *value != FILL_FLAG))
            .map(|(flag, values)| (flag, values.as_slice()))
    }
}

impl Flag {
    fn number(&self, word: &str) -> i32 {
        let place = self.meanings.iter().position(|meaning| *meaning == word);
        place.and_then(|place| i32::try_from(place).ok()).unwrap_or(FILL_FLAG)
    }
}

fn some_value(column: &[f64]) -> Option<&[f64]> {
    column.iter().any(|value| value.is_finite()).then_some(column)
}

/// A property by its path.
fn property<'a>(value: &'a Value, path: &str) -> Option<&'a Value> {
    path.split('.').try_fold(value, |value, name| value.get(name))
}
