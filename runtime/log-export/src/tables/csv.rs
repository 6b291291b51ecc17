//! Comma-separated values. An absent value is an empty field, and so is an empty text.

use std::io;

use super::Writer;
use crate::error::Error;
use crate::output::OutputFile;
use crate::table::{Cell, Table};
use crate::time::rfc3339;

pub(super) struct Csv {
    path: std::path::PathBuf,
    writer: csv::Writer<OutputFile>,
}

impl Csv {
    pub(super) fn new(file: OutputFile, table: &Table) -> Result<Self, Error> {
        let path = file.path().to_owned();
        let mut writer = csv::Writer::from_writer(file);
        let columns = table.columns.iter().map(|column| column.name.as_str());
        writer
            .write_record(["time", "t_s"].into_iter().chain(columns))
            .map_err(|error| Error::write(&path, error.into()))?;
        Ok(Self { path, writer })
    }

    fn failed(&self, error: impl Into<io::Error>) -> Error {
        Error::write(&self.path, error.into())
    }
}

impl Writer for Csv {
    fn write(&mut self, log_time: u64, t_s: f64, row: &[Cell<'_>]) -> Result<usize, Error> {
        let mut put = |field: &str| self.writer.write_field(field);
        let written = put(&rfc3339(log_time))
            .and_then(|()| put(&decimal(t_s)))
            .and_then(|()| {
                row.iter().try_for_each(|cell| match cell {
                    Cell::Absent => put(""),
                    Cell::Boolean(true) => put("true"),
                    Cell::Boolean(false) => put("false"),
                    Cell::Integer(value) => put(&value.to_string()),
                    Cell::Number(value) => put(&decimal(*value)),
                    Cell::Text(text) => put(text),
                })
            })
            .and_then(|()| self.writer.write_record(None::<&[u8]>));
        written.map_err(|error| self.failed(error))?;
        Ok(0)
    }

    fn flush(&mut self) -> Result<(), Error> {
        self.writer.flush().map_err(|error| self.failed(error))
    }

    fn finish(self: Box<Self>) -> Result<OutputFile, Error> {
        let Self { path, writer } = *self;
        writer
            .into_inner()
            .map_err(|error| Error::write(&path, io::Error::new(error.error().kind(), error.error().to_string())))
    }
}

/// The shortest text that reads back as the same number, as in JSON. What JSON lacks has the names that pandas and
/// DuckDB know.
pub(crate) fn decimal(value: f64) -> String {
    if value.is_finite() {
        serde_json::Number::from_f64(value).map_or_else(String::new, |number| number.to_string())
    } else if value.is_nan() {
        "NaN".to_owned()
    } else {
        (if value > 0.0 { "inf" } else { "-inf" }).to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact() {
        let numbers = [0.1, -0.0, 3.0, 1e-7, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        assert_eq!(
            numbers.map(decimal),
            ["0.1", "-0.0", "3.0", "1e-7", "1e+300", "NaN", "inf", "-inf"]
        );
    }
}
