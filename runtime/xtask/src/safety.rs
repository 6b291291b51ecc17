use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// The document with the requirements.
const DOCUMENT: &str = "runtime/docs/safety.md";
/// The document that says whom the runtime trusts, with tests.
const TRUST: &str = "runtime/docs/trust.md";
/// The number of requirements.
const REQUIREMENTS: u32 = 25;

/// A requirement in the document.
#[derive(Debug, Default, PartialEq)]
struct Requirement {
    number: String,
    code: Vec<String>,
    tests: Vec<String>,
}

/// For each test, by its name: the numbers of the requirements that it claims to test.
type Tests = BTreeMap<String, BTreeSet<String>>;

/// Checks that every requirement has code that cites it and tests that exist, and that the document names each test
/// that claims to test a requirement.
pub(crate) fn safety(root: &Path, sources: &[PathBuf], faults: &mut Vec<String>) -> Result<()> {
    let document = std::fs::read_to_string(root.join(DOCUMENT)).with_context(|| DOCUMENT.to_owned())?;
    let requirements = parse(&document);
    let mut all = Tests::new();
    for file in sources {
        let text = std::fs::read_to_string(root.join(file)).with_context(|| file.display().to_string())?;
        for (name, numbers) in tests(&text) {
            all.entry(name.to_owned()).or_default().extend(numbers);
        }
    }
    let cites = |file: &str, number: &str| {
        std::fs::read_to_string(root.join(file)).is_ok_and(|text| citations(&text).contains(number))
    };
    faults.extend(judge(&requirements, &all, cites));
    let trust = std::fs::read_to_string(root.join(TRUST)).with_context(|| TRUST.to_owned())?;
    let named = trust
        .lines()
        .filter_map(|line| line.strip_prefix("- `")?.strip_suffix('`'));
    for test in named.filter(|test| !all.contains_key(*test)) {
        faults.push(format!("{TRUST}: names the test {test}, which does not exist"));
    }
    Ok(())
}

fn judge(requirements: &[Requirement], all: &Tests, cites: impl Fn(&str, &str) -> bool) -> Vec<String> {
    let mut faults = Vec::new();
    let numbers: Vec<&str> = requirements
        .iter()
        .map(|requirement| requirement.number.as_str())
        .collect();
    let expected: Vec<String> = (1..=REQUIREMENTS).map(|number| format!("{number:03}")).collect();
    if numbers != expected {
        faults.push(format!(
            "{DOCUMENT}: has {numbers:?}, expected 001 to {REQUIREMENTS:03}, each once"
        ));
    }
    for Requirement { number, code, tests } in requirements {
        if code.is_empty() || tests.is_empty() {
            faults.push(format!("{DOCUMENT}: SR-{number} has no code or no tests"));
        }
        for file in code.iter().filter(|file| !cites(file, number)) {
            faults.push(format!("{file}: does not cite safety requirement {number}"));
        }
        for test in tests {
            match all.get(test) {
                None => faults.push(format!(
                    "{DOCUMENT}: SR-{number} names the test {test}, which does not exist"
                )),
                Some(numbers) if !numbers.contains(number) => faults.push(format!(
                    "{test}: {DOCUMENT} names it as a test of SR-{number}, but neither its name nor its comment has that number"
                )),
                Some(_) => {}
            }
        }
        let own = format!("sr_{number}");
        if !tests.iter().any(|test| test.contains(&own)) {
            faults.push(format!("{DOCUMENT}: no test of SR-{number} has the number in its name"));
        }
        let of_it = all.iter().filter(|(_, numbers)| numbers.contains(number));
        for (test, _) in of_it.filter(|(name, _)| !tests.contains(name)) {
            faults.push(format!(
                "{DOCUMENT}: SR-{number} does not name the test {test}, which claims to test it"
            ));
        }
    }
    for (test, numbers) in all {
        for number in numbers.difference(&expected.iter().cloned().collect()) {
            faults.push(format!("{test}: there is no SR-{number}"));
        }
    }
    faults
}

fn parse(document: &str) -> Vec<Requirement> {
    let mut requirements: Vec<Requirement> = Vec::new();
    let mut in_tests = false;
    for line in document.lines() {
        if let Some(head) = line.strip_prefix("## SR-") {
            requirements.push(Requirement {
                number: head.split(':').next().unwrap_or_default().to_owned(),
                ..Requirement::default()
            });
        } else if line == "Code:" {
            in_tests = false;
        } else if line == "Tests:" {
            in_tests = true;
        } else if let (Some(item), Some(requirement)) = (line.strip_prefix("- "), requirements.last_mut()) {
            let item = item.trim_matches('`').to_owned();
            if in_tests {
                requirement.tests.push(item);
            } else {
                requirement.code.push(item);
            }
        }
    }
    requirements
}

