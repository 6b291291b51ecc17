//! Writes the survey of the tests into a folder, with everything that `backseat s7k` makes of it, for the scripts in
//! `tests/suite/scripts` to open with readers that others wrote.
//!
//! ```sh
//! cargo run -p backseat-s7k-tools --example survey -- FOLDER
//! python tests/suite/scripts/sonar_exports.py FOLDER
//! ```

#[allow(
    clippy::allow_attributes,
    clippy::unwrap_used,
    dead_code,
    reason = "shared with the tests, which use all of it"
)]
mod compose;

use std::error::Error;
use std::fs::{File, create_dir_all, write};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use backseat_s7k_tools::{
    Blend, Crs, CsvOf, Mosaic, Nadir, Selection, Signal, Source, Waterfall, dump, export_csv, export_mosaic,
    export_segy, export_waterfall, export_xtf,
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("expected a folder")?);
    create_dir_all(&folder)?;
    write(folder.join("damaged.s7k"), compose::damaged().0)?;
    write(folder.join("survey.s7k"), compose::clean())?;
    for name in ["survey", "damaged"] {
        let source = Source::open(&folder.join(name).with_extension("s7k"))?;
        let mut out = BufWriter::new(File::create(folder.join(name).with_extension("jsonl"))?);
        dump(&source, &Selection::default(), true, &mut out)?;
    }
    let source = Source::open(&folder.join("survey.s7k"))?;
    for exported in exports(&source, &folder)? {
        println!("{exported}");
    }
    Ok(())
}

fn exports(source: &Source, folder: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    let at = |name: &str| folder.join(name);
    let of = |device: u32| Selection {
        devices: vec![device],
        ..Selection::default()
    };
    let (high, low, all) = (of(11_002), of(11_001), Selection::default());
    let ground = Waterfall {
        ground: true,
        ..Waterfall::default()
    };
    let degrees = Mosaic {
        crs: Crs::Wgs84,
        resolution_m: 0.5,
        blend: Blend::Brightest,
        nadir: Nadir::Drop,
        ..Mosaic::default()
    };
    Ok([
        export_segy(source, &all, Signal::Envelope, 0, &at("envelope.sgy"))?,
        export_segy(source, &all, Signal::Real, 0, &at("real.sgy"))?,
        export_csv(source, &all, CsvOf::Navigation, &at("navigation.csv"))?,
        export_csv(source, &all, CsvOf::Environment, &at("environment.csv"))?,
        export_xtf(source, &high, None, &at("high.xtf"))?,
        export_xtf(source, &low, None, &at("low.xtf"))?,
        export_waterfall(source, &high, &Waterfall::default(), &at("slant.png"))?,
        export_waterfall(source, &high, &ground, &at("ground.png"))?,
        export_mosaic(source, &high, &Mosaic::default(), &at("utm.tif"))?,
        export_mosaic(source, &high, &degrees, &at("degrees.tif"))?,
    ]
    .map(|exported| exported.to_string())
    .to_vec())
}
