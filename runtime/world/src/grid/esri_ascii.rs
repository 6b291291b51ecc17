use std::sync::Arc;

use super::{CELLS_MAX, Grid, Layout, NO_DATA, VALUE_EXPECTED, VALUE_MAX_M, quoted};
use crate::error::WorldError;

/// The value of cells without data if the header does not give one: ESRI's default.
const NO_DATA_DEFAULT: f64 = -9999.0;

/// The numbers of the header, each with its line.
#[derive(Default)]
struct Header {
    ncols: Option<(usize, f64)>,
    nrows: Option<(usize, f64)>,
    xllcorner: Option<(usize, f64)>,
    xllcenter: Option<(usize, f64)>,
    yllcorner: Option<(usize, f64)>,
    yllcenter: Option<(usize, f64)>,
    cellsize: Option<(usize, f64)>,
    nodata_value: Option<(usize, f64)>,
}

pub(super) fn read(text: &str) -> Result<Grid, WorldError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let last_line = text.lines().count().max(1);
    let mut words = text
        .split('\n')
        .enumerate()
        .flat_map(|(index, line)| line.split_ascii_whitespace().map(move |word| (index + 1, word)))
        .peekable();
    let mut header = Header::default();
    while let Some((line, key)) = words.next_if(|(_, word)| is_key(word)) {
        let slot = header.slot(line, key)?;
        let Some((value_line, word)) = words.next() else {
            return Err(fault(
                line,
                format!("{} without a value", quoted(key)),
                "a number after the key",
            ));
        };
        // Cells without data may be marked with NaN or an infinity.
        let value = match word.parse::<f64>() {
            Ok(value) if value.is_finite() || key.eq_ignore_ascii_case("nodata_value") => value,
            _ => return Err(fault(value_line, quoted(word), format!("a number for {}", quoted(key)))),
        };
        if slot.replace((value_line, value)).is_some() {
            return Err(fault(line, format!("a second {}", quoted(key)), "each key once"));
        }
    }
    let values_line = words.peek().map_or(last_line, |(line, _)| *line);
    let layout = header.layout(values_line)?;
    let no_data = header.nodata_value.map_or(NO_DATA_DEFAULT, |(_, value)| value);
    let count = layout.columns * layout.rows;
    let shape = || format!("{count} values ({} rows of {})", layout.rows, layout.columns);
    // A value takes at least two bytes of text. So a header cannot make us allocate more memory than the length of the
    // text justifies.
    let mut values = Vec::with_capacity(count.min(text.len() / 2 + 1));
    for (line, word) in words {
        if values.len() == count {
            return Err(fault(
                line,
                quoted(word),
                format!("the end of the file after {}", shape()),
            ));
        }
        let Ok(value) = word.parse::<f64>() else {
            return Err(fault(line, quoted(word), VALUE_EXPECTED));
        };
        if value == no_data || (value.is_nan() && no_data.is_nan()) {
            values.push(NO_DATA);
        } else if value.abs() <= VALUE_MAX_M {
            values.push(value as f32);
        } else {
            return Err(fault(line, quoted(word), VALUE_EXPECTED));
        }
    }
    if values.len() < count {
        return Err(fault(
            last_line,
            format!("the end after {} values", values.len()),
            shape(),
        ));
    }
    Ok(Grid {
        layout,
        values: Arc::new(values),
    })
}

/// Whether a word of the header is a key. `nan` and `inf` are values, not keys.
fn is_key(word: &str) -> bool {
    word.starts_with(|first: char| first.is_ascii_alphabetic()) && word.parse::<f64>().is_err()
}

