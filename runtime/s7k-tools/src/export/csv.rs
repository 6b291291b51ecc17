//! Vehicle data (records 3100) as CSV: a row for each frame.

use std::path::Path;

use backseat_s7k::record::{
    BluefinData, BluefinFrame, BluefinRecord, EnvironmentField, EnvironmentFrame, NavigationField, NavigationFrame,
    Record,
};
use backseat_s7k::{BluefinChecksum, FrameHeader, LayoutField};

use super::Exported;
use crate::error::Error;
use crate::moment::Moment;
use crate::output::Output;
use crate::selection::Selection;
use crate::source::Source;
use crate::unmatched::Unmatched;

/// What a CSV file has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CsvOf {
    /// Navigation: position, depth, altitude, attitude, and their rates.
    #[default]
    Navigation,
    /// Environment: the speed of sound.
    Environment,
}

/// The columns in front of the frame's own fields.
const HEAD: [&str; 10] = [
    "record_offset",
    "record_count",
    "record_utc",
    "device",
    "enumerator",
    "record_time_ms",
    "frame",
    "frame_version",
    "frame_utc",
    "frame_checksum",
];

/// Writes a row for each frame of navigation or of environment: where it is, all its fields, and a column with 1 or 0
/// for each quality bit.
///
/// # Errors
/// [`Error::Read`] and [`Error::Write`]; [`Error::Contents`] if there is no such frame.
pub fn export_csv(source: &Source, selection: &Selection, what: CsvOf, out: &Path) -> Result<Exported, Error> {
    let failed = |error: csv::Error| Error::write(out, plain(error));
    let mut writer = csv::Writer::from_writer(Output::create(out, source)?);
    let (fields, bits): (_, Vec<String>) = match what {
        CsvOf::Navigation => (
            NavigationFrame::LAYOUT.fields,
            NavigationField::ALL.iter().map(name).collect(),
        ),
        CsvOf::Environment => (
            EnvironmentFrame::LAYOUT.fields,
            EnvironmentField::ALL.iter().map(name).collect(),
        ),
    };
    let fields = fields
        .iter()
        .map(|field: &LayoutField| field.name)
        .filter(|name| !name.starts_with("reserved"));
    let valid = bits.iter().map(|bit| format!("{bit}_valid"));
    let head = HEAD.into_iter().chain(fields).map(str::to_owned).chain(valid);
    writer.write_record(head).map_err(failed)?;
    let (mut rows, mut wrong) = (0_u64, 0);
    source.each_record(|offset, frame| {
        let header = frame.header();
        if header.record_type != 3100 || !selection.contains(header) {
            return Ok(());
        }
        let Ok(Record::Bluefin(record)) = Record::read(frame) else {
            return Ok(());
        };
        for (index, data) in record.frames().enumerate() {
            let values = match (&data.data, what) {
                (BluefinData::Navigation(navigation), CsvOf::Navigation) => navigation_values(navigation),
                (BluefinData::Environment(environment), CsvOf::Environment) => environment_values(environment),
                (BluefinData::Navigation(_) | BluefinData::Environment(_) | BluefinData::Other(_), _) => continue,
            };
            let readings = [BluefinChecksum::WholePacket, BluefinChecksum::DataOnly];
            let right = readings
                .iter()
                .any(|reading| data.checksum_matches(*reading) == Some(true));
            wrong += usize::from(!right && data.header.checksum != 0);
            let row = head_values(offset, header, &record, index, &data)
                .into_iter()
                .chain(values);
            writer.write_record(row).map_err(failed)?;
            rows += 1;
        }
        Ok(())
    })?;
    if rows == 0 {
        let kind = match what {
            CsvOf::Navigation => "navigation",
            CsvOf::Environment => "environment",
        };
        return Err(Unmatched::survey(source, 3100)?.refuse(source, selection, 3100, kind));
    }
    let output = writer
        .into_inner()
        .map_err(|error| Error::write(out, error.into_error()))?;
    output.commit()?;
    let mut exported = Exported::new(format!("{rows} rows"));
    exported.note_if(
        wrong,
        "frames whose checksum is right by neither reading of the specification",
    );
    exported.note_left_out(source);
    Ok(exported)
}

/// The file's own error, which says more than the writer's.
fn plain(error: csv::Error) -> std::io::Error {
    let text = error.to_string();
    if let csv::ErrorKind::Io(error) = error.into_kind() {
        error
    } else {
        std::io::Error::other(text)
    }
}

/// A quality bit's name, as JSON has it.
fn name(field: &impl serde::Serialize) -> String {
    serde_json::to_value(field)
        .ok()
        .and_then(|value| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}

fn head_values(
    offset: u64,
    header: &FrameHeader,
    record: &BluefinRecord<'_>,
    index: usize,
    frame: &BluefinFrame<'_>,
) -> [String; 10] {
    let utc = |moment: Option<Moment>| {
        let json = moment.and_then(|moment| serde_json::to_string(&moment).ok());
        json.map_or_else(String::new, |text| text.trim_matches('"').to_owned())
    };
    [
        offset.to_string(),
        header.record_count.to_string(),
        utc(Moment::of(&header.time)),
        header.device.to_string(),
        header.enumerator.to_string(),
        record.header.time_ms.to_string(),
        index.to_string(),
        frame.header.version.to_string(),
        utc(Moment::of(&frame.header.time)),
        format!("{:08x}", frame.header.checksum),
    ]
}

fn bit(valid: bool) -> String {
    u8::from(valid).to_string()
}

/// The values in the order of the layout, then the quality bits.
fn navigation_values(frame: &NavigationFrame) -> Vec<String> {
    let NavigationFrame {
        quality,
        latitude_rad,
        longitude_rad,
        speed_mps,
        depth_m,
        altitude_m,
        roll_rad,
        pitch_rad,
        yaw_rad,
        northing_rate_mps,
        easting_rate_mps,
        depth_rate_mps,
        altitude_rate_mps,
        roll_rate_radps,
        pitch_rate_radps,
        yaw_rate_radps,
        position_time_s,
        attitude_time_s,
    } = frame;
    let mut values = vec![quality.0.to_string()];
    values.extend([latitude_rad, longitude_rad].map(f64::to_string));
    values.push(speed_mps.to_string());
    values.extend([depth_m, altitude_m].map(f64::to_string));
    let narrow = [
        roll_rad,
        pitch_rad,
        yaw_rad,
        northing_rate_mps,
        easting_rate_mps,
        depth_rate_mps,
        altitude_rate_mps,
        roll_rate_radps,
        pitch_rate_radps,
        yaw_rate_radps,
    ];
    values.extend(narrow.map(f32::to_string));
    values.extend([position_time_s, attitude_time_s].map(f64::to_string));
    values.extend(NavigationField::ALL.iter().map(|field| bit(quality.contains(*field))));
    values
}

fn environment_values(frame: &EnvironmentFrame) -> Vec<String> {
    let mut values = vec![frame.quality.0.to_string(), frame.sound_speed_mps.to_string()];
    values.extend(
        EnvironmentField::ALL
            .iter()
            .map(|field| bit(frame.quality.contains(*field))),
    );
    values
}
