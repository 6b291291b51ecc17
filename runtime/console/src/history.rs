use std::collections::VecDeque;
use std::sync::Arc;

/// How much the console keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of what happened. The oldest of it is forgotten beyond this.
    pub history_bytes: usize,
    /// Items that a browser may be behind before it has to begin again.
    pub recent: usize,
}

impl Limits {
    /// For a run that goes on: a week of a quiet one.
    pub const LIVE: Self = Self {
        history_bytes: 96 << 20,
        recent: 8192,
    };
    /// For a log, which is there as a whole.
    pub const RECORDED: Self = Self {
        history_bytes: 512 << 20,
        recent: 0,
    };
}

/// An item as the browsers get it.
#[derive(Clone, Debug)]
pub(crate) struct Numbered {
    pub(crate) n: u64,
    pub(crate) json: Arc<str>,
}

/// What happened, within bounds.
#[derive(Debug)]
pub(crate) struct History {
    limits: Limits,
    next: u64,
    kept: VecDeque<Numbered>,
    kept_bytes: usize,
    recent: VecDeque<Numbered>,
}

impl History {
    pub(crate) const fn new(limits: Limits) -> Self {
        Self {
            limits,
            next: 1,
            kept: VecDeque::new(),
            kept_bytes: 0,
            recent: VecDeque::new(),
        }
    }

    /// The number of the next item.
    pub(crate) const fn next(&self) -> u64 {
        self.next
    }

    /// Adds an item that was made with the next number. One that is not kept reaches only browsers that listen now.
    pub(crate) fn add(&mut self, json: Arc<str>, keep: bool) {
        let item = Numbered { n: self.next, json };
        self.next += 1;
        if self.limits.recent > 0 {
            self.recent.push_back(item.clone());
            if self.recent.len() > self.limits.recent {
                self.recent.pop_front();
            }
        }
        if !keep {
            return;
        }
        self.kept_bytes += item.json.len();
        self.kept.push_back(item);
        while self.kept_bytes > self.limits.history_bytes {
            let Some(oldest) = self.kept.pop_front() else { break };
            self.kept_bytes -= oldest.json.len();
        }
    }

    /// All that is kept.
    pub(crate) fn all(&self) -> Vec<Numbered> {
        self.kept.iter().cloned().collect()
    }

    /// The items after this number; `None` if some of them are gone, or if the number is of another run.
    pub(crate) fn after(&self, n: u64) -> Option<Vec<Numbered>> {
        if n >= self.next {
            return None;
        }
        if n + 1 == self.next {
            return Some(Vec::new());
        }
        let first = self.recent.front()?.n;
        if n + 1 < first {
            return None;
        }
        let skipped = (n + 1 - first) as usize;
        Some(self.recent.iter().skip(skipped).cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_is_forgotten_and_who_is_late_begins_again() {
        let mut history = History::new(Limits {
            history_bytes: 100,
            recent: 10,
        });
        for n in 1..=50u64 {
            assert_eq!(history.next(), n);
            history.add(format!("{n:010}").into(), n % 2 == 0);
        }
        let kept: Vec<u64> = history.all().iter().map(|item| item.n).collect();
        assert_eq!(kept, [32, 34, 36, 38, 40, 42, 44, 46, 48, 50]);
        let numbers = |n| {
            let items: Option<Vec<Numbered>> = history.after(n);
            items.map(|items| items.iter().map(|item| item.n).collect::<Vec<_>>())
        };
        assert_eq!(numbers(48), Some(vec![49, 50]));
        assert_eq!(numbers(50), Some(vec![]));
        assert_eq!(numbers(51), None);
        assert_eq!(numbers(40).map(|all| all.len()), Some(10));
        assert_eq!(numbers(39), None);
    }
}
