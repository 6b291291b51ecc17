//! Parquet by the low-level writer and reader: a flat table whose columns may be absent in a row, in row groups of a
//! fixed size, compressed with Snappy.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use crate::error::CampaignError;
use crate::row::Cell;

/// The rows of each group but the last.
const ROWS: usize = 10_000;

/// The type of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// True or false.
    Boolean,
    /// A signed number of 64 bits.
    Integer,
    /// An unsigned number of 64 bits.
    Natural,
    /// A floating-point number of 64 bits.
    Number,
    /// Text.
    Text,
}

/// A table's columns in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sheet {
    /// Name and type.
    pub columns: Vec<(String, ColumnKind)>,
}

/// A column as it was read; absent values are `None`.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Of [`ColumnKind::Boolean`].
    Boolean(Vec<Option<bool>>),
    /// Of [`ColumnKind::Integer`].
    Integer(Vec<Option<i64>>),
    /// Of [`ColumnKind::Natural`].
    Natural(Vec<Option<u64>>),
    /// Of [`ColumnKind::Number`].
    Number(Vec<Option<f64>>),
    /// Of [`ColumnKind::Text`].
    Text(Vec<Option<String>>),
}

/// The writer of one table. The file appears under its name when it is whole.
pub(crate) struct Table {
    path: PathBuf,
    temporary: PathBuf,
    writer: SerializedFileWriter<BufWriter<File>>,
    columns: Vec<Kept>,
    rows: usize,
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

impl Table {
    pub(crate) fn create(path: &Path, sheet: &Sheet, facts: &[(&str, String)]) -> Result<Self, CampaignError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let temporary = path.with_file_name(format!(".{name}.{}", std::process::id()));
        let file = File::create(&temporary).map_err(|source| CampaignError::file(path, source))?;
        let failed = |error| failed(path, error);
        let facts = facts
            .iter()
            .map(|(key, value)| KeyValue::new(format!("backseat.{key}"), value.clone()));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("backseat ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_key_value_metadata(Some(facts.collect()))
            .build();
        let schema = schema(sheet).map_err(failed)?;
        let writer = SerializedFileWriter::new(BufWriter::new(file), schema, Arc::new(properties)).map_err(failed)?;
        let columns = sheet.columns.iter().map(|(_, kind)| Kept {
            values: match kind {
                ColumnKind::Boolean => Values::Boolean(Vec::new()),
                ColumnKind::Integer | ColumnKind::Natural => Values::Integer(Vec::new()),
                ColumnKind::Number => Values::Number(Vec::new()),
                ColumnKind::Text => Values::Text(Vec::new()),
            },
            present: Vec::new(),
        });
        Ok(Self {
            path: path.to_path_buf(),
            temporary,
            writer,
            columns: columns.collect(),
            rows: 0,
        })
    }

    /// Appends a row: for each column a cell of its type, or none.
    pub(crate) fn write(&mut self, row: &[Option<Cell>]) -> Result<(), CampaignError> {
        for (column, cell) in self.columns.iter_mut().zip(row) {
            column.push(cell.as_ref());
        }
        self.rows += 1;
        if self.rows == ROWS {
            self.write_group()?;
        }
        Ok(())
    }

    /// Writes the rest, has the file on the disk, and gives it its name.
    pub(crate) fn finish(mut self) -> Result<(), CampaignError> {
        if self.rows > 0 {
            self.write_group()?;
        }
        let Self {
            path,
            temporary,
            writer,
            ..
        } = self;
        let file = |source| CampaignError::file(&path, source);
        let out = writer.into_inner().map_err(|error| failed(&path, error))?;
        let out = out.into_inner().map_err(|error| file(error.into_error()))?;
        out.sync_all().map_err(file)?;
        std::fs::rename(&temporary, &path).map_err(file)
    }

