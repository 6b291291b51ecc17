//! Writes the log of a run on a thread of its own (safety requirement 022), so that a slow, stuck or full disk delays
//! nothing. Records that find no room in the queue are left out and counted, and the log marks the gap.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use anyhow::Result;
use backseat_recorder::{Header, Listener, Recorder, RecorderError};
use backseat_units::Timestamp;
use tracing::{error, info, warn};

use crate::aside;
use crate::log_parts::Parts;

/// Bytes that may wait for the disk: minutes of an ordinary run.
const WAITING_MAX: usize = 32 << 20;
/// After a gap, recording starts again when this few bytes wait.
const WAITING_LOW: usize = 1 << 20;
/// Bytes in one piece of the queue.
const PIECE: usize = 64 << 10;
/// How long the end of a run waits until the log is on the disk.
const FAREWELL: Duration = Duration::from_secs(2);

/// The log of a run while it is being written.
pub(crate) struct Recording {
    /// What messages call the file.
    name: String,
    /// `None` once the disk has failed: a full disk stops the log, not the vehicle.
    recorder: Option<Recorder<Queue>>,
    /// Tells a listener what happens, whatever the disk does. It writes nothing.
    teller: Option<Recorder<Queue>>,
    disk: Arc<Disk>,
    gap: Option<Gap>,
    /// One for each part whose thread may still write: this part's, and those of parts before it.
    endings: Vec<Receiver<()>>,
    /// When the log goes on in another file; `None` for never.
    parts: Option<Parts>,
    /// The part that is to follow, while its file is being created.
    next: Option<Next>,
}

/// A part that is to follow.
struct Next {
    path: PathBuf,
    queue: Queue,
    /// Whether its file is there.
    opened: Receiver<io::Result<()>>,
    ended: Receiver<()>,
}

/// Records that were left out.
#[derive(Debug)]
struct Gap {
    since: Timestamp,
    records: u64,
}

/// What the writing thread and the loop share.
#[derive(Debug, Default)]
struct Disk {
    waiting: AtomicUsize,
    /// Bytes of the current part.
    part: AtomicU64,
    failure: Mutex<Option<io::Error>>,
}

impl Disk {
    /// The failure since the last call, if there was one.
    fn failure(&self) -> Option<io::Error> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn fail(&self, failure: io::Error) {
        *self.failure.lock().unwrap_or_else(PoisonError::into_inner) = Some(failure);
    }
}

impl Recording {
    /// Creates the file, and replaces an existing one. A listener is told everything.
    pub(crate) fn create(path: &Path, header: &Header<'_>, listener: Option<Listener>) -> Result<Self> {
        let file = File::create(path).map_err(|source| RecorderError::Create {
            path: path.to_owned(),
            source,
        })?;
        let mut recording = Self::to(file, path.display().to_string(), header)?;
        recording.teller = listener
            .map(|listener| {
                let mut teller = Recorder::named(Queue::nowhere(), "nowhere".to_owned(), header)?;
                teller.listen(listener);
                Ok::<_, RecorderError>(teller)
            })
            .transpose()?;
        Ok(recording)
    }

    /// Writes the log to `file`; messages call it `name`.
    pub(crate) fn to(file: impl Write + Send + 'static, name: String, header: &Header<'_>) -> Result<Self> {
        let disk = Arc::new(Disk::default());
        let (queue, _opened, ended) = queue(Arc::clone(&disk), || Ok(file))?;
        Ok(Self {
            name: name.clone(),
            recorder: Some(Recorder::named(queue, name, header)?),
            teller: None,
            disk,
            gap: None,
            endings: vec![ended],
            parts: None,
            next: None,
        })
    }

    /// Has the log go on in another file now and then.
    pub(crate) fn in_parts(mut self, parts: Parts) -> Self {
        self.parts = Some(parts);
        self
    }

