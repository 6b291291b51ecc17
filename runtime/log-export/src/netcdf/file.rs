//! NetCDF classic by the crate `netcdf3`, which writes to anything that it can seek in. It writes a file from its first
//! byte to its last if the variables come in their order, so that an [`OutputFile`] of any kind will do.

use std::cell::RefCell;
use std::io::{self, Seek, SeekFrom, Write};
use std::rc::Rc;

use netcdf3::error::WriteError;
use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version};

use super::variables::{FILL, FILL_FLAG};
use crate::error::Error;
use crate::output::OutputFile;

/// The dimension of the rows.
pub(super) const TIME: &str = "time";

/// An attribute's value.
#[derive(Clone, Debug)]
pub(super) enum Attribute {
    Text(String),
    Number(f64),
    Integers(Vec<i32>),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// Names and values in the order of the file.
pub(super) type Attributes = Vec<(String, Attribute)>;

/// A variable's values.
#[derive(Clone, Debug)]
pub(super) enum Values<'a> {
    /// Numbers of the rows, each divided by a unit; NaN and infinity become [`FILL`].
    Numbers(&'a [f64], f64),
    /// Flags of the rows.
    Flags(&'a [i32]),
    /// One text, without a row.
    Text(&'a str),
    /// Nothing: the attributes are all.
    Empty,
}

/// A variable.
#[derive(Clone, Debug)]
pub(super) struct Variable<'a> {
    pub(super) name: String,
    pub(super) attributes: Attributes,
    pub(super) values: Values<'a>,
}

/// Writes a file of these variables, and gives it its name.
pub(super) fn write(
    file: OutputFile,
    rows: usize,
    attributes: &Attributes,
    variables: &[Variable<'_>],
) -> Result<(), Error> {
    let stream = Rc::new(RefCell::new(Stream {
        file,
        position: 0,
        fault: None,
    }));
    let written = definition(rows, attributes, variables)
        .map_err(|error| io::Error::other(format!("netcdf3: {error}")))
        .and_then(|set| write_all(&set, variables, &stream));
    let Ok(stream) = Rc::try_unwrap(stream) else {
        unreachable!("the writer has been dropped, and nothing else shares the stream");
    };
    let Stream { file, fault, .. } = stream.into_inner();
    match fault.map_or(written, Err) {
        Ok(()) => file.commit(),
        Err(error) => Err(file.failed(error)),
    }
}

fn definition(rows: usize, attributes: &Attributes, variables: &[Variable<'_>]) -> Result<DataSet, InvalidDataSet> {
    let mut set = DataSet::new();
    set.add_fixed_dim(TIME, rows)?;
    for (name, value) in attributes {
        match value {
            Attribute::Text(text) => set.add_global_attr_string(name, text)?,
            Attribute::Number(number) => set.add_global_attr_f64(name, vec![*number])?,
            Attribute::Integers(integers) => set.add_global_attr_i32(name, integers.clone())?,
        }
    }
    for variable in variables {
        let name = &variable.name;
        match variable.values {
            Values::Numbers(..) => set.add_var_f64(name, &[TIME])?,
            Values::Flags(_) => set.add_var_i32(name, &[TIME])?,
            Values::Text(text) => {
                let length = format!("{name}_length");
                set.add_fixed_dim(&length, text.len())?;
                set.add_var_u8(name, &[length])?;
            }
            Values::Empty => set.add_var_i32::<&str>(name, &[])?,
        }
        for (attribute, value) in &variable.attributes {
            match value {
                Attribute::Text(text) => set.add_var_attr_string(name, attribute, text)?,
                Attribute::Number(number) => set.add_var_attr_f64(name, attribute, vec![*number])?,
                Attribute::Integers(integers) => set.add_var_attr_i32(name, attribute, integers.clone())?,
            }
        }
    }
    Ok(set)
}

fn write_all(set: &DataSet, variables: &[Variable<'_>], stream: &Rc<RefCell<Stream>>) -> io::Result<()> {
    let failed = |error: WriteError| io::Error::other(format!("netcdf3: {error:?}"));
    let output = Box::new(Shared(Rc::clone(stream)));
    let mut writer = FileWriter::open_seek_write("", output).map_err(failed)?;
    // Offsets of 64 bits: a long dive at ten rows a second has more than 2 GiB.
    writer.set_def(set, Version::Offset64Bit, 0).map_err(failed)?;
    for Variable { name, values, .. } in variables {
        let written = match values {
            Values::Numbers(numbers, per_unit) => {
                let numbers = numbers.iter().map(|number| number / per_unit);
                let numbers = numbers.map(|number| if number.is_finite() { number } else { FILL });
                writer.write_var_f64(name, &numbers.collect::<Vec<_>>())
            }
            Values::Flags(flags) => writer.write_var_i32(name, flags),
            Values::Text(text) => writer.write_var_u8(name, text.as_bytes()),
            Values::Empty => writer.write_var_i32(name, &[FILL_FLAG]),
        };
        written.map_err(failed)?;
    }
    writer.close().map_err(failed)
}

/// A file that is written from its first byte to its last.
#[derive(Debug)]
struct Stream {
    file: OutputFile,
    position: u64,
    /// The first error, because `netcdf3` keeps only its kind.
    fault: Option<io::Error>,
}

struct Shared(Rc<RefCell<Stream>>);

impl Write for Shared {
    /// Writes everything, because `netcdf3` does not look how much was written.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut stream = self.0.borrow_mut();
        if let Err(error) = stream.file.write_all(bytes) {
            let kind = error.kind();
            stream.fault.get_or_insert(error);
            return Err(kind.into());
        }
        stream.position += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.borrow_mut().file.flush()
    }
}

impl Seek for Shared {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = self.0.borrow().position;
        if to == SeekFrom::Start(position) {
            Ok(position)
        } else {
            Err(io::ErrorKind::NotSeekable.into())
        }
    }
}