    fn write_group(&mut self) -> Result<(), CampaignError> {
        let failed = |error| failed(&self.path, error);
        let mut group = self.writer.next_row_group().map_err(failed)?;
        let mut columns = self.columns.iter_mut();
        while let Some(mut column) = group.next_column().map_err(failed)? {
            if let Some(kept) = columns.next() {
                kept.write(column.untyped()).map_err(failed)?;
            }
            column.close().map_err(failed)?;
        }
        group.close().map_err(failed)?;
        self.rows = 0;
        Ok(())
    }
}

impl Kept {
    fn push(&mut self, cell: Option<&Cell>) {
        let present = match (&mut self.values, cell) {
            (Values::Boolean(values), Some(Cell::Boolean(value))) => {
                values.push(*value);
                true
            }
            (Values::Integer(values), Some(Cell::Integer(value))) => {
                values.push(*value);
                true
            }
            (Values::Integer(values), Some(Cell::Natural(value))) => {
                values.push(value.cast_signed());
                true
            }
            (Values::Number(values), Some(Cell::Number(value))) => {
                values.push(*value);
                true
            }
            // A parameter may be 1 in one run and 1.5 in another.
            (Values::Number(values), Some(Cell::Integer(value))) => {
                values.push(*value as f64);
                true
            }
            (Values::Text(values), Some(Cell::Text(text))) => {
                values.push(ByteArray::from(text.as_bytes().to_vec()));
                true
            }
            (Values::Boolean(_) | Values::Integer(_) | Values::Number(_) | Values::Text(_), _) => false,
        };
        self.present.push(i16::from(present));
    }

