//! Apache Parquet by the low-level writer: a flat schema, columns that may be absent, compressed with Snappy.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::{Sheet, Writer};
use crate::contents::Contents;
use crate::error::Error;
use crate::output::OutputFile;
use crate::table::{Cell, Kind};

/// Rows of a group at most.
const ROWS_MAX: usize = 1 << 17;
/// Bytes of a group at most, before they are encoded.
const BYTES_MAX: usize = 16 << 20;

/// The writer of one table. It keeps the rows of one row group.
pub(super) struct Parquet {
    path: PathBuf,
    writer: SerializedFileWriter<OutputFile>,
    times: Vec<i64>,
    seconds: Vec<f64>,
    columns: Vec<Kept>,
    bytes: usize,
}

/// The values of a column that are not written yet.
struct Kept {
    values: Values,
    /// For each row 1 if it has a value, else 0.
    present: Vec<i16>,
}

enum Values {
    Boolean(Vec<bool>),
    Integer(Vec<i64>),
    Number(Vec<f64>),
    Text(Vec<ByteArray>),
}

impl Parquet {
    pub(super) fn new(file: OutputFile, sheet: &Sheet, contents: &Contents) -> Result<Self, Error> {
        let path = file.path().to_owned();
        let failed = |error| failed(&path, error);
        let schema = schema(sheet).map_err(failed)?;
        let mut facts = vec![
            KeyValue::new("topic".to_owned(), sheet.topic.clone()),
            KeyValue::new("schema".to_owned(), sheet.schema.clone()),
        ];
        let run = contents.run.iter();
        facts.extend(run.map(|(key, value)| KeyValue::new(format!("backseat.{key}"), value.clone())));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("backseat ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_key_value_metadata(Some(facts))
            .build();
        let writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(failed)?;
        let columns = sheet.table.columns.iter().map(|column| Kept {
            values: match column.kind {
                Kind::Boolean => Values::Boolean(Vec::new()),
                Kind::Integer => Values::Integer(Vec::new()),
                Kind::Number => Values::Number(Vec::new()),
                Kind::Text => Values::Text(Vec::new()),
            },
            present: Vec::new(),
        });
        Ok(Self {
            columns: columns.collect(),
            path,
            writer,
            times: Vec::new(),
            seconds: Vec::new(),
            bytes: 0,
        })
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        let (mut own, mut columns) = (0, self.columns.iter_mut());
        while let Some(mut column) = group.next_column()? {
            own += 1;
            match (own, column.untyped()) {
                (1, ColumnWriter::Int64ColumnWriter(writer)) => writer.write_batch(&self.times, None, None)?,
                (2, ColumnWriter::DoubleColumnWriter(writer)) => writer.write_batch(&self.seconds, None, None)?,
                (_, writer) => match columns.next() {
                    Some(kept) => kept.write(writer)?,
                    None => 0,
                },
            };
            column.close()?;
        }
        group.close()?;
        self.times.clear();
        self.seconds.clear();
        self.bytes = 0;
        Ok(())
    }
}

impl Kept {
    /// Keeps a value; returns the memory that it uses, bytes.
    fn push(&mut self, cell: &Cell<'_>) -> usize {
        let size = match (&mut self.values, cell) {
            (Values::Boolean(values), Cell::Boolean(value)) => {
                values.push(*value);
                1
            }
            (Values::Integer(values), Cell::Integer(value)) => {
                values.push(*value);
                8
            }
            (Values::Number(values), Cell::Number(value)) => {
                values.push(*value);
                8
            }
            (Values::Text(values), Cell::Text(text)) => {
                values.push(ByteArray::from(text.as_bytes().to_vec()));
                size_of::<ByteArray>() + text.len()
            }
            // A table gives each column cells of its kind, and absent ones.
            (Values::Boolean(_) | Values::Integer(_) | Values::Number(_) | Values::Text(_), _) => 0,
        };
        self.present.push(i16::from(size > 0));
        size + size_of::<i16>()
    }

    fn write(&mut self, writer: &mut ColumnWriter<'_>) -> Result<usize, ParquetError> {
        let present = Some(self.present.as_slice());
        let written = match (&mut self.values, writer) {
            (Values::Boolean(values), ColumnWriter::BoolColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?
            }
            (Values::Integer(values), ColumnWriter::Int64ColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?
            }
            (Values::Number(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?
            }
            (Values::Text(values), ColumnWriter::ByteArrayColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?
            }
            (Values::Boolean(_) | Values::Integer(_) | Values::Number(_) | Values::Text(_), _) => {
                return Err(ParquetError::General("a column has two types".to_owned()));
            }
        };
        match &mut self.values {
            Values::Boolean(values) => values.clear(),
            Values::Integer(values) => values.clear(),
            Values::Number(values) => values.clear(),
            Values::Text(values) => values.clear(),
        }
        self.present.clear();
        Ok(written)
    }
}

impl Writer for Parquet {
    fn write(&mut self, log_time: u64, t_s: f64, row: &[Cell<'_>]) -> Result<usize, Error> {
        // Times after the year 2262 do not fit.
        self.times.push(i64::try_from(log_time).unwrap_or(i64::MAX));
        self.seconds.push(t_s);
        self.bytes += size_of::<i64>() + size_of::<f64>();
        for (column, cell) in self.columns.iter_mut().zip(row) {
            self.bytes += column.push(cell);
        }
        if self.times.len() >= ROWS_MAX || self.bytes >= BYTES_MAX {
            self.flush()?;
        }
        Ok(self.bytes)
    }

    fn flush(&mut self) -> Result<(), Error> {
        if self.times.is_empty() {
            return Ok(());
        }
        self.write_group().map_err(|error| failed(&self.path, error))
    }

    fn finish(mut self: Box<Self>) -> Result<OutputFile, Error> {
        self.flush()?;
        let Self { path, writer, .. } = *self;
        writer.into_inner().map_err(|error| failed(&path, error))
    }
}

fn failed(path: &Path, error: ParquetError) -> Error {
    let source = if let ParquetError::External(source) = error {
        source
            .downcast::<io::Error>()
            .map_or_else(io::Error::other, |source| *source)
    } else {
        io::Error::other(error)
    };
    Error::write(path, source)
}

fn schema(sheet: &Sheet) -> Result<TypePtr, ParquetError> {
    let own = |name: &'static str, physical| {
        Type::primitive_type_builder(name, physical).with_repetition(Repetition::REQUIRED)
    };
    let nanos = LogicalType::timestamp(true, TimeUnit::NANOS);
    let mut fields = vec![
        Arc::new(own("time", Physical::INT64).with_logical_type(Some(nanos)).build()?),
        Arc::new(own("t_s", Physical::DOUBLE).build()?),
    ];
    for column in &sheet.table.columns {
        let (physical, logical) = match column.kind {
            Kind::Boolean => (Physical::BOOLEAN, None),
            Kind::Integer => (Physical::INT64, None),
            Kind::Number => (Physical::DOUBLE, None),
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()?;
        fields.push(Arc::new(field));
    }
    let schema = Type::group_type_builder("message").with_fields(fields).build()?;
    Ok(Arc::new(schema))
}
