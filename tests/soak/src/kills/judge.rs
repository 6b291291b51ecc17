use std::collections::BTreeSet;

use backseat_suite::{Line, Way};

use super::plan::{Act, Plan, Subject};
use super::trial::{BACK, FAULT, Record};

/// One step of the vehicle, seconds: a lapse is noticed within this time.
const TICK_S: f64 = 0.1;
/// Bytes that had left the runtime when its fault began are received within this time, seconds.
const UNDER_WAY_S: f64 = 0.25;
/// A suspension that lasts longer is always noticed, seconds: core has promised to wake within a second at the latest,
/// and a wake-up more than half a second later ends every lease. A shorter suspension may not be noticed, but what is
/// sent after it has been judged after it.
const NOTICED_S: f64 = 1.6;
/// Output that was judged longer ago is not sent, seconds: the driver's limit of half a second.
const JUDGED_WITHIN_S: f64 = 0.6;
/// The precision of clocks, a millisecond.
const ROUNDED_S: f64 = 0.002;
/// The mission's limit on open inserts.
const INSERTS_OPEN_MAX: usize = 4;

/// The results of a trial, from the vehicle's log.
#[derive(Clone, Debug, Default)]
pub(super) struct Verdict {
    /// From the last refresh that it received to the end, seconds; `None` if the lease continued.
    pub(super) after_last_s: Option<f64>,
    /// From the fault to the end, seconds; for SIGTERM, from the process's end.
    pub(super) after_fault_s: Option<f64>,
    /// From when the runtime could act again to its next refresh, seconds.
    pub(super) again_s: Option<f64>,
    /// Whether a lease was active when the fault began.
    pub(super) stood: bool,
    /// The identifiers that were used.
    pub(super) identifiers: usize,
    /// Everything that is not as required.
    pub(super) misses: Vec<String>,
}

/// Judges a trial.
pub(super) fn judge(plan: &Plan, record: &Record) -> Verdict {
    let mut verdict = Verdict::default();
    let lines = &record.lines;
    let Some(fault) = mark(lines, FAULT) else {
        verdict
            .misses
            .push("the vehicle's log has no mark of the fault".to_owned());
        return verdict;
    };
    let back = mark(lines, BACK);
    if let Some(panic) = &record.panic {
        verdict.misses.push(format!("the runtime panicked: {panic}"));
    }
    if let Some(exit) = record.exit
        && exit != Some(0)
    {
        verdict.misses.push(format!("it ended with {exit:?}"));
    }
    silence(plan, lines, fault, back, &mut verdict);
    match plan.subject {
        Subject::Modify | Subject::Station => {
            lapses(plan, lines, &mut verdict);
            end(plan, lines, fault, &mut verdict);
            if let Some(back) = back {
                again(plan, record, fault, back, &mut verdict);
            }
        }
        Subject::Insert => {
            if let Some(back) = back {
                stale(plan, record, back, &mut verdict);
            }
        }
    }
    identifiers(lines, &mut verdict);
    verdict
}

/// The index of our mark with this text in the log.
fn mark(lines: &[Line], text: &str) -> Option<usize> {
    lines
        .iter()
        .position(|line| line.is_received("BPMSG") && line.field(2) == text)
}

fn is_end(subject: Subject, line: &Line) -> bool {
    let begin = match subject {
        Subject::Modify | Subject::Insert => "modify ended: ",
        Subject::Station => "suspension ended: ",
    };
    line.way == Way::Event && line.text.starts_with(begin)
}

fn is_release(subject: Subject, line: &Line) -> bool {
    line.is_received(match subject {
        Subject::Modify | Subject::Insert => "BPEMB",
        Subject::Station => "BPRES",
    })
}

