//! The points of a campaign: which value each parameter has in which run.

use std::fmt;

use backseat_units::math::{exp, ln};
use backseat_world::Stream;
use sobol_burley::sample;
use toml::Value as Toml;

/// The seed from which designs are drawn: a campaign's points do not depend on its seeds.
const DESIGN_SEED: u64 = 0;
/// The most dimensions that the Sobol sequence has.
const SOBOL_MAX: usize = sobol_burley::NUM_DIMENSIONS as usize;
/// The most points of a design.
pub(crate) const POINTS_MAX: u64 = 1 << 16;

/// The value of a parameter in a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// True or false.
    Boolean(bool),
    /// A text, or anything else as TOML.
    Text(String),
}

impl Value {
    pub(crate) fn of(value: &Toml) -> Self {
        match value {
            Toml::Integer(value) => Self::Integer(*value),
            Toml::Float(value) => Self::Number(*value),
            Toml::Boolean(value) => Self::Boolean(*value),
            Toml::String(value) => Self::Text(value.clone()),
            other @ (Toml::Datetime(_) | Toml::Array(_) | Toml::Table(_)) => Self::Text(other.to_string()),
        }
    }
}

impl fmt::Display for Value {
    /// As in `--set KEY=VALUE`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            // With a point, so that it stays a number with one for TOML.
            Self::Number(value) => write!(f, "{value:?}"),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Text(value) => f.write_str(value),
        }
    }
}

/// The ends of a range, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ends {
    /// Whole numbers.
    Integers(i64, i64),
    /// Any numbers.
    Numbers(f64, f64),
    /// Any positive numbers, even in their logarithm.
    Logarithmic(f64, f64),
}

impl Ends {
    /// The value at a share of the range, from 0 to 1.
    fn at(self, share: f64) -> Value {
        match self {
            Self::Integers(from, to) => {
                let count = to.abs_diff(from).saturating_add(1) as f64;
                let steps = (share * count).min(count - 1.0) as u64;
                Value::Integer(from.saturating_add_unsigned(steps))
            }
            Self::Numbers(from, to) => Value::Number(short(from + (to - from) * share).clamp(from, to)),
            Self::Logarithmic(from, to) => {
                Value::Number(short(exp(ln(from) + (ln(to) - ln(from)) * share)).clamp(from, to))
            }
        }
    }

    /// How many values there are, if they are whole numbers.
    pub(crate) fn count(self) -> Option<u64> {
        match self {
            Self::Integers(from, to) => Some(to.abs_diff(from).saturating_add(1)),
            Self::Numbers(..) | Self::Logarithmic(..) => None,
        }
    }

    /// `steps` values from one end to the other.
    pub(crate) fn steps(self, steps: u32) -> Vec<Value> {
        let last = f64::from(steps.saturating_sub(1)).max(1.0);
        (0..steps)
            .map(|step| match self {
                Self::Integers(from, to) => {
                    let whole = u64::from(step) as f64 * to.abs_diff(from) as f64 / last;
                    Value::Integer(from.saturating_add_unsigned(whole.round() as u64))
                }
                Self::Numbers(..) | Self::Logarithmic(..) => match (step, self) {
                    // The ends exactly.
                    (0, Self::Numbers(from, _) | Self::Logarithmic(from, _)) => Value::Number(from),
                    (step, Self::Numbers(_, to) | Self::Logarithmic(_, to)) if step + 1 == steps => Value::Number(to),
                    _ => self.at(f64::from(step) / last),
                },
            })
            .collect()
    }
}

/// A number with six significant digits, so that people can read the command that flies a run alone.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// How a parameter gets its values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// Each of these, with each value of every other parameter.
    Listed(Vec<Value>),
    /// A Latin hypercube over the points.
    Latin(Ends),
    /// A Sobol sequence over the points.
    Sobol(Ends),
    /// Drawn from the run's seed and the parameter's name.
    Seed(Ends),
}

/// A parameter of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Parameter {
    pub(crate) key: String,
    /// Whether a range is even in its logarithm.
    pub(crate) logarithmic: bool,
    pub(crate) source: Source,
}

/// All parameters, with their points in one order: those of the design within those of the lists, and the last list
/// changes fastest.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    parameters: Vec<Parameter>,
    /// For each parameter with a Latin hypercube its shares by point, otherwise none.
    latin: Vec<Vec<f64>>,
    /// The points of the Latin hypercube and of the Sobol sequence; 1 without these.
    points: u64,
    /// The product of the lists' lengths.
    listed: u64,
}