    fn write(&mut self, writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
        let present = Some(self.present.as_slice());
        match (&mut self.values, writer) {
            (Values::Boolean(values), ColumnWriter::BoolColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
                values.clear();
            }
            (Values::Integer(values), ColumnWriter::Int64ColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
                values.clear();
            }
            (Values::Number(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
                values.clear();
            }
            (Values::Text(values), ColumnWriter::ByteArrayColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
                values.clear();
            }
            (Values::Boolean(_) | Values::Integer(_) | Values::Number(_) | Values::Text(_), _) => {
                return Err(ParquetError::General("a column has two types".to_owned()));
            }
        }
        self.present.clear();
        Ok(())
    }
}

fn schema(sheet: &Sheet) -> Result<TypePtr, ParquetError> {
    let fields = sheet.columns.iter().map(|(name, kind)| {
        let (physical, logical) = match kind {
            ColumnKind::Boolean => (Physical::BOOLEAN, None),
            ColumnKind::Integer => (Physical::INT64, None),
            ColumnKind::Natural => (Physical::INT64, Some(LogicalType::integer(64, false))),
            ColumnKind::Number => (Physical::DOUBLE, None),
            ColumnKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()?;
        Ok(Arc::new(field))
    });
    let fields = fields.collect::<Result<Vec<_>, ParquetError>>()?;
    let schema = Type::group_type_builder("runs").with_fields(fields).build()?;
    Ok(Arc::new(schema))
}

fn failed(path: &Path, error: ParquetError) -> CampaignError {
    let source = if let ParquetError::External(source) = error {
        source
            .downcast::<io::Error>()
            .map_or_else(io::Error::other, |source| *source)
    } else {
        io::Error::other(error)
    };
    CampaignError::file(path, source)
}

/// The names and types of a table's columns.
///
/// # Errors
///
/// [`CampaignError`] if the file cannot be read.
pub fn read_names(path: &Path) -> Result<Sheet, CampaignError> {
    let reader = open(path)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let columns = schema.columns().iter().map(|column| {
        let kind = match (column.physical_type(), column.logical_type_ref()) {
            (Physical::BOOLEAN, _) => ColumnKind::Boolean,
            (Physical::INT64, Some(LogicalType::Integer { .. })) => ColumnKind::Natural,
            (Physical::INT64, _) => ColumnKind::Integer,
            (Physical::DOUBLE, _) => ColumnKind::Number,
            _ => ColumnKind::Text,
        };
        (column.name().to_owned(), kind)
    });
    Ok(Sheet {
        columns: columns.collect(),
    })
}

/// Reads some columns of a table, in the order of `names`; a column that the table does not have is `None`.
///
/// # Errors
///
/// [`CampaignError`] if the file cannot be read.
pub fn read_columns(path: &Path, names: &[&str]) -> Result<Vec<Option<Column>>, CampaignError> {
    let sheet = read_names(path)?;
    let reader = open(path)?;
    names
        .iter()
        .map(|name| {
            let Some(place) = sheet.columns.iter().position(|(column, _)| column == name) else {
                return Ok(None);
            };
            read_column(&reader, place, sheet.columns[place].1)
                .map(Some)
                .map_err(|error| failed(path, error))
        })
        .collect()
}

fn open(path: &Path) -> Result<SerializedFileReader<File>, CampaignError> {
    let file = File::open(path).map_err(|source| CampaignError::file(path, source))?;
    SerializedFileReader::new(file).map_err(|error| failed(path, error))
}

fn read_column(reader: &SerializedFileReader<File>, place: usize, kind: ColumnKind) -> Result<Column, ParquetError> {
    let mut column = match kind {
        ColumnKind::Boolean => Column::Boolean(Vec::new()),
        ColumnKind::Integer => Column::Integer(Vec::new()),
        ColumnKind::Natural => Column::Natural(Vec::new()),
        ColumnKind::Number => Column::Number(Vec::new()),
        ColumnKind::Text => Column::Text(Vec::new()),
    };
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let source = group.get_column_reader(place)?;
        macro_rules! read {
            ($reader:expr, $all:expr, $convert:expr) => {{
                let (mut values, mut levels) = (Vec::new(), Vec::new());
                let mut reader = $reader;
                reader.read_records(rows, Some(&mut levels), None, &mut values)?;
                let mut values = values.into_iter().map($convert);
                $all.extend(
                    levels
                        .iter()
                        .map(|level| if *level > 0 { values.next() } else { None }),
                );
            }};
        }
        match (&mut column, source) {
            (Column::Boolean(all), ColumnReader::BoolColumnReader(reader)) => read!(reader, all, |value| value),
            (Column::Integer(all), ColumnReader::Int64ColumnReader(reader)) => read!(reader, all, |value| value),
            (Column::Natural(all), ColumnReader::Int64ColumnReader(reader)) => {
                read!(reader, all, |value: i64| value.cast_unsigned());
            }
            (Column::Number(all), ColumnReader::DoubleColumnReader(reader)) => read!(reader, all, |value| value),
            (Column::Text(all), ColumnReader::ByteArrayColumnReader(reader)) => {
                read!(reader, all, |value: ByteArray| {
                    String::from_utf8_lossy(value.data()).into_owned()
                });
            }
            _ => return Err(ParquetError::General("a column is not of its type".to_owned())),
        }
    }
    Ok(column)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        let sheet = Sheet {
            columns: [
                ("run", ColumnKind::Integer),
                ("seed", ColumnKind::Natural),
                ("passed", ColumnKind::Boolean),
                ("rms_m", ColumnKind::Number),
                ("outcome", ColumnKind::Text),
            ]
            .map(|(name, kind)| (name.to_owned(), kind))
            .to_vec(),
        };
        let mut table = Table::create(&path, &sheet, &[("campaign", "x".to_owned())]).unwrap();
        let count = ROWS as i64 + 5;
        for run in 0..count {
            let odd = run % 2 == 1;
            table
                .write(&[
                    Some(Cell::Integer(run)),
                    Some(Cell::Natural(u64::MAX - run.cast_unsigned())),
                    odd.then_some(Cell::Boolean(true)),
                    if odd {
                        Some(Cell::Integer(run))
                    } else {
                        Some(Cell::Number(0.5))
                    },
                    (!odd).then(|| Cell::Text(format!("run {run}"))),
                ])
                .unwrap();
        }
        assert!(!path.exists(), "it has its name only when it is whole");
        table.finish().unwrap();
        assert_eq!(read_names(&path).unwrap(), sheet);
        let columns = read_columns(&path, &["seed", "rms_m", "nothing", "outcome", "passed"]).unwrap();
        let Some(Column::Natural(seeds)) = &columns[0] else {
            panic!()
        };
        assert_eq!((seeds.len(), seeds[1]), (count as usize, Some(u64::MAX - 1)));
        let Some(Column::Number(rms)) = &columns[1] else {
            panic!()
        };
        assert_eq!(rms[..4], [Some(0.5), Some(1.0), Some(0.5), Some(3.0)]);
        assert_eq!(columns[2], None);
        let Some(Column::Text(outcomes)) = &columns[3] else {
            panic!()
        };
        assert_eq!(outcomes[..2], [Some("run 0".to_owned()), None]);
        let Some(Column::Boolean(passed)) = &columns[4] else {
            panic!()
        };
        assert_eq!(passed[..2], [None, Some(true)]);
    }
}
