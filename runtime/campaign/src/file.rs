use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::{Spanned, Table, Value as Toml};

use crate::design::{Ends, Parameter, Source, Value};
use crate::error::CampaignError;
use crate::faults::DrawnFaults;
use crate::seeds::Seeds;

/// The most values of a range with steps.
const STEPS_MAX: u32 = 10_000;

/// A campaign's file as it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CampaignFile {
    /// The missions' folders, relative to this file.
    pub missions: Vec<PathBuf>,
    /// The seeds: `"1..1000"`, both ends count.
    pub seeds: Seeds,
    /// How many points the parameters with `spread` are spread over.
    #[serde(default)]
    pub points: Option<u64>,
    /// Keys that are set in every run.
    #[serde(default)]
    pub set: Table,
    /// What is compared: each variant is flown with every mission, point and seed.
    #[serde(default, rename = "variant")]
    pub(crate) variants: Vec<VariantTable>,
    /// What differs from point to point.
    #[serde(default, rename = "parameter")]
    pub(crate) parameters: Vec<Spanned<ParameterTable>>,
    /// Faults that the seed draws, instead of the `[faults]` of the world.
    #[serde(default)]
    pub faults: Option<DrawnFaults>,
    /// What the report shows first.
    #[serde(default)]
    pub report: ReportTable,
}

/// A variant: a name for the results, and the keys that it sets.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct VariantTable {
    /// Its name in the results.
    pub name: String,
    /// The keys that it sets, such as `"plugin.isobath.component" = "isobath-old"`.
    #[serde(default)]
    pub set: Table,
}

/// A parameter as it is written.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterTable {
    /// A key of `mission.toml`, or of `world.toml` behind `world.`.
    pub key: String,
    /// Its values.
    #[serde(default)]
    pub values: Option<Vec<Toml>>,
    /// The first end of a range.
    #[serde(default)]
    pub from: Option<Toml>,
    /// The other end.
    #[serde(default)]
    pub to: Option<Toml>,
    /// How many values from one end to the other.
    #[serde(default)]
    pub steps: Option<u32>,
    /// How values are spread over the range instead.
    #[serde(default)]
    pub spread: Option<Spread>,
    /// Whether the values are whole numbers.
    #[serde(default)]
    pub whole: bool,
    /// Whether the values are even in their logarithm.
    #[serde(default)]
    pub logarithmic: bool,
}

/// How the values of a parameter are spread over its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Spread {
    /// A Latin hypercube over the campaign's points.
    LatinHypercube,
    /// An Owen-scrambled Sobol sequence over the campaign's points.
    Sobol,
    /// A value for each seed, drawn from the seed and the key.
    Seed,
}

/// What the report shows first.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReportTable {
    /// The measure by which runs are compared and the worst ones are chosen.
    #[serde(default)]
    pub measure: Option<String>,
    /// Which of its values are better.
    #[serde(default)]
    pub better: Better,
}

/// Which values of a measure are better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Better {
    /// The smaller ones.
    #[default]
    Less,
    /// The larger ones.
    More,
}

impl CampaignFile {
    /// A campaign of one mission.
    #[must_use]
    pub fn of_mission(mission: PathBuf, seeds: Seeds) -> Self {
        Self {
            missions: vec![mission],
            seeds,
            points: None,
            set: Table::new(),
            variants: Vec::new(),
            parameters: Vec::new(),
            faults: None,
            report: ReportTable::default(),
        }
    }

    /// Reads a campaign's file.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] with the file, and the line or the key.
    pub fn read(path: &Path) -> Result<Self, CampaignError> {
        let text = std::fs::read_to_string(path).map_err(|source| CampaignError::file(path, source))?;
        let file: Self = toml::from_str(&text).map_err(|error| CampaignError::Toml {
            path: path.to_path_buf(),
            line: error.span().map_or(1, |span| line_of(&text, span.start)),
            message: backseat_mission::with_suggestion(&error.message().replace('\n', " ")),
        })?;
        file.check(path)?;
        // What is wrong with a parameter is said with its line.
        for parameter in &file.parameters {
            parameter.get_ref().resolve().map_err(|message| CampaignError::Toml {
                path: path.to_path_buf(),
                line: line_of(&text, parameter.span().start),
                message,
            })?;
        }
        Ok(file)
    }

