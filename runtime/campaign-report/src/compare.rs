use std::cmp::Ordering;
use std::fmt;

use serde::Serialize;

use crate::figure::figure;
use crate::outcome::{Arm, Outcomes};
use crate::statistics::{Interval, bootstrap_mean, mean, sign_test};

/// A measure of two arms, run by run with the same point and seed.
///
/// Runs of one seed share their world at all points, so a seed counts once: with the mean of its differences.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The measure's name.
    pub measure: String,
    /// The name of the arm that is compared with the first.
    pub other: String,
    /// Pairs in which both runs have the measure.
    pub pairs: u64,
    /// Pairs in which only one of the two has it.
    pub alone: u64,
    /// The mean of the differences: the other less the first.
    pub difference: f64,
    /// The interval of the mean of the differences.
    pub interval: Interval,
    /// Seeds with such a pair.
    pub seeds: u64,
    /// Seeds for which the other's value is smaller.
    pub smaller: u64,
    /// Seeds for which it is larger.
    pub larger: u64,
    /// The sign test's probability.
    pub p: f64,
}

/// What a comparison shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// There are too few seeds to say anything.
    TooFew,
    /// All pairs are equal.
    Equal,
    /// The interval holds zero, and the sign test finds chance enough.
    NoDifference,
    /// One of the two shows a difference and the other does not, or they show opposite ones: the mean differs, but not the
    /// same way for most seeds, or the other way round.
    Mixed,
    /// Both say that the other is smaller.
    Smaller,
    /// Both say that the other is larger.
    Larger,
}

/// Fewer seeds show nothing.
const SEEDS_MIN: u64 = 6;
/// The sign test's threshold.
const P_MAX: f64 = 0.05;

impl Comparison {
    /// Compares a measure of two arms; `None` if no pair has it.
    #[must_use]
    pub fn new(outcomes: &Outcomes, first: &Arm, other: &Arm, measure: usize) -> Option<Self> {
        let (name, values) = &outcomes.measures[measure];
        let pairs = outcomes.range(first).zip(outcomes.range(other));
        let mut of_seed = vec![(0.0, 0u64); outcomes.seeds as usize];
        let (mut count, mut alone) = (0, 0);
        for (one, another) in pairs {
            let (sum, pairs) = &mut of_seed[outcomes.seed_of(first, one)];
            match (values[one], values[another]) {
                (Some(one), Some(another)) => {
                    *sum += another - one;
                    *pairs += 1;
                    count += 1;
                }
                (None, None) => {}
                (Some(_), None) | (None, Some(_)) => alone += 1,
            }
        }
        if count == 0 {
            return None;
        }
        let paired = of_seed.iter().filter(|(_, pairs)| *pairs > 0);
        let differences: Vec<f64> = paired.map(|(sum, pairs)| sum / *pairs as f64).collect();
        let smaller = differences.iter().filter(|difference| **difference < 0.0).count() as u64;
        let larger = differences.iter().filter(|difference| **difference > 0.0).count() as u64;
        Some(Self {
            measure: name.clone(),
            other: other.name.clone(),
            pairs: count,
            seeds: differences.len() as u64,
            alone,
            difference: mean(&differences),
            interval: bootstrap_mean(&differences),
            smaller,
            larger,
            p: sign_test(smaller, larger),
        })
    }

