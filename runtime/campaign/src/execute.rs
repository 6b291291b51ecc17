use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::error::CampaignError;
use crate::flight::{Crew, Prepared, fly_row};
use crate::folder::Folder;
use crate::journal::JournalWriter;
use crate::plan::{Key, Plan};
use crate::row::Row;
use crate::shard::Shard;
use crate::stop::Stop;

/// A thread takes so many runs at a time.
const TAKEN: u64 = 8;
/// Rows are on the disk at the latest after this.
const SYNC_EVERY: Duration = Duration::from_secs(2);
/// After so many rows it is known which measures there are.
const LOOKED_AT: u64 = 8;
/// The progress is shown this often while nothing ends.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// What to fly.
pub struct Order<'a> {
    /// The campaign.
    pub plan: &'a Plan,
    /// Its plugins.
    pub crew: &'a Crew,
    /// Where its journal is.
    pub folder: &'a Folder,
    /// Which share of it.
    pub shard: Shard,
    /// The number of threads, at least 1.
    pub workers: usize,
    /// The time after which no run goes on.
    pub stop_after: Option<Duration>,
    /// The computer's name, for `timing.parquet`.
    pub host: &'a str,
}

/// How far a campaign has come.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// The runs of this shard.
    pub runs: u64,
    /// Of those, flown before this process.
    pub before: u64,
    /// Of those, flown by this process.
    pub now: u64,
    /// Of the latter, those that missed an expectation.
    pub missed: u64,
    /// Of the latter, those that could not be flown.
    pub not_flown: u64,
    /// Violations in the latter.
    pub violations: u64,
    /// Bytes at the journal's end that were damaged and have been cut off: the runs in them are flown again.
    pub cut_off: u64,
    /// The first runs have measures, and not the one that the report shows first: in words.
    pub lacks_measure: Option<String>,
}

/// How the flying of a campaign ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// How far it came.
    pub progress: Progress,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

/// Flies the runs of a shard that its journal does not have.
///
/// `tell` is called with the progress whenever runs end, and a few times a second.
///
/// # Errors
///
/// [`CampaignError`] if the journal cannot be read or written. What is in it stays.
pub fn fly(order: &Order<'_>, stop: &Stop, mut tell: impl FnMut(&Progress)) -> Result<Ended, CampaignError> {
    order.folder.is_divided_alike(order.shard)?;
    let (mut journal, done) = JournalWriter::open(
        &order.folder.journal(order.shard),
        &order.folder.manifest()?.identity(),
        order.host,
    )?;
    let runs = order.shard.of(order.plan.runs());
    let mut pending = Pending::new(runs.clone(), done.rows.iter().map(|place| place.run));
    let mut progress = Progress {
        runs: runs.end - runs.start,
        before: pending.done,
        cut_off: done.damaged,
        ..Progress::default()
    };
    drop(done);
    tell(&progress);
    let per_point = order.plan.runs_of_point();
    pending.within = per_point;
    let pending = Mutex::new(pending);
    let (rows, ended) = sync_channel::<Told>(order.workers.max(1) * 16);
    let begun = now();
    let mut synced = begun;
    let mut measured = BTreeSet::new();
    let written = thread::scope(|scope| {
        for _ in 0..order.workers.max(1) {
            let rows = rows.clone();
            let pending = &pending;
            scope.spawn(move || work(order, stop, pending, &rows));
        }
        drop(rows);
        loop {
            match ended.recv_timeout(LOOK_EVERY) {
                Ok(Err(error)) => {
                    stop.set();
                    journal.sync()?;
                    return Err(error);
                }
                Ok(Ok((run, wall_ns, row))) => {
                    progress.now += 1;
                    progress.missed += u64::from(row.flown() && !row.passed());
                    progress.not_flown += u64::from(!row.flown());
                    progress.violations += row.violations();
                    if progress.now <= LOOKED_AT {
                        measured.extend(row.measures().map(str::to_owned));
                        if progress.now == LOOKED_AT {
                            progress.lacks_measure = order.plan.unmeasured(&measured);
                        }
                    }
                    if let Err(error) = journal.write(run, wall_ns, &row) {
                        stop.set();
                        return Err(error);
                    }
                    tell(&progress);
                }
                Err(RecvTimeoutError::Timeout) => tell(&progress),
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if progress.now == 1 || now().duration_since(synced) >= SYNC_EVERY {
                if let Err(error) = journal.sync().and_then(|()| journal.is_there()) {
                    stop.set();
                    return Err(error);
                }
                synced = now();
            }
            if order
                .stop_after
                .is_some_and(|after| now().duration_since(begun) >= after)
            {
                stop.set();
            }
        }
        journal.sync()
    });
    written?;
    let stopped = progress.before + progress.now < progress.runs;
    Ok(Ended { progress, stopped })
}

#[expect(
    clippy::disallowed_methods,
    reason = "how long runs take, which does not affect any of them"
)]
fn now() -> Instant {
    Instant::now()
}

