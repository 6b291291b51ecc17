//! Every section of SPI 1.12a that says what the vehicle does, with a sentence of it and a conversation that shows it.

mod command_messages;
mod communications;
mod dives;
mod hovering;
mod readings;
mod requests;
mod session;
mod status_messages;

use std::collections::BTreeSet;

use backseat_mvc::{DiveError, Mvc, Truth};
use backseat_spi::catalogue;
use backseat_units::Timestamp;

use crate::files::CALM;
use crate::hovering::HARBOUR;
use crate::payload::{ME, Payload};

/// A section and what it promises.
pub(crate) struct Section {
    /// Its number: `7.12`.
    number: &'static str,
    /// The promise, in the section's words.
    says: &'static str,
    /// The world of the conversation.
    world: World,
    /// The messages that are switched on at the connection. The answers to that are not part of the conversation.
    on: &'static [&'static str],
    talk: &'static [Step],
}

/// How a conversation's world differs from [`CALM`].
pub(crate) enum World {
    Calm,
    /// A hovering vehicle beside a ship.
    Harbour,
    /// The calm world with these lines, each after the header of its section: `[mission]`, `wrap_up = "surface"`.
    With(&'static [(&'static str, &'static str)]),
}

/// A step of a conversation.
pub(crate) enum Step {
    /// The time passes until this many seconds after the start.
    Until(f64),
    /// The vehicle's operator does this, and it is not refused.
    Operate(&'static str, fn(&mut Mvc, Timestamp) -> Result<(), DiveError>),
    /// The client sends this.
    Say(&'static str),
    /// The vehicle has sent a sentence that begins like this, after the one that was found last.
    Hear(&'static str),
    /// The vehicle has sent no sentence that begins like this since the one that was found last.
    Never(&'static str),
    /// The condition holds for the vehicle.
    Is(&'static str, fn(&Truth) -> bool),
    /// The condition comes to hold for the vehicle within this many seconds.
    Becomes(f64, &'static str, fn(&Truth) -> bool),
    /// Forgets the sentences that were received so far.
    Forget,
}

fn sections() -> impl Iterator<Item = &'static Section> {
    session::SECTIONS
        .iter()
        .chain(command_messages::SECTIONS)
        .chain(status_messages::SECTIONS)
        .chain(requests::SECTIONS)
        .chain(hovering::SECTIONS)
        .chain(communications::SECTIONS)
        .chain(dives::SECTIONS)
        .chain(readings::SECTIONS)
}

fn world(of: &World) -> String {
    let mut text = match of {
        World::Calm | World::With(_) => CALM.to_owned(),
        World::Harbour => HARBOUR.to_owned(),
    };
    if let World::With(lines) = of {
        for (header, line) in *lines {
            let head = format!("{header}\n");
            let key = line.split('=').next().unwrap_or("").trim();
            if header.starts_with("[[") {
                text = format!("{text}\n{head}{line}\n");
                continue;
            }
            if !text.contains(&head) {
                text = format!("{text}\n{head}");
            }
            let at = text.find(&head).expect("it was put there") + head.len();
            let end = text[at..].find("\n[").map_or(text.len(), |length| at + length + 1);
            let body: String = text[at..end]
                .lines()
                .filter(|old| old.split('=').next().is_none_or(|old| old.trim() != key))
                .map(|old| format!("{old}\n"))
                .collect();
            text = format!("{}{line}\n{body}{}", &text[..at], &text[end..]);
        }
    }
    text
}

/// Holds the conversation. An error says where it went differently.
fn talk(section: &Section) -> Result<(), String> {
    let mut payload = Payload::new(&world(&section.world), 1);
    payload.connect(ME);
    let mut heard = payload.all_heard();
    for message in section.on {
        payload.say(&format!("$BPLOG,{message},ON"));
    }
    payload.all_heard();
    for (number, step) in (1..).zip(section.talk) {
        heard.extend(payload.all_heard());
        let holds = match step {
            Step::Until(seconds) => {
                payload.until(*seconds);
                true
            }
            Step::Operate(_, act) => payload.operate(act).is_ok(),
            Step::Say(sentence) => {
                payload.say(sentence);
                true
            }
            Step::Forget => {
                heard.clear();
                true
            }
            Step::Hear(begin) => match heard.iter().position(|line| line.starts_with(begin)) {
                Some(found) => {
                    heard.drain(..=found);
                    true
                }
                None => false,
            },
            Step::Never(begin) => !heard.iter().any(|line| line.starts_with(begin)),
            Step::Is(_, is) => is(&payload.mvc.truth()),
            Step::Becomes(seconds, _, is) => payload.until_that(payload.now.as_secs_f64() + seconds, is),
        };
        if !holds {
            let what = match step {
                Step::Hear(begin) => format!("no {begin} among {heard:#?}"),
                Step::Never(begin) => format!("{begin} among {heard:#?}"),
                Step::Operate(what, _) => format!("refused: {what}: {:?}", payload.mvc.mission_status()),
                Step::Is(what, _) | Step::Becomes(_, what, _) => format!("not: {what}: {:?}", payload.mvc.truth()),
                Step::Until(_) | Step::Say(_) | Step::Forget => String::new(),
            };
            let (section, says, now) = (section.number, section.says, payload.now);
            return Err(format!("{section}, \"{says}\", step {number} at {now}: {what}"));
        }
    }
    Ok(())
}

#[test]
fn the_vehicle_keeps_what_each_section_promises() {
    let failures: Vec<String> = sections().filter_map(|section| talk(section).err()).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_section_has_a_conversation() {
    let covered: BTreeSet<&str> = sections().map(|section| section.number).collect();
    let mut expected: BTreeSet<&str> = catalogue().iter().map(|entry| entry.section).collect();
    // These sections describe no message.
    expected.extend(["4.1", "4.2", "4.3", "4.4"]);
    assert_eq!(expected.len(), 75);
    let missing: Vec<_> = expected.difference(&covered).collect();
    let unknown: Vec<_> = covered.difference(&expected).collect();
    assert!(
        missing.is_empty() && unknown.is_empty(),
        "missing {missing:?}, unknown {unknown:?}"
    );
}

#[test]
fn every_message_occurs_in_the_conversation_of_its_section() {
    for entry in catalogue().iter().filter(|entry| entry.name.starts_with("BP")) {
        let said = sections()
            .filter(|section| section.number == entry.section)
            .flat_map(|section| section.talk)
            .any(|step| matches!(step, Step::Say(sentence) if sentence.contains(entry.name)));
        assert!(said, "{} {}", entry.section, entry.name);
    }
    for entry in catalogue().iter().filter(|entry| entry.name.starts_with("BF")) {
        let heard = sections()
            .filter(|section| section.number == entry.section)
            .flat_map(|section| section.talk)
            .any(|step| matches!(step, Step::Hear(sentence) if sentence.contains(entry.name)));
        assert!(heard, "{} {}", entry.section, entry.name);
    }
}