    /// Goes on in the next part, if it is due and its file is there. The part's own thread creates the file, so that nothing
    /// here waits for the disk. If it cannot, this part goes on, and the next one is tried later.
    fn turn(&mut self, now: Timestamp) -> Result<(), RecorderError> {
        let bytes = self.disk.part.load(Ordering::Relaxed);
        let (Some(recorder), Some(parts), None) = (&mut self.recorder, &mut self.parts, &self.gap) else {
            return Ok(());
        };
        let Some(next) = self.next.take() else {
            // While the disk is behind, another file would wait too, with a thread of its own.
            let is_behind = self.disk.waiting.load(Ordering::Relaxed) > WAITING_LOW;
            if !is_behind && let Some(path) = parts.due(now, bytes) {
                let file = path.clone();
                match queue(Arc::clone(&self.disk), move || File::create(file)) {
                    Ok((queue, opened, ended)) => {
                        self.next = Some(Next {
                            path,
                            queue,
                            opened,
                            ended,
                        });
                    }
                    Err(error) => put_off(parts, now, &self.name, &path, &error.to_string()),
                }
            }
            return Ok(());
        };
        match next.opened.try_recv() {
            Ok(Ok(())) => {
                let name = next.path.display().to_string();
                info!("the log goes on in {name}");
                // The thread of the part before ends by itself.
                self.endings
                    .retain(|ended| matches!(ended.try_recv(), Err(TryRecvError::Empty)));
                self.endings.push(next.ended);
                self.name.clone_from(&name);
                parts.begin(now, next.path);
                let turned = recorder.turn(next.queue, name);
                self.disk.part.store(0, Ordering::Relaxed);
                turned
            }
            Ok(Err(error)) => {
                put_off(parts, now, &self.name, &next.path, &error.to_string());
                Ok(())
            }
            Err(TryRecvError::Disconnected) => {
                put_off(parts, now, &self.name, &next.path, "its thread has ended");
                Ok(())
            }
            Err(TryRecvError::Empty) => {
                self.next = Some(next);
                Ok(())
            }
        }
    }

    /// Runs `act` to record something of the time `now`, where there is room for it. A gap gets this time too: it comes
    /// before what is recorded.
    pub(crate) fn record(&mut self, now: Timestamp, act: impl Fn(&mut Recorder<Queue>) -> Result<(), RecorderError>) {
        if let Some(teller) = &mut self.teller
            && act(teller).is_err()
        {
            // It writes nowhere, so this is an error of the encoder, and the log says so.
            self.teller = None;
        }
        let Some(recorder) = &mut self.recorder else { return };
        if let Some(failure) = self.disk.failure() {
            let text = format!(
                "the log ends here, the run continues: {}: {failure}; the log does not begin again, also when there is room",
                self.name
            );
            error!("{text}");
            tell(&mut self.teller, now, false, &text);
            self.recorder = None;
            return;
        }
        let waiting = self.disk.waiting.load(Ordering::Relaxed);
        let result = match &mut self.gap {
            Some(gap) if waiting > WAITING_LOW => {
                gap.records += 1;
                return;
            }
            Some(gap) => {
                let Gap { since, records } = *gap;
                self.gap = None;
                let text = format!(
                    "the log has a gap of {:.1} s, {records} records: the disk took them too slowly",
                    now.since(since).as_secs_f64()
                );
                warn!("{text}");
                tell(&mut self.teller, now, true, &text);
                recorder.gap(now, since, records).and_then(|()| act(recorder))
            }
            None if waiting > WAITING_MAX => {
                self.gap = Some(Gap { since: now, records: 1 });
                let text = "the disk does not accept the log: records are left out until it does";
                warn!("{text}");
                tell(&mut self.teller, now, false, text);
                return;
            }
            None => act(recorder),
        };
        if let Err(error) = result.and_then(|()| self.turn(now)) {
            let text = format!("the log ends here, the run continues: {error}; the log does not begin again");
            error!("{text}");
            tell(&mut self.teller, now, false, &text);
            self.recorder = None;
        }
    }

    /// Ends the file in order. If the disk is stuck, the file is left without its end.
    pub(crate) fn finish(mut self, now: Timestamp) {
        if self.gap.is_some() && self.disk.waiting.load(Ordering::Relaxed) <= WAITING_MAX {
            // The end of the file closes the last gap.
            let Gap { since, records } = self.gap.take().unwrap_or(Gap { since: now, records: 0 });
            if let Some(recorder) = &mut self.recorder {
                let _told_below = recorder.gap(now, since, records);
            }
        }
        let finished = self.recorder.take().map(Recorder::finish);
        if let Some(Err(error)) = finished {
            error!("the log has no end: {error}");
        }
        let is_stuck = |ended: &Receiver<()>| matches!(ended.recv_timeout(FAREWELL), Err(RecvTimeoutError::Timeout));
        if self.endings.iter().any(is_stuck) {
            error!("the log has no end: the disk does not accept it");
        } else if let Some(failure) = self.disk.failure() {
            error!("the log has no end: {failure}");
        }
    }
}

/// Tells a console whether the log is written now, and why not.
fn tell(teller: &mut Option<Recorder<Queue>>, now: Timestamp, written: bool, text: &str) {
    if let Some(teller) = teller {
        let told = serde_json::json!({ "written": written, "text": text });
        teller.tell(now, "/recording", told.to_string().as_bytes());
    }
}

