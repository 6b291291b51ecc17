//! The page on outcomes lists every rule, figure, state, end and count of the code.

use backseat_core::RequestCounts;
use backseat_core::ended::EndCause;
use backseat_core::refusal::{Figure, Reason, Rule, Uncontrolled};

#[test]
fn the_page_lists_every_rule_figure_state_end_and_count() {
    let page = include_str!("../../../docs/outcomes.md");
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    let mut expected: Vec<String> = Vec::new();
    expected.extend(Figure::ALL.iter().map(|figure| {
        let (name, spoken, unit, rule) = (figure.name(), figure.spoken(), figure.unit(), figure.rule());
        format!("| `{name}` | {spoken} | {unit} | `{rule}` |")
    }));
    let state = |name: &str, rule: Rule, text: &str| format!("| `{name}` | `{rule}` | {text} |");
    expected.extend(
        Uncontrolled::ALL
            .iter()
            .map(|of| state(of.name(), of.rule(), of.text())),
    );
    expected.extend(Reason::ALL.iter().map(|of| state(of.name(), of.rule(), of.text())));
    expected.extend(EndCause::ALL.iter().map(|cause| {
        let kind = serde_json::to_value(cause.kind()).unwrap();
        format!(
            "| `{}` | `{}` | {} |",
            cause.name(),
            kind.as_str().unwrap(),
            cause.text()
        )
    }));
    expected.extend(Rule::ALL.iter().map(|rule| format!("| `{rule}` | ")));
    let counts = serde_json::to_value(RequestCounts::default()).unwrap();
    expected.extend(counts.as_object().unwrap().keys().map(|name| format!("| `{name}` | ")));
    for start in &expected {
        assert!(
            rows.iter().any(|row| row.starts_with(start)),
            "no row begins with: {start}"
        );
    }
    // Beside them the page has rows for five ends and for the fifteen kinds of an end.
    assert_eq!(rows.len(), expected.len() + 5 + 15);
}