impl Header {
    fn slot(&mut self, line: usize, key: &str) -> Result<&mut Option<(usize, f64)>, WorldError> {
        Ok(match key.to_ascii_lowercase().as_str() {
            "ncols" => &mut self.ncols,
            "nrows" => &mut self.nrows,
            "xllcorner" => &mut self.xllcorner,
            "xllcenter" | "xllcentre" => &mut self.xllcenter,
            "yllcorner" => &mut self.yllcorner,
            "yllcenter" | "yllcentre" => &mut self.yllcenter,
            "cellsize" => &mut self.cellsize,
            "nodata_value" => &mut self.nodata_value,
            _ => {
                let expected = "ncols, nrows, xllcorner, xllcenter, yllcorner, yllcenter, cellsize, NODATA_value or a \
                                number";
                return Err(fault(line, quoted(key), expected));
            }
        })
    }

    fn layout(&self, values_line: usize) -> Result<Layout, WorldError> {
        let given = |slot: Option<(usize, f64)>, key: &str| {
            slot.ok_or_else(|| {
                fault(
                    values_line,
                    format!("no `{key}` before the values"),
                    "this key in the header",
                )
            })
        };
        let columns = count(given(self.ncols, "ncols")?, "ncols")?;
        let rows = count(given(self.nrows, "nrows")?, "nrows")?;
        if columns * rows > CELLS_MAX {
            let (line, _) = given(self.nrows, "nrows")?;
            let found = format!("{columns} columns and {rows} rows");
            return Err(fault(line, found, "at most 25 million cells"));
        }
        let (line, cell) = given(self.cellsize, "cellsize")?;
        if !(cell > 0.0 && cell <= 1e6) {
            return Err(fault(
                line,
                format!("a cellsize of {cell}"),
                "more than 0, at most 1000000",
            ));
        }
        let west = first_centre(self.xllcorner, self.xllcenter, cell, "xllcorner", values_line)?;
        let south = first_centre(self.yllcorner, self.yllcenter, cell, "yllcorner", values_line)?;
        Ok(Layout {
            columns,
            rows,
            west,
            north: south + (rows - 1) as f64 * cell,
            cell_east: cell,
            cell_north: cell,
            declared: None,
        })
    }
}

/// A number of rows or columns.
fn count((line, value): (usize, f64), key: &str) -> Result<usize, WorldError> {
    // The bound keeps the product of two such numbers within a machine word.
    if value.fract() == 0.0 && (2.0..=CELLS_MAX as f64).contains(&value) {
        Ok(value as usize)
    } else {
        let found = format!("{key} of {value}");
        Err(fault(line, found, "a whole number, 2 to 25000000"))
    }
}

fn first_centre(
    corner: Option<(usize, f64)>,
    centre: Option<(usize, f64)>,
    cell: f64,
    key: &str,
    values_line: usize,
) -> Result<f64, WorldError> {
    let (line, at) = match (corner, centre) {
        (Some((line, corner)), None) => (line, corner + 0.5 * cell),
        (None, Some(centre)) => centre,
        (Some((line, _)), Some(_)) => {
            return Err(fault(line, format!("both `{key}` and the centre"), "one of the two"));
        }
        (None, None) => {
            let found = format!("no `{key}` before the values");
            return Err(fault(values_line, found, "the corner or the centre in the header"));
        }
    };
    if at.abs() <= 1e9 {
        Ok(at)
    } else {
        Err(fault(line, format!("{at}"), "a coordinate, -1e9 to 1e9"))
    }
}

