use std::collections::BTreeSet;

use backseat_spi::CommandName;
use backseat_units::Timestamp;

use super::{Beginning, Order, Rule, Script, Trigger};
use crate::event::{Behavior, Source};

/// How many firings of rules may wait for their time. What would start more is ignored.
const WAITING_MAX: usize = 10_000;
/// How often the rules of a run fire in all.
const FIRINGS_MAX: u32 = 100_000;

/// The rules of a run: what each of them has seen, and when it fires.
#[derive(Debug, Default)]
pub(crate) struct Rules {
    rules: Vec<Watched>,
    /// The firings to come, in their order: by time, then by the rule's place. So a rule fires once at one instant.
    due: BTreeSet<(Timestamp, usize)>,
    fired: u32,
}

#[derive(Debug)]
struct Watched {
    rule: Rule,
    /// How often it has seen what it waits for.
    seen: u32,
    fired_at: Option<Timestamp>,
}

/// Something that a rule may wait for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Seen {
    Connected,
    Received(CommandName),
    Began(Behavior),
}

impl Rules {
    pub(crate) fn new(script: Script) -> Self {
        let mut rules = Self::default();
        for (index, rule) in script.rules.into_iter().enumerate() {
            if let Trigger::At(at) = rule.when {
                rules.due.insert((at + rule.after, index));
            }
            rules.rules.push(Watched {
                rule,
                seen: 0,
                fired_at: None,
            });
        }
        rules
    }

    /// Something has happened. Every rule that has waited for it fires at its time, at the earliest now.
    pub(crate) fn see(&mut self, now: Timestamp, seen: Seen) {
        if self.fired >= FIRINGS_MAX {
            return;
        }
        for (index, watched) in self.rules.iter_mut().enumerate() {
            if !watched.rule.when.is(seen) {
                continue;
            }
            watched.seen = watched.seen.saturating_add(1);
            let (seen, rule) = (watched.seen, &watched.rule);
            let meant = seen == rule.nth || rule.again && seen > rule.nth;
            let at = now + rule.after;
            // What a rule orders can be what it waits for: without this it would fire for ever at one instant.
            if meant && self.due.len() < WAITING_MAX && watched.fired_at != Some(at) {
                self.due.insert((at, index));
            }
        }
    }

    /// When the next rule fires; [`Timestamp::MAX`] means never.
    pub(crate) fn next(&self) -> Timestamp {
        self.due.first().map_or(Timestamp::MAX, |(at, _)| *at)
    }

    /// The number of the next rule that fires by `now`, from 1, and what it orders.
    pub(crate) fn next_due(&mut self, now: Timestamp) -> Option<(u32, Order)> {
        let (at, index) = self.due.first().copied().filter(|(at, _)| *at <= now)?;
        self.due.pop_first();
        self.fired += 1;
        if self.fired >= FIRINGS_MAX {
            self.due.clear();
        }
        let watched = &mut self.rules[index];
        watched.fired_at = Some(at);
        let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
        Some((number, watched.rule.order.clone()))
    }
}

