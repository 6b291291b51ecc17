//! What `info` says of the records of one type from one device.

use std::collections::BTreeMap;

use backseat_s7k::file::IndexEntry;
use backseat_units::math::ln;
use serde::Serialize;

use crate::listed::Listed;
use crate::moment::Moment;

/// Records of one type from one device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// The record type.
    #[serde(rename = "type")]
    pub record_type: u32,
    /// The type's title, if it is known.
    pub title: Option<&'static str>,
    /// The device.
    pub device: u32,
    /// The device's title, if it is known.
    pub device_title: Option<&'static str>,
    /// Tells apart several devices of one kind.
    pub enumerator: u16,
    /// How many records.
    pub records: u64,
    /// Their length with their frames, bytes.
    pub bytes: u64,
    /// The earliest time.
    pub first: Option<Moment>,
    /// The latest time.
    pub last: Option<Moment>,
    /// Records without a time.
    pub without_time: u64,
    /// Records a second between the first and the last.
    pub rate_hz: Option<f64>,
    /// The median of the times from record to record, to 9 %.
    pub interval_s: Option<f64>,
    /// Times from record to record of over three times the median.
    pub time_gaps: Listed<TimeGap>,
    /// Records whose time is before that of the record before them.
    pub times_backwards: Listed<TimeGap>,
    /// Whether the record counts count: false if every record has 0.
    pub counted: bool,
    /// Record counts that do not follow the one before.
    pub count_gaps: Listed<CountGap>,
    /// Records that are missing by their counts.
    pub missing: u64,
}

/// A pause between two records.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeGap {
    /// The place of the record behind the pause, in bytes from the file's start.
    pub offset: u64,
    /// The time of the record before it.
    pub from: Moment,
    /// The time from record to record; negative if it goes back.
    pub seconds: f64,
}

/// A step in the record counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct CountGap {
    /// The place of the record behind the step, in bytes from the file's start.
    pub offset: u64,
    /// The record count before.
    pub from: u32,
    /// The record count behind.
    pub to: u32,
}

/// Gathers a [`Group`].
#[derive(Debug, Default)]
pub(super) struct Gathering {
    records: u64,
    bytes: u64,
    first: Option<Moment>,
    last: Option<Moment>,
    without_time: u64,
    intervals: Intervals,
    times_backwards: Listed<TimeGap>,
    before: Option<(Option<Moment>, u32)>,
    counted: bool,
    count_gaps: Listed<CountGap>,
    missing: u64,
}

impl Gathering {
    pub(super) fn add(&mut self, entry: &IndexEntry) {
        let time = Moment::of(&entry.time);
        self.records += 1;
        self.bytes += u64::from(entry.size);
        self.counted |= entry.record_count != 0;
        match time {
            Some(time) => {
                self.first = Some(self.first.map_or(time, |first| first.min(time)));
                self.last = Some(self.last.map_or(time, |last| last.max(time)));
            }
            None => self.without_time += 1,
        }
        let time_before = match self.before {
            Some((time_before, count_before)) => {
                self.step(entry, count_before);
                time_before
            }
            None => None,
        };
        if let (Some(from), Some(time)) = (time_before, time) {
            let gap = TimeGap {
                offset: entry.offset,
                from,
                seconds: time.seconds_since(from),
            };
            if gap.seconds < 0.0 {
                self.times_backwards.push(gap);
            } else {
                self.intervals.add(gap);
            }
        }
        self.before = Some((time.or(time_before), entry.record_count));
    }

    fn step(&mut self, entry: &IndexEntry, before: u32) {
        let count = entry.record_count;
        if count == before.wrapping_add(1) || (count == 0 && before == 0) {
            return;
        }
        self.count_gaps.push(CountGap {
            offset: entry.offset,
            from: before,
            to: count,
        });
        if count > before {
            self.missing += u64::from(count - before - 1);
        }
    }

