//! NetCDF classic with a trajectory by the conventions CF 1.8 and ACDD 1.3, as data centres of gliders take it.
//!
//! Each message of `/navigation` is a row. A measurement of another channel is in the row whose time is nearest, if that
//! is within a second; other rows have `_FillValue` there. Nothing is interpolated.

mod file;
mod rows;
mod salinity;
mod variables;

use std::path::Path;

use self::file::{Attribute, Attributes, TIME, Values, Variable};
use self::rows::Rows;
use self::variables::{
    CONTROL, COORDINATES, FILL, FILL_FLAG, Flag, MEASURED, Measured, NAVIGATION, PUBLISHED_UNITS, SALINITY, SPEED,
    TRUTH,
};
use crate::contents::Contents;
use crate::error::Error;
use crate::output::OutputFile;
use crate::source::Source;
use crate::time::rfc3339;
use crate::{Exported, counted};

/// The variable of the vehicle, and that of the Earth's shape.
const PLATFORM: &str = "platform";
const CRS: &str = "crs";
const CTD: &str = "instrument_ctd";
const TRAJECTORY: &str = "trajectory";

pub(crate) fn export(source: &Source, out: &Path) -> Result<Exported, Error> {
    let file = OutputFile::create(out)?;
    let contents = Contents::of(source, |_| false)?;
    let mut rows = Rows::default();
    contents.read(source, Rows::wants, |message| {
        rows.take(&message, contents.start_ns);
        Ok(())
    })?;
    let mut channels = contents.channels.iter();
    rows.finish(channels.any(|channel| channel.topic == CONTROL));
    if rows.times.is_empty() {
        return Err(Error::NoPosition {
            path: source.path().to_owned(),
        });
    }
    let id = identifier(&contents);
    let salinity = rows.salinity();
    let variables = variables(&rows, salinity.as_deref(), &id);
    file::write(file, rows.times.len(), &global(&contents, &rows, &id), &variables)?;
    Ok(Exported {
        summary: format!(
            "{}: {} of {}",
            out.display(),
            counted(rows.times.len() as u64, "row"),
            counted(variables.len() as u64, "variable")
        ),
        remarks: [contents.remarks(source), remarks(source, &rows)].concat(),
    })
}

fn remarks(source: &Source, rows: &Rows) -> Vec<String> {
    let log = source.path().display();
    let mut remarks = Vec::new();
    if rows.rows_left_out > 0 {
        remarks.push(format!(
            "{log}: {} left out, without a position or not later than the one before",
            counted(rows.rows_left_out, "solution")
        ));
    }
    if rows.measurements_left_out > 0 {
        remarks.push(format!(
            "{log}: {} left out, because no navigation is within 1 s of them: --to parquet has all",
            counted(rows.measurements_left_out, "measurement")
        ));
    }
    remarks
}

/// `MISSION-20260601T233000Z`, with the seed of a simulation, in letters that any name may have.
fn identifier(contents: &Contents) -> String {
    let run = |key: &str| contents.run.get(key).map_or("", String::as_str);
    let start = rfc3339(contents.start_ns).replace(['-', ':'], "");
    let start = start.split('.').next().unwrap_or_default();
    let mut id = format!("{}-{start}Z", run("mission"));
    if !run("seed").is_empty() {
        id = format!("{id}-seed-{}", run("seed"));
    }
    plain(&id)
}

/// A text in letters that any name may have.
fn plain(text: &str) -> String {
    const LENGTH_MAX: usize = 100;
    let letters = text.chars().take(LENGTH_MAX);
    let letters = letters.map(|letter| {
        if letter.is_ascii_alphanumeric() || letter == '-' {
            letter
        } else {
            '_'
        }
    });
    letters.collect()
}

/// A plain name, with a number behind it if another has it.
fn distinct(name: &str, taken: &[&str]) -> String {
    let name = plain(name).replace('-', "_");
    if !taken.contains(&name.as_str()) {
        return name;
    }
    let mut numbered = (2..).map(|number| format!("{name}_{number}"));
    numbered
        .find(|name| !taken.contains(&name.as_str()))
        .unwrap_or_default()
}

