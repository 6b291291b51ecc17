use std::collections::BTreeMap;

/// Topics that are counted at most. What a plugin publishes under more names is shown no more.
const TOPICS_MAX: usize = 1024;

/// Lets through one item a period of each topic.
#[derive(Debug, Default)]
pub(super) struct Thin {
    due: BTreeMap<String, f64>,
}

impl Thin {
    /// Whether [`Thin::takes`] would let an item of this topic through.
    pub(super) fn is_due(&self, topic: &str, t: f64) -> bool {
        self.due.get(topic).is_none_or(|due| t >= *due)
    }

    /// Whether an item of this topic is due at `t` seconds.
    pub(super) fn takes(&mut self, topic: &str, t: f64, every_s: f64) -> bool {
        // Whole periods, so that a rate near the period is not halved by its jitter.
        let next = (t / every_s).floor() * every_s + every_s;
        if let Some(due) = self.due.get_mut(topic) {
            let takes = t >= *due;
            if takes {
                *due = next;
            }
            return takes;
        }
        if self.due.len() >= TOPICS_MAX {
            return false;
        }
        self.due.insert(topic.to_owned(), next);
        true
    }
}