/// The test functions: what follows `#[test]`, with attributes and comments between. Each with the numbers in its name,
/// `sr_001_…`, and those that its comment cites.
fn tests(text: &str) -> impl Iterator<Item = (&str, BTreeSet<String>)> {
    let mut marked = false;
    let mut comment = String::new();
    text.lines().filter_map(move |line| {
        let line = line.trim();
        if let Some(words) = line.strip_prefix("//") {
            comment.push_str(words);
            comment.push('\n');
            return None;
        }
        if line.starts_with("#[") {
            marked |= line.starts_with("#[test]") || line.starts_with("#[tokio::test");
            return None;
        }
        let comment = core::mem::take(&mut comment);
        if !core::mem::take(&mut marked) {
            return None;
        }
        let name = line
            .trim_start_matches("async ")
            .strip_prefix("fn ")?
            .split('(')
            .next()?;
        let mut numbers = citations(&comment);
        let words: Vec<&str> = name.split('_').collect();
        numbers.extend(
            words
                .windows(2)
                .filter(|pair| pair[0] == "sr")
                .map(|pair| pair[1].to_owned()),
        );
        Some((name, numbers))
    })
}

/// The numbers that follow the words "safety requirement" in comments.
fn citations(text: &str) -> BTreeSet<String> {
    let words: Vec<&str> = text
        .split(|character: char| !character.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    let mut found = BTreeSet::new();
    for (at, pair) in words.windows(2).enumerate() {
        if pair[0].eq_ignore_ascii_case("safety") && pair[1].starts_with("requirement") {
            let numbers = words[at + 2..].iter().take_while(|word| {
                **word == "and" || word.len() == 3 && word.bytes().all(|byte| byte.is_ascii_digit())
            });
            found.extend(numbers.filter(|word| **word != "and").map(|word| (*word).to_owned()));
        }
    }
    found
}

#[cfg(test)]
mod tests_of_the_check {
    use super::*;

    fn whole() -> Vec<Requirement> {
        (1..=REQUIREMENTS)
            .map(|number| Requirement {
                number: format!("{number:03}"),
                code: vec!["a.rs".to_owned()],
                tests: vec![format!("sr_{number:03}_holds")],
            })
            .collect()
    }

    fn functions() -> Tests {
        let one = |requirement: Requirement| {
            let [test] = <[String; 1]>::try_from(requirement.tests).expect("one test");
            (test, BTreeSet::from([requirement.number]))
        };
        whole().into_iter().map(one).collect()
    }

    #[test]
    fn a_whole_table_passes_and_each_gap_is_named() {
        assert!(judge(&whole(), &functions(), |_, _| true).is_empty());
        let mut removed = functions();
        removed.remove("sr_007_holds");
        let faults = judge(&whole(), &removed, |_, _| true);
        assert_eq!(faults.len(), 1);
        assert!(faults[0].contains("sr_007_holds"), "{faults:?}");
        let mut added = functions();
        added.insert("c".to_owned(), BTreeSet::from(["007".to_owned(), "026".to_owned()]));
        let faults = judge(&whole(), &added, |_, _| true);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].contains("SR-007 does not name the test c"), "{faults:?}");
        assert!(faults[1].contains("there is no SR-026"), "{faults:?}");
        let mut another = whole();
        another[4].tests.push("sr_006_holds".to_owned());
        assert_eq!(judge(&another, &functions(), |_, _| true).len(), 1);
        let mut shorter = whole();
        shorter.remove(3);
        assert_eq!(judge(&shorter, &functions(), |_, _| true).len(), 1);
        let mut untested = whole();
        untested[4].tests.clear();
        assert_eq!(judge(&untested, &functions(), |_, _| true).len(), 3);
        assert_eq!(judge(&whole(), &functions(), |_, number| number != "012").len(), 1);
    }

    #[test]
    fn the_document_and_the_sources_are_read() {
        let document = "words\n## SR-001: a\n\nwhy\n\nCode:\n- `x.rs`\n\nTests:\n- `sr_001_b`\n- `c`\n";
        let expected = Requirement {
            number: "001".to_owned(),
            code: vec!["x.rs".to_owned()],
            tests: vec!["sr_001_b".to_owned(), "c".to_owned()],
        };
        assert_eq!(parse(document), [expected]);
        let source = "#[test]\n#[should_panic]\nfn one() {}\nfn two() {}\n    /// (Safety requirement\n    /// 003.)\n    #[test]\n    \
                      fn sr_001_sr_002_three(x: u8) {}\n#[tokio::test]\nasync fn four() {}";
        let numbers = |numbers: &[&str]| numbers.iter().map(|&number| number.to_owned()).collect::<BTreeSet<_>>();
        let expected = [
            ("one", numbers(&[])),
            ("sr_001_sr_002_three", numbers(&["001", "002", "003"])),
            ("four", numbers(&[])),
        ];
        assert_eq!(tests(source).collect::<Vec<_>>(), expected);
        let text = "//! Safety requirements 002, 009 and 019.\n// (safety\n/// requirement 021) in 10 s";
        assert_eq!(
            citations(text).into_iter().collect::<Vec<_>>(),
            ["002", "009", "019", "021"]
        );
    }
}
