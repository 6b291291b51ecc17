use std::collections::BTreeSet;

use backseat_campaign::{Better, Column, ColumnKind, Folder, Plan, RUNS, read_columns, read_names};

use crate::ReportError;
use crate::statistics::{Interval, pass_rate};

/// What is compared: a mission with a variant. The runs of an arm follow each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arm {
    /// Its name in the report.
    pub name: String,
    /// Its first run.
    pub first: u64,
    /// How many runs it has, the same number in all arms.
    pub runs: u64,
}

/// The results of a campaign, as the report needs them.
#[derive(Clone, Debug)]
pub struct Outcomes {
    /// The arms in their order.
    pub arms: Vec<Arm>,
    /// How many seeds each point has. Runs of one seed share their world, so seeds are what is independent.
    pub seeds: u64,
    /// For each run whether it met its expectations.
    pub passed: Vec<bool>,
    /// For each run whether it was flown.
    pub flown: Vec<bool>,
    /// For each run its violations.
    pub violations: Vec<u64>,
    /// Why runs did not pass, the most frequent reasons first, each with how often it came and one example.
    pub reasons: Vec<(u64, String)>,
    /// The measures by name: of missions, of plugins behind `published.`, and margins of safety behind `margin.`.
    pub measures: Vec<(String, Vec<Option<f64>>)>,
    /// The parameters by name, with their values.
    pub(crate) parameters: Vec<Parameter>,
    /// Which measure comes first, and which of its values are better.
    pub(crate) leading: Option<(usize, Better)>,
}

/// A parameter with its values.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    pub(crate) values: Values,
    /// Each seed has drawn one value.
    pub(crate) of_seed: bool,
    /// Its values are even in their logarithm.
    pub(crate) logarithmic: bool,
}

/// The values of a parameter.
#[derive(Clone, Debug)]
pub(crate) enum Values {
    Numbers(Vec<Option<f64>>),
    /// The place of each run's value among the texts.
    Texts(Vec<usize>, Vec<String>),
}

impl Outcomes {
    /// Reads `runs.parquet` of a results folder.
    ///
    /// # Errors
    ///
    /// [`ReportError`] if it cannot be read, or if the campaign's report asks for a measure that no run has.
    pub fn read(folder: &Folder, plan: &Plan) -> Result<Self, ReportError> {
        let path = folder.path().join(RUNS);
        let sheet = read_names(&path)?;
        let parameters: Vec<&str> = plan.parameters().collect();
        // Measures are the numbers behind the last column that every campaign has.
        let last = sheet.columns.iter().position(|(name, _)| name == "replay").unwrap_or(0);
        let measures: Vec<&str> = sheet.columns[last..]
            .iter()
            .filter(|(_, kind)| *kind == ColumnKind::Number)
            .map(|(name, _)| name.as_str())
            .collect();
        let mut names = vec!["passed", "error", "violations"];
        names.extend(&parameters);
        names.extend(&measures);
        let mut columns = read_columns(&path, &names)?.into_iter();
        let passed = match columns.next().flatten() {
            Some(Column::Boolean(values)) => values.into_iter().map(|value| value == Some(true)).collect(),
            _ => Vec::new(),
        };
        let flown = match columns.next().flatten() {
            Some(Column::Text(values)) => values.into_iter().map(|value| value.is_none()).collect(),
            _ => vec![true; passed.len()],
        };
        let violations = match columns.next().flatten() {
            Some(Column::Integer(values)) => values
                .into_iter()
                .map(|value| value.map_or(0, i64::cast_unsigned))
                .collect(),
            _ => vec![0; passed.len()],
        };
        let parameters = parameters
            .iter()
            .zip(plan.drawn_from_seeds().zip(plan.logarithmic()))
            .map(|(name, (of_seed, logarithmic))| Parameter {
                name: (*name).to_owned(),
                values: Values::of(columns.next().flatten()),
                of_seed,
                logarithmic,
            })
            .collect();
        let measures: Vec<(String, Vec<Option<f64>>)> = measures
            .iter()
            .filter_map(|name| match columns.next().flatten() {
                Some(Column::Number(values)) => Some(((*name).to_owned(), values)),
                _ => None,
            })
            .collect();
        let leading = leading(plan, &measures)?;
        Ok(Self {
            reasons: reasons(&path)?,
            arms: arms(plan),
            seeds: plan.runs_of_point(),
            passed,
            flown,
            violations,
            measures,
            parameters,
            leading,
        })
    }

    /// The places of an arm's runs.
    pub(crate) fn range(&self, arm: &Arm) -> std::ops::Range<usize> {
        let end = ((arm.first + arm.runs) as usize).min(self.passed.len());
        (arm.first as usize).min(end)..end
    }

    /// The place of a run's seed among the seeds.
    pub(crate) fn seed_of(&self, arm: &Arm, run: usize) -> usize {
        ((run as u64 - arm.first) % self.seeds.max(1)) as usize
    }

    /// How many runs of an arm passed, and how many were flown.
    #[must_use]
    pub fn passed_of(&self, arm: &Arm) -> (u64, u64) {
        let range = self.range(arm);
        let passed = self.passed[range.clone()].iter().filter(|passed| **passed).count();
        let flown = self.flown[range].iter().filter(|flown| **flown).count();
        (passed as u64, flown as u64)
    }

    /// The interval of the share of runs that pass, of those that were flown. It counts seeds: several points of a seed are
    /// no more evidence than one.
    #[must_use]
    pub fn pass_interval(&self, arm: &Arm) -> Interval {
        let (passed, flown) = self.passed_of(arm);
        let seeds: BTreeSet<usize> = self
            .range(arm)
            .filter(|run| self.flown[*run])
            .map(|run| self.seed_of(arm, run))
            .collect();
        pass_rate(passed as f64 / flown.max(1) as f64, seeds.len() as u64)
    }