/// A runtime that is not running sends nothing.
fn silence(plan: &Plan, lines: &[Line], fault: usize, back: Option<usize>, verdict: &mut Verdict) {
    let from_s = lines[fault].at_s + UNDER_WAY_S;
    let restarted = plan.subject == Subject::Insert && back.is_none();
    let to = if restarted { fault } else { back.unwrap_or(lines.len()) };
    for line in &lines[fault.min(to)..to] {
        if line.at_s > from_s && plan.subject.is_refresh(line) {
            verdict.misses.push(format!(
                "received {:.3} s after the fault: {}",
                line.at_s - lines[fault].at_s,
                line.text
            ));
        }
    }
}

/// In the whole log, everything that was refreshed has ended in time.
fn lapses(plan: &Plan, lines: &[Line], verdict: &mut Verdict) {
    let most_s = plan.subject.lasts_s() + TICK_S + ROUNDED_S;
    let mut last: Option<&Line> = None;
    let mut late = |last: &Line, at_s: f64, what: &str| {
        if at_s - last.at_s > most_s {
            verdict.misses.push(format!(
                "{what} {:.3} s after the last that was received",
                at_s - last.at_s
            ));
        }
    };
    for line in lines {
        if plan.subject.is_refresh(line) {
            last = Some(line);
        } else if is_end(plan.subject, line)
            && let Some(last) = last.take()
        {
            late(last, line.at_s, "it ended");
        }
    }
    // A refused suspension begins nothing, but in these missions none is refused unless control is lost.
    if let (Some(last), Some(end)) = (last, lines.last()) {
        late(last, end.at_s, "it stood");
    }
}

/// The time to the end, from the last refresh before the fault took effect.
fn end(plan: &Plan, lines: &[Line], fault: usize, verdict: &mut Verdict) {
    let under_way = |line: &&Line| line.at_s <= lines[fault].at_s + UNDER_WAY_S;
    let before = lines.iter().take_while(under_way).count();
    let steered = lines[..before]
        .iter()
        .rposition(|line| plan.subject.is_refresh(line))
        .expect("a trial begins when it has steered");
    let next = lines[steered + 1..]
        .iter()
        .find(|line| plan.subject.is_refresh(line) || is_end(plan.subject, line));
    let ended = next.filter(|line| is_end(plan.subject, line));
    verdict.stood = ended.is_none_or(|ended| ended.at_s >= lines[fault].at_s) || plan.act == Act::Terminate;
    if let Some(ended) = ended.filter(|_| verdict.stood) {
        verdict.after_last_s = Some(ended.at_s - lines[steered].at_s);
        verdict.after_fault_s = Some(ended.at_s - lines[fault].at_s);
    }
    if plan.act == Act::Terminate && !lines[steered..].iter().any(|line| is_release(plan.subject, line)) {
        verdict
            .misses
            .push("told to end, it did not hand back control".to_owned());
    }
}

/// What the runtime does when it can act again.
fn again(plan: &Plan, record: &Record, fault: usize, back: usize, verdict: &mut Verdict) {
    let lines = &record.lines;
    let first = lines[back..].iter().find(|line| plan.subject.is_refresh(line));
    verdict.again_s = first.map(|line| line.at_s - lines[back].at_s);
    if first.is_none() {
        verdict.misses.push("it never steered again".to_owned());
    }
    stale(plan, record, back, verdict);
    let Some(first) = first else { return };
    let noticed = plan.act.lasts().is_some_and(|lasts| lasts.as_secs_f64() > NOTICED_S);
    if !noticed && !plan.act.is_cut() {
        return;
    }
    let before = lines[..fault].iter().rfind(|line| plan.subject.is_refresh(line));
    if before.is_some_and(|before| before.client != first.client) {
        // On another connection, everything of the previous one has ended.
        return;
    }
    if plan.act.is_cut() {
        verdict
            .misses
            .push(format!("sent on a connection that was cut: {}", first.text));
    } else if verdict.stood {
        let release = lines[back..].iter().position(|line| is_release(plan.subject, line));
        let refresh = lines[back..].iter().position(|line| plan.subject.is_refresh(line));
        if release.is_none() || release > refresh {
            verdict.misses.push(format!(
                "it continued to steer without ending the earlier lease: {}",
                first.text
            ));
        }
    }
}

