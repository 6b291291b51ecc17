use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{Happened, Report};

const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --soft: #8881; --bad: #c00020; }
@media (prefers-color-scheme: dark) { :root { --bad: #ff6b76; } }
body { font: 16px/1.45 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: .2rem; } h2 { font-size: 1.1rem; margin: 1.6rem 0 .4rem; }
table { border-collapse: collapse; width: 100%; } th { text-align: left; background: var(--soft); }
td, th { padding: .25rem .6rem; border-bottom: 1px solid var(--line); vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.bad { color: var(--bad); } .soft { opacity: .75; }
";

/// The page; it loads nothing.
pub(super) fn page(report: &Report) -> String {
    let title = format!("{} {}", report.mission, report.began);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (report.mission) @if let Some(seed) = report.seed { ", seed " (seed) } }
                p {
                    (format!("{:.1} min", report.seconds / 60.0)) " from " (report.began) ", the runtime had control for "
                    (format!("{:.1} min", report.control_s / 60.0)) "."
                    br;
                    @for words in report.control_words() {
                        (words) "."
                        br;
                    }
                    span.soft { (report.log) ", backseat " (report.version) }
                }
                @if !report.complete { p.bad { "The log is cut short, or still being written: its last records may be missing." } }
                @if report.missing > 0 {
                    p.bad { (report.missing) " records are missing: the disk was too slow." }
                }
                (asked(report)) (refused(report)) (flown(report)) (leases(report))
                (happened("What the operator did", &report.operator))
                (happened("Troubles", &report.troubles))
                @if let Some(left_out) = report.left_out() { p { (left_out) "." } }
            }
        }
    };
    page.into_string()
}

fn asked(report: &Report) -> Markup {
    html! {
        h2 { "What was asked for, and what came of it" }
        table {
            tr {
                th { "by" } th.n { "requests" } th.n { "refused" } th.n { "failed" } th.n { "not answered" }
                th.n { "cancelled before" } th.n { "ended unsent" } th.n { "carried out" } th.n { "open at the end" }
            }
            @for (owner, asked) in &report.asked {
                tr {
                    td { (owner) } td.n { (asked.all) } td.n { (asked.refused) } td.n { (asked.failed) }
                    td.n { (asked.unanswered) } td.n { (asked.cancelled) } td.n { (asked.unsent) }
                    td.n { (asked.ended) } td.n { (asked.open) }
                }
            }
        }
    }
}

fn refused(report: &Report) -> Markup {
    html! {
        h2 { "What was refused, and by which rule" }
        @if report.refused.is_empty() { p { "Nothing." } } @else {
            table {
                tr { th { "by" } th { "rule" } th.n { "times" } th.n { "first" } th { "the first one" } }
                @for refused in &report.refused {
                    tr {
                        td { (refused.owner) } td { (refused.rule) } td.n { (refused.times) }
                        td.n { (seconds(refused.first_s)) } td { (refused.text) }
                    }
                }
            }
        }
    }
}

fn flown(report: &Report) -> Markup {
    html! {
        h2 { "What was flown" }
        @if report.flown.is_empty() { p { "No insert." } } @else {
            table {
                tr { th { "request" } th { "of" } th.n { "from" } th.n { "to" } th { "end" } }
                @for flown in &report.flown {
                    tr {
                        td { (flown.kind) " " (flown.request) } td { (flown.owner) } td.n { (seconds(flown.from_s)) }
                        td.n { @if let Some(until_s) = flown.until_s { (seconds(until_s)) } } td { (flown.end) }
                    }
                }
            }
        }
    }
}

fn leases(report: &Report) -> Markup {
    html! {
        h2 { "Why leases ended" }
        @if report.leases.is_empty() { p { "None ended." } } @else {
            table {
                tr { th { "of" } th.n { "times" } th.n { "first" } th { "why" } }
                @for lease in &report.leases {
                    tr {
                        td { (lease.owner) } td.n { (lease.times) } td.n { (seconds(lease.first_s)) }
                        td { (lease.reason) }
                    }
                }
            }
        }
    }
}

fn happened(title: &str, rows: &[Happened]) -> Markup {
    html! {
        h2 { (title) }
        @if rows.is_empty() { p { "Nothing." } } @else {
            table {
                @for row in rows { tr { td.n { (seconds(row.at_s)) } td { (row.text) } } }
            }
        }
    }
}

fn seconds(at_s: f64) -> String {
    format!("{at_s:.1} s")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_log_says_is_text() {
        let evil = "<script>alert(1)</script>";
        let report = Report {
            mission: evil.to_owned(),
            log: evil.to_owned(),
            operator: vec![Happened {
                at_s: 1.0,
                text: evil.to_owned(),
            }],
            ..Report::default()
        };
        let page = page(&report);
        assert!(!page.contains("<script"), "{page}");
        assert_eq!(page.matches("&lt;script&gt;").count(), 4, "{page}");
    }
}