    pub(super) fn finish(self, (record_type, device, enumerator): (u32, u32, u16)) -> Group {
        let span = self.first.zip(self.last).map(|(first, last)| last.seconds_since(first));
        let timed = self.records - self.without_time;
        #[expect(clippy::cast_precision_loss, reason = "a rate needs no more digits")]
        let rate_hz = span
            .filter(|span| *span > 0.0 && timed > 1)
            .map(|span| (timed - 1) as f64 / span);
        let known = backseat_s7k::record::RECORD_TYPES
            .iter()
            .find(|known| known.number == record_type);
        Group {
            record_type,
            title: known.map(|known| known.title),
            device,
            device_title: backseat_s7k::DeviceId(device).title(),
            enumerator,
            records: self.records,
            bytes: self.bytes,
            first: self.first,
            last: self.last,
            without_time: self.without_time,
            rate_hz,
            interval_s: self.intervals.median().map(|(_, median)| median),
            time_gaps: self.intervals.gaps(),
            times_backwards: self.times_backwards,
            counted: self.counted,
            count_gaps: self.count_gaps,
            missing: self.missing,
        }
    }
}

/// Times from record to record, in classes an eighth of an octave wide, so that memory does not grow with the file.
#[derive(Debug, Default)]
struct Intervals {
    /// Number and sum of the intervals of each class, seconds.
    classes: BTreeMap<i32, (u64, f64)>,
    /// The longest ones.
    longest: Vec<TimeGap>,
}

/// Classes an octave.
const PER_OCTAVE: f64 = 8.0;
/// A gap is so many classes above the median's: at least three times as long.
const GAP_CLASSES: i32 = 13;
/// How many of the longest intervals are kept.
const LONGEST_MAX: usize = crate::listed::LIST_MAX;
/// Of fewer intervals none is called a gap.
const INTERVALS_MIN: u64 = 4;

fn class(seconds: f64) -> i32 {
    // Shorter than 7k time resolves: one class for all of them.
    let octaves = ln(seconds.max(1e-6)) / core::f64::consts::LN_2;
    #[expect(clippy::cast_possible_truncation, reason = "within 200 classes of zero")]
    let class = (octaves * PER_OCTAVE).floor() as i32;
    class
}

impl Intervals {
    fn add(&mut self, gap: TimeGap) {
        let (count, sum) = self.classes.entry(class(gap.seconds)).or_default();
        *count += 1;
        *sum += gap.seconds;
        let shortest = self.longest.last().map_or(0.0, |gap| gap.seconds);
        if self.longest.len() < LONGEST_MAX || gap.seconds > shortest {
            let place = self.longest.partition_point(|longer| longer.seconds >= gap.seconds);
            self.longest.insert(place, gap);
            self.longest.truncate(LONGEST_MAX);
        }
    }

    /// The median's class, and the mean of that class, seconds.
    fn median(&self) -> Option<(i32, f64)> {
        let all: u64 = self.classes.values().map(|(count, _)| count).sum();
        let mut below = 0;
        for (class, (count, sum)) in &self.classes {
            below += count;
            if 2 * below >= all {
                #[expect(clippy::cast_precision_loss, reason = "a mean needs no more digits")]
                return Some((*class, sum / *count as f64));
            }
        }
        None
    }

    fn gaps(&self) -> Listed<TimeGap> {
        let all: u64 = self.classes.values().map(|(count, _)| count).sum();
        let Some((median, _)) = self.median().filter(|_| all >= INTERVALS_MIN) else {
            return Listed::default();
        };
        let is_gap = |class: i32| class >= median + GAP_CLASSES;
        let count = self
            .classes
            .iter()
            .filter(|(class, _)| is_gap(**class))
            .map(|(_, (count, _))| count)
            .sum();
        let mut first: Vec<TimeGap> = self
            .longest
            .iter()
            .filter(|gap| is_gap(class(gap.seconds)))
            .copied()
            .collect();
        first.sort_by_key(|gap| gap.offset);
        Listed { count, first }
    }
}