fn fault(line: usize, found: String, expected: impl Into<String>) -> WorldError {
    WorldError::GridText {
        line,
        found,
        expected: expected.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner -50\ncellsize 10\nNODATA_value -1\n1 2 3\n4 5 -1\n";

    fn message(text: &str) -> String {
        let message = read(text).unwrap_err().to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    }

    #[test]
    fn a_header_may_have_corner_or_centre_any_case_any_lines() {
        let grid = read(TEXT).unwrap();
        let layout = grid.layout();
        assert_eq!((layout.west, layout.north, layout.cell_east), (105.0, -35.0, 10.0));
        assert_eq!(grid.value(0, 0), Some(1.0));
        assert_eq!(grid.value(1, 2), None);
        assert_eq!(grid.first_without_data(), Some((1, 2)));
        let other = "\u{feff}NROWS 2 NCOLS 3\r\nCellSize 1e1\r\nXLLCENTER 105 YLLCENTRE -45\r\nnodata_VALUE -1\r\n\
                     1\r\n2 3 4.0\r\n\r\n+5 -1";
        assert_eq!(read(other).unwrap(), grid);
        // ESRI's default, and NaN if the header says so.
        let absent = TEXT.replace("NODATA_value -1\n", "").replace("5 -1", "5 -9999");
        assert_eq!(read(&absent).unwrap(), grid);
        let nan = TEXT
            .replace("NODATA_value -1", "NODATA_value nan")
            .replace("5 -1", "5 NaN");
        assert_eq!(read(&nan).unwrap(), grid);
    }

    #[test]
    fn every_fault_is_one_line_with_its_place() {
        let fault = |from: &str, to: &str| {
            assert!(TEXT.contains(from), "{from}");
            message(&TEXT.replace(from, to))
        };
        assert_eq!(
            fault("4 5 -1\n", "4 5\n"),
            "grid, line 8: the end after 5 values, expected 6 values (2 rows of 3)"
        );
        assert_eq!(
            fault("4 5 -1\n", "4 5 6\n7\n"),
            "grid, line 9: `7`, expected the end of the file after 6 values (2 rows of 3)"
        );
        assert_eq!(
            fault("2 3", "2 x"),
            "grid, line 7: `x`, expected a number, -12000 to 12000 m"
        );
        assert_eq!(
            fault("2 3", "nan 3"),
            "grid, line 7: `nan`, expected a number, -12000 to 12000 m"
        );
        assert_eq!(
            fault("2 3", "2 inf"),
            "grid, line 7: `inf`, expected a number, -12000 to 12000 m"
        );
        assert_eq!(
            fault("2 3", "2 30000"),
            "grid, line 7: `30000`, expected a number, -12000 to 12000 m"
        );
        assert_eq!(
            fault("cellsize 10", "cellsize 0"),
            "grid, line 5: a cellsize of 0, expected more than 0, at most 1000000"
        );
        assert_eq!(
            fault("cellsize 10", "cellsize nan"),
            "grid, line 5: `nan`, expected a number for `cellsize`"
        );
        assert_eq!(
            fault("cellsize 10\n", ""),
            "grid, line 6: no `cellsize` before the values, expected this key in the header"
        );
        assert_eq!(
            fault("xllcorner 100\n", ""),
            "grid, line 6: no `xllcorner` before the values, expected the corner or the centre in the header"
        );
        assert_eq!(
            fault("xllcorner 100", "xllcorner 100 xllcenter 100"),
            "grid, line 3: both `xllcorner` and the centre, expected one of the two"
        );
        assert_eq!(
            fault("nrows 2", "nrows 2 nrows 2"),
            "grid, line 2: a second `nrows`, expected each key once"
        );
        assert_eq!(
            fault("ncols 3", "ncols 2.5"),
            "grid, line 1: ncols of 2.5, expected a whole number, 2 to 25000000"
        );
        assert_eq!(
            fault("ncols 3", "ncols 4000000000"),
            "grid, line 1: ncols of 4000000000, expected a whole number, 2 to 25000000"
        );
        assert_eq!(
            fault("nrows 2", "nrows 25000000"),
            "grid, line 2: 3 columns and 25000000 rows, expected at most 25 million cells"
        );
        assert!(fault("ncols", "columns").starts_with("grid, line 1: `columns`, expected ncols, nrows,"));
        assert_eq!(
            message("ncols"),
            "grid, line 1: `ncols` without a value, expected a number after the key"
        );
        assert_eq!(
            message(""),
            "grid, line 1: no `ncols` before the values, expected this key in the header"
        );
    }
}