    /// What differs from point to point.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = &ParameterTable> {
        self.parameters.iter().map(Spanned::get_ref)
    }

    fn check(&self, path: &Path) -> Result<(), CampaignError> {
        let fault = |message: String| Err(CampaignError::value(path, message));
        if self.missions.is_empty() {
            return fault("missions is empty: expected at least one mission's folder".to_owned());
        }
        let mut missions = BTreeSet::new();
        // Components tell `a/b`, `./a/b` and `a/b/` to be the same.
        let normal = |mission: &Path| -> PathBuf {
            let parts = mission.components();
            parts.filter(|part| *part != std::path::Component::CurDir).collect()
        };
        if let Some(mission) = self.missions.iter().find(|mission| !missions.insert(normal(mission))) {
            return fault(format!("missions has {} twice", mission.display()));
        }
        let mut names = BTreeSet::new();
        for variant in &self.variants {
            let plain = variant.name.trim() == variant.name && !variant.name.chars().any(char::is_control);
            if variant.name.is_empty() || !plain || !names.insert(&variant.name) {
                return fault(format!(
                    "variant `{}`: expected a name that is not empty, has no blanks around it, and is not used twice",
                    variant.name.escape_debug()
                ));
            }
        }
        let mut keys: Vec<&str> = Vec::new();
        let sets = self.variants.iter().map(|variant| &variant.set).chain([&self.set]);
        let set_keys: Vec<String> = sets.flat_map(flat).map(|(key, _)| key).collect();
        let given = self.parameters().map(|parameter| parameter.key.as_str());
        if let Some(key) = given
            .chain(set_keys.iter().map(String::as_str))
            .find(|key| !is_key(key))
        {
            return fault(format!(
                "key `{key}`: expected a key such as limits.speed_max_mps or world.plan.1.timeout_s"
            ));
        }
        for parameter in self.parameters() {
            if let Some(other) = keys.iter().find(|other| overlap(other, &parameter.key)) {
                return fault(format!(
                    "parameter `{}` sets what parameter `{other}` sets",
                    parameter.key
                ));
            }
            keys.push(&parameter.key);
        }
        for (key, _) in flat(&self.set) {
            if let Some(other) = keys.iter().find(|other| overlap(other, &key)) {
                return fault(format!("set has `{key}`, and `{other}` is a parameter"));
            }
        }
        for (within, key) in self.variants.iter().flat_map(|variant| {
            flat(&variant.set)
                .into_iter()
                .map(move |(key, _)| (variant.name.as_str(), key))
        }) {
            if let Some(other) = keys.iter().find(|other| overlap(other, &key)) {
                return fault(format!("variant `{within}` sets `{key}`, and `{other}` is a parameter"));
            }
        }
        if let Some(faults) = &self.faults {
            faults
                .validate()
                .map_err(|message| CampaignError::value(path, message))?;
        }
        Ok(())
    }
}

impl ParameterTable {
    /// # Errors
    ///
    /// In words, with the key.
    pub(crate) fn resolve(&self) -> Result<Parameter, String> {
        let key = self.key.clone();
        let fault = |message: &str| format!("parameter `{key}`: {message}");
        let source = match (&self.values, &self.from, &self.to) {
            (Some(values), None, None) if self.stands_alone() => {
                if values.is_empty() {
                    return Err(fault("values is empty: expected at least one value"));
                }
                if let Some((place, value)) = values
                    .iter()
                    .enumerate()
                    .find(|(place, value)| values[..*place].contains(value))
                {
                    return Err(fault(&format!(
                        "value {} of values, {value}, is there twice",
                        place + 1
                    )));
                }
                Source::Listed(values.iter().map(Value::of).collect())
            }
            (None, Some(from), Some(to)) => {
                let ends = self.ends(from, to).map_err(|message| fault(&message))?;
                match (self.steps, self.spread) {
                    (Some(steps), None) if (2..=STEPS_MAX).contains(&steps) => {
                        if let Some(most) = ends.count().filter(|most| *most < u64::from(steps)) {
                            return Err(fault(&format!(
                                "steps is {steps}, but the range has only {most} whole numbers"
                            )));
                        }
                        Source::Listed(ends.steps(steps))
                    }
                    (Some(steps), None) => {
                        return Err(fault(&format!("steps is {steps}: expected 2 to {STEPS_MAX}")));
                    }
                    (None, Some(Spread::LatinHypercube)) => Source::Latin(ends),
                    (None, Some(Spread::Sobol)) => Source::Sobol(ends),
                    (None, Some(Spread::Seed)) => Source::Seed(ends),
                    (Some(_), Some(_)) | (None, None) => {
                        return Err(fault(
                            "expected either steps = N, or spread = \"latin-hypercube\", \"sobol\" or \"seed\"",
                        ));
                    }
                }
            }
            _ => {
                return Err(fault(
                    "expected either values = [...], or from and to with steps or spread",
                ));
            }
        };
        Ok(Parameter {
            key,
            logarithmic: self.logarithmic,
            source,
        })
    }

