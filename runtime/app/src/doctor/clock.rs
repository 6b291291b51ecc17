//! The clock, and whether something keeps it right.

use std::process::Command;

use backseat_fence::Rfc3339;
use backseat_units::Utc;

use super::{Finding, Word};
use crate::check::machine::{CLOCK_MAX, CLOCK_MIN};
use crate::clock::Clock;

pub(super) fn findings() -> Vec<Finding> {
    let now = Clock::start().utc_at_start();
    vec![
        time(now),
        kept(
            &output("chronyc", &["-n", "tracking"]),
            &output("timedatectl", &["show"]),
        ),
    ]
}

fn time(now: Utc) -> Finding {
    let text = Rfc3339(Utc::from_unix_nanos(
        now.as_unix_nanos() / 1_000_000_000 * 1_000_000_000,
    ))
    .to_string();
    if (CLOCK_MIN..=CLOCK_MAX).contains(&now) {
        Finding::new("clock", Word::Ok, text)
    } else {
        Finding::new("clock", Word::Bad, format!("{text}: set it"))
    }
}

/// What a program prints, if it is there and ends well.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Whether chrony or systemd keeps the clock, from what they print.
fn kept(chrony: &Option<String>, systemd: &Option<String>) -> Finding {
    let what = "clock's source";
    if let Some(tracking) = chrony {
        let field = |name: &str| {
            let line = tracking.lines().find(|line| line.starts_with(name))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let offset = field("System time").unwrap_or_default();
        return match field("Leap status").as_deref() {
            Some("Normal") => Finding::new(what, Word::Ok, format!("chrony: {offset}")),
            Some(other) => Finding::new(
                what,
                Word::Odd,
                format!("chrony: {other}: no source keeps this clock right"),
            ),
            None => Finding::new(what, Word::Odd, "chrony says nothing of its source"),
        };
    }
    let synchronized = systemd
        .as_ref()
        .map(|text| text.lines().any(|line| line == "NTPSynchronized=yes"));
    match synchronized {
        Some(true) => Finding::new(what, Word::Ok, "synchronized"),
        Some(false) => Finding::new(
            what,
            Word::Odd,
            "not synchronized: zones with a time window depend on this clock; have chrony follow the vehicle's NTP",
        ),
        None => Finding::new(
            what,
            Word::Odd,
            "neither chronyc nor timedatectl says whether something keeps it right",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chrony_and_systemd_say_whether_the_clock_is_kept() {
        let chrony = |leap: &str| {
            Some(format!(
                "Reference ID    : 0A000001\nSystem time     : 0.000012 seconds slow of NTP time\nLeap status     : {leap}\n"
            ))
        };
        let systemd = |yes: &str| Some(format!("Timezone=UTC\nNTPSynchronized={yes}\n"));
        assert_eq!(kept(&chrony("Normal"), &None).word, Word::Ok);
        assert_eq!(kept(&chrony("Not synchronised"), &systemd("yes")).word, Word::Odd);
        assert_eq!(kept(&None, &systemd("yes")).word, Word::Ok);
        assert_eq!(kept(&None, &systemd("no")).word, Word::Odd);
        assert_eq!(kept(&None, &None).word, Word::Odd);
        assert!(kept(&chrony("Normal"), &None).text.contains("0.000012 seconds slow"));
        assert_eq!(time(Utc::from_unix_nanos(0)).word, Word::Bad);
    }
}