/// Tries the next part again later.
fn put_off(parts: &mut Parts, now: Timestamp, name: &str, path: &Path, error: &str) {
    warn!(
        "the log goes on in {name}, because its next part cannot begin: {}: {error}",
        path.display()
    );
    parts.put_off(now);
}

/// Starts a thread that opens a file and writes to it. Returns its queue, and what tells whether the file is open, and that
/// the thread has ended. Nothing may be put into the queue of a file that could not be opened.
fn queue<F: Write>(
    disk: Arc<Disk>,
    open: impl FnOnce() -> io::Result<F> + Send + 'static,
) -> io::Result<(Queue, Receiver<io::Result<()>>, Receiver<()>)> {
    let (pieces, waiting) = channel();
    let (has_opened, opened) = channel();
    let (has_ended, ended) = channel();
    let shared = Arc::clone(&disk);
    aside::spawn("log", move || {
        // A thread that has panicked takes no more pieces, so the queue stays full and no later send can fail.
        let written = catch_unwind(AssertUnwindSafe(|| {
            let (opened, file) = match open() {
                Ok(file) => (Ok(()), Some(file)),
                Err(error) => (Err(error), None),
            };
            // The loop may have ended.
            let _gone = has_opened.send(opened);
            if let Some(file) = file {
                write_out(file, &waiting, &shared);
            }
        }));
        if written.is_err() {
            shared.fail(io::Error::other("its thread has panicked"));
        }
        // The loop may have ended.
        let _gone = has_ended.send(());
    })?;
    let queue = Queue {
        pieces: Some(pieces),
        disk,
        buffer: Vec::with_capacity(PIECE),
        position: 0,
    };
    Ok((queue, opened, ended))
}

fn write_out(file: impl Write, pieces: &Receiver<Vec<u8>>, disk: &Disk) {
    let mut file = Some(file);
    while let Ok(piece) = pieces.recv() {
        // After a failure the remaining pieces are taken and dropped, so that none pile up until the loop learns of it.
        if let Some(open) = &mut file
            && let Err(failure) = open.write_all(&piece)
        {
            file = None;
            disk.fail(failure);
        }
        disk.waiting.fetch_sub(piece.len(), Ordering::Relaxed);
    }
}

/// The loop's end of the queue. Writing to it never waits and never fails.
pub(crate) struct Queue {
    /// `None` writes nowhere.
    pieces: Option<Sender<Vec<u8>>>,
    disk: Arc<Disk>,
    buffer: Vec<u8>,
    position: u64,
}

impl Queue {
    fn nowhere() -> Self {
        Self {
            pieces: None,
            disk: Arc::default(),
            buffer: Vec::new(),
            position: 0,
        }
    }
}

impl Write for Queue {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.position += bytes.len() as u64;
        if self.pieces.is_none() {
            return Ok(bytes.len());
        }
        self.disk.part.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        self.buffer.extend_from_slice(bytes);
        if self.buffer.len() >= PIECE {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if let Some(pieces) = &self.pieces
            && !self.buffer.is_empty()
        {
            let piece = std::mem::replace(&mut self.buffer, Vec::with_capacity(PIECE));
            self.disk.waiting.fetch_add(piece.len(), Ordering::Relaxed);
            // The thread runs as long as this end exists, unless it has panicked, which it has then reported.
            let _gone = pieces.send(piece);
        }
        Ok(())
    }
}

/// The recorder asks for its position and never seeks elsewhere.
impl Seek for Queue {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.position),
            SeekFrom::Start(_) | SeekFrom::End(_) | SeekFrom::Current(_) => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}

impl Drop for Queue {
    fn drop(&mut self) {
        // This never fails.
        let _infallible = self.flush();
    }
}

#[cfg(test)]
mod tests {
    use backseat_recorder::{Rate, Record, Sources, parse};
    use backseat_units::{Position, Utc};

    use super::*;
    use crate::log_parts::{Current, Split};

    /// A disk that accepts nothing until the test lets it.
    struct Stuck {
        thaw: Receiver<()>,
        thawed: bool,
        written: Arc<Mutex<Vec<u8>>>,
    }

    impl Write for Stuck {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if !self.thawed {
                // The test has let it continue, or has failed.
                let _let = self.thaw.recv();
                self.thawed = true;
            }
            self.written.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn at(millis: u64) -> Timestamp {
        Timestamp::ZERO + Duration::from_millis(millis)
    }

    /// A disk that panics.
    struct Panics;

