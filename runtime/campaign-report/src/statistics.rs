//! The statistics of the report. Everything random is drawn from a fixed seed: the same results give the same report.

use backseat_units::math::{exp, ln};
use backseat_world::Stream;
use statrs::distribution::{Binomial, ContinuousCDF as _, DiscreteCDF as _, FisherSnedecor};

/// The 97.5 % point of the normal distribution.
const Z: f64 = 1.959_963_984_540_054;
/// How often a bootstrap draws.
const DRAWS: usize = 2000;

/// An interval that holds the true value with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// The interval of a share of successes, from 0 to 1, that was seen in so many cases: Wilson's score interval (JASA 22,
/// 1927), or where nothing failed the exact bound behind the rule of three (Hanley and Lippman-Hand, JAMA 249, 1983): the
/// share of failures is at most about 3/N.
#[must_use]
pub fn pass_rate(share: f64, count: u64) -> Interval {
    let n = count as f64;
    if count == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    if share >= 1.0 {
        return Interval {
            low: exp(ln(0.05) / n),
            high: 1.0,
        };
    }
    let middle = (share + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    Interval {
        low: (middle - half).max(0.0),
        high: (middle + half).min(1.0),
    }
}

/// The value below which a share of sorted values lies, between two values linearly.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share * last as f64;
    let below = (place as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64)
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The bootstrap's percentile interval of the mean of values (Efron and Tibshirani, 1993, chapter 13).
pub(crate) fn bootstrap_mean(values: &[f64]) -> Interval {
    /// Of more values, the mean is normal to many digits, and drawing them takes long.
    const MANY: usize = 20_000;
    let n = values.len();
    let middle = mean(values);
    if n > MANY {
        let variance = values
            .iter()
            .map(|value| (value - middle) * (value - middle))
            .sum::<f64>()
            / (n - 1) as f64;
        let half = Z * (variance / n as f64).sqrt();
        return Interval {
            low: middle - half,
            high: middle + half,
        };
    }
    let mut stream = Stream::new(0, "bootstrap");
    let mut means: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let sum: f64 = (0..n)
                .map(|_| values[((stream.uniform() * n as f64) as usize).min(n - 1)])
                .sum();
            sum / n as f64
        })
        .collect();
    means.sort_by(f64::total_cmp);
    Interval {
        low: quantile(&means, 0.025),
        high: quantile(&means, 0.975),
    }
}

/// The sign test: how probable it is that so many of the pairs that differ, or even more, differ in the same direction
/// if both directions are equally likely.
pub(crate) fn sign_test(smaller: u64, larger: u64) -> f64 {
    let count = smaller + larger;
    let rare = smaller.min(larger);
    Binomial::new(0.5, count).map_or(1.0, |binomial| (2.0 * binomial.cdf(rare)).min(1.0))
}

/// Spearman's rank correlation, from -1 to 1; `None` if one of the two does not vary.
pub(crate) fn rank_correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let first = ranks(&pairs.iter().map(|pair| pair.0).collect::<Vec<_>>());
    let second = ranks(&pairs.iter().map(|pair| pair.1).collect::<Vec<_>>());
    let middle = (pairs.len() as f64 - 1.0) / 2.0;
    let (mut both, mut one, mut other) = (0.0, 0.0, 0.0);
    for (a, b) in first.iter().zip(&second) {
        let (a, b) = (a - middle, b - middle);
        both += a * b;
        one += a * a;
        other += b * b;
    }
    (one > 0.0 && other > 0.0).then(|| both / (one * other).sqrt())
}

/// The rank of each value from 0; equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|one, other| values[*one].total_cmp(&values[*other]));
    let mut ranks = vec![0.0; values.len()];
    let mut begin = 0;
    while begin < order.len() {
        let mut end = begin + 1;
        while end < order.len() && values[order[end]] == values[order[begin]] {
            end += 1;
        }
        let shared = (begin + end - 1) as f64 / 2.0;
        for place in &order[begin..end] {
            ranks[*place] = shared;
        }
        begin = end;
    }
    ranks
}

/// The share of the variance of values that their groups explain, from 0 to 1, without what chance explains: epsilon
/// squared (Kelley, PNAS 21(9), 1935). `None` if the values do not vary, or if each group has one value.
pub(crate) fn explained(groups: &[Vec<f64>]) -> Option<f64> {
    let Sums {
        between,
        within,
        groups,
        values,
    } = Sums::of(groups)?;
    let noise = within / (values - groups);
    Some(((between - (groups - 1.0) * noise) / (between + within)).clamp(0.0, 1.0))
}

/// How probable it is that the means of groups differ so much by chance: p of the F test of a one-way analysis of variance
/// (Fisher, Statistical Methods for Research Workers, 1925). `None` as in [`explained`].
pub(crate) fn chance(groups: &[Vec<f64>]) -> Option<f64> {
    let Sums {
        between,
        within,
        groups,
        values,
    } = Sums::of(groups)?;
    let ratio = between / (groups - 1.0) / (within / (values - groups));
    if !ratio.is_finite() {
        return Some(0.0);
    }
    let distribution = FisherSnedecor::new(groups - 1.0, values - groups).ok()?;
    Some(distribution.sf(ratio).clamp(0.0, 1.0))
}

