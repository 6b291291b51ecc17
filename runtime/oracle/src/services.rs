//! What does not move the vehicle: the triggering of the DVL, acoustic packets, silent mode, messages, and BFSHT, which
//! announces that power will go.

use std::collections::VecDeque;
use std::time::Duration;

use crate::moment::Moment;
use crate::time_of_day::{Echo, TimeOfDay};

use crate::limits::{Caps, seconds};
use crate::rule::Rule;
use crate::violation::Findings;

/// How soon the runtime answers the order to stop triggering: the plugin's time and some more.
const CEASE_WITHIN: Duration = Duration::from_millis(1300);
/// How long after BFSHT we may send anything, and some more.
const LAST_WORD: Duration = Duration::from_millis(10_500);
/// Silence that ends within this time may be requested again.
const SILENCE_SLACK: Duration = Duration::from_secs(1);

/// External triggering of the DVL (SPI 5.6, 7.4).
#[derive(Clone, Debug, Default)]
pub(crate) struct Trigger {
    leave: bool,
    /// When the vehicle withdrew the permission.
    ceased: Option<Moment>,
    external: bool,
    triggering: bool,
    cease_due: Option<Moment>,
}

impl Trigger {
    /// The vehicle sent BFDVT. `hears` is true if we can answer; `heard` is the latest time at which we hear it.
    pub(crate) fn vehicle_says(&mut self, at: Moment, begin: bool, heard: Moment, hears: bool) {
        self.leave = begin;
        self.ceased = (!begin).then_some(at);
        if begin {
            self.cease_due = None;
        } else if self.triggering && hears {
            self.cease_due.get_or_insert(heard + CEASE_WITHIN);
        }
    }

    /// We sent BPDVR. We have certainly heard what the vehicle sent before `heard`.
    pub(crate) fn we_say(
        &mut self,
        at: Moment,
        external: bool,
        triggering: bool,
        heard: Moment,
        findings: &mut Findings,
    ) {
        if triggering {
            findings.judge(Rule::TriggerWithoutLeave);
        }
        if triggering && !self.leave && self.ceased.is_none_or(|ceased| ceased < heard) {
            findings.add(at, Rule::TriggerWithoutLeave, || match self.ceased {
                Some(ceased) => format!("BPDVR says that we trigger, although BFDVT 0 came at {ceased}"),
                None => "BPDVR says that we trigger, although no BFDVT 1 has come".to_owned(),
            });
        }
        if !triggering && self.cease_due.take().is_some() {
            findings.judge(Rule::TriggerNotCeased);
        }
        (self.external, self.triggering) = (external, triggering);
    }

    /// Whether BPDVR with this request asks for external triggering that was not requested before.
    pub(crate) const fn asks_anew(&self, external: bool) -> bool {
        external && !self.external
    }

    pub(crate) fn check(&mut self, now: Moment, findings: &mut Findings) {
        if let Some(due) = self.cease_due.take_if(|due| now > *due) {
            findings.judge(Rule::TriggerNotCeased);
            findings.add(now, Rule::TriggerNotCeased, || {
                format!("no BPDVR by {due} that says that triggering has stopped, as BFDVT 0 demands")
            });
        }
    }

    /// We cannot send anything any more.
    pub(crate) fn cut(&mut self) {
        self.cease_due = None;
    }

    /// The record has a gap: triggering may be permitted, and may have been requested.
    pub(crate) fn forget(&mut self) {
        *self = Self {
            leave: true,
            external: true,
            ..Self::default()
        };
    }
}

/// The vehicle's windows for acoustic packets (SPI 9.1).
#[derive(Clone, Debug, Default)]
pub(crate) struct Acoustic {
    open_until: Option<Moment>,
    /// A window may be open whose end is in a gap of the record.
    unseen: bool,
}

impl Acoustic {
    /// The vehicle gave a window. It is over when its length has passed since the vehicle sent the sentence.
    pub(crate) fn window(&mut self, at: Moment, created: TimeOfDay, until: TimeOfDay) {
        self.unseen = false;
        if let Ok(length_ns) = u64::try_from(until.nanos_since(created)) {
            self.open_until = self.open_until.max(Some(at + Duration::from_nanos(length_ns)));
        }
    }

    /// We sent a BPCPD.
    pub(crate) fn packet(&self, at: Moment, sure: Duration, findings: &mut Findings) {
        if self.unseen {
            return;
        }
        findings.judge(Rule::PacketWindow);
        if self.open_until.is_none_or(|until| until + sure < at) {
            findings.add(at, Rule::PacketWindow, || match self.open_until {
                Some(until) => format!("BPCPD after the window that ended at {until}"),
                None => "BPCPD without any window on this connection".to_owned(),
            });
        }
    }

    pub(crate) fn cut(&mut self) {
        *self = Self::default();
    }

    /// The record has a gap.
    pub(crate) fn forget(&mut self) {
        self.unseen = true;
    }
}

/// Silent mode (SPI 7.22).
#[derive(Clone, Debug, Default)]
pub(crate) struct Silence {
    asked: Option<(TimeOfDay, Moment)>,
    stands_until: Option<Moment>,
}

impl Silence {
    /// We sent BPSIL.
    pub(crate) fn we_say(&mut self, at: Moment, created: TimeOfDay, silent: bool, findings: &mut Findings) {
        if !silent {
            *self = Self::default();
            return;
        }
        findings.judge(Rule::SilenceRepeated);
        if let Some(until) = self.stands_until
            && at + SILENCE_SLACK < until
        {
            findings.add(at, Rule::SilenceRepeated, || {
                format!("BPSIL 1 although silent mode lasts until {until} and cannot be prolonged")
            });
        }
        self.asked = Some((created.to_the_millisecond(), at));
    }