    /// Whether nothing is said of a range.
    fn stands_alone(&self) -> bool {
        self.steps.is_none() && self.spread.is_none() && !self.logarithmic && !self.whole
    }

    fn ends(&self, from: &Toml, to: &Toml) -> Result<Ends, String> {
        ends(from, to, self.whole, self.logarithmic)
    }
}

fn ends(from: &Toml, to: &Toml, whole: bool, logarithmic: bool) -> Result<Ends, String> {
    let number = |value: &Toml| match value {
        Toml::Integer(value) => Some(*value as f64),
        Toml::Float(value) => value.is_finite().then_some(*value),
        Toml::String(_) | Toml::Boolean(_) | Toml::Datetime(_) | Toml::Array(_) | Toml::Table(_) => None,
    };
    let (Some(low), Some(high)) = (number(from), number(to)) else {
        return Err("from and to: expected two finite numbers".to_owned());
    };
    if low >= high {
        return Err(format!("from is {low} and to is {high}: expected from below to"));
    }
    match (from, to) {
        _ if whole && logarithmic => Err("expected either whole = true or logarithmic = true".to_owned()),
        (Toml::Integer(from), Toml::Integer(to)) if whole => Ok(Ends::Integers(*from, *to)),
        _ if whole => Err(format!(
            "from is {low} and to is {high}: expected whole numbers, because of whole = true"
        )),
        _ if logarithmic && low <= 0.0 => Err(format!("from is {low}: a logarithmic range begins above 0")),
        _ if logarithmic => Ok(Ends::Logarithmic(low, high)),
        _ => Ok(Ends::Numbers(low, high)),
    }
}

/// Whether a key is written as keys are: names between points, without blanks, and places of lists without a zero in front,
/// so that no two keys are the same.
fn is_key(key: &str) -> bool {
    key.split('.').all(|part| {
        let number = part.bytes().all(|byte| byte.is_ascii_digit());
        !part.is_empty() && part.trim() == part && !(number && part.len() > 1 && part.starts_with('0'))
    })
}

/// The line of a place in a text, from 1.
fn line_of(text: &str, place: usize) -> usize {
    text[..place].matches('\n').count() + 1
}

