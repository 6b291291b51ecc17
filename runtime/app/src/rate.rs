//! How fast the vehicle's clock runs, measured by this computer's.
//!
//! A vehicle in the sea lives as fast as its payload. A mock vehicle may not (`mvc --speed 20`). Core then finds in each
//! round trip that the vehicle's clock was set, does not trust its navigation, and sends nothing that steers (safety
//! requirement 023). Only a look at the clock over some seconds shows why.
//!
//! Only round trips count. The vehicle writes an acknowledgement after the command has left us and before the
//! acknowledgement arrives, so two round trips bound the time between two acknowledgements on both sides, however long
//! each of the messages was on its way. A link that holds messages up, or brings what it held up in a burst, cannot make
//! a clock look fast or slow.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_spi::{Acknowledgement, CommandName, Framer, FromVehicle, Policy, Sentence, ToVehicle};
use backseat_units::{TimeOfDay, Timestamp};

/// The clocks are compared over windows of at least this length...
const WINDOW: Duration = Duration::from_secs(2);
/// ...and so many windows in a row must show the same, because a clock that was set changes one window.
const WINDOWS: usize = 3;
/// Rates that are less far from 1 are not worth a line. A time daemon may correct a clock by a tenth.
const OFF: f64 = 0.1;
/// What a vehicle's times may be wrong by, seconds: some write the time when their own cycle began, and a clock without
/// decimals is a second wrong in three windows together.
const WRONG_S: f64 = 0.2;
/// The windows agree if the greatest rate is at most so many times the least.
const AGREE: f64 = 1.5;
/// Slower than this, the time in the messages stands still, which is another fault.
const STILL: f64 = 0.02;
/// A window is exact enough to show that the clocks run at one rate if its bounds are this close.
const EXACT: Duration = Duration::from_millis(500);
/// The time in a longer window may have come round the day.
const WINDOW_MAX: Duration = Duration::from_secs(600);
/// How many commands may wait for their acknowledgements.
const SENT_MAX: usize = 64;

/// Follows the round trips of our status (BPSTS).
#[derive(Debug)]
pub(crate) struct Rate {
    framer: Framer,
    /// The commands that wait for their acknowledgements: the time in them, and when they left.
    sent: VecDeque<(TimeOfDay, Timestamp)>,
    /// The round trip with which the window began.
    begun: Option<Trip>,
    windows: VecDeque<Window>,
    /// Another rate was reported, and still lasts.
    off: bool,
}

/// When a command left, when its acknowledgement came, and what time the vehicle gave that.
#[derive(Clone, Copy, Debug)]
struct Trip {
    sent: Timestamp,
    received: Timestamp,
    written: TimeOfDay,
}

/// The time between two acknowledgements, seconds: by the vehicle's clock, and its bounds by ours.
#[derive(Clone, Copy, Debug)]
struct Window {
    vehicle_s: f64,
    least_s: f64,
    most_s: f64,
}

impl Window {
    fn rate(self) -> f64 {
        2.0 * self.vehicle_s / (self.least_s + self.most_s)
    }

    fn is_fast(self) -> bool {
        self.vehicle_s > self.most_s * (1.0 + OFF) + WRONG_S
    }

    fn is_slow(self) -> bool {
        self.vehicle_s < self.least_s * (1.0 - OFF) - WRONG_S && self.rate() > STILL
    }

    fn is_alike(self) -> bool {
        !self.is_fast() && !self.is_slow() && self.rate() > STILL && self.most_s - self.least_s < EXACT.as_secs_f64()
    }
}

impl Default for Rate {
    fn default() -> Self {
        Self {
            framer: Framer::new(Policy::FromVehicle),
            sent: VecDeque::new(),
            begun: None,
            windows: VecDeque::new(),
            off: false,
        }
    }
}

impl Rate {
    /// Whether the clocks run at rates so different that nothing steers.
    pub(crate) const fn is_off(&self) -> bool {
        self.off
    }

    /// The connection has ended.
    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    /// A sentence has left.
    pub(crate) fn sent(&mut self, now: Timestamp, sentence: &[u8]) {
        if let Some(created) = status_created(sentence) {
            if self.sent.len() >= SENT_MAX {
                self.sent.pop_front();
            }
            self.sent.push_back((created, now));
        }
    }