    /// What it shows. A difference must show in both: in the mean and in the signs.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        if self.smaller + self.larger == 0 {
            return Verdict::Equal;
        }
        if self.seeds < SEEDS_MIN {
            return Verdict::TooFew;
        }
        let signs = (self.p < P_MAX).then_some(self.larger.cmp(&self.smaller));
        let mean = if self.interval.high < 0.0 {
            Some(Ordering::Less)
        } else {
            (self.interval.low > 0.0).then_some(Ordering::Greater)
        };
        match (mean, signs) {
            (Some(Ordering::Less), Some(Ordering::Less)) => Verdict::Smaller,
            (Some(Ordering::Greater), Some(Ordering::Greater)) => Verdict::Larger,
            (None, None) => Verdict::NoDifference,
            (_, _) => Verdict::Mixed,
        }
    }

    /// The sign test's probability for people.
    pub(crate) fn p_text(&self) -> String {
        if self.p < 1e-4 {
            "p < 0.0001".to_owned()
        } else {
            format!("p = {:.4}", self.p)
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.verdict() {
            Verdict::Equal => write!(f, "no difference: equal for each of {} seeds", self.seeds)?,
            Verdict::TooFew => write!(f, "too few seeds ({}) to say", self.seeds)?,
            verdict @ (Verdict::NoDifference | Verdict::Mixed | Verdict::Smaller | Verdict::Larger) => {
                let word = match verdict {
                    Verdict::Smaller => "smaller",
                    Verdict::Larger => "larger",
                    Verdict::Mixed => "mixed, mean and sign test disagree",
                    Verdict::NoDifference | Verdict::Equal | Verdict::TooFew => "no difference shown",
                };
                write!(
                    f,
                    "{word}: difference {} (95 % interval {} to {}); smaller for {}, larger for {} of {} seeds, {}",
                    figure(self.difference),
                    figure(self.interval.low),
                    figure(self.interval.high),
                    self.smaller,
                    self.larger,
                    self.seeds,
                    self.p_text()
                )?;
            }
        }
        if self.alone > 0 {
            write!(f, "; in {} pairs only one of the two has it", self.alone)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use backseat_world::Stream;

    fn compared(values: Vec<Option<f64>>) -> Comparison {
        let seeds = values.len() as u64 / 2;
        compared_at_points(values, seeds)
    }

    fn compared_at_points(values: Vec<Option<f64>>, seeds: u64) -> Comparison {
        let runs = values.len() as u64 / 2;
        let arm = |name: &str, first| Arm {
            name: name.to_owned(),
            first,
            runs,
        };
        let outcomes = Outcomes {
            arms: vec![arm("a", 0), arm("b", runs)],
            seeds,
            passed: vec![true; values.len()],
            flown: vec![true; values.len()],
            violations: vec![0; values.len()],
            reasons: Vec::new(),
            measures: vec![("rms_m".to_owned(), values)],
            parameters: Vec::new(),
            leading: None,
        };
        Comparison::new(&outcomes, &outcomes.arms[0], &outcomes.arms[1], 0).unwrap()
    }

    fn noise(count: usize, name: &str) -> Vec<Option<f64>> {
        let mut stream = Stream::new(1, name);
        (0..count).map(|_| Some(stream.gaussian())).collect()
    }

    #[test]
    fn an_arm_against_itself_does_not_differ() {
        let values = noise(100, "a");
        let comparison = compared([values.clone(), values].concat());
        assert_eq!(comparison.verdict(), Verdict::Equal);
        assert_eq!(comparison.to_string(), "no difference: equal for each of 100 seeds");
    }

    #[test]
    fn a_mean_that_differs_without_most_seeds_is_mixed_and_so_are_seeds_without_the_mean() {
        let verdict = |values: fn(usize) -> f64| {
            let other = (0..100).map(|seed| Some(values(seed)));
            compared(vec![Some(0.0); 100].into_iter().chain(other).collect())
        };
        // Half of the seeds lose ten, and half gain one.
        let mean = verdict(|seed| if seed % 2 == 0 { -10.0 } else { 1.0 });
        assert_eq!(mean.verdict(), Verdict::Mixed);
        assert!(
            mean.to_string()
                .starts_with("mixed, mean and sign test disagree: difference -4.5"),
            "{mean}"
        );
        // Most lose a little, and few gain much.
        let most = verdict(|seed| if seed % 4 == 0 { 3.0 } else { -1.0 });
        assert_eq!((most.verdict(), most.smaller), (Verdict::Mixed, 75));
    }

    #[test]
    fn noise_does_not_differ_and_a_shift_does() {
        assert_eq!(
            compared([noise(100, "a"), noise(100, "b")].concat()).verdict(),
            Verdict::NoDifference
        );
        let shifted = noise(100, "a").into_iter().map(|value| value.map(|value| value + 0.3));
        let comparison = compared(noise(100, "a").into_iter().chain(shifted).collect());
        assert_eq!((comparison.verdict(), comparison.larger), (Verdict::Larger, 100));
        let text = comparison.to_string();
        assert!(
            text.starts_with("larger: difference 0.3 (95 % interval 0.3 to 0.3)"),
            "{text}"
        );
    }

    #[test]
    fn one_of_a_pair_without_a_value_is_counted() {
        let mut values = [noise(10, "a"), noise(10, "b")].concat();
        values[3] = None;
        values[15] = None;
        values[7] = None;
        values[17] = None;
        let comparison = compared(values);
        assert_eq!((comparison.pairs, comparison.alone), (7, 2));
    }

    #[test]
    fn more_points_of_a_seed_are_no_more_evidence() {
        // Two seeds at four points each: the second differs, and four times the same is once.
        let first: Vec<Option<f64>> = (0..8).map(|run| Some(f64::from(run % 2))).collect();
        let other = first.iter().map(|value| value.map(|value| value + 1.0)).collect();
        let comparison = compared_at_points([first, other].concat(), 2);
        assert_eq!((comparison.pairs, comparison.seeds, comparison.larger), (8, 2, 2));
        assert_eq!(comparison.verdict(), Verdict::TooFew);
    }

    #[test]
    fn few_pairs_say_nothing() {
        assert_eq!(
            compared([noise(4, "a"), noise(4, "b")].concat()).verdict(),
            Verdict::TooFew
        );
    }
}
