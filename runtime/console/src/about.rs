use serde::Serialize;
use serde_json::Value;

/// The vehicle takes control back if no modify is refreshed within this, seconds (SPI 7.12).
const WATCHDOG_S: f64 = 5.0;

/// What the console shows, for `/api/about`.
#[derive(Clone, Debug, Serialize)]
pub struct About {
    /// Whether it goes on, and is simulated.
    pub kind: Kind,
    /// The mission's name.
    pub mission: String,
    /// The vehicle's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vehicle: Option<String>,
    /// The program's version.
    pub version: String,
    /// Differs from run to run.
    pub run: String,
    /// UTC at the start of the run, nanoseconds since 1970, as text, because JavaScript's numbers do not hold it.
    pub began_ns: String,
    /// Whether the runtime may steer; unknown of a log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub armed: Option<bool>,
    /// Whether the console can hold and release.
    pub operator: bool,
    /// From which metres count.
    pub origin: Origin,
    /// The plugins in priority order.
    pub plugins: Vec<Member>,
    /// `[limits]` of the mission.
    pub limits: Value,
    /// The vehicle takes control back if no modify is refreshed within this, seconds.
    pub watchdog_s: f64,
    /// The fence as GeoJSON.
    pub fence: Value,
}

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A vehicle is steered.
    Live,
    /// A mock vehicle is steered.
    Simulated,
    /// It is the log of a run.
    Recorded,
}

/// A position, degrees.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Origin {
    /// Latitude.
    pub lat: f64,
    /// Longitude.
    pub lon: f64,
}

/// A plugin of the mission.
#[derive(Clone, Debug, Serialize)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// What it may ask for.
    pub grants: Vec<String>,
    /// Its fuel for a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fuel_limit: Option<u64>,
    /// Its component.
    pub component: String,
}

impl About {
    /// Describes a run of a mission. `mission_toml` is the mission as the program resolved it, and `fence` its fence, both
    /// as a log has them attached. What cannot be read there is left out.
    #[must_use]
    pub fn new(kind: Kind, mission: &str, began_ns: u64, origin: Origin, mission_toml: &str, fence: &str) -> Self {
        let table: toml::Table = mission_toml.parse().unwrap_or_default();
        let text = |value: Option<&toml::Value>| value.and_then(toml::Value::as_str).map(str::to_owned);
        let plugins = table.get("plugin").and_then(toml::Value::as_array);
        let plugins = plugins.into_iter().flatten().map(|plugin| {
            let grants = plugin.get("grants").and_then(toml::Value::as_array);
            let fuel = plugin.get("budget").and_then(|budget| budget.get("fuel_per_step"));
            Member {
                name: text(plugin.get("name")).unwrap_or_default(),
                grants: grants
                    .into_iter()
                    .flatten()
                    .filter_map(|grant| text(Some(grant)))
                    .collect(),
                fuel_limit: fuel
                    .and_then(toml::Value::as_integer)
                    .and_then(|fuel| u64::try_from(fuel).ok()),
                component: text(plugin.get("component")).unwrap_or_default(),
            }
        });
        let limits = table.get("limits").and_then(|limits| serde_json::to_value(limits).ok());
        Self {
            kind,
            mission: mission.to_owned(),
            vehicle: text(table.get("vehicle").and_then(|vehicle| vehicle.get("name"))),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            run: String::new(),
            began_ns: began_ns.to_string(),
            armed: None,
            operator: false,
            origin,
            plugins: plugins.collect(),
            limits: limits.unwrap_or_default(),
            watchdog_s: WATCHDOG_S,
            fence: serde_json::from_str(fence).unwrap_or_default(),
        }
    }

    /// The plugins' names and fuel, for a [`crate::Teller`].
    pub fn budgets(&self) -> impl Iterator<Item = (String, Option<u64>)> {
        self.plugins
            .iter()
            .map(|plugin| (plugin.name.clone(), plugin.fuel_limit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_described_by_what_its_log_has_attached() {
        let mission = "[vehicle]\nname = \"v\"\n[limits]\nspeed_max_mps = 2.0\n[[plugin]]\nname = \"p\"\n\
                       component = \"c\"\ngrants = [\"modify\"]\n[plugin.budget]\nfuel_per_step = 5\n";
        let origin = Origin { lat: 42.0, lon: -70.0 };
        let about = About::new(Kind::Recorded, "m", 7, origin, mission, r#"{"features":[]}"#);
        let json = serde_json::to_value(&about).unwrap();
        assert_eq!(json["kind"], "recorded");
        assert_eq!(json["vehicle"], "v");
        assert_eq!(json["plugins"][0]["grants"][0], "modify");
        assert_eq!(json["limits"]["speed_max_mps"], 2.0);
        assert_eq!(about.budgets().next(), Some(("p".to_owned(), Some(5))));
        let about = About::new(Kind::Recorded, "m", 7, origin, "not TOML [", "no fence");
        assert!(about.plugins.is_empty() && about.fence.is_null());
    }
}
