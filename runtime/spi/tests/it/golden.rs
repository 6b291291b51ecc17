use std::collections::BTreeMap;

use backseat_spi::{Sentence, catalogue};

use crate::Message;

/// A line for each message: the sentence as its section of the specification writes it, a tab, and its values.
const GOLDEN: &str = include_str!("golden.txt");

#[test]
fn every_message_has_the_values_that_its_section_says() {
    let rows: BTreeMap<&str, (&str, &str)> = GOLDEN
        .lines()
        .map(|line| {
            let (sentence, values) = line.split_once('\t').unwrap();
            (&sentence[1..6], (sentence, values))
        })
        .collect();
    assert_eq!(rows.len(), catalogue().len());
    for entry in catalogue() {
        let (line, values) = rows[entry.name];
        assert_eq!(line, entry.example);
        let message = Message::example(entry);
        assert_eq!(message.to_json(), values, "{line}");
        assert_eq!(
            Message::from_json(entry.direction, entry.name, values).unwrap(),
            message
        );
    }
}

#[test]
fn serialised_values_have_the_names_of_the_catalogue() {
    for entry in catalogue() {
        let values: serde_json::Value = serde_json::from_str(&Message::example(entry).to_json()).unwrap();
        for field in entry.fields {
            assert!(values.get(field.name).is_some(), "{} has no {}", entry.name, field.name);
        }
        assert_eq!(values.as_object().unwrap().len(), entry.fields.len(), "{}", entry.name);
    }
}

#[test]
fn incomplete_serialised_messages_are_refused() {
    for entry in catalogue() {
        let read = |name: &str, json: &str| Message::from_json(entry.direction, name, json);
        let whole = Message::example(entry).to_json();
        assert!(read(entry.name, &whole).is_ok());
        let mut more: serde_json::Value = serde_json::from_str(&whole).unwrap();
        more["depht_m"] = 1.into();
        assert!(read(entry.name, &more.to_string()).is_err(), "{more}");
        assert!(read(entry.name, "{}").is_err(), "{}", entry.name);
        assert!(
            read("BFXYZ", &whole)
                .unwrap_err()
                .to_string()
                .contains("\"BFXYZ\" is not a message")
        );
    }
}

#[test]
fn an_unknown_message_is_serialised_with_its_name_and_fields() {
    let sentence = Sentence::parse("$BFXYZ,1,,two words*00").unwrap();
    let message = backseat_spi::FromVehicle::decode(&sentence).unwrap();
    let json = serde_json::to_string(&message).unwrap();
    assert_eq!(json, r#"{"name":"BFXYZ","fields":["1","","two words"]}"#);
}
