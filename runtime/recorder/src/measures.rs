//! The channels of what plugins publish: one for each name of a plugin, `/measures/PLUGIN/NAME`.

use std::collections::BTreeMap;

use backseat_core::plugin::{Measure, PluginId};
use serde::Serialize;
use serde_json::Value;

use crate::header::Header;
use crate::schema::Fields;

/// The channels that there are. The plugin host bounds the names of a plugin.
#[derive(Debug)]
pub(crate) struct Measures {
    /// The plugins' names in priority order.
    plugins: Vec<String>,
    /// MCAP identifiers of the channels, by plugin and name.
    ids: BTreeMap<(usize, String), u16>,
}

/// A published value.
#[derive(Serialize)]
pub(crate) struct MeasureRow<'a> {
    value: f64,
    unit: &'a str,
}

impl<'a> From<&'a Measure> for MeasureRow<'a> {
    fn from(measure: &'a Measure) -> Self {
        Self {
            value: measure.value,
            unit: &measure.unit,
        }
    }
}

/// The name of the schema of every such channel.
pub(crate) const SCHEMA: &str = "backseat.Measure";

/// The schema of every such channel.
pub(crate) fn schema() -> Value {
    Fields::new()
        .number("value", "In the unit.")
        .text("unit", "As the plugin gave it; may be empty.")
        .into_message("A value that a plugin published.", &["value", "unit"])
}

/// The topic of a name.
pub(crate) fn topic(plugins: &[String], plugin: PluginId, name: &str) -> String {
    match plugins.get(plugin.0) {
        Some(plugin) => format!("/measures/{plugin}/{name}"),
        None => format!("/measures/{}/{name}", plugin.0),
    }
}

impl Measures {
    pub(crate) fn new(header: &Header<'_>) -> Self {
        Self {
            plugins: header.components.iter().map(|(name, _)| name.clone()).collect(),
            ids: BTreeMap::new(),
        }
    }

    /// Forgets the channels, because another file begins.
    pub(crate) fn forget_channels(&mut self) {
        self.ids.clear();
    }

    /// The channel of a name, which `add` makes if there is none: it takes the topic and the text of the schema.
    pub(crate) fn channel<E>(
        &mut self,
        plugin: PluginId,
        name: &str,
        add: impl FnOnce(&str, &str) -> Result<u16, E>,
    ) -> Result<u16, E> {
        let key = (plugin.0, name.to_owned());
        if let Some(id) = self.ids.get(&key) {
            return Ok(*id);
        }
        let topic = topic(&self.plugins, plugin, name);
        let id = add(&topic, &schema().to_string())?;
        self.ids.insert(key, id);
        Ok(id)
    }
}