    /// The vehicle answered a BPSIL. Returns whether silence begins with it.
    pub(crate) fn answered(&mut self, echo: Echo, taken: bool, caps: &Caps) -> bool {
        let Some((asked, at)) = self.asked else { return false };
        if !echo.echoes(asked) {
            return false;
        }
        let until = at + seconds(caps.silent_term_s);
        let begins = taken && self.stands_until != Some(until);
        self.stands_until = taken.then_some(until);
        begins
    }
}

/// How much one process of the runtime has requested.
#[derive(Clone, Debug, Default)]
pub(crate) struct Quota {
    /// What the vehicle accepted, by the time of the request, because an answer may come twice.
    taken: Vec<(Counted, Echo)>,
    topside: Rate,
    packets: Rate,
    messages: Rate,
    devices: Rate,
}

/// The times of the last requests of a kind.
#[derive(Clone, Debug, Default)]
struct Rate(VecDeque<Moment>);

/// Requests that are counted in total.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Counted {
    GpsHit,
    Adjustment,
    Silence,
}

/// Requests that are counted by the minute or the second.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rated {
    Topside,
    Packet,
    Message,
    Device,
}

impl Quota {
    /// The vehicle accepted a request.
    pub(crate) fn taken(&mut self, at: Moment, (what, created): (Counted, Echo), caps: &Caps, findings: &mut Findings) {
        let (max, name) = match what {
            Counted::GpsHit => (caps.gps_hits_total_max, "GPS hits"),
            Counted::Adjustment => (caps.adjustments_total_max, "adjustments"),
            Counted::Silence => (caps.silences_total_max, "silences"),
        };
        if self.taken.contains(&(what, created)) {
            return;
        }
        self.taken.push((what, created));
        findings.judge(Rule::RequestsTotal);
        let count = self.taken.iter().filter(|(other, _)| *other == what).count();
        if count > max as usize {
            findings.add(at, Rule::RequestsTotal, || {
                format!("{count} {name} accepted, {max} allowed")
            });
        }
    }

    /// We sent a request. A limit on the average lets through twice as many in its time if there was none before.
    pub(crate) fn asked(&mut self, at: Moment, what: Rated, caps: &Caps, findings: &mut Findings) {
        const MINUTE: (Duration, &str) = (Duration::from_secs(60), "a minute");
        const SECOND: (Duration, &str) = (Duration::from_secs(1), "a second");
        let (rate, max, name, (within, while_)) = match what {
            Rated::Topside => (
                &mut self.topside,
                caps.topside_per_min,
                "messages to the topside",
                MINUTE,
            ),
            Rated::Packet => (&mut self.packets, caps.packets_per_min, "packets", MINUTE),
            Rated::Message => (&mut self.messages, caps.messages_per_s, "lines in the log", SECOND),
            Rated::Device => (
                &mut self.devices,
                caps.device_commands_per_s,
                "commands to devices",
                SECOND,
            ),
        };
        findings.judge(Rule::RequestsTotal);
        let max = max as usize * 2 + 1;
        rate.0.push_back(at);
        while rate.0.front().is_some_and(|first| at.since(*first) > within) {
            rate.0.pop_front();
        }
        if rate.0.len() > max {
            rate.0.pop_front();
            findings.add(at, Rule::RequestsTotal, || {
                format!("more than {max} {name} within {while_}")
            });
        }
    }
}

/// BFSHT, the vehicle's message that power will go (SPI 5.2).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shutdown {
    heard: Option<Moment>,
    /// The vehicle sent it while the runtime was stopped.
    unheard: bool,
    told: bool,
}

impl Shutdown {
    /// The vehicle sent BFSHT, and we hear it by `heard`; or, if the runtime is stopped, when it continues.
    pub(crate) fn said(&mut self, heard: Moment, stopped: bool) {
        if stopped {
            self.unheard = true;
        } else {
            self.heard.get_or_insert(heard);
        }
    }

    /// The runtime is stopped. What is on its way to it then is heard when it continues.
    pub(crate) fn stopped(&mut self, now: Moment) {
        if self.heard.take_if(|heard| now < *heard).is_some() {
            self.unheard = true;
        }
    }

    /// The link is lost, and with it what we have not certainly heard by now.
    pub(crate) fn cut(&mut self, now: Moment) {
        self.heard = self.heard.filter(|heard| *heard <= now);
        self.unheard = false;
    }

    /// The runtime continues, and hears by `heard` what the vehicle sent meanwhile.
    pub(crate) fn goes_on(&mut self, heard: Moment) {
        if core::mem::take(&mut self.unheard) {
            self.heard.get_or_insert(heard);
        }
    }

    /// We sent a sentence; `is_new` is true if it is a new request.
    pub(crate) fn we_say(&mut self, at: Moment, name: &[u8; 5], is_new: bool, findings: &mut Findings) {
        let Some(heard) = self.heard else { return };
        findings.judge(Rule::AfterShutdown);
        let late = at > heard + LAST_WORD;
        if (late || is_new && at > heard) && !core::mem::replace(&mut self.told, late) {
            findings.add(at, Rule::AfterShutdown, || {
                let name = String::from_utf8_lossy(name);
                format!("{name} was sent although BFSHT was heard by {heard}")
            });
        }
    }
}