    /// Bytes have come from the vehicle. Returns a line for the operator, if the rate has changed.
    pub(crate) fn received(&mut self, now: Timestamp, bytes: &[u8]) -> Option<String> {
        self.framer.push(bytes);
        let mut told = None;
        while let Some(sentence) = self.framer.next_sentence() {
            if sentence.name() == "BFACK"
                && let Ok(FromVehicle::Acknowledgement(ack)) = FromVehicle::decode(&sentence)
            {
                told = self.acknowledged(now, &ack).or(told);
            }
        }
        told
    }

    fn acknowledged(&mut self, now: Timestamp, ack: &Acknowledgement) -> Option<String> {
        if CommandName::new("STS") != Ok(ack.command) {
            return None;
        }
        let answered = |(created, _): &(TimeOfDay, Timestamp)| ack.command_created.echoes(*created);
        let index = self.sent.iter().position(answered)?;
        let (_, sent) = self.sent.remove(index)?;
        self.trip(Trip {
            sent,
            received: now,
            written: ack.created,
        })
    }

    fn trip(&mut self, trip: Trip) -> Option<String> {
        let from = *self.begun.get_or_insert(trip);
        let least = trip.sent.since(from.received);
        if least < WINDOW {
            return None;
        }
        self.begun = Some(trip);
        let most = trip.received.since(from.sent);
        if most > WINDOW_MAX {
            self.windows.clear();
            return None;
        }
        self.windows.push_back(Window {
            vehicle_s: trip.written.nanos_since(from.written) as f64 / 1e9,
            least_s: least.as_secs_f64(),
            most_s: most.as_secs_f64(),
        });
        if self.windows.len() > WINDOWS {
            self.windows.pop_front();
        }
        self.judge()
    }

    fn judge(&mut self) -> Option<String> {
        if self.windows.len() < WINDOWS {
            return None;
        }
        let all = |is: fn(Window) -> bool| self.windows.iter().all(|window| is(*window));
        if self.off {
            let alike = all(Window::is_alike);
            self.off = !alike;
            return alike.then(|| "the vehicle's clock runs as fast as this computer's again".to_owned());
        }
        let rates = || self.windows.iter().map(|window| window.rate());
        let agree = rates().fold(f64::MIN, f64::max) <= AGREE * rates().fold(f64::MAX, f64::min);
        if !agree || !(all(Window::is_fast) || all(Window::is_slow)) {
            return None;
        }
        self.off = true;
        let rate = rates().sum::<f64>() / WINDOWS as f64;
        Some(format!(
            "the vehicle's clock runs {rate:.1} times as fast as this computer's, so nothing may steer; run a mock \
             vehicle with `mvc --speed 1`, or fly both together with `backseat fly --speed`"
        ))
    }
}