fn variables<'a>(rows: &'a Rows, salinity: Option<&'a [f64]>, id: &'a str) -> Vec<Variable<'a>> {
    let mut variables = vec![trajectory(id), time(rows)];
    let present = MEASURED.iter().enumerate();
    let present = present.filter_map(|(place, measured)| Some((measured, rows.column(place)?)));
    let computed = [(&SPEED, rows.speed()), (&SALINITY, salinity)];
    let computed = computed
        .into_iter()
        .filter_map(|(measured, column)| Some((measured, column?)));
    variables.extend(
        present
            .chain(computed)
            .map(|(measured, column)| of_channel(measured, column)),
    );
    for (name, (unit, column)) in &rows.published {
        let taken: Vec<&str> = variables.iter().map(|variable| variable.name.as_str()).collect();
        let variable = of_plugin(&distinct(&format!("measure_{name}"), &taken), name, unit, column);
        variables.push(variable);
    }
    variables.extend(rows.flags().map(|(flag, values)| of_flag(flag, values)));
    let has_ctd = variables.iter().any(|variable| {
        let mut attributes = variable.attributes.iter();
        attributes.any(|(name, _)| name == "instrument")
    });
    variables.push(empty(
        PLATFORM,
        &[
            ("long_name", "Bluefin autonomous underwater vehicle"),
            ("type", "AUV"),
            ("id", id),
        ],
    ));
    if has_ctd {
        variables.push(empty(
            CTD,
            &[
                ("long_name", "Conductivity, temperature and depth sensor"),
                ("type", "CTD"),
                ("platform", PLATFORM),
                (
                    "comment",
                    "The vehicle's, by the message BFCTD of the Standard Payload Interface.",
                ),
            ],
        ));
    }
    let mut crs = empty(
        CRS,
        &[
            ("long_name", "World Geodetic System 1984"),
            ("grid_mapping_name", "latitude_longitude"),
            ("epsg_code", "EPSG:4326"),
        ],
    );
    for (name, value) in [
        ("semi_major_axis", 6_378_137.0),
        ("inverse_flattening", 298.257_223_563),
        ("longitude_of_prime_meridian", 0.0),
    ] {
        crs.attributes.push((name.to_owned(), Attribute::Number(value)));
    }
    variables.push(crs);
    variables
}

fn texts(pairs: &[(&str, &str)]) -> Attributes {
    let pairs = pairs.iter().filter(|(_, value)| !value.is_empty());
    pairs
        .map(|(name, value)| ((*name).to_owned(), (*value).into()))
        .collect()
}

fn empty<'a>(name: &str, attributes: &[(&str, &str)]) -> Variable<'a> {
    Variable {
        name: name.to_owned(),
        attributes: texts(attributes),
        values: Values::Empty,
    }
}

fn trajectory(id: &str) -> Variable<'_> {
    Variable {
        name: TRAJECTORY.to_owned(),
        attributes: texts(&[("cf_role", "trajectory_id"), ("long_name", "Name of the trajectory")]),
        values: Values::Text(id),
    }
}

fn time(rows: &Rows) -> Variable<'_> {
    Variable {
        name: TIME.to_owned(),
        attributes: texts(&[
            ("standard_name", "time"),
            ("long_name", "Time of the navigation solution"),
            ("units", "seconds since 1970-01-01T00:00:00Z"),
            ("calendar", "standard"),
            ("axis", "T"),
            ("observation_type", "measured"),
        ]),
        values: Values::Numbers(&rows.times, 1.0),
    }
}

fn number(name: &str, value: f64) -> (String, Attribute) {
    (name.to_owned(), Attribute::Number(value))
}

fn of_channel<'a>(measured: &Measured, column: &'a [f64]) -> Variable<'a> {
    let mut attributes = texts(&[
        ("standard_name", measured.standard_name),
        ("long_name", measured.long_name),
        ("units", measured.units),
    ]);
    attributes.push(number("_FillValue", FILL));
    if let Some((least, greatest)) = measured.range {
        attributes.extend([number("valid_min", least), number("valid_max", greatest)]);
    }
    attributes.extend(texts(measured.more));
    let is_coordinate = COORDINATES.split(' ').any(|coordinate| coordinate == measured.name);
    let content = match measured.topic {
        _ if is_coordinate => "coordinate",
        TRUTH => "modelResult",
        _ => "physicalMeasurement",
    };
    attributes.extend(texts(&[("coverage_content_type", content)]));
    if !is_coordinate {
        attributes.extend(of_trajectory());
    }
    Variable {
        name: measured.name.to_owned(),
        attributes,
        values: Values::Numbers(column, measured.per_unit),
    }
}

/// Where the values of the rows belong.
fn of_trajectory() -> Attributes {
    texts(&[
        ("coordinates", COORDINATES),
        ("grid_mapping", CRS),
        ("platform", PLATFORM),
    ])
}