/// A run's number, the nanoseconds that it took and its row, or why the campaign cannot go on.
type Told = Result<(u64, u64, Row), CampaignError>;

fn work(order: &Order<'_>, stop: &Stop, pending: &Mutex<Pending>, rows: &SyncSender<Told>) {
    let per_seed = order.plan.drawn_from_seeds().any(|drawn| drawn);
    let mut prepared: Option<(Key, Result<Prepared, CampaignError>)> = None;
    loop {
        let taken = pending.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(taken) = taken else { return };
        for run in taken {
            if stop.is_set() {
                return;
            }
            let Some(key) = order.plan.key(run) else { return };
            let begun = now();
            let same = |other: &Key| {
                (other.mission, other.variant, other.point) == (key.mission, key.variant, key.point)
                    && (!per_seed || other.seed == key.seed)
            };
            let ready = match prepared.take() {
                Some((other, ready)) if same(&other) => ready,
                _ => order.crew.prepare(order.plan, &key),
            };
            if let Err(error @ CampaignError::Changed { .. }) = ready {
                // Nobody reads it if the campaign has stopped already.
                rows.send(Err(error)).ok();
                return;
            }
            let Some(row) = fly_row(&ready, order.plan, &key, stop) else {
                return;
            };
            prepared = Some((key, ready));
            let wall_ns = u64::try_from(now().duration_since(begun).as_nanos()).unwrap_or(u64::MAX);
            if rows.send(Ok((run, wall_ns, row))).is_err() {
                return;
            }
        }
    }
}

/// The runs that are not flown yet, in their order.
struct Pending {
    next: u64,
    end: u64,
    first: u64,
    /// One bit for each run that is done.
    bits: Vec<u64>,
    done: u64,
    /// No share crosses a multiple of this.
    within: u64,
}

impl Pending {
    fn new(runs: Range<u64>, flown: impl Iterator<Item = u64>) -> Self {
        let mut pending = Self {
            next: runs.start,
            end: runs.end,
            first: runs.start,
            bits: vec![0; ((runs.end - runs.start) as usize).div_ceil(64)],
            done: 0,
            within: u64::MAX,
        };
        for run in flown.filter(|run| runs.contains(run)) {
            let place = run - runs.start;
            let bit = 1 << (place % 64);
            let word = &mut pending.bits[(place / 64) as usize];
            pending.done += u64::from(*word & bit == 0);
            *word |= bit;
        }
        pending
    }

    fn is_done(&self, run: u64) -> bool {
        let place = run - self.first;
        self.bits[(place / 64) as usize] >> (place % 64) & 1 == 1
    }

    /// The next runs that follow each other, all of the same mission, variant and point.
    fn take(&mut self) -> Option<Range<u64>> {
        while self.next < self.end && self.is_done(self.next) {
            self.next += 1;
        }
        let begin = self.next;
        while self.next < self.end
            && self.next - begin < TAKEN
            && !self.is_done(self.next)
            && self.next / self.within == begin / self.within
        {
            self.next += 1;
        }
        (begin < self.next).then_some(begin..self.next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pending_runs_are_taken_once_and_never_across_a_point() {
        let done = [3, 4, 5, 17];
        let mut pending = Pending::new(2..23, done.into_iter().chain([4, 99]));
        pending.within = 10;
        assert_eq!(pending.done, 4);
        let mut taken = Vec::new();
        while let Some(range) = pending.take() {
            assert_eq!(range.start / 10, (range.end - 1) / 10);
            taken.extend(range);
        }
        let expected: Vec<u64> = (2..23).filter(|run| !done.contains(run)).collect();
        assert_eq!(taken, expected);
    }
}
