//! `backseat s7k export`: formats and their options.

use std::ffi::OsStr;
use std::path::PathBuf;

use backseat_s7k_tools::{
    AltitudeFrom, Blend, Crs, CsvOf, Error, Exported, GainBy, Moment, Mosaic, Nadir, Selection, Signal, Waterfall,
    export_csv, export_mosaic, export_segy, export_waterfall, export_xtf,
};
use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Args, ValueEnum};

use super::Recordings;

/// A format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Sub-bottom profiles (record 3001) as SEG-Y revision 1, one trace a ping
    Segy,
    /// Sidescan (3000) as a picture in grey, port to the left, time upwards
    Png,
    /// Sidescan (3000) as a georeferenced mosaic, 8 bits, 0 where there is no data
    Geotiff,
    /// Vehicle data (3100) as a table, one row a frame, with a column for each quality bit
    Csv,
    /// Sidescan (3000) in the eXtended Triton Format, revision 42
    Xtf,
}

/// Reads a format. `cut` and `dump` have `--to` for a time, so a time here is worth a hint.
#[derive(Clone, Copy, Debug)]
struct FormatParser;

impl TypedValueParser for FormatParser {
    type Value = Format;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<Format, clap::Error> {
        if value.to_str().is_some_and(|text| text.parse::<Moment>().is_ok()) {
            let text = "--to is the format of an export: for the end of the time, use --until\n";
            return Err(clap::Error::raw(ErrorKind::InvalidValue, text).with_cmd(command));
        }
        EnumValueParser::<Format>::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let values = Format::value_variants().iter();
        Some(Box::new(values.filter_map(ValueEnum::to_possible_value)))
    }
}

#[derive(Debug, Args)]
pub(crate) struct S7kExport {
    #[command(flatten)]
    recordings: Recordings,
    /// The format
    #[arg(long, value_parser = FormatParser)]
    to: Format,
    /// Write to this file; it is replaced if it exists, once the new one is complete
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Only this device, such as 11002 for the sidescan's high frequency
    #[arg(long, value_name = "N")]
    device: Option<u32>,
    /// Only records at this time in UTC or later, such as 2026-11-23T14:05:07.25 or 2026-327T14:05:07.25
    #[arg(long, value_name = "TIME")]
    from: Option<Moment>,
    /// Only records before this time in UTC
    #[arg(long, value_name = "TIME")]
    until: Option<Moment>,
    #[command(flatten)]
    imagery: ImageryOptions,
    #[command(flatten)]
    mosaic: MosaicOptions,
    /// segy: the envelope (magnitude of complex samples), or the real part of complex samples [default: envelope]
    #[arg(long, value_enum, help_heading = "Options for one format")]
    signal: Option<SignalOption>,
    /// segy: the channel, from 0 [default: 0]
    #[arg(long, value_name = "N", help_heading = "Options for one format")]
    channel: Option<usize>,
    /// csv: the frames [default: navigation]
    #[arg(long, value_enum, help_heading = "Options for one format")]
    data: Option<DataOption>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Options for sidescan")]
struct ImageryOptions {
    /// png: correct slant range to range along the seabed, which is taken to be flat
    #[arg(long)]
    ground: bool,
    /// png: width of the picture [default: as many as there are samples, at most 2000]
    #[arg(long, value_name = "PIXELS")]
    width: Option<u32>,
    /// png, geotiff: the altitude for that correction: navigation, first bottom return, or navigation where it is valid
    /// and else bottom [default: auto]
    #[arg(long, value_enum)]
    altitude: Option<AltitudeOption>,
    /// png, geotiff: divide amplitudes by the median at their range and side, or by nothing [default: range]
    #[arg(long, value_enum)]
    gain: Option<GainOption>,
    /// png, geotiff, xtf: speed of sound in m/s [default: from record 3100, else 1500]
    #[arg(long, value_name = "M/S", value_parser = sound_speed)]
    sound_speed: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Options for geotiff")]
struct MosaicOptions {
    /// Coordinates: metres in the UTM zone of the first position, or degrees [default: utm]
    #[arg(long, value_enum)]
    crs: Option<CrsOption>,
    /// Size of a cell in metres [default: 0.25]
    #[arg(long, value_name = "M")]
    resolution: Option<f64>,
    /// What a cell becomes that several samples hit [default: mean]
    #[arg(long, value_enum)]
    blend: Option<BlendOption>,
    /// The strip below the vehicle, to 0.3 of the altitude on each side: show it below other data, drop it, or keep it
    /// as the rest [default: below]
    #[arg(long, value_enum)]
    nadir: Option<NadirOption>,
    /// The most memory for the raster [default: 512]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    memory: Option<u64>,
}

/// An option of the command line that stands for a value of the tools.
macro_rules! choices {
    ($( $Option:ident for $Value:ident { $( $Variant:ident ),* } )*) => { $(
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
        enum $Option { $( $Variant ),* }

        impl From<$Option> for $Value {
            fn from(option: $Option) -> Self {
                match option { $( $Option::$Variant => Self::$Variant ),* }
            }
        }
    )* };
}

choices! {
    SignalOption for Signal { Envelope, Real }
    DataOption for CsvOf { Navigation, Environment }
    AltitudeOption for AltitudeFrom { Auto, Navigation, Bottom }
    GainOption for GainBy { Range, None }
    CrsOption for Crs { Utm, Wgs84 }
    BlendOption for Blend { Mean, Brightest, Last }
    NadirOption for Nadir { Below, Drop, Keep }
}

fn chosen<O: Into<V>, V: Default>(option: Option<O>) -> V {
    option.map_or_else(V::default, Into::into)
}

fn sound_speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(speed) if (1000.0..=2000.0).contains(&speed) => Ok(speed),
        _ => Err("expected 1000 to 2000 m/s".to_owned()),
    }
}

