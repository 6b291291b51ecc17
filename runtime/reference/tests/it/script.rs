//! A script.

use backseat_mvc::Script;
use backseat_reference::Reference;
use toml::Table;

use crate::held;

fn reference() -> &'static Reference {
    Reference::of("script.toml").expect("it is registered")
}

fn read(document: &Table) -> Result<String, String> {
    match Script::from_toml(&toml::to_string(document).expect("documents are TOML")) {
        Ok(script) => Ok(format!("{script:?}")),
        // The code's types also have the time of a fault and transports without a name, and refuse both in a rule.
        Err(error) => Err(error
            .to_string()
            .replace("`at_s`, `kind`", "`kind`")
            .replace(", `other`", "")),
    }
}

#[test]
fn every_key_of_a_script_has_an_entry() {
    held::none(&held::keys(reference(), &read));
}

#[test]
fn examples_defaults_and_required_keys_of_scripts_are_the_codes() {
    held::none(&held::values(reference(), &read));
}

#[test]
fn ranges_of_scripts_are_the_codes() {
    held::none(&held::bounds(reference(), &[], &read));
}

#[test]
fn the_fault_of_a_rule_has_no_time() {
    let script = |time: &str| {
        let text =
            format!("[[rule]]\nwhen = \"connected\"\ndo = {{ fault = {{ {time}kind = \"stall\", for_s = 1 }} }}");
        Script::from_toml(&text).map_err(|error| error.to_string())
    };
    assert!(script("").is_ok());
    let error = script("at_s = 3, ").unwrap_err();
    assert!(error.contains("rule 1: a fault has no `at_s` here"), "{error}");
}
