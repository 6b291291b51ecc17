use backseat_campaign::{Column, Folder, Plan, RUNS, read_columns};
use backseat_oracle::{Bound, Margin};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::ReportError;
use crate::chart::{Series, bars, distributions, scatter, spreads};
use crate::compare::{Comparison, Verdict};
use crate::figure::{figure, percent, words};
use crate::gallery::Gallery;
use crate::outcome::{Arm, Outcomes, Parameter, Values};
use crate::sensitivity::{Sensitivity, sensitivities};
use crate::statistics::{mean, quantile};
use crate::worst::worst;

/// The page is for people who print it, or look at it in a bright or a dark room.
const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --dim: #777; --bad: #b3261e; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: 0; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
p.dim, .dim { color: var(--dim); } .bad { color: var(--bad); font-weight: 600; }
table { border-collapse: collapse; margin: .5rem 0; } th, td { padding: .2rem .7rem .2rem 0; text-align: right; } td { white-space: nowrap; }
th { border-bottom: 1px solid var(--line); font-weight: 600; } th:first-child, td:first-child, td.text, th.text { text-align: left; }
figure { margin: 1rem 0; background: #fff; color: #000; border: 1px solid var(--line); border-radius: 6px; padding: .5rem; display: inline-block; max-width: 100%; }
figure svg { max-width: 100%; height: auto; } figcaption { font-size: .9rem; padding: .2rem .5rem; }
code { font-size: .85rem; overflow-wrap: anywhere; } details { margin: .5rem 0; } .wide { overflow-x: auto; }
";
/// Points of a scatter chart at most.
const POINTS: usize = 1500;
/// More distributions than this are not drawn over each other, but a row each.
const OVERLAID: usize = 3;
/// Rows of the worst runs, and of the reasons for which runs could not be flown.
const WORST: usize = 12;
const REASONS: usize = 10;

/// The report of a campaign: one HTML file with everything in it.
///
/// # Errors
///
/// [`ReportError`] if the results cannot be read or a chart cannot be drawn.
pub fn page(folder: &Folder, plan: &Plan, outcomes: &Outcomes, gallery: &Gallery) -> Result<String, ReportError> {
    let manifest = folder.manifest()?;
    let title = outcomes
        .arms
        .iter()
        .map(|arm| arm.name.as_str())
        .collect::<Vec<_>>()
        .join(" / ");
    let (leading, others): (Vec<usize>, Vec<usize>) =
        (0..outcomes.measures.len()).partition(|measure| outcomes.leading.is_some_and(|(first, _)| first == *measure));
    let (margins, measures): (Vec<usize>, Vec<usize>) = others
        .into_iter()
        .partition(|measure| outcomes.measures[*measure].0.starts_with("margin."));
    let shown: Vec<usize> = leading.iter().copied().chain(measures).collect();
    let body = html! {
        h1 { "Campaign: " (title) }
        p.dim {
            (counted(plan.runs(), "run")) ": " (counted(plan.missions() as u64, "mission")) " x "
            (counted((outcomes.arms.len() / plan.missions().max(1)) as u64, "variant")) " x "
            (counted(plan.points(), "point")) " x " (counted(plan.runs_of_point(), "seed")) ". backseat "
            (manifest.version) ", campaign " (manifest.identity()[..12])
            @if let Some(faults) = plan.faults() { ", drawn faults " (faults) }
        }
        (setup(plan))
        h2 { "How many runs passed" }
        (rates(outcomes))
        (reasons(folder)?)
        @if outcomes.arms.len() > 1 {
            h2 { "Comparison" }
            (comparisons(outcomes, &shown))
        }
        h2 { "Distributions" }
        @for measure in &shown { (distribution(outcomes, *measure)?) }
        @if let (Some((measure, _)), false) = (outcomes.leading, outcomes.parameters.is_empty()) {
            h2 { "Which parameter moves " (words(&outcomes.measures[measure].0)) }
            (sensitivity(outcomes, measure)?)
        }
        h2 { "The worst runs" }
        (worst_runs(folder, outcomes, gallery)?)
        @if !gallery.maps.is_empty() {
            h2 { "Tracks" }
            p.dim { "Some runs of each variant, at even distances. Green: the edge of a keep-in zone; red: a keep-out zone." }
            @for (name, svg) in &gallery.maps {
                figure { (PreEscaped(svg)) figcaption { (name) } }
            }
        }
        @if !margins.is_empty() {
            h2 { "How near the runs came to what the safety requirements forbid" }
            (margin_table(outcomes, &margins))
        }
    };
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Campaign: " (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { (body) }
        }
    }
    .into_string())
}

