use comfy_table::{CellAlignment, Table, presets};

use crate::compare::Comparison;
use crate::figure::{figure, percent, words};
use crate::outcome::Outcomes;
use crate::statistics::quantile;

/// What results show, for the terminal: pass rates, measures, and comparisons with the first variant.
#[must_use]
pub fn table(outcomes: &Outcomes) -> String {
    let mut rates = new(&["variant", "runs", "passed", "95 % interval", "not flown", "violations"]);
    for arm in &outcomes.arms {
        let (passed, flown) = outcomes.passed_of(arm);
        let interval = outcomes.pass_interval(arm);
        let not_flown = arm.runs - flown;
        let violations: u64 = outcomes.violations[outcomes.range(arm)].iter().sum();
        rates.add_row([
            arm.name.clone(),
            arm.runs.to_string(),
            match percent(passed as f64 / flown.max(1) as f64) {
                share if not_flown == 0 => format!("{passed} ({share})"),
                share => format!("{passed} of {flown} flown ({share})"),
            },
            format!("{} to {}", percent(interval.low), percent(interval.high)),
            not_flown.to_string(),
            violations.to_string(),
        ]);
    }
    let mut text = aligned(rates, 1);
    for (count, reason) in &outcomes.reasons {
        text.push_str(&format!(" {count} x {reason}\n"));
    }
    let shown = || (0..outcomes.measures.len()).filter(|measure| !outcomes.measures[*measure].0.starts_with("margin."));
    let mut measures = new(&["measure", "variant", "runs", "least", "5 %", "median", "95 %", "most"]);
    for measure in shown() {
        for arm in &outcomes.arms {
            let values = outcomes.sorted(arm, measure);
            if values.is_empty() {
                continue;
            }
            let mut row = vec![
                words(&outcomes.measures[measure].0),
                arm.name.clone(),
                values.len().to_string(),
            ];
            row.extend([0.0, 0.05, 0.5, 0.95, 1.0].map(|share| figure(quantile(&values, share))));
            measures.add_row(row);
        }
    }
    if !measures.is_empty() {
        text.push('\n');
        text.push_str(&aligned(measures, 2));
    }
    if let [first, others @ ..] = &outcomes.arms[..] {
        for other in others {
            text.push_str(&format!(
                "\n{} compared with {}, seed by seed:\n",
                other.name, first.name
            ));
            for measure in shown() {
                if let Some(comparison) = Comparison::new(outcomes, first, other, measure) {
                    text.push_str(&format!("  {}: {comparison}\n", words(&comparison.measure)));
                }
            }
        }
    }
    text
}

fn new(head: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(head.to_vec());
    table
}

/// The table with its numbers at the right, from this column on.
fn aligned(mut table: Table, from: usize) -> String {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}