/// Whether two keys set the same: they are equal, or one is a table that the other is in.
pub(crate) fn overlap(one: &str, other: &str) -> bool {
    let (short, long) = if one.len() < other.len() {
        (one, other)
    } else {
        (other, one)
    };
    long.strip_prefix(short)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The keys of a table joined by dots, with their values: `{a.b = 1}` and `{"a.b" = 1}` are the same.
pub(crate) fn flat(table: &Table) -> Vec<(String, Toml)> {
    let mut all = Vec::new();
    for (key, value) in table {
        if let Some(inner) = value.as_table().filter(|inner| !inner.is_empty()) {
            let inner = flat(inner).into_iter();
            all.extend(inner.map(|(name, value)| (format!("{key}.{name}"), value)));
        } else {
            all.push((key.clone(), value.clone()));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<CampaignFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("campaign.toml");
        std::fs::write(&path, text).unwrap();
        CampaignFile::read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn a_campaign_has_missions_seeds_variants_and_parameters() {
        let file = read(
            "missions = [\"../isobath\"]\nseeds = \"1..1000\"\npoints = 16\n[set]\nlimits.speed_max_mps = 1.8\n\
             [[variant]]\nname = \"old\"\nset = { \"plugin.isobath.component\" = \"isobath-old\" }\n\
             [[variant]]\nname = \"new\"\n\
             [[parameter]]\nkey = \"world.current.speed_mps\"\nvalues = [0.0, [0.1, 0.2]]\n\
             [[parameter]]\nkey = \"plugin.isobath.config.speed_mps\"\nfrom = 1.0\nto = 2.0\nspread = \"sobol\"\n\
             [faults]\ncount = [3, 9]\nfrom_s = 30\nuntil_s = 800\n[report]\nmeasure = \"contour_rms_m\"\n",
        )
        .unwrap();
        assert_eq!(file.seeds.count(), 1000);
        assert_eq!(flat(&file.set)[0].0, "limits.speed_max_mps");
        assert_eq!(flat(&file.variants[0].set)[0].0, "plugin.isobath.component");
        let parameter = file.parameters().next().unwrap().resolve().unwrap();
        let Source::Listed(values) = parameter.source else {
            panic!("{parameter:?}")
        };
        assert_eq!(values[1].to_string(), "[0.1, 0.2]");
        assert_eq!(
            file.parameters().nth(1).unwrap().resolve().unwrap().source,
            Source::Sobol(Ends::Numbers(1.0, 2.0))
        );
    }

    #[test]
    fn what_is_wrong_is_said_in_a_line() {
        let head = "missions = [\"m\"]\nseeds = \"1..3\"\n";
        for (text, expected) in [
            (
                "missions = [\"m\"]\nseedz = \"1..3\"\n",
                "campaign.toml:2: unknown field `seedz`",
            ),
            ("missions = []\nseeds = \"1\"\n", "missions is empty"),
            (
                "missions = [\"m\"]\nseeds = \"3..1\"\n",
                "campaign.toml:2: `3..1`: the range is empty",
            ),
            (
                &format!("{head}[[variant]]\nname = \"a\"\n[[variant]]\nname = \"a\"\n"),
                "variant `a`: expected a name that is not empty",
            ),
            (
                &format!(
                    "{head}[[variant]]\nname = \"a\"\nset = {{ k.x = 1 }}\n[[parameter]]\nkey = \"k.x\"\nvalues = [1]\n"
                ),
                "variant `a` sets `k.x`, and `k.x` is a parameter",
            ),
            (
                &format!("{head}\n[[parameter]]\nkey = \"k.x\"\nvalues = []\n"),
                "campaign.toml:4: parameter `k.x`: values is empty",
            ),
            (
                &format!("{head}[[parameter]]\nkey = \" k.x\"\nvalues = [1]\n"),
                "key ` k.x`: expected a key such as",
            ),
            (
                &format!("{head}[[parameter]]\nkey = \"world.plan.01.x\"\nvalues = [1]\n"),
                "key `world.plan.01.x`: expected a key such as",
            ),
            (
                &format!("{head}[[variant]]\nname = \" \"\n"),
                "variant ` `: expected a name",
            ),
            (
                "missions = [\"m\", \"./m/\"]\nseeds = \"1..3\"\n",
                "missions has ./m/ twice",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn a_parameter_is_a_list_or_a_range() {
        let resolve = |text: &str| {
            let table: ParameterTable = toml::from_str(&format!("key = \"k\"\n{text}")).unwrap();
            table.resolve().map(|parameter| parameter.source)
        };
        assert_eq!(
            resolve("from = 1\nto = 3\nspread = \"seed\"\nwhole = true"),
            Ok(Source::Seed(Ends::Integers(1, 3)))
        );
        for (text, expected) in [
            ("values = []", "values is empty"),
            ("values = [1, 2, 1]", "value 3 of values, 1, is there twice"),
            ("from = 1\nto = 1\nsteps = 3", "expected from below to"),
            ("from = 1\nto = 2", "expected either steps = N"),
            ("from = 1\nto = 2\nsteps = 1", "steps is 1: expected 2 to 10000"),
            ("from = \"a\"\nto = 2\nsteps = 2", "two finite numbers"),
            ("from = 0.0\nto = 2.0\nsteps = 2\nlogarithmic = true", "begins above 0"),
            ("values = [1]\nfrom = 2", "expected either values"),
            ("from = 0\nto = 1\nsteps = 5\nwhole = true", "only 2 whole numbers"),
            ("from = 0.5\nto = 1\nsteps = 2\nwhole = true", "expected whole numbers"),
            ("", "expected either values"),
        ] {
            let error = resolve(text).unwrap_err();
            assert!(
                error.starts_with("parameter `k`: ") && error.contains(expected),
                "{error}"
            );
        }
    }
}