/// Output that was judged before the runtime could act again is not sent.
fn stale(plan: &Plan, record: &Record, back: usize, verdict: &mut Verdict) {
    let Some(back_s) = record.back_utc_s else { return };
    if plan
        .act
        .lasts()
        .is_some_and(|lasts| lasts.as_secs_f64() <= JUDGED_WITHIN_S)
        && !plan.act.is_cut()
    {
        return;
    }
    for line in &record.lines[back..] {
        if !plan.subject.is_refresh(line) {
            continue;
        }
        let Some(made_s) = seconds_of_day(line.field(1)) else {
            verdict.misses.push(format!("no time in {}", line.text));
            continue;
        };
        // Half a day in either direction, because it may be midnight in between.
        let later_s = (made_s - back_s + 43_200.0).rem_euclid(86_400.0) - 43_200.0;
        if later_s < -ROUNDED_S {
            verdict.misses.push(format!(
                "made {:.3} s before it could act again, and sent: {}",
                -later_s, line.text
            ));
        }
    }
}

fn seconds_of_day(time: &str) -> Option<f64> {
    let part = |range: std::ops::Range<usize>| time.get(range)?.parse::<f64>().ok();
    Some(part(0..2)? * 3600.0 + part(2..4)? * 60.0 + part(4..time.len())?)
}