fn of_plugin<'a>(variable: &str, name: &str, unit: &str, column: &'a [f64]) -> Variable<'a> {
    let known = PUBLISHED_UNITS.iter().find(|(known, _)| *known == unit);
    let comment = format!("Published by a plugin as {name}, in the unit \"{unit}\".");
    let mut attributes = texts(&[
        ("long_name", &format!("Measure {name}")),
        ("units", known.map_or("", |(_, units)| units)),
        ("comment", &comment),
        ("coverage_content_type", "physicalMeasurement"),
    ]);
    attributes.push(number("_FillValue", FILL));
    attributes.extend(of_trajectory());
    Variable {
        name: variable.to_owned(),
        attributes,
        values: Values::Numbers(column, 1.0),
    }
}

fn of_flag<'a>(flag: &Flag, values: &'a [i32]) -> Variable<'a> {
    let numbers = (0..).take(flag.meanings.len()).collect();
    let mut attributes = texts(&[("long_name", flag.long_name), ("comment", flag.comment)]);
    attributes.push(("flag_values".to_owned(), Attribute::Integers(numbers)));
    attributes.extend(texts(&[
        ("flag_meanings", &flag.meanings.join(" ")),
        ("coverage_content_type", flag.content),
    ]));
    attributes.push(("_FillValue".to_owned(), Attribute::Integers(vec![FILL_FLAG])));
    attributes.extend(of_trajectory());
    Variable {
        name: flag.name.to_owned(),
        attributes,
        values: Values::Flags(values),
    }
}

/// The attributes of the file. They say nothing of the computer or of when the export was made, so that a log always
/// gives the same bytes.
fn global(contents: &Contents, rows: &Rows, id: &str) -> Attributes {
    let run = |key: &str| contents.run.get(key).map_or("", String::as_str);
    let mission = run("mission");
    let [first, last] = [rows.times.first(), rows.times.last()].map(|time| time.copied().unwrap_or_default());
    let at = |time_s: f64| rfc3339((time_s * 1e9) as u64);
    let is_simulated = run("rate") == "simulation";
    let kind = if is_simulated { "simulated dive" } else { "dive" };
    let source = if is_simulated {
        format!("simulation by backseat {} with seed {}", run("version"), run("seed"))
    } else {
        "navigation and sensors of an autonomous underwater vehicle, recorded on its payload computer".to_owned()
    };
    let history = format!(
        "{}: recorded by backseat {}\nexported by backseat {}: log export --to netcdf",
        rfc3339(contents.start_ns),
        run("version"),
        env!("CARGO_PKG_VERSION"),
    );
    let mut attributes = texts(&[
        ("Conventions", "CF-1.8, ACDD-1.3"),
        ("featureType", "trajectory"),
        ("cdm_data_type", "Trajectory"),
        ("title", &format!("Trajectory of the {kind} {mission}")),
        (
            "summary",
            &format!(
                "Track, attitude and measurements of a Bluefin autonomous underwater vehicle in the {kind} {mission}, \
                 from the log of its payload computer. Each row is a navigation solution with the measurements nearest \
                 to it in time."
            ),
        ),
        (
            "keywords",
            "autonomous underwater vehicle, AUV, trajectory, sea water, navigation",
        ),
        ("source", &source),
        ("history", &history),
        ("id", id),
        ("naming_authority", "backseat"),
        ("references", "Standard Payload Interface 1.12a"),
        ("platform", "autonomous underwater vehicle"),
        ("processing_level", "as recorded, without quality control"),
        ("time_coverage_start", &at(first)),
        ("time_coverage_end", &at(last)),
        (
            "time_coverage_duration",
            &format!(
                "PT{}S",
                crate::tables::decimal((last - first).round()).trim_end_matches(".0")
            ),
        ),
        ("geospatial_bounds_crs", "EPSG:4326"),
        ("geospatial_lat_units", "degrees_north"),
        ("geospatial_lon_units", "degrees_east"),
        ("geospatial_vertical_units", "m"),
        ("geospatial_vertical_positive", "down"),
    ]);
    for (name, what) in [("lat", "lat"), ("lon", "lon"), ("depth", "vertical")] {
        let place = MEASURED
            .iter()
            .position(|measured| measured.topic == NAVIGATION && measured.name == name);
        let column = place.and_then(|place| rows.column(place)).unwrap_or_default();
        let least = column.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        attributes.push(number(&format!("geospatial_{what}_min"), least));
        attributes.push(number(&format!("geospatial_{what}_max"), greatest));
    }
    for (key, value) in contents.run.iter().filter(|(_, value)| !value.is_empty()) {
        let taken: Vec<&str> = attributes.iter().map(|(name, _)| name.as_str()).collect();
        let name = distinct(&format!("backseat_{key}"), &taken);
        attributes.push((name, Attribute::Text(value.clone())));
    }
    attributes
}