/// `1 run` or `2 runs`.
fn counted(count: u64, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

/// What was varied.
fn setup(plan: &Plan) -> Markup {
    let variants: Vec<(&str, &[String])> = plan.variants().filter(|(name, _)| !name.is_empty()).collect();
    let parameters: Vec<(&str, String)> = plan.parameters().zip(plan.ranges()).collect();
    html! {
        @if !variants.is_empty() || !parameters.is_empty() {
            details {
                summary { "What was varied" }
                table {
                    @for (name, sets) in variants { tr { td { "variant " (name) } td.text { code { (sets.join("  ")) } } } }
                    @for (name, range) in parameters { tr { td { (name) } td.text { (range) } } }
                }
            }
        }
    }
}

fn rates(outcomes: &Outcomes) -> Markup {
    html! {
        table {
            tr { th { "variant" } th { "runs" } th { "passed" } th { "share" } th { "95 % interval" } th { "not flown" } th { "violations" } }
            @for arm in &outcomes.arms {
                @let (passed, flown) = outcomes.passed_of(arm);
                @let not_flown = arm.runs - flown;
                @let violations: u64 = outcomes.violations[outcomes.range(arm)].iter().sum();
                @let interval = outcomes.pass_interval(arm);
                tr {
                    td { (arm.name) } td { (arm.runs) } td { (passed) }
                    td { (percent(passed as f64 / flown.max(1) as f64)) }
                    td { (percent(interval.low)) " to " (percent(interval.high)) }
                    td.bad[not_flown > 0] { (not_flown) } td.bad[violations > 0] { (violations) }
                }
            }
        }
        p.dim {
            "A run passes if every expectation of its world.toml held; the share is of the runs that were flown. The interval is "
            "Wilson's; where no run failed, it is the exact bound, about 3/N. It counts seeds, because the runs of one seed at "
            "several points share their world."
        }
    }
}

/// Why runs could not be flown, each reason with how often it came.
fn reasons(folder: &Folder) -> Result<Markup, ReportError> {
    let columns = read_columns(&folder.path().join(RUNS), &["error"])?;
    let Some(Some(Column::Text(errors))) = columns.into_iter().next() else {
        return Ok(html! {});
    };
    let mut counts = std::collections::BTreeMap::<&str, (u64, usize)>::new();
    for (run, error) in errors.iter().enumerate() {
        if let Some(error) = error {
            counts.entry(error).or_insert((0, run)).0 += 1;
        }
    }
    let mut sorted: Vec<_> = counts.into_iter().collect();
    sorted.sort_by_key(|(_, (count, run))| (std::cmp::Reverse(*count), *run));
    Ok(html! {
        @if !sorted.is_empty() {
            p { "Runs that could not be flown:" }
            ul {
                @for (error, (count, run)) in sorted.iter().take(REASONS) { li { (count) " x " (error) " (first: run " (run) ")" } }
                @if sorted.len() > REASONS { li { (sorted.len() - REASONS) " more reasons" } }
            }
        }
    })
}

fn comparisons(outcomes: &Outcomes, measures: &[usize]) -> Markup {
    let first = &outcomes.arms[0];
    html! {
        p.dim {
            "Each run is compared with the run of " strong { (first.name) } " with the same point and seed: difference = other "
            "less " (first.name) ". Each seed counts once, with the mean over its points. The verdict is smaller or larger "
            "only if the bootstrap's 95 % interval of the mean difference leaves 0 out and the sign test finds p < 0.05, both to the "
            "same side; it is mixed if only one of them does. In the pairs both runs have the measure; alone are "
            "pairs in which only one has it. Among many measures some differ by chance."
        }
        div.wide { table {
            tr { th { "measure" } th.text { "other" } th.text { "verdict" } th { "mean difference" } th { "95 % interval" } th { "smaller" } th { "larger" } th { "seeds" } th { "pairs" } th { "alone" } th { "sign test" } }
            @for measure in measures {
                @for other in &outcomes.arms[1..] {
                    @if let Some(comparison) = Comparison::new(outcomes, first, other, *measure) {
                        (comparison_row(&comparison))
                    }
                }
            }
        } }
    }
}

fn comparison_row(comparison: &Comparison) -> Markup {
    let verdict = match comparison.verdict() {
        Verdict::TooFew => "too few seeds",
        Verdict::Equal => "no difference: all are equal",
        Verdict::NoDifference => "no difference shown",
        Verdict::Mixed => "mixed",
        Verdict::Smaller => "smaller",
        Verdict::Larger => "larger",
    };
    html! {
        tr {
            td { (words(&comparison.measure)) } td.text { (comparison.other) } td.text { strong { (verdict) } }
            td { (figure(comparison.difference)) }
            td { (figure(comparison.interval.low)) " to " (figure(comparison.interval.high)) }
            td { (comparison.smaller) } td { (comparison.larger) }
            td { (comparison.seeds) }
            td { (comparison.pairs) } td { (comparison.alone) }
            td { (comparison.p_text()) }
        }
    }
}

fn distribution(outcomes: &Outcomes, measure: usize) -> Result<Markup, ReportError> {
    let name = &outcomes.measures[measure].0;
    let sorted: Vec<(&Arm, Vec<f64>)> = outcomes
        .arms
        .iter()
        .map(|arm| (arm, outcomes.sorted(arm, measure)))
        .collect();
    let series: Vec<Series<'_, f64>> = sorted
        .iter()
        .map(|(arm, values)| Series {
            name: &arm.name,
            values: values.clone(),
        })
        .collect();
    let draw = if series.len() > OVERLAID {
        spreads
    } else {
        distributions
    };
    let Some(chart) = draw(&words(name), &series)? else {
        return Ok(html! {});
    };
    Ok(html! {
        figure { (PreEscaped(chart)) figcaption { (words(name)) " " span.dim { (name) } } }
        div.wide { table {
            tr { th { (words(name)) } th { "runs" } th { "mean" } th { "least" } th { "5 %" } th { "median" } th { "95 %" } th { "most" } }
            @for (arm, values) in &sorted {
                @if !values.is_empty() {
                    tr {
                        td { (arm.name) } td { (values.len()) } td { (figure(mean(values))) }
                        @for share in [0.0, 0.05, 0.5, 0.95, 1.0] { td { (figure(quantile(values, share))) } }
                    }
                }
            }
        } }
    })
}

fn sensitivity(outcomes: &Outcomes, measure: usize) -> Result<Markup, ReportError> {
    let found = sensitivities(outcomes, measure);
    if found.is_empty() {
        return Ok(html! { p { "No parameter or not the measure varies, or there are too few seeds to say." } });
    }
    let shares: Vec<(String, f64)> = found
        .iter()
        .map(|found| (found.parameter.clone(), found.share))
        .collect();
    let chart = bars("share of the variance that the parameter explains", &shares)?;
    let mut scatters = Vec::new();
    for parameter in &outcomes.parameters {
        if let Values::Numbers(numbers) = &parameter.values
            && let Some(svg) = scatter_of(outcomes, measure, parameter, numbers)?
        {
            scatters.push(svg);
        }
    }
    let without = outcomes.measures[measure]
        .1
        .iter()
        .filter(|value| value.is_none())
        .count();
    Ok(html! {
        @if without > 0 {
            p.bad {
                (without) " of " (outcomes.passed.len()) " runs have no value of this measure, and are not in these figures: look "
                "at how many runs passed at each value too."
            }
        }
        p.dim {
            "How much of the variance within a variant each parameter explains by itself, less what chance would explain "
            "(epsilon squared; a range is cut into ten parts). What two parameters do only together is in no share. The rank "
            "correlation (Spearman, of the differences from the variant's mean) says in which direction. A parameter that each "
            "seed draws is compared seed by seed, and cannot be told from the rest of what that seed draws unless there are "
            "many seeds; with too few it is left out. By chance: p of the F test."
        }
        figure { (PreEscaped(chart)) }
        table {
            tr { th { "parameter" } th { "share explained" } th { "rank correlation" } th { "by chance, p" } th { "values" } th.text { "" } }
            @for Sensitivity { parameter, share, correlation, chance, count } in &found {
                tr {
                    td { (parameter) } td { (percent(*share)) }
                    td { @if let Some(correlation) = correlation { (format!("{correlation:+.2}")) } }
                    td { @if *chance < 1e-4 { "< 0.0001" } @else { (format!("{chance:.4}")) } } td { (count) }
                    td.text.dim { @if *chance >= 0.05 { "not told from chance" } }
                }
            }
        }
        @for svg in &scatters { figure { (PreEscaped(svg)) } }
    })
}

fn scatter_of(
    outcomes: &Outcomes,
    measure: usize,
    parameter: &Parameter,
    numbers: &[Option<f64>],
) -> Result<Option<String>, ReportError> {
    let (title, values) = &outcomes.measures[measure];
    let step = (outcomes.passed.len() / POINTS).max(1);
    let series: Vec<Series<'_, (f64, f64)>> = outcomes
        .arms
        .iter()
        .map(|arm| Series {
            name: &arm.name,
            values: outcomes
                .range(arm)
                .step_by(step)
                .filter_map(|run| Some((numbers.get(run).copied()??, values[run]?)))
                .collect(),
        })
        .collect();
    scatter(&parameter.name, &words(title), parameter.logarithmic, &series)
}

fn worst_runs(folder: &Folder, outcomes: &Outcomes, gallery: &Gallery) -> Result<Markup, ReportError> {
    let all = worst(outcomes, WORST);
    let manifest = folder.manifest()?;
    let columns = read_columns(&folder.path().join(RUNS), &["replay", "unmet", "rules_broken"])?;
    let text = |column: usize, run: u64| match columns.get(column) {
        Some(Some(Column::Text(values))) => values.get(run as usize).cloned().flatten().unwrap_or_default(),
        _ => String::new(),
    };
    Ok(html! {
        @if all.is_empty() {
            p { "No run has a measure, and none failed." }
        } @else {
            p.dim {
                "Each command flies the run alone. Run it in " code { (manifest.folder.display()) }
                @if let Some(plugins) = &manifest.plugins { ", with " code { "--plugins " (plugins.display()) } }
                "; unlike the campaign, it reads BACKSEAT__ variables of the environment."
            }
        }
        @for worst in &all {
            @let picture = gallery.runs.iter().find(|(run, _)| *run == worst.run);
            p {
                strong { "run " (worst.run) } ": " (worst.why)
                @let unmet = text(1, worst.run);
                @if !unmet.is_empty() { br; span.bad { (unmet) } }
                @let rules = text(2, worst.run);
                @if !rules.is_empty() { br; span.bad { "rules broken: " (rules) } }
                br; code { (text(0, worst.run)) }
            }
            @if let Some((_, svg)) = picture { figure { (PreEscaped(svg)) } }
        }
        @if gallery.runs.is_empty() && !all.is_empty() {
            p.dim { "Without pictures: the missions or their plugins were not at hand when this report was written, or have changed." }
        }
    })
}

fn margin_table(outcomes: &Outcomes, margins: &[usize]) -> Markup {
    html! {
        p.dim {
            "The figure of each run that came nearest. Where less is worse, look at the least; where more is worse, at the most."
        }
        div.wide { table {
            tr { th { "margin" } th.text { "variant" } th { "runs" } th { "least" } th { "1 %" } th { "median" } th { "99 %" } th { "most" } }
            @for margin in margins {
                @for arm in &outcomes.arms {
                    @let values = outcomes.sorted(arm, *margin);
                    @if !values.is_empty() {
                        tr {
                            td { (margin_words(&outcomes.measures[*margin].0)) } td.text { (arm.name) } td { (values.len()) }
                            @for share in [0.0, 0.01, 0.5, 0.99, 1.0] { td { (figure(quantile(&values, share))) } }
                        }
                    }
                }
            }
        } }
    }
}

/// What a margin of safety is, with its unit and the side of it that is worse.
fn margin_words(name: &str) -> String {
    let short = name.trim_start_matches("margin.");
    let Some(margin) = Margin::ALL.into_iter().find(|margin| margin.name() == short) else {
        return short.to_owned();
    };
    let worse = match margin.bound() {
        Bound::Most => "more",
        Bound::Least => "less",
    };
    format!("{}, {} ({worse} is worse)", margin.title(), margin.unit())
}