/// No identifier is used twice, and no more inserts are open than the mission allows.
fn identifiers(lines: &[Line], verdict: &mut Verdict) {
    let (mut used, mut open) = (BTreeSet::new(), BTreeSet::new());
    for line in lines {
        if ["BPRTK", "BPRTC", "BPRGP"].iter().any(|name| line.is_received(name)) && !used.insert(line.field(2)) {
            verdict.misses.push(format!("an identifier twice: {}", line.text));
        }
        if line.way != Way::Event {
            continue;
        }
        let words: Vec<&str> = line.text.split(' ').collect();
        match words.as_slice() {
            ["insert", id, .., "accepted"] => {
                open.insert((*id).to_owned());
            }
            ["insert", id, "cancelled:", ..] | ["inserted", _, id, "ended:", ..] => {
                open.remove(*id);
            }
            _ => {}
        }
        if open.len() > INSERTS_OPEN_MAX {
            verdict
                .misses
                .push(format!("{} inserts are open: {open:?}", open.len()));
        }
    }
    verdict.identifiers = used.len();
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn line(at_s: f64, way: Way, client: u32, text: &str) -> Line {
        Line {
            at_s,
            way,
            client,
            text: text.to_owned(),
        }
    }

    fn received(at_s: f64, client: u32, text: &str) -> Line {
        line(at_s, Way::Received, client, text)
    }

    fn event(at_s: f64, text: &str) -> Line {
        line(at_s, Way::Event, 0, text)
    }

    fn mark(at_s: f64, text: &str) -> Line {
        received(at_s, 1, &format!("$BPMSG,000000.000,{text}"))
    }

    /// A modify with this second after noon as its creation time.
    fn modify(at_s: f64, client: u32, made_s: u32) -> Line {
        received(
            at_s,
            client,
            &format!("$BPRMB,12{:02}{:02}.000,90,8,0,1.5,1,0*00", made_s / 60, made_s % 60),
        )
    }

    fn misses(act: Act, lines: Vec<Line>) -> Vec<String> {
        let plan = Plan {
            number: 1,
            subject: Subject::Modify,
            act,
            after: Duration::ZERO,
        };
        let back = act.lasts().map(|lasts| 12.0 * 3600.0 + 10.5 + lasts.as_secs_f64());
        let record = Record {
            lines,
            back_utc_s: back,
            exit: (act == Act::Terminate).then_some(Some(0)),
            ..Record::default()
        };
        judge(&plan, &record).misses
    }

    #[track_caller]
    fn one(misses: &[String], word: &str) {
        assert_eq!(misses.len(), 1, "{misses:?}");
        assert!(misses[0].contains(word), "{misses:?}");
    }

    #[test]
    fn a_kill_is_judged_by_silence_and_by_the_lapse() {
        let lapses = |at_s| {
            vec![
                modify(9.0, 2, 9),
                modify(10.0, 2, 10),
                mark(10.5, FAULT),
                event(at_s, "modify ended: 5 s without a refresh"),
                event(20.0, "the clock"),
            ]
        };
        assert!(misses(Act::Kill, lapses(15.0)).is_empty());
        one(&misses(Act::Kill, lapses(15.2)), "it ended 5.200 s after");
        let mut stands = lapses(15.0);
        stands.remove(3);
        one(&misses(Act::Kill, stands), "it stood 10.000 s after");
        let mut heard = lapses(15.0);
        heard.insert(3, modify(11.0, 2, 11));
        one(&misses(Act::Kill, heard), "received 0.500 s after the fault");
        let mut under_way = lapses(15.1);
        under_way.insert(3, modify(10.6, 2, 10));
        assert!(misses(Act::Kill, under_way).is_empty());
    }

    #[test]
    fn who_was_suspended_ends_what_stood_and_sends_nothing_old() {
        let goes_on = |then: Vec<Line>| {
            let mut lines = vec![modify(10.0, 2, 10), mark(10.5, FAULT), mark(13.5, BACK)];
            lines.extend(then);
            misses(Act::Pause(Duration::from_secs(3)), lines)
        };
        let (release, ended) = (
            received(13.6, 2, "$BPEMB,1*00"),
            event(13.6, "modify ended: by the payload"),
        );
        assert!(goes_on(vec![release.clone(), ended.clone(), modify(14.0, 2, 14)]).is_empty());
        one(&goes_on(vec![modify(13.6, 2, 14)]), "without ending the earlier lease");
        one(
            &goes_on(vec![release.clone(), ended.clone(), modify(14.0, 2, 12)]),
            "made 1.500 s before it could act again",
        );
        one(&goes_on(vec![release, ended]), "never steered again");
        assert!(goes_on(vec![modify(14.0, 3, 14)]).is_empty(), "a connection of its own");
    }

    #[test]
    fn nothing_comes_over_a_connection_that_was_cut() {
        let cut = |then: Line| {
            let lines = vec![modify(10.0, 2, 10), mark(10.5, FAULT), mark(12.5, BACK), then];
            misses(Act::Reset(Duration::from_secs(2)), lines)
        };
        assert!(cut(modify(13.0, 3, 13)).is_empty());
        one(&cut(modify(13.0, 2, 13)), "a connection that was cut");
        one(&cut(modify(13.0, 3, 12)), "made 0.500 s before");
    }

    #[test]
    fn who_is_told_to_end_gives_the_helm_back() {
        let ends = |release: &str| {
            let lines = vec![
                modify(10.0, 2, 10),
                received(10.4, 2, release),
                event(10.4, "modify ended: by the payload"),
                mark(10.5, FAULT),
            ];
            misses(Act::Terminate, lines)
        };
        assert!(ends("$BPEMB,1*00").is_empty());
        one(&ends("$BPSTS,1*00"), "did not hand back control");
    }

    #[test]
    fn no_identifier_twice_and_no_more_open_than_the_cap() {
        let mut lines = vec![modify(10.0, 2, 10), event(10.1, "modify ended: by the payload")];
        lines.push(mark(10.5, FAULT));
        for id in [7, 8, 7] {
            lines.push(received(11.0, 2, &format!("$BPRTK,120000.000,{id},42*00")));
        }
        one(&misses(Act::Kill, lines.clone()), "twice");
        lines.truncate(3);
        lines.extend((1..=5).map(|id| event(12.0, &format!("insert {id} of client 2 accepted"))));
        one(&misses(Act::Kill, lines.clone()), "5 inserts are open");
        lines.insert(6, event(12.0, "inserted trackline 2 ended: done"));
        assert!(misses(Act::Kill, lines).is_empty());
    }
}
