use backseat_campaign::Better;

use crate::figure::{figure, words};
use crate::outcome::Outcomes;

/// A run that the report shows, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Worst {
    pub(crate) run: u64,
    pub(crate) why: String,
}

/// The worst runs, at most so many: those that broke a rule, then those that missed an expectation, then those with the
/// worst values of the leading measure. Runs that could not be flown are not among them.
pub(crate) fn worst(outcomes: &Outcomes, most: usize) -> Vec<Worst> {
    let flown = |run: &usize| outcomes.flown[*run];
    let count = outcomes.passed.len();
    let mut all: Vec<Worst> = Vec::new();
    let broken = (0..count).filter(flown).filter(|run| outcomes.violations[*run] > 0);
    all.extend(broken.take(most).map(|run| Worst {
        run: run as u64,
        why: format!("{} violations", outcomes.violations[run]),
    }));
    let value = |run: usize| {
        let (measure, better) = outcomes.leading?;
        let value = outcomes.measures[measure].1[run]?;
        Some(match better {
            Better::Less => value,
            Better::More => -value,
        })
    };
    let said = |run: usize| {
        let (measure, _) = outcomes.leading?;
        let (name, values) = &outcomes.measures[measure];
        Some(format!("{}: {}", words(name), figure(values[run]?)))
    };
    let mut missed: Vec<usize> = (0..count)
        .filter(flown)
        .filter(|run| !outcomes.passed[*run] && outcomes.violations[*run] == 0)
        .collect();
    // A run without the measure has not come so far as to have one.
    let worse = |one: &usize, other: &usize| {
        let key = |run: usize| value(run).unwrap_or(f64::INFINITY);
        key(*other).total_cmp(&key(*one)).then(one.cmp(other))
    };
    missed.sort_by(worse);
    all.extend(missed.into_iter().take(most).map(|run| Worst {
        run: run as u64,
        why: said(run).map_or_else(
            || "missed an expectation".to_owned(),
            |said| format!("missed an expectation; {said}"),
        ),
    }));
    let mut measured: Vec<usize> = (0..count)
        .filter(|run| outcomes.passed[*run] && outcomes.violations[*run] == 0 && value(*run).is_some())
        .collect();
    measured.sort_by(worse);
    all.extend(measured.into_iter().take(most).filter_map(|run| {
        Some(Worst {
            run: run as u64,
            why: said(run)?,
        })
    }));
    all.truncate(most);
    all
}
