//! GeoJSON (RFC 7946) for geographic information systems. Every feature has the property `layer`.

use std::io;
use std::path::Path;

use geojson::{Feature, FeatureWriter, JsonObject};

use crate::contents::Contents;
use crate::error::Error;
use crate::map::Map;
use crate::output::OutputFile;
use crate::source::Source;
use crate::{Exported, counted};

pub(crate) fn export(source: &Source, every_s: f64, out: &Path) -> Result<Exported, Error> {
    let mut file = OutputFile::create(out)?;
    let contents = Contents::of(source, |_| false)?;
    let map = Map::of(source, &contents, every_s)?;
    let written = write(&map, &contents, &mut file);
    let features = written.map_err(|error| file.failed(io_error(error)))?;
    file.commit()?;
    Ok(Exported {
        summary: format!("{}: {}", out.display(), counted(features, "feature")),
        remarks: [contents.remarks(source), map.remarks(source)].concat(),
    })
}

fn io_error(error: geojson::Error) -> io::Error {
    if let geojson::Error::Io(source) = error {
        source
    } else if let geojson::Error::MalformedGeoJson(source) = error {
        // serde_json wraps the errors of a writer.
        source.into()
    } else {
        io::Error::other(error)
    }
}

fn write(map: &Map, contents: &Contents, file: &mut OutputFile) -> Result<u64, geojson::Error> {
    let mut writer = FeatureWriter::from_writer(file);
    if let Some(mission) = contents.run.get("mission") {
        writer.write_foreign_member("name", mission)?;
    }
    let mut count = 0;
    let mut put = |mut feature: Feature, layer: &str| {
        let properties = feature.properties.get_or_insert_with(JsonObject::new);
        properties.insert("layer".to_owned(), layer.into());
        count += 1;
        writer.write_feature(&feature)
    };
    for track in [&map.track, &map.truth] {
        track.features().try_for_each(|feature| put(feature, track.name))?;
    }
    for layer in &map.layers {
        let mut features = layer.features.iter();
        features.try_for_each(|standing| put(standing.stamped(), &layer.name))?;
    }
    writer.finish()?;
    Ok(count)
}
