use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use backseat_oracle::{Bound, Margin, Margins, Nearest};
use serde::{Deserialize, Serialize};

/// How near missions came to what the safety requirements forbid: for each margin, the nearest figure of each mission.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Distributions(BTreeMap<String, Distribution>);

/// The nearest figures of many missions.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Distribution {
    /// Missions in which a case of the margin occurred.
    missions: u64,
    /// The missions by their measure, in steps.
    steps: BTreeMap<i64, u64>,
    /// The mission that came nearest.
    nearest: Option<Record>,
}

/// The nearest figure of all, and the seed of its mission.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Record {
    value: f64,
    allowed: f64,
    seed: u64,
}

/// Steps beyond this are counted as this: what is far from the limit needs no detail.
const STEPS_MAX: i64 = 1000;

impl Distributions {
    pub(crate) fn add(&mut self, margins: &Margins, seed: u64) {
        for margin in Margin::ALL {
            let Some(nearest) = margins.nearest(margin) else {
                continue;
            };
            let distribution = self.0.entry(margin.name().to_owned()).or_default();
            distribution.missions += 1;
            *distribution.steps.entry(step(margin, &nearest)).or_default() += 1;
            let Nearest { value, allowed } = nearest;
            distribution.keep(margin, Record { value, allowed, seed });
        }
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        for margin in Margin::ALL {
            let Some(theirs) = other.0.get(margin.name()) else {
                continue;
            };
            let ours = self.0.entry(margin.name().to_owned()).or_default();
            ours.missions += theirs.missions;
            for (step, count) in &theirs.steps {
                *ours.steps.entry(*step).or_default() += count;
            }
            if let Some(nearest) = theirs.nearest {
                ours.keep(margin, nearest);
            }
        }
    }
}

impl Distribution {
    fn keep(&mut self, margin: Margin, record: Record) {
        let order = |record: &Record| (record.nearest().measure(margin.bound()), record.seed);
        let nearer = self.nearest.is_none_or(|known| {
            let (ours, theirs) = (order(&record), order(&known));
            // Of equals the first seed, in whatever order the missions were flown.
            record.nearest().is_nearer(&known.nearest(), margin.bound()) || ours.0 == theirs.0 && ours.1 < theirs.1
        });
        if nearer {
            self.nearest = Some(record);
        }
    }

    /// The measure that this share of the missions kept away from what is forbidden.
    fn quantile(&self, margin: Margin, share: f64) -> f64 {
        // Rounded, because a share like 0.9 is no exact number.
        let nearer = (self.missions as f64 * (1.0 - share)).round() as u64;
        let mut steps: Vec<(&i64, &u64)> = self.steps.iter().collect();
        if margin.bound() == Bound::Most {
            steps.reverse();
        }
        let mut passed = 0;
        for (step, count) in steps {
            passed += count;
            if passed > nearer {
                return *step as f64 * step_size(margin);
            }
        }
        f64::NAN
    }
}

impl Record {
    const fn nearest(&self) -> Nearest {
        Nearest {
            value: self.value,
            allowed: self.allowed,
        }
    }
}

/// How much a step is: a hundredth of what is allowed, a decimetre, a hundredth of a second.
fn step_size(margin: Margin) -> f64 {
    match (margin.bound(), margin.unit()) {
        (Bound::Least, "m") => 0.1,
        (Bound::Most | Bound::Least, _) => 0.01,
    }
}

/// The step of a measure, rounded towards what is forbidden.
fn step(margin: Margin, nearest: &Nearest) -> i64 {
    let steps = nearest.measure(margin.bound()) / step_size(margin);
    let steps = match margin.bound() {
        Bound::Most => steps.ceil(),
        Bound::Least => steps.floor(),
    };
    (steps as i64).min(STEPS_MAX)
}

impl Display for Distributions {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:4}{:62}{:>9}{:>22}{:>10}{:>10}{:>10}{:>10}",
            "req", "margin", "missions", "nearest (allowed)", "99.9 %", "99 %", "90 %", "seed"
        )?;
        for margin in Margin::ALL {
            let Some(distribution) = self.0.get(margin.name()) else {
                continue;
            };
            let Some(nearest) = distribution.nearest else { continue };
            let unit = margin.unit();
            let quantile = |share: f64| match margin.bound() {
                Bound::Most => format!("{:.0} %", 100.0 * distribution.quantile(margin, share)),
                Bound::Least if distribution.quantile(margin, share) >= STEPS_MAX as f64 * step_size(margin) => {
                    format!("> {:.0} {unit}", STEPS_MAX as f64 * step_size(margin))
                }
                Bound::Least => format!("{:.2} {unit}", distribution.quantile(margin, share)),
            };
            writeln!(
                f,
                "{:03} {:62}{:>9}{:>22}{:>10}{:>10}{:>10}{:>10}",
                margin.requirement(),
                margin.title(),
                distribution.missions,
                format!("{:.3} {unit} ({:.3})", nearest.value, nearest.allowed),
                quantile(0.999),
                quantile(0.99),
                quantile(0.9),
                nearest.seed
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distribution(margin: Margin, values: &[f64], allowed: f64) -> Distribution {
        let mut distribution = Distribution::default();
        for (seed, value) in (0..).zip(values) {
            let record = Record {
                value: *value,
                allowed,
                seed,
            };
            distribution.missions += 1;
            *distribution.steps.entry(step(margin, &record.nearest())).or_default() += 1;
            distribution.keep(margin, record);
        }
        distribution
    }

    #[test]
    fn a_quantile_is_what_that_share_of_the_missions_kept_away() {
        let gaps: Vec<f64> = (1..=100).map(|number| f64::from(number) * 0.02).collect();
        let gaps = distribution(Margin::ModifyGap, &gaps, 2.0);
        assert_eq!(gaps.nearest.map(|record| (record.value, record.seed)), Some((2.0, 99)));
        assert!(
            (gaps.quantile(Margin::ModifyGap, 0.9) - 0.9).abs() < 0.011,
            "{}",
            gaps.quantile(Margin::ModifyGap, 0.9)
        );
        let metres: Vec<f64> = (1..=100).map(f64::from).collect();
        let metres = distribution(Margin::Clearance, &metres, 0.0);
        assert_eq!(metres.nearest.map(|record| record.seed), Some(0));
        assert!(
            (metres.quantile(Margin::Clearance, 0.9) - 11.0).abs() < 0.11,
            "{}",
            metres.quantile(Margin::Clearance, 0.9)
        );
    }

    #[test]
    fn hunts_in_parts_give_the_distribution_of_the_whole() {
        let parts = [[3.0, 50.0], [1.0, 2000.0]];
        let mut whole = Distributions::default();
        for part in parts {
            let part = distribution(Margin::Clearance, &part, 0.0);
            let part = Distributions(BTreeMap::from([(Margin::Clearance.name().to_owned(), part)]));
            whole.merge(&part);
        }
        let all = &whole.0[Margin::Clearance.name()];
        assert_eq!((all.missions, all.steps[&10], all.steps[&STEPS_MAX]), (4, 1, 1));
        assert_eq!(all.nearest.map(|record| record.value), Some(1.0));
    }
}