    /// The values of a measure in an arm, in ascending order.
    pub(crate) fn sorted(&self, arm: &Arm, measure: usize) -> Vec<f64> {
        let mut values: Vec<f64> = self.measures[measure].1[self.range(arm)]
            .iter()
            .copied()
            .flatten()
            .collect();
        values.sort_by(f64::total_cmp);
        values
    }
}

impl Values {
    fn of(column: Option<Column>) -> Self {
        match column {
            Some(Column::Number(values)) => Self::Numbers(values),
            Some(Column::Integer(values)) => Self::Numbers(
                values
                    .into_iter()
                    .map(|value| value.map(|value| value as f64))
                    .collect(),
            ),
            Some(Column::Natural(values)) => Self::Numbers(
                values
                    .into_iter()
                    .map(|value| value.map(|value| value as f64))
                    .collect(),
            ),
            Some(Column::Boolean(values)) => Self::texts(values.into_iter().map(|value| value == Some(true))),
            Some(Column::Text(values)) => Self::texts(values.into_iter().map(Option::unwrap_or_default)),
            None => Self::Numbers(Vec::new()),
        }
    }

    fn texts(values: impl Iterator<Item = impl ToString>) -> Self {
        let mut known: Vec<String> = Vec::new();
        let places = values
            .map(|value| {
                let text = value.to_string();
                known.iter().position(|other| *other == text).unwrap_or_else(|| {
                    known.push(text);
                    known.len() - 1
                })
            })
            .collect();
        Self::Texts(places, known)
    }
}

/// The most frequent reasons for which runs did not pass. Reasons that differ in their figures alone are one.
fn reasons(path: &std::path::Path) -> Result<Vec<(u64, String)>, ReportError> {
    const SHOWN: usize = 3;
    let mut counts = std::collections::BTreeMap::<String, (u64, String)>::new();
    for column in read_columns(path, &["error", "unmet"])? {
        let Some(Column::Text(texts)) = column else { continue };
        for reason in texts.iter().flatten().flat_map(|text| text.split("; ")) {
            let kind: String = reason.chars().filter(|character| !character.is_ascii_digit()).collect();
            counts.entry(kind).or_insert_with(|| (0, reason.to_owned())).0 += 1;
        }
    }
    let mut sorted: Vec<(u64, String)> = counts.into_values().collect();
    sorted.sort_by(|one, other| other.0.cmp(&one.0).then_with(|| one.1.cmp(&other.1)));
    sorted.truncate(SHOWN);
    Ok(sorted)
}

fn leading(plan: &Plan, measures: &[(String, Vec<Option<f64>>)]) -> Result<Option<(usize, Better)>, ReportError> {
    match plan.measure() {
        Some((name, better)) => match measures.iter().position(|(measure, _)| measure == name) {
            Some(place) => Ok(Some((place, better))),
            // No run may have reached what it measures.
            None if measures.is_empty() => Ok(None),
            None => Err(ReportError::Measure {
                measure: name.to_owned(),
                known: measures
                    .iter()
                    .map(|(name, _)| name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
            }),
        },
        None => Ok(measures
            .iter()
            .position(|(name, _)| !name.starts_with("margin."))
            .map(|place| (place, Better::Less))),
    }
}

fn arms(plan: &Plan) -> Vec<Arm> {
    let runs = plan.points() * plan.runs_of_point();
    let count = plan.runs().checked_div(runs).unwrap_or(0);
    let short = |key: &backseat_campaign::Key| {
        let name = plan.mission(key).file_name();
        name.map_or_else(
            || plan.mission(key).display().to_string(),
            |name| name.to_string_lossy().into_owned(),
        )
    };
    let keys = || (0..count).filter_map(|arm| plan.key(arm * runs));
    let names: std::collections::BTreeSet<String> = keys().map(|key| short(&key)).collect();
    // Missions in folders of the same name need their whole paths.
    let unique = names.len() == plan.missions();
    (0..count)
        .filter_map(|arm| {
            let key = plan.key(arm * runs)?;
            let mission = if unique {
                short(&key)
            } else {
                plan.mission(&key).display().to_string()
            };
            let variant = plan.variant(&key);
            let name = match (plan.missions(), variant) {
                (_, "") => mission,
                (1, variant) => variant.to_owned(),
                (_, variant) => format!("{mission}, {variant}"),
            };
            Some(Arm {
                name,
                first: arm * runs,
                runs,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten seeds at three points. The second point could not be flown.
    #[test]
    fn the_interval_counts_the_seeds_that_were_flown() {
        let arm = Arm {
            name: "a".to_owned(),
            first: 0,
            runs: 30,
        };
        let outcomes = |flown: Vec<bool>| Outcomes {
            arms: vec![arm.clone()],
            seeds: 10,
            passed: flown.clone(),
            flown,
            violations: vec![0; 30],
            reasons: Vec::new(),
            measures: Vec::new(),
            parameters: Vec::new(),
            leading: None,
        };
        let of_seeds = |count| pass_rate(1.0, count).low;
        let low = |flown| outcomes(flown).pass_interval(&arm).low;
        assert_eq!(low(vec![true; 30]), of_seeds(10));
        assert_eq!(low((0..30).map(|run| !(10..20).contains(&run)).collect()), of_seeds(10));
        assert_eq!(low((0..30).map(|run| run % 10 < 4).collect()), of_seeds(4));
    }
}