    impl Write for Panics {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            panic!("the test panics in a write")
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn header() -> Header<'static> {
        Header {
            utc_at_start: Utc::from_unix_nanos(0),
            rate: Rate::Deployed,
            mission: "a mission",
            seed: None,
            resolved_mission: "",
            fence: "{}",
            origin: Position::from_deg(42.0, -70.0).unwrap(),
            world: None,
            components: &[],
            version: "0",
            sources: Sources::default(),
        }
    }

    #[test]
    fn sr_022_a_log_whose_thread_panics_ends_and_the_run_goes_on() {
        let mut recording = Recording::to(Panics, "a log".to_owned(), &header()).unwrap();
        // Far more than the queue holds, because the panic takes some time.
        let bytes = vec![b'x'; 1 << 20];
        let mut second = 0;
        while recording.recorder.is_some() {
            second += 1;
            assert!(second < 10_000_000, "the log has not ended");
            let now = at(1000 * second);
            recording.record(now, |recorder| {
                recorder.input(now, &backseat_core::Input::Received(&bytes))
            });
            std::thread::yield_now();
        }
        recording.finish(at(1_000_000));
    }

    #[test]
    fn sr_022_a_log_whose_next_part_cannot_begin_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let first = folder.path().join("logs/dive-0.mcap");
        let written = Arc::new(Mutex::new(Vec::new()));
        let (_, thaw) = channel();
        let disk = Stuck {
            thaw,
            thawed: true,
            written: Arc::clone(&written),
        };
        let current = Current::new(&first);
        let parts = Parts::new(
            vec![Split::Bytes(1_000_000)],
            current.clone(),
            "dive",
            Utc::from_unix_nanos(0),
        );
        let mut recording = Recording::to(disk, "a log".to_owned(), &header())
            .unwrap()
            .in_parts(parts);
        let record = |recording: &mut Recording, second: u64| {
            let now = Timestamp::from_secs(second);
            let bytes = vec![b'x'; 100_000];
            recording.record(now, |recorder| {
                recorder.input(now, &backseat_core::Input::Received(&bytes))
            });
            // The part's thread has its turn.
            std::thread::yield_now();
        };
        // There is no such folder, as there may be no file left for the process.
        let mut second = 0;
        while second < 40 || recording.next.is_some() {
            second += 1;
            record(&mut recording, second);
        }
        assert_eq!(current.path(), first);
        std::fs::create_dir(folder.path().join("logs")).unwrap();
        let before = second;
        while current.path() == first {
            second += 1;
            assert!(second < 100_000, "no part begins");
            record(&mut recording, second);
        }
        recording.finish(Timestamp::from_secs(second));
        // Nothing is missing.
        let one = parse(&written.lock().unwrap()).unwrap();
        let two = parse(&std::fs::read(current.path()).unwrap()).unwrap();
        assert!(one.complete && two.complete);
        assert!(one.entries.len() as u64 >= before, "{} of {second}", one.entries.len());
        assert_eq!(one.entries.len() + two.entries.len(), usize::try_from(second).unwrap());
    }

    #[test]
    fn sr_022_a_disk_that_is_stuck_costs_records_and_the_log_says_which() {
        let (thaws, thaw) = channel();
        let written = Arc::new(Mutex::new(Vec::new()));
        let stuck = Stuck {
            thaw,
            thawed: false,
            written: Arc::clone(&written),
        };
        let mut recording = Recording::to(stuck, "a log".to_owned(), &header()).unwrap();
        let bytes = vec![b'x'; 1 << 20];
        let read = backseat_core::Input::Received(&bytes);
        for second in 0..100 {
            recording.record(at(1000 * second), |recorder| recorder.input(at(1000 * second), &read));
        }
        assert!(
            recording.disk.waiting.load(Ordering::Relaxed) < WAITING_MAX + (4 << 20),
            "the queue is bounded"
        );
        thaws.send(()).unwrap();
        while recording.disk.waiting.load(Ordering::Relaxed) > WAITING_LOW {
            std::thread::yield_now();
        }
        recording.record(at(200_000), |recorder| recorder.input(at(200_000), &read));
        recording.finish(at(200_000));
        let log = parse(&written.lock().unwrap()).unwrap();
        assert!(log.complete);
        let gaps: Vec<(usize, u64)> = log
            .entries
            .iter()
            .enumerate()
            .filter_map(|(place, entry)| {
                let Record::Gap { records, since_s } = entry.record else {
                    return None;
                };
                assert!(since_s < 100.0);
                Some((place, records))
            })
            .collect();
        let [(place, records)] = gaps[..] else {
            panic!("{gaps:?}");
        };
        assert_eq!(
            place as u64 + records,
            100,
            "recorded and missing records add up to all"
        );
        assert_eq!(log.entries.len(), place + 2);
    }
}
