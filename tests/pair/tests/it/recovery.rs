use backseat_core::plugin::Request;
use backseat_core::{Limits, Note, PluginSetup, Recovery, Settings};
use backseat_mvc::Activity;
use backseat_pair::{Dive, Setup, course_plugin, line, limits, modify};

fn recovery(dive: &Dive) -> Vec<&str> {
    let told = |(_, note): &'_ (_, Note)| matches!(note, Note::Recovery { .. });
    let _ = told;
    dive.notes
        .iter()
        .filter_map(|(_, note)| match note {
            Note::Recovery { text } => Some(text.as_str()),
            _ => None,
        })
        .collect()
}
