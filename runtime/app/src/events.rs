use std::time::Duration;

/// How many events a second are shown; further ones are counted.
const EVENTS_PER_S: u32 = 20;

/// What the screen shows of the events of a mock: not more than a person can read.
#[derive(Debug, Default)]
pub(crate) struct Events {
    second: u64,
    shown: u32,
    hidden: u64,
}

impl Events {
    /// Prints an event, if there were not too many in this second of real time.
    pub(crate) fn show(&mut self, now: Duration, text: &str, mut print: impl FnMut(&str)) {
        if now.as_secs() != self.second {
            self.second = now.as_secs();
            self.shown = 0;
            if self.hidden > 0 {
                let hidden = std::mem::take(&mut self.hidden);
                print(&format!("{hidden} more events; the log has them all"));
            }
        }
        self.shown += 1;
        if self.shown > EVENTS_PER_S {
            self.hidden += 1;
        } else {
            print(text);
        }
    }
}
