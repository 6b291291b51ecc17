//! The page `runtime/docs/plc.md` says what the mock does with each text of appendix C, and which keys it has.

use backseat_plc::PlcConfig;
use backseat_s7k::plc::{TextKind, texts};

const PAGE: &str = include_str!("../../../docs/plc.md");

/// The cells of the rows of the table below a heading.
fn rows(heading: &str) -> Vec<Vec<String>> {
    let text = PAGE.split(&format!("\n## {heading}\n")).nth(1).expect(heading);
    let text = text.split("\n## ").next().unwrap_or_default();
    text.lines()
        .filter(|line| line.starts_with("| "))
        .skip(1)
        .map(|line| {
            line.trim_matches('|')
                .split('|')
                .map(|cell| cell.trim().to_owned())
                .collect()
        })
        .collect()
}

#[test]
fn every_text_of_appendix_c_has_its_row() {
    for (heading, kind) in [
        ("Commands", TextKind::Command),
        ("Generic commands", TextKind::Generic),
        ("Status", TextKind::Status),
        ("Alarms", TextKind::Alarm),
    ] {
        let documented: Vec<(String, String, String)> = rows(heading)
            .into_iter()
            .map(|row| {
                assert_eq!(row.len(), 6, "{row:?}");
                assert!(row.iter().all(|cell| !cell.is_empty()), "{row:?}");
                (row[0].clone(), row[1].clone(), row[2].clone())
            })
            .collect();
        let catalogue: Vec<(String, String, String)> = texts()
            .filter(|entry| entry.kind == kind)
            .map(|entry| {
                (
                    entry.id.to_string(),
                    entry.name.to_owned(),
                    format!("`{}`", entry.format()),
                )
            })
            .collect();
        assert_eq!(documented, catalogue, "{heading}");
    }
}

/// The page's file has every key, with its default.
#[test]
fn the_documented_defaults_are_the_defaults() {
    let file = PAGE.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let file: toml::Table = toml::from_str(file.expect("a file")).expect("it is TOML");
    let table = file
        .get("plc")
        .and_then(toml::Value::as_table)
        .expect("the table [plc]")
        .clone();
    let config: PlcConfig = table.clone().try_into().expect("it is read");
    config.validate().expect("it is allowed");
    let defaults = PlcConfig {
        fault: config.fault.clone(),
        ..PlcConfig::default()
    };
    assert_eq!(config, defaults);
    // A key that the page leaves out would have its default unnoticed. `health_period_s` has none.
    let sources = [
        include_str!("../../src/config.rs"),
        include_str!("../../src/interpretation.rs"),
    ];
    let (config, interpretation) = (sources[0], sources[1]);
    let written = |section: &str, of: &str| {
        let body = config.split(&format!("pub struct {of} {{")).nth(1).expect(of);
        let body = body.split("\n}").next().unwrap_or_default();
        for line in body.lines() {
            if let Some((key, _)) = line.trim().strip_prefix("pub ").and_then(|line| line.split_once(':')) {
                assert!(
                    PAGE.contains(&format!("{key} = "))
                        || PAGE.contains(&format!("[plc.{key}]"))
                        || PAGE.contains(&format!("[[plc.{key}]]")),
                    "{section}{key}"
                );
            }
        }
    };
    written("plc.", "PlcConfig");
    written("plc.disk.", "DiskConfig");
    written("plc.logging.", "LoggingConfig");
    let keys = interpretation.split("readings! {").nth(1).expect("the table");
    for line in keys.lines() {
        if let Some((key, _)) = line.strip_suffix(" {").and_then(|line| line.trim().split_once(": ")) {
            assert!(PAGE.contains(&format!("\n{key} = \"")), "plc.interpretation.{key}");
        }
    }
}

/// Each kind of fault has a row.
#[test]
fn every_fault_is_documented() {
    let documented: Vec<String> = rows("Faults")
        .into_iter()
        .map(|row| row[0].trim_matches('`').to_owned())
        .collect();
    let plan = include_str!("../../src/config/faults.rs");
    let body = plan.split("pub enum FaultName {").nth(1).expect("the kinds");
    let kinds: Vec<String> = body
        .split("\n}")
        .next()
        .unwrap_or_default()
        .lines()
        .filter_map(|line| line.trim().strip_suffix(','))
        .map(|name| {
            let snake: String = name
                .chars()
                .flat_map(|letter| {
                    let begin = letter.is_uppercase().then_some('_');
                    begin.into_iter().chain(letter.to_lowercase())
                })
                .collect();
            snake.trim_start_matches('_').to_owned()
        })
        .collect();
    assert_eq!(documented, kinds);
}
