//! Which parameter moves a measure.

use crate::outcome::{Outcomes, Values};
use crate::statistics::{chance, explained, quantile, rank_correlation};

/// A parameter with more values than this is cut into parts with equally many runs.
const VALUES_MAX: usize = 12;
const PARTS: usize = 10;

/// How a measure depends on a parameter, over all arms.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sensitivity {
    pub(crate) parameter: String,
    /// The share of the measure's variance within the arms that the parameter explains, 0 to 1.
    pub(crate) share: f64,
    /// Spearman's rank correlation, if the parameter is a number.
    pub(crate) correlation: Option<f64>,
    /// How probable such a share is by chance: the F test's p.
    pub(crate) chance: f64,
    /// The values that were compared: runs, or seeds where each seed draws.
    pub(crate) count: usize,
}

/// The parameters by the share that they explain, the largest first. The runs of each arm are compared with the mean of
/// that arm, so that a difference between arms counts for no parameter.
pub(crate) fn sensitivities(outcomes: &Outcomes, measure: usize) -> Vec<Sensitivity> {
    let of_runs = centred(outcomes, measure);
    let of_seeds = means_of_seeds(outcomes, &of_runs);
    let mut all: Vec<Sensitivity> = outcomes
        .parameters
        .iter()
        .filter_map(|parameter| {
            // What a seed draws is one value for all of its runs.
            let values = if parameter.of_seed { &of_seeds } else { &of_runs };
            let (groups, correlation) = match &parameter.values {
                Values::Numbers(numbers) => {
                    let pairs: Vec<(f64, f64)> = numbers
                        .iter()
                        .zip(values)
                        .filter_map(|(number, value)| Some(((*number)?, (*value)?)))
                        .collect();
                    (grouped(&pairs), rank_correlation(&pairs))
                }
                Values::Texts(places, texts) => {
                    let mut groups = vec![Vec::new(); texts.len()];
                    for (place, value) in places.iter().zip(values) {
                        groups[*place].extend(*value);
                    }
                    (groups, None)
                }
            };
            Some(Sensitivity {
                parameter: parameter.name.clone(),
                share: explained(&groups)?,
                correlation,
                chance: chance(&groups)?,
                count: groups.iter().map(Vec::len).sum(),
            })
        })
        .collect();
    all.sort_by(|one, other| other.share.total_cmp(&one.share));
    all
}

/// For the first run of each seed the mean of all values of the seed, and nothing for its other runs.
fn means_of_seeds(outcomes: &Outcomes, values: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut sums = vec![(0.0, 0u64, None); outcomes.seeds as usize];
    for arm in &outcomes.arms {
        for run in outcomes.range(arm) {
            let (sum, count, first) = &mut sums[outcomes.seed_of(arm, run)];
            first.get_or_insert(run);
            if let Some(value) = values[run] {
                *sum += value;
                *count += 1;
            }
        }
    }
    let mut means = vec![None; values.len()];
    for (sum, count, first) in sums {
        if let Some(first) = first.filter(|_| count > 0) {
            means[first] = Some(sum / count as f64);
        }
    }
    means
}

/// Each run's value less the mean of its arm.
fn centred(outcomes: &Outcomes, measure: usize) -> Vec<Option<f64>> {
    let mut values = outcomes.measures[measure].1.clone();
    for arm in &outcomes.arms {
        let range = outcomes.range(arm);
        let there: Vec<f64> = values[range.clone()].iter().copied().flatten().collect();
        let middle = crate::statistics::mean(&there);
        for value in values[range].iter_mut().flatten() {
            *value -= middle;
        }
    }
    values
}

fn grouped(pairs: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let mut numbers: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
    numbers.sort_by(f64::total_cmp);
    let mut edges = numbers.clone();
    edges.dedup();
    if edges.len() > VALUES_MAX {
        edges = (0..PARTS)
            .map(|part| quantile(&numbers, part as f64 / PARTS as f64))
            .collect();
        edges.dedup();
    }
    let mut groups = vec![Vec::new(); edges.len()];
    for (number, value) in pairs {
        let group = edges.partition_point(|edge| edge <= number).saturating_sub(1);
        groups[group].push(*value);
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::{Arm, Parameter};
    use backseat_world::Stream;

    fn named(name: &str, values: Values) -> Parameter {
        Parameter {
            name: name.to_owned(),
            values,
            of_seed: false,
            logarithmic: false,
        }
    }

    #[test]
    fn what_few_seeds_draw_explains_nothing() {
        // Six seeds with a world each, at six points: the drawn value stands for the seed.
        let (seeds, points) = (6_i32, 6_i32);
        let worlds: Vec<f64> = (0..seeds).map(|seed| f64::from(seed * seed)).collect();
        let runs = || (0..points).flat_map(|_| 0..seeds as usize);
        let outcomes = Outcomes {
            arms: vec![Arm {
                name: "a".to_owned(),
                first: 0,
                runs: (seeds * points) as u64,
            }],
            seeds: seeds as u64,
            passed: vec![true; 36],
            flown: vec![true; 36],
            violations: vec![0; 36],
            reasons: Vec::new(),
            measures: vec![("m".to_owned(), runs().map(|seed| Some(worlds[seed])).collect())],
            parameters: vec![Parameter {
                of_seed: true,
                ..named("drawn", Values::Numbers(runs().map(|seed| Some(seed as f64)).collect()))
            }],
            leading: None,
        };
        assert_eq!(sensitivities(&outcomes, 0), []);
    }

    #[test]
    fn the_parameter_that_moves_the_measure_comes_first() {
        let mut stream = Stream::new(1, "runs");
        let count = 1000;
        let draw = |stream: &mut Stream| (0..count).map(|_| stream.uniform()).collect::<Vec<f64>>();
        let (strong, weak, none) = (draw(&mut stream), draw(&mut stream), draw(&mut stream));
        let kinds: Vec<usize> = (0..count).map(|run| run % 2).collect();
        let measure = (0..count)
            .map(|run| Some(-3.0 * strong[run] + 0.5 * weak[run] + 0.2 * kinds[run] as f64 + 0.1 * stream.gaussian()))
            .collect();
        let numbers = |values: Vec<f64>| Values::Numbers(values.into_iter().map(Some).collect());
        let outcomes = Outcomes {
            arms: vec![Arm {
                name: "a".to_owned(),
                first: 0,
                runs: count as u64,
            }],
            seeds: count as u64,
            passed: vec![true; count],
            flown: vec![true; count],
            violations: vec![0; count],
            reasons: Vec::new(),
            measures: vec![("m".to_owned(), measure)],
            parameters: vec![
                named("none", numbers(none)),
                named("kind", Values::Texts(kinds, vec!["x".to_owned(), "y".to_owned()])),
                named("weak", numbers(weak)),
                named("strong", numbers(strong)),
            ],
            leading: None,
        };
        let found = sensitivities(&outcomes, 0);
        assert_eq!(found[0].parameter, "strong");
        assert!(found[0].share > 0.9 && found[0].correlation.unwrap() < -0.9);
        let none = found.iter().find(|found| found.parameter == "none").unwrap();
        assert!(none.share < 0.02);
    }
}
