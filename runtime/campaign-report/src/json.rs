use serde::Serialize;

use crate::compare::{Comparison, Verdict};
use crate::outcome::{Arm, Outcomes};
use crate::statistics::{Interval, quantile};

/// What results show, for programs: as [`table`](crate::table), with all measures, margins of safety too.
#[derive(Debug, Serialize)]
pub struct Summary {
    variants: Vec<VariantSummary>,
    /// Why runs did not pass, the most frequent reasons first.
    reasons: Vec<ReasonSummary>,
    measures: Vec<MeasureSummary>,
    /// Each variant compared with the first, seed by seed.
    comparisons: Vec<ComparisonSummary>,
}

#[derive(Debug, Serialize)]
struct VariantSummary {
    variant: String,
    runs: u64,
    flown: u64,
    passed: u64,
    /// The 95 % interval of the share that passes, of those that were flown.
    pass_interval: [f64; 2],
    violations: u64,
}

#[derive(Debug, Serialize)]
struct ReasonSummary {
    runs: u64,
    reason: String,
}

#[derive(Debug, Serialize)]
struct MeasureSummary {
    measure: String,
    variant: String,
    /// Runs that have the measure.
    runs: u64,
    least: f64,
    quantile_05: f64,
    median: f64,
    quantile_95: f64,
    most: f64,
}

#[derive(Debug, Serialize)]
struct ComparisonSummary {
    measure: String,
    variant: String,
    compared_with: String,
    verdict: Verdict,
    /// Pairs in which both runs have the measure.
    pairs: u64,
    /// Pairs in which only one of the two has it.
    alone: u64,
    /// The mean of the differences: the variant less the first.
    difference: f64,
    /// Its 95 % interval, by bootstrap.
    interval: [f64; 2],
    seeds: u64,
    /// Seeds for which the variant's value is smaller, and larger.
    smaller: u64,
    larger: u64,
    /// The sign test's probability.
    p: f64,
}

impl Summary {
    /// Sums up results.
    #[must_use]
    pub fn new(outcomes: &Outcomes) -> Self {
        let measures = 0..outcomes.measures.len();
        let of_arms = measures.clone().flat_map(|measure| {
            let arms = outcomes.arms.iter();
            arms.filter_map(move |arm| MeasureSummary::new(outcomes, arm, measure))
        });
        let others = outcomes.arms.iter().skip(1);
        let pairs = outcomes.arms.first().into_iter().flat_map(|first| {
            let pairs = others.clone().map(move |other| (first, other));
            pairs.flat_map(|(first, other)| measures.clone().map(move |measure| (first, other, measure)))
        });
        Self {
            variants: outcomes
                .arms
                .iter()
                .map(|arm| VariantSummary::new(outcomes, arm))
                .collect(),
            reasons: outcomes
                .reasons
                .iter()
                .map(|(runs, reason)| ReasonSummary {
                    runs: *runs,
                    reason: reason.clone(),
                })
                .collect(),
            measures: of_arms.collect(),
            comparisons: pairs
                .filter_map(|(first, other, measure)| {
                    let comparison = Comparison::new(outcomes, first, other, measure)?;
                    Some(ComparisonSummary::new(comparison, &first.name))
                })
                .collect(),
        }
    }
}

impl VariantSummary {
    fn new(outcomes: &Outcomes, arm: &Arm) -> Self {
        let (passed, flown) = outcomes.passed_of(arm);
        Self {
            variant: arm.name.clone(),
            runs: arm.runs,
            flown,
            passed,
            pass_interval: ends(outcomes.pass_interval(arm)),
            violations: outcomes.violations[outcomes.range(arm)].iter().sum(),
        }
    }
}

impl MeasureSummary {
    /// `None` if no run of the arm has the measure.
    fn new(outcomes: &Outcomes, arm: &Arm, measure: usize) -> Option<Self> {
        let values = outcomes.sorted(arm, measure);
        let (least, most) = (*values.first()?, *values.last()?);
        Some(Self {
            measure: outcomes.measures[measure].0.clone(),
            variant: arm.name.clone(),
            runs: values.len() as u64,
            least,
            quantile_05: quantile(&values, 0.05),
            median: quantile(&values, 0.5),
            quantile_95: quantile(&values, 0.95),
            most,
        })
    }
}

impl ComparisonSummary {
    fn new(comparison: Comparison, first: &str) -> Self {
        Self {
            verdict: comparison.verdict(),
            measure: comparison.measure,
            variant: comparison.other,
            compared_with: first.to_owned(),
            pairs: comparison.pairs,
            alone: comparison.alone,
            difference: comparison.difference,
            interval: ends(comparison.interval),
            seeds: comparison.seeds,
            smaller: comparison.smaller,
            larger: comparison.larger,
            p: comparison.p,
        }
    }
}

fn ends(interval: Interval) -> [f64; 2] {
    [interval.low, interval.high]
}