impl Trigger {
    fn is(&self, seen: Seen) -> bool {
        match (self, seen) {
            (Self::Connected, Seen::Connected) => true,
            (Self::Received(name), Seen::Received(seen)) => *name == seen,
            (Self::Began(Beginning::Any), Seen::Began(_)) => true,
            (Self::Began(Beginning::Insert), Seen::Began(behavior)) => match behavior.source {
                Source::Insert(_) => true,
                Source::Plan(_) | Source::Empty => false,
            },
            (Self::Began(Beginning::Kind(kind)), Seen::Began(behavior)) => *kind == behavior.kind,
            (
                Self::At(_) | Self::Connected | Self::Received(_) | Self::Began(_),
                Seen::Connected | Seen::Received(_) | Seen::Began(_),
            ) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use backseat_spi::BehaviorId;

    use super::*;

    fn rules(text: &str) -> Rules {
        Rules::new(Script::from_toml(text).expect("the test's script is right"))
    }

    fn name(name: &str) -> Seen {
        Seen::Received(CommandName::new(name).expect("a name"))
    }

    fn at(seconds: u64) -> Timestamp {
        Timestamp::from_secs(seconds)
    }

    /// The numbers of the rules that fire by then.
    fn fired(rules: &mut Rules, by: u64) -> Vec<u32> {
        core::iter::from_fn(|| rules.next_due(at(by)).map(|(number, _)| number)).collect()
    }

    #[test]
    fn a_rule_fires_some_time_after_the_nth_and_once() {
        let mut rules = rules("[[rule]]\nwhen = { received = \"BPRMB\" }\nnth = 2\nafter_s = 3\ndo = \"abort\"");
        rules.see(at(10), name("RMB"));
        rules.see(at(11), name("EMB"));
        assert_eq!(rules.next(), Timestamp::MAX);
        rules.see(at(12), name("RMB"));
        rules.see(at(13), name("RMB"));
        assert_eq!(rules.next(), at(15));
        assert_eq!(fired(&mut rules, 14), []);
        assert_eq!(fired(&mut rules, 15), [1]);
        assert_eq!(fired(&mut rules, 1000), []);
    }

    #[test]
    fn a_rule_that_acts_again_fires_for_each_from_the_nth_on() {
        let mut rules = rules("[[rule]]\nwhen = \"connected\"\nnth = 2\nagain = true\nafter_s = 10\ndo = \"shutdown\"");
        for second in 1..=4 {
            rules.see(at(second), Seen::Connected);
        }
        // Two at one instant are one.
        rules.see(at(4), Seen::Connected);
        assert_eq!(fired(&mut rules, 100), [1, 1, 1]);
    }

    #[test]
    fn times_come_by_themselves_and_at_one_instant_the_first_rule_comes_first() {
        let mut rules = rules(
            "[[rule]]\nwhen = \"connected\"\nafter_s = 2\ndo = \"abort\"\n\
             [[rule]]\nwhen = { at_s = 4 }\nafter_s = 1\ndo = \"abort\"\n\
             [[rule]]\nwhen = { at_s = 1 }\ndo = \"abort\"",
        );
        rules.see(at(3), Seen::Connected);
        assert_eq!((rules.next(), fired(&mut rules, 5)), (at(1), vec![3, 1, 2]));
    }

    #[test]
    fn behaviors_are_known_by_their_type_or_as_inserts() {
        let began = |source, kind| Seen::Began(Behavior { source, kind });
        let mut rules = rules(
            "[[rule]]\nwhen = { began = \"any\" }\ndo = \"abort\"\n\
             [[rule]]\nwhen = { began = \"insert\" }\ndo = \"abort\"\n\
             [[rule]]\nwhen = { began = \"trackcircle\" }\ndo = \"abort\"",
        );
        rules.see(at(1), began(Source::Plan(1), "trackline"));
        assert_eq!(fired(&mut rules, 1), [1]);
        let id = BehaviorId::new(7);
        rules.see(at(2), began(Source::Insert(id), "trackcircle"));
        assert_eq!(fired(&mut rules, 2), [2, 3]);
    }

    #[test]
    fn a_rule_that_brings_about_what_it_waits_for_fires_once_at_one_instant() {
        let mut rules = rules("[[rule]]\nwhen = { began = \"any\" }\nagain = true\ndo = \"abort\"");
        let began = Seen::Began(Behavior {
            source: Source::Plan(1),
            kind: "trackline",
        });
        for second in [1, 2] {
            rules.see(at(second), began);
            assert_eq!(fired(&mut rules, second), [1]);
            rules.see(at(second), began);
            assert_eq!(fired(&mut rules, second), []);
        }
    }

    #[test]
    fn a_flood_of_what_a_rule_waits_for_is_bounded() {
        let mut rules = rules("[[rule]]\nwhen = \"connected\"\nagain = true\nafter_s = 1e6\ndo = \"abort\"");
        for second in 0..2 * WAITING_MAX as u64 {
            rules.see(at(second), Seen::Connected);
        }
        assert_eq!(fired(&mut rules, 100_000_000).len(), WAITING_MAX);
        for second in 0..2 * u64::from(FIRINGS_MAX) {
            rules.see(at(2_000_000 + second), Seen::Connected);
            while rules.next_due(at(100_000_000)).is_some() {}
        }
        assert_eq!(rules.fired, FIRINGS_MAX);
        assert_eq!(rules.next(), Timestamp::MAX);
    }
}