/// The time in a status that is sent.
fn status_created(sentence: &[u8]) -> Option<TimeOfDay> {
    if !sentence.starts_with(b"$BPSTS,") {
        return None;
    }
    let line = std::str::from_utf8(sentence).ok()?;
    let ToVehicle::PayloadStatus(status) = ToVehicle::decode(&Sentence::parse(line.trim_end()).ok()?).ok()? else {
        return None;
    };
    Some(status.created)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One round trip a second for some seconds of our time. `vehicle_ms` is the vehicle's time for ours, and `delays`
    /// says how long the command and the acknowledgement are on their way, milliseconds. Returns the lines that are
    /// printed.
    fn told(
        rate: &mut Rate,
        seconds: std::ops::Range<u64>,
        vehicle_ms: impl Fn(u64) -> u64,
        delays: impl Fn(u64) -> (u64, u64),
    ) -> Vec<String> {
        let heard = seconds.filter_map(|second| {
            let sent_ms = 1000 * second;
            let (there_ms, back_ms) = delays(sent_ms);
            let written_ms = vehicle_ms(sent_ms + there_ms) % 86_400_000;
            rate.trip(Trip {
                sent: Timestamp::from_millis(sent_ms),
                received: Timestamp::from_millis(sent_ms + there_ms + back_ms),
                written: TimeOfDay::from_nanos(written_ms * 1_000_000).unwrap(),
            })
        });
        heard.collect()
    }

    const fn prompt(_: u64) -> (u64, u64) {
        (2, 3)
    }

    #[test]
    fn a_clock_of_another_rate_is_reported_once() {
        for (times, shown) in [(20, "20.0"), (2, "2.0"), (300, "300.0")] {
            let mut rate = Rate::default();
            let lines = told(&mut rate, 0..60, |ms| 86_000_000 + times * ms, prompt);
            assert_eq!(lines.len(), 1, "{lines:?}");
            assert!(lines[0].contains(&format!("runs {shown} times as fast")), "{lines:?}");
            assert!(rate.is_off());
            let lines = told(&mut rate, 60..90, |ms| 1000 + ms, prompt);
            assert_eq!(lines, ["the vehicle's clock runs as fast as this computer's again"]);
            assert!(!rate.is_off());
        }
        for (half, shown) in [(2, "0.5"), (10, "0.1")] {
            let lines = told(&mut Rate::default(), 0..30, |ms| ms / half, |_| (900, 3));
            assert!(lines.len() == 1 && lines[0].contains(shown), "{lines:?}");
        }
    }

    #[test]
    fn a_clock_that_is_set_or_drifts_or_stands_still_has_no_other_rate() {
        let steps = |ms: u64| if ms < 12_000 { ms } else { ms + 7_200_000 };
        let back = |ms: u64| 7_200_000 + if ms < 12_000 { ms } else { ms - 5000 };
        let stuck = |ms: u64| ms.min(6000);
        let drifts = |ms: u64| ms + ms / 20;
        let late = |ms: u64| ms - ms / 20;
        let whole_seconds = |ms: u64| (ms * 21 / 20) / 1000 * 1000;
        let cycles = |ms: u64| ms / 100 * 100;
        let day = |ms: u64| 86_395_000 + ms;
        let clocks = [
            steps as fn(u64) -> u64,
            back,
            stuck,
            drifts,
            late,
            whole_seconds,
            cycles,
            day,
        ];
        for (index, vehicle) in clocks.into_iter().enumerate() {
            assert_eq!(
                told(&mut Rate::default(), 0..60, vehicle, prompt),
                [""; 0],
                "clock {index}"
            );
        }
    }

    #[test]
    fn no_delay_makes_a_clock_look_fast_or_slow() {
        // A link that falls behind and catches up, in either direction; one that stalls; one whose delay jumps about.
        let saw = |ms: u64| {
            if ms % 40_000 < 20_000 {
                ms % 40_000 / 2
            } else {
                (40_000 - ms % 40_000) / 2
            }
        };
        let there = move |ms: u64| (saw(ms), 3_u64);
        let back = move |ms: u64| (2_u64, saw(ms));
        let both = move |ms: u64| (saw(ms), saw(ms + 20_000));
        let stalls = |ms: u64| {
            if (5000..15_000).contains(&ms) {
                (15_000 - ms, 2)
            } else {
                (2, 2)
            }
        };
        let jumps = |ms: u64| (ms * 7919 % 997, ms * 104_729 % 991);
        for delays in [&there as &dyn Fn(u64) -> (u64, u64), &back, &both, &stalls, &jumps] {
            assert_eq!(told(&mut Rate::default(), 0..200, |ms| 5_000_000 + ms, delays), [""; 0]);
        }
    }

    fn sentence(body: &str) -> Vec<u8> {
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n").into_bytes()
    }

    #[test]
    fn round_trips_are_read_from_the_lines_however_they_come() {
        let mut rate = Rate::default();
        let mut lines = Vec::new();
        for second in 0..20 {
            let at = Timestamp::from_secs(second);
            rate.sent(at, &sentence(&format!("BPSTS,0810{second:02}.000,1,has control")));
            rate.sent(at, &sentence("BPLOG,ACK,ON"));
            let minute = 10 + second / 3;
            let ack = format!(
                "BFACK,08{minute}{:02}.000,STS,0810{second:02}.000,,2,0",
                second % 3 * 20
            );
            let bytes = [sentence("BFACK,081000.000,RMB,081000.000,,2,0"), sentence(&ack)].concat();
            let (first, rest) = bytes.split_at(usize::try_from(second).unwrap() * 3);
            lines.extend(rate.received(at, first));
            lines.extend(rate.received(at, rest));
        }
        assert!(lines.len() == 1 && lines[0].contains("runs 20.0 times"), "{lines:?}");
        assert!(rate.sent.is_empty(), "each was answered");
        rate.reset();
        assert!(!rate.is_off());
    }

    #[test]
    fn neither_noise_nor_silence_is_an_error() {
        let mut rate = Rate::default();
        for second in 0..1000 {
            let at = Timestamp::from_secs(second);
            rate.sent(at, &sentence("BPSTS,081025.987,1,has control"));
            assert_eq!(rate.received(at, &[b'x'; 9000]), None);
            assert_eq!(rate.received(at, b"$BFACK,\xff\n$BFACK,,,,\n$BFACK\n"), None);
        }
        assert!(rate.sent.len() <= SENT_MAX);
    }
}