impl Design {
    /// # Errors
    ///
    /// In words, if there are too many points or parameters.
    pub(crate) fn new(parameters: Vec<Parameter>, points: Option<u64>) -> Result<Self, String> {
        let spread = |parameter: &Parameter| matches!(parameter.source, Source::Latin(_) | Source::Sobol(_));
        let points = match (parameters.iter().find(|parameter| spread(parameter)), points) {
            (Some(_), Some(points)) if (1..=POINTS_MAX).contains(&points) => points,
            (Some(_), Some(points)) => return Err(format!("points is {points}: expected 1 to {POINTS_MAX}")),
            (Some(parameter), None) => {
                return Err(format!(
                    "parameter `{}` is spread over points: expected `points = N` beside `seeds`",
                    parameter.key
                ));
            }
            (None, Some(_)) => {
                return Err("points is set, but no parameter is spread over points: \
                            expected one with spread = \"latin-hypercube\" or \"sobol\""
                    .to_owned());
            }
            (None, None) => 1,
        };
        let sobol = parameters
            .iter()
            .filter(|parameter| matches!(parameter.source, Source::Sobol(_)));
        if sobol.count() > SOBOL_MAX {
            return Err(format!("more than {SOBOL_MAX} parameters with spread = \"sobol\""));
        }
        let mut listed = 1u64;
        for parameter in &parameters {
            if let Source::Listed(values) = &parameter.source {
                listed = listed
                    .checked_mul(values.len() as u64)
                    .ok_or("the lists have too many combinations")?;
            }
        }
        let latin = parameters
            .iter()
            .map(|parameter| match parameter.source {
                Source::Latin(_) => latin_shares(&parameter.key, points),
                Source::Listed(_) | Source::Sobol(_) | Source::Seed(_) => Vec::new(),
            })
            .collect();
        Ok(Self {
            parameters,
            latin,
            points,
            listed,
        })
    }

    /// How many points there are.
    ///
    /// # Errors
    ///
    /// In words, if there are too many.
    pub(crate) fn count(&self) -> Result<u64, String> {
        self.listed
            .checked_mul(self.points)
            .ok_or_else(|| "the parameters have too many points".to_owned())
    }

    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|parameter| parameter.key.as_str())
    }

    /// For each parameter whether its value depends on the seed.
    pub(crate) fn drawn_from_seeds(&self) -> impl Iterator<Item = bool> {
        self.parameters
            .iter()
            .map(|parameter| matches!(parameter.source, Source::Seed(_)))
    }

    /// For each parameter whether its range is even in its logarithm.
    pub(crate) fn logarithmic(&self) -> impl Iterator<Item = bool> {
        self.parameters.iter().map(|parameter| parameter.logarithmic)
    }

    /// For each parameter in words which values it has.
    pub(crate) fn ranges(&self) -> impl Iterator<Item = String> {
        const SHOWN: usize = 12;
        self.parameters.iter().map(|parameter| {
            let (ends, spread) = match &parameter.source {
                Source::Listed(values) => {
                    let shown: Vec<String> = values.iter().take(SHOWN).map(ToString::to_string).collect();
                    let more = if values.len() > SHOWN { ", ..." } else { "" };
                    return format!("{}{more}", shown.join(", "));
                }
                Source::Latin(ends) => (ends, "Latin hypercube"),
                Source::Sobol(ends) => (ends, "Sobol sequence"),
                Source::Seed(ends) => (ends, "drawn by each seed"),
            };
            match ends {
                Ends::Integers(from, to) => format!("{from} to {to}, whole, {spread}"),
                Ends::Numbers(from, to) => format!("{from} to {to}, {spread}"),
                Ends::Logarithmic(from, to) => format!("{from} to {to}, even in the logarithm, {spread}"),
            }
        })
    }

    /// Values of a parameter of every type that it has: all of a list, one of a range.
    pub(crate) fn samples(&self, place: usize, seed: u64) -> Vec<Value> {
        match &self.parameters[place].source {
            Source::Listed(values) => values.clone(),
            Source::Latin(_) | Source::Sobol(_) | Source::Seed(_) => vec![self.values(0, seed)[place].clone()],
        }
    }

    /// The value of each parameter, in their order, at a point and for a seed.
    pub(crate) fn values(&self, point: u64, seed: u64) -> Vec<Value> {
        let (mut listed, spread) = (point / self.points, point % self.points);
        // The last list changes fastest.
        let mut choices = vec![0; self.parameters.len()];
        for (choice, parameter) in choices.iter_mut().zip(&self.parameters).rev() {
            if let Source::Listed(values) = &parameter.source {
                *choice = (listed % values.len() as u64) as usize;
                listed /= values.len() as u64;
            }
        }
        let mut dimension = 0;
        self.parameters
            .iter()
            .enumerate()
            .map(|(place, parameter)| match &parameter.source {
                Source::Listed(values) => values[choices[place]].clone(),
                Source::Latin(ends) => ends.at(self.latin[place][spread as usize]),
                Source::Sobol(ends) => {
                    let share = sample(spread as u32, dimension, DESIGN_SEED as u32);
                    dimension += 1;
                    ends.at(f64::from(share))
                }
                Source::Seed(ends) => ends.at(Stream::new(seed, &format!("parameter {}", parameter.key)).uniform()),
            })
            .collect()
    }
}

