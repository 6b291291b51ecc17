use backseat_log_export::{Export, Format, export};
use serde_json::Value;

use crate::{Desk, compose, names};

/// The lines of a table, each with its fields; no field of these tables has a comma or a line end.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().map(|line| line.split(',').collect()).collect()
}

fn one(desk: &Desk, channel: &str, out: &str) -> Result<String, String> {
    let path = desk.at(out);
    export(&Export {
        log: &desk.log,
        to: Format::Csv,
        out: &path,
        channel: Some(channel),
        every_s: None,
    })
    .map_err(|error| error.to_string())?;
    Ok(std::fs::read_to_string(path).unwrap())
}

#[test]
fn a_folder_has_a_table_a_channel_and_says_what_its_columns_are() {
    let desk = Desk::with(&compose::whole());
    for (format, out) in [(Format::Csv, "csv"), (Format::Parquet, "parquet")] {
        let done = desk.export(format, out).unwrap();
        assert!(done.summary.contains("17 tables with "), "{}", done.summary);
        let files = names(&desk.at(out));
        assert_eq!(files.len(), 18, "{files:?}");
        assert!(files.contains(&format!("sensors_CTD.{out}")), "{files:?}");
        let index: Value = serde_json::from_slice(&std::fs::read(desk.at(out).join("tables.json")).unwrap()).unwrap();
        assert_eq!((&index["complete"], &index["run"]["seed"]), (&true.into(), &"7".into()));
        assert_eq!(index["gaps"][0]["records"], 250);
        let tables = index["tables"].as_array().unwrap();
        let navigation = tables.iter().find(|table| table["topic"] == "/navigation").unwrap();
        // Each 0.2 s over 120 s, without the 49 of the gap.
        assert_eq!(navigation["rows"], 601 - 49);
        let depth = navigation["columns"]
            .as_array()
            .unwrap()
            .iter()
            .find(|column| column["name"] == "depth_m");
        assert_eq!(depth.unwrap()["description"], "Metres below the surface.");
    }
    assert_eq!(
        std::fs::read(desk.at("parquet/navigation.parquet")).unwrap()[..4],
        *b"PAR1"
    );
}

#[test]
fn one_channel_is_one_file_with_exact_figures() {
    let desk = Desk::with(&compose::whole());
    let text = one(&desk, "/sensors/CTD", "ctd.csv").unwrap();
    let rows = rows(&text);
    assert_eq!(
        rows[0],
        ["time", "t_s", "created", "temperature_degc", "count", "frames", "never"]
    );
    assert_eq!(rows[2][..2], ["2026-11-23T14:05:09.250000000Z", "2.0"]);
    let temperature: f64 = rows[2][3].parse().unwrap();
    assert_eq!(temperature, 10.0_f64.sqrt() / 3.0);
    let not_measured = rows.iter().find(|row| row[1] == "20.0").unwrap();
    assert_eq!(not_measured[3], "NaN");
    assert_eq!(rows.len() - 1, 61 - 4);
    // The slash may be left out.
    assert_eq!(one(&desk, "sensors/CTD", "again.csv").unwrap(), text);
}

#[test]
fn bytes_of_the_link_are_text_or_base64() {
    let desk = Desk::with(&compose::whole());
    let text = one(&desk, "/link/from_vehicle", "link.csv").unwrap();
    assert!(text.starts_with("time,t_s,text,base64\n"), "{text}");
    assert!(text.contains(",,//7/DQo=\n"), "{text}");
}

#[test]
fn a_channel_that_the_log_lacks_is_refused_with_those_that_it_has() {
    let desk = Desk::with(&compose::whole());
    let error = one(&desk, "/navigatoin", "x.csv").unwrap_err();
    assert!(
        error.contains("no channel /navigatoin; the log has /link/from_vehicle, "),
        "{error}"
    );
    assert_eq!(desk.names(), ["dive.mcap"]);
}