/// The sums of squares of a one-way analysis of variance.
struct Sums {
    /// Of the groups' means.
    between: f64,
    /// Of values about the mean of their group.
    within: f64,
    /// How many groups have values.
    groups: f64,
    /// How many values there are.
    values: f64,
}

impl Sums {
    /// `None` if the values do not vary, or if each group has one value.
    fn of(groups: &[Vec<f64>]) -> Option<Self> {
        let count: usize = groups.iter().map(Vec::len).sum();
        let filled = groups.iter().filter(|group| !group.is_empty()).count();
        if filled < 2 || count <= filled {
            return None;
        }
        let all = groups.iter().flatten().sum::<f64>() / count as f64;
        let (mut between, mut within) = (0.0, 0.0);
        for group in groups.iter().filter(|group| !group.is_empty()) {
            let middle = mean(group);
            between += group.len() as f64 * (middle - all) * (middle - all);
            within += group
                .iter()
                .map(|value| (value - middle) * (value - middle))
                .sum::<f64>();
        }
        (between + within > 0.0).then_some(Self {
            between,
            within,
            groups: filled as f64,
            values: count as f64,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-4, "{value} is not {expected}");
    }

    #[test]
    fn groups_that_differ_by_chance_are_told_from_others() {
        // Heights of three groups; R: oneway.test(..., var.equal = TRUE) has F(2, 6) = 27, p = 0.001.
        let groups = [vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0], vec![7.0, 8.0, 9.0]];
        near(chance(&groups).unwrap(), 0.001);
        let same = [vec![1.0, 2.0, 3.0], vec![3.0, 2.0, 1.0]];
        near(chance(&same).unwrap(), 1.0);
        assert_eq!(chance(&[vec![1.0, 1.0], vec![2.0, 2.0]]), Some(0.0));
        assert_eq!(chance(&[vec![1.0], vec![2.0]]), None);
    }

    #[test]
    fn pass_rates_have_the_bounds_of_the_books() {
        // Newcombe, Statistics in Medicine 17, 1998, table I, method 3: 81 of 263 and 15 of 148.
        let interval = pass_rate(81.0 / 263.0, 263);
        near(interval.low, 0.2553);
        near(interval.high, 0.3662);
        let interval = pass_rate(15.0 / 148.0, 148);
        near(interval.low, 0.0624);
        near(interval.high, 0.1605);
        near(pass_rate(1.0, 1000).low, 0.997_01);
        near(pass_rate(1.0, 2).low, 0.223_6);
        assert_eq!(pass_rate(0.0, 0), Interval { low: 0.0, high: 1.0 });
    }

    #[test]
    fn the_sign_test_is_exact() {
        // 2 * (1 + 10 + 45) / 1024.
        near(sign_test(2, 8), 0.109_375);
        near(sign_test(8, 2), 0.109_375);
        near(sign_test(5, 5), 1.0);
        near(sign_test(0, 0), 1.0);
    }

    #[test]
    fn ranks_correlate_as_in_the_textbook() {
        // Without ties: 1 - 6 * 194 / (10 * 99).
        let iq = [106.0, 100.0, 86.0, 101.0, 99.0, 103.0, 97.0, 113.0, 112.0, 110.0];
        let hours = [7.0, 27.0, 2.0, 50.0, 28.0, 29.0, 20.0, 12.0, 6.0, 17.0];
        let pairs: Vec<(f64, f64)> = iq.into_iter().zip(hours).collect();
        near(rank_correlation(&pairs).unwrap(), -0.175_757);
        assert_eq!(rank_correlation(&[(1.0, 2.0), (1.0, 3.0)]), None);
        assert_eq!(ranks(&[3.0, 1.0, 3.0]), [1.5, 0.0, 1.5]);
    }

    #[test]
    fn groups_explain_what_they_explain_and_chance_explains_nothing() {
        assert_eq!(explained(&[vec![1.0, 1.0], vec![2.0, 2.0]]), Some(1.0));
        assert_eq!(explained(&[vec![1.0], vec![2.0]]), None);
        assert_eq!(explained(&[vec![1.0, 1.0], vec![1.0]]), None);
        let mut stream = Stream::new(3, "noise");
        let groups: Vec<Vec<f64>> = (0..10).map(|_| (0..50).map(|_| stream.gaussian()).collect()).collect();
        assert!(explained(&groups).unwrap() < 0.05);
    }

    #[test]
    fn the_bootstrap_holds_the_mean() {
        let mut stream = Stream::new(5, "values");
        let values: Vec<f64> = (0..400).map(|_| 2.0 + stream.gaussian()).collect();
        let interval = bootstrap_mean(&values);
        // 1.96 / sqrt(400) to each side.
        near(((interval.high - interval.low) / 2.0 * 50.0).round() / 50.0, 0.1);
        assert!(interval.low < mean(&values) && mean(&values) < interval.high);
    }

    #[test]
    fn quantiles_lie_between_the_values() {
        let sorted = [1.0, 2.0, 4.0];
        near(quantile(&sorted, 0.0), 1.0);
        near(quantile(&sorted, 0.5), 2.0);
        near(quantile(&sorted, 0.75), 3.0);
        near(quantile(&sorted, 1.0), 4.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