/// For each point a share of its own of the range: the range is cut into as many parts as there are points, and each
/// part has one of them, at a random place in it (McKay, Beckman and Conover, Technometrics 21(2), 1979).
fn latin_shares(key: &str, points: u64) -> Vec<f64> {
    let mut stream = Stream::new(DESIGN_SEED, &format!("latin hypercube {key}"));
    let mut parts: Vec<u64> = (0..points).collect();
    for last in (1..parts.len()).rev() {
        let other = (stream.uniform() * (last + 1) as f64) as usize;
        parts.swap(last, other.min(last));
    }
    parts
        .into_iter()
        .map(|part| (part as f64 + stream.uniform()) / points as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(key: &str, values: &[i64]) -> Parameter {
        Parameter {
            key: key.to_owned(),
            logarithmic: false,
            source: Source::Listed(values.iter().copied().map(Value::Integer).collect()),
        }
    }

    fn numbers(values: &[Value]) -> Vec<f64> {
        values
            .iter()
            .map(|value| match value {
                Value::Number(value) => *value,
                Value::Integer(value) => *value as f64,
                Value::Boolean(_) | Value::Text(_) => f64::NAN,
            })
            .collect()
    }

    #[test]
    fn lists_are_combined_and_the_last_changes_fastest() {
        let design = Design::new(vec![listed("a", &[1, 2]), listed("b", &[10, 20, 30])], None).unwrap();
        assert_eq!(design.count(), Ok(6));
        let points: Vec<Vec<f64>> = (0..6).map(|point| numbers(&design.values(point, 1))).collect();
        assert_eq!(points[0], [1.0, 10.0]);
        assert_eq!(points[1], [1.0, 20.0]);
        assert_eq!(points[3], [2.0, 10.0]);
        assert_eq!(points[5], [2.0, 30.0]);
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_part_of_each_parameter() {
        let ends = Ends::Numbers(10.0, 20.0);
        let parameters = ["a", "b"].map(|key| Parameter {
            key: key.to_owned(),
            logarithmic: false,
            source: Source::Latin(ends),
        });
        let design = Design::new(parameters.to_vec(), Some(50)).unwrap();
        let points: Vec<Vec<f64>> = (0..50).map(|point| numbers(&design.values(point, 9))).collect();
        for parameter in 0..2 {
            let mut parts: Vec<u64> = points
                .iter()
                .map(|point| ((point[parameter] - 10.0) * 5.0) as u64)
                .collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..50).collect::<Vec<_>>());
        }
        // The two are not the same permutation.
        assert!(points.iter().any(|point| (point[0] - point[1]).abs() > 1.0));
    }

    #[test]
    fn another_parameter_does_not_change_what_is_drawn_for_the_first() {
        let latin = |key: &str| Parameter {
            key: key.to_owned(),
            logarithmic: false,
            source: Source::Latin(Ends::Numbers(0.0, 1.0)),
        };
        let seeded = |key: &str| Parameter {
            key: key.to_owned(),
            logarithmic: false,
            source: Source::Seed(Ends::Numbers(0.0, 1.0)),
        };
        let one = Design::new(vec![latin("a"), seeded("s")], Some(8)).unwrap();
        let two = Design::new(vec![latin("z"), latin("a"), seeded("t"), seeded("s")], Some(8)).unwrap();
        for point in 0..8 {
            let (one, two) = (one.values(point, 5), two.values(point, 5));
            assert_eq!((&one[0], &one[1]), (&two[1], &two[3]));
        }
        assert_ne!(one.values(0, 5)[1], one.values(0, 6)[1]);
    }

    #[test]
    fn a_sobol_sequence_fills_the_square_evenly() {
        let parameters = ["a", "b"].map(|key| Parameter {
            key: key.to_owned(),
            logarithmic: false,
            source: Source::Sobol(Ends::Numbers(0.0, 1.0)),
        });
        let design = Design::new(parameters.to_vec(), Some(64)).unwrap();
        let mut cells = [0; 16];
        for point in 0..64 {
            let at = numbers(&design.values(point, 1));
            cells[(at[0] * 4.0) as usize * 4 + (at[1] * 4.0) as usize] += 1;
        }
        assert_eq!(cells, [4; 16]);
    }

    #[test]
    fn ranges_include_their_ends() {
        assert_eq!(
            Ends::Numbers(0.0, 0.3).steps(4),
            [0.0, 0.1, 0.2, 0.3].map(Value::Number).to_vec().as_slice()
        );
        assert_eq!(Ends::Integers(1, 3).steps(3), [1, 2, 3].map(Value::Integer));
        assert_eq!(Ends::Logarithmic(0.1, 10.0).steps(3)[2], Value::Number(10.0));
        assert_eq!(Ends::Numbers(0.0, 1.0).at(1.0 / 3.0), Value::Number(0.333_333));
        assert_eq!(Ends::Integers(1, 3).at(0.0), Value::Integer(1));
        assert_eq!(Ends::Integers(1, 3).at(0.999_999), Value::Integer(3));
    }

    #[test]
    fn points_and_parameters_must_fit() {
        let latin = Parameter {
            key: "a".to_owned(),
            logarithmic: false,
            source: Source::Latin(Ends::Numbers(0.0, 1.0)),
        };
        for (parameters, points, expected) in [
            (vec![latin.clone()], None, "expected `points = N`"),
            (vec![latin.clone()], Some(0), "points is 0: expected 1 to 65536"),
            (vec![listed("a", &[1])], Some(4), "no parameter is spread"),
        ] {
            let error = Design::new(parameters, points).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
