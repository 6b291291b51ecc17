//! A campaign's file.

use std::path::Path;

use backseat_campaign::{CampaignFile, Plan};
use backseat_reference::Reference;
use toml::{Table, Value};

use crate::held;

fn reference() -> &'static Reference {
    Reference::of("campaign.toml").expect("it is registered")
}

/// Reads a document, with what its parts need beside them: a parameter has values of one sort, and points belong to a
/// parameter that is spread over them.
fn read(document: &Table) -> Result<String, String> {
    let mut document = document.clone();
    let has_points = document.contains_key("points");
    if has_points && !document.contains_key("parameter") {
        let spread = toml::from_str::<Table>("key = \"k\"\nfrom = 1.0\nto = 2.0\nspread = \"sobol\"");
        let spread = Value::Table(spread.expect("it is TOML"));
        document.insert("parameter".to_owned(), Value::Array(vec![spread]));
    }
    if let Some(parameter) = document
        .get_mut("parameter")
        .and_then(Value::as_array_mut)
        .and_then(|list| list.first_mut())
        && let Some(parameter) = parameter.as_table_mut()
    {
        if !parameter.contains_key("values") {
            let chosen = parameter.contains_key("steps") || parameter.contains_key("spread");
            parameter.entry("from").or_insert(Value::Integer(1));
            parameter.entry("to").or_insert(Value::Integer(1_000_000_000));
            if !chosen {
                parameter.insert("steps".to_owned(), Value::Integer(2));
            }
        }
        let spread = parameter
            .get("spread")
            .and_then(Value::as_str)
            .is_some_and(|spread| spread != "seed");
        if spread && !has_points {
            document.insert("points".to_owned(), Value::Integer(4));
        }
    }
    let text = toml::to_string(&document).expect("documents are TOML");
    let folder = std::env::temp_dir();
    let path = folder.join(format!(
        "backseat-campaign-{}-{:?}.toml",
        std::process::id(),
        std::thread::current().id()
    ));
    std::fs::write(&path, text).expect("there is room");
    let file = CampaignFile::read(&path);
    std::fs::remove_file(&path).ok();
    let file = file.map_err(|error| error.to_string())?;
    Plan::new(&file, &path, Path::new(""), &[])
        .map(|_| format!("{file:?}"))
        .map_err(|error| error.to_string())
}

#[test]
fn every_key_of_a_campaign_has_an_entry() {
    held::none(&held::keys(reference(), &read));
}

#[test]
fn examples_defaults_and_required_keys_of_campaigns_are_the_codes() {
    held::none(&held::values(reference(), &read));
}

#[test]
fn ranges_of_campaigns_are_the_codes() {
    // The lower end of a range is below its upper end.
    let elsewhere = ["parameter.from", "parameter.to", "faults.from_s", "faults.until_s"];
    held::none(&held::bounds(reference(), &elsewhere, &read));
}