impl S7kExport {
    pub(super) fn export(&self) -> Result<Exported, Error> {
        self.check_options()?;
        let source = self.recordings.open()?;
        let selection = Selection {
            types: Vec::new(),
            devices: self.device.into_iter().collect(),
            from: self.from,
            to: self.until,
        };
        let Self {
            imagery, mosaic, out, ..
        } = self;
        match self.to {
            Format::Segy => {
                let channel = self.channel.unwrap_or(0);
                export_segy(&source, &selection, chosen(self.signal), channel, out)
            }
            Format::Csv => export_csv(&source, &selection, chosen(self.data), out),
            Format::Xtf => export_xtf(&source, &selection, imagery.sound_speed, out),
            Format::Png => {
                let drawing = Waterfall {
                    ground: imagery.ground,
                    altitude: chosen(imagery.altitude),
                    gain: chosen(imagery.gain),
                    width: imagery.width,
                    sound_speed_mps: imagery.sound_speed,
                };
                export_waterfall(&source, &selection, &drawing, out)
            }
            Format::Geotiff => {
                let usual = Mosaic::default();
                let mosaic = Mosaic {
                    crs: chosen(mosaic.crs),
                    resolution_m: mosaic.resolution.unwrap_or(usual.resolution_m),
                    blend: chosen(mosaic.blend),
                    nadir: chosen(mosaic.nadir),
                    altitude: chosen(imagery.altitude),
                    gain: chosen(imagery.gain),
                    sound_speed_mps: imagery.sound_speed,
                    memory_mib: mosaic.memory.unwrap_or(usual.memory_mib),
                };
                export_mosaic(&source, &selection, &mosaic, out)
            }
        }
    }

    /// An option that the format does not have is a mistake, and not ignored.
    fn check_options(&self) -> Result<(), Error> {
        use Format::{Csv, Geotiff, Png, Segy, Xtf};
        let Self { imagery, mosaic, .. } = self;
        let options: [(&'static str, bool, &[Format]); 13] = [
            ("--ground", imagery.ground, &[Png]),
            ("--width", imagery.width.is_some(), &[Png]),
            ("--altitude", imagery.altitude.is_some(), &[Png, Geotiff]),
            ("--gain", imagery.gain.is_some(), &[Png, Geotiff]),
            ("--sound-speed", imagery.sound_speed.is_some(), &[Png, Geotiff, Xtf]),
            ("--crs", mosaic.crs.is_some(), &[Geotiff]),
            ("--resolution", mosaic.resolution.is_some(), &[Geotiff]),
            ("--blend", mosaic.blend.is_some(), &[Geotiff]),
            ("--nadir", mosaic.nadir.is_some(), &[Geotiff]),
            ("--memory", mosaic.memory.is_some(), &[Geotiff]),
            ("--signal", self.signal.is_some(), &[Segy]),
            ("--channel", self.channel.is_some(), &[Segy]),
            ("--data", self.data.is_some(), &[Csv]),
        ];
        match options
            .into_iter()
            .find(|(_, given, formats)| *given && !formats.contains(&self.to))
        {
            None => Ok(()),
            Some((option, _, formats)) => {
                let formats: Vec<String> = formats
                    .iter()
                    .map(|format| format!("{format:?}").to_lowercase())
                    .collect();
                let fault = format!("it is an option of --to {} only", formats.join(" and "));
                Err(Error::Option { option, fault })
            }
        }
    }
}
