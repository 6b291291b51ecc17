//! A file of faults.

use backseat_mvc::FaultPlan;
use backseat_reference::Reference;
use toml::Table;

use crate::held;

fn reference() -> &'static Reference {
    Reference::of("faults.toml").expect("it is registered")
}

fn read(document: &Table) -> Result<String, String> {
    match FaultPlan::from_toml(&toml::to_string(document).expect("documents are TOML")) {
        Ok(plan) => Ok(format!("{plan:?}")),
        Err(error) => Err(error.to_string()),
    }
}

#[test]
fn every_key_of_a_file_of_faults_has_an_entry() {
    held::none(&held::keys(reference(), &read));
}

#[test]
fn examples_defaults_and_required_keys_of_faults_are_the_codes() {
    held::none(&held::values(reference(), &read));
}

#[test]
fn ranges_of_faults_are_the_codes() {
    held::none(&held::bounds(reference(), &[], &read));
}

#[test]
fn each_kind_of_fault_takes_its_own_keys_alone() {
    held::none(&held::company(reference(), &read));
}
