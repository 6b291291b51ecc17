//! The controller's disk: a folder, behind a bounded queue with a thread of its own, so that a slow, stuck or full disk
//! stalls neither the controller nor its clients.

mod folder;
mod writer;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::Duration;

use anyhow::Result;
use backseat_plc::{FileEffect, FileFailure, FileId};
use tokio::sync::mpsc::UnboundedSender;

pub(crate) use folder::Folder;
pub(crate) use writer::Files;
use writer::Writer;

/// How many bytes may wait to be written. With all sonars pinging, the controller logs about 0.3 MB a second.
const WAITING_MAX: usize = 32 << 20;
/// What an effect counts for, besides its bytes.
const EFFECT: usize = 256;

/// What the disk says.
#[derive(Debug)]
pub(crate) enum Report {
    /// An effect on this file could not be carried out; the text says why.
    Failed(FileId, FileFailure, String),
    /// So many bytes are free, less those that wait.
    Free(u64),
}

/// The queue to the thread.
#[derive(Debug)]
pub(crate) struct Disk {
    effects: Sender<Job>,
    waiting: Arc<AtomicUsize>,
    /// Files of which an effect found no room in the queue. What else comes for them is dropped.
    lost: BTreeSet<FileId>,
}

#[derive(Debug)]
enum Job {
    Effect(FileEffect),
    /// Reports that everything before it has been written, and ends the thread.
    End(SyncSender<()>),
}

impl Disk {
    /// Starts the thread.
    ///
    /// # Errors
    ///
    /// If there can be no more threads.
    pub(crate) fn start(folder: Folder, reports: UnboundedSender<Report>) -> Result<Self> {
        let (effects, jobs) = channel();
        let waiting = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&waiting);
        thread::Builder::new().name("disk".to_owned()).spawn(move || {
            Writer::new(folder, counted, reports).serve(&jobs);
        })?;
        Ok(Self {
            effects,
            waiting,
            lost: BTreeSet::new(),
        })
    }

    /// Queues an effect. Where too much waits, nothing more of this file is written but its end, and the file is returned
    /// once.
    pub(crate) fn carry_out(&mut self, effect: FileEffect) -> Option<FileId> {
        let file = file_of(&effect);
        let closes = matches!(effect, FileEffect::Close { .. });
        if self.lost.contains(&file) {
            if !closes {
                return None;
            }
            self.lost.remove(&file);
        }
        let size = size_of(&effect);
        if !closes && self.waiting.load(Ordering::Relaxed) + size > WAITING_MAX {
            self.lost.insert(file);
            return Some(file);
        }
        self.waiting.fetch_add(size, Ordering::Relaxed);
        // The thread never ends before this queue does.
        let _sent = self.effects.send(Job::Effect(effect));
        None
    }

    /// Waits until everything is written; false if the disk takes longer.
    pub(crate) fn finish(self, within: Duration) -> bool {
        let (done, is_done) = sync_channel(1);
        self.effects.send(Job::End(done)).is_ok() && is_done.recv_timeout(within).is_ok()
    }
}

pub(crate) const fn file_of(effect: &FileEffect) -> FileId {
    match effect {
        FileEffect::Open { file, .. }
        | FileEffect::Append { file, .. }
        | FileEffect::Patch { file, .. }
        | FileEffect::Truncate { file, .. }
        | FileEffect::Close { file } => *file,
    }
}

const fn size_of(effect: &FileEffect) -> usize {
    let bytes = match effect {
        FileEffect::Append { bytes, .. } | FileEffect::Patch { bytes, .. } => bytes.len(),
        FileEffect::Open { .. } | FileEffect::Truncate { .. } | FileEffect::Close { .. } => 0,
    };
    bytes + EFFECT
}

#[cfg(test)]
mod tests {
    use std::fs;

    use backseat_plc::FilePlace;

    use super::*;

    fn place(folder: Option<&str>, name: &str) -> FilePlace {
        FilePlace {
            folder: folder.map(str::to_owned),
            name: name.to_owned(),
        }
    }

    #[test]
    fn effects_become_files_and_a_failure_leaves_the_rest_of_a_file_out() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::open(temporary.path(), "D:\\data").unwrap();
        fs::write(temporary.path().join("6046.cfg"), "old").unwrap();
        fs::write(temporary.path().join("taken.s7k"), "mine").unwrap();
        let (reports, mut reported) = tokio::sync::mpsc::unbounded_channel();
        let mut disk = Disk::start(folder, reports).unwrap();
        let bytes = |text: &str| text.as_bytes().to_vec();
        let open = |file, place, replace| FileEffect::Open { file, place, replace };
        let (log, settings, taken) = (FileId(1), FileId(2), FileId(3));
        for effect in [
            open(log, place(Some("D:\\data"), "a.s7k"), false),
            FileEffect::Append {
                file: log,
                bytes: bytes("header record"),
            },
            FileEffect::Patch {
                file: log,
                at: 0,
                bytes: bytes("HEADER"),
            },
            FileEffect::Append {
                file: log,
                bytes: bytes(" half"),
            },
            FileEffect::Truncate { file: log, length: 13 },
            FileEffect::Append {
                file: log,
                bytes: bytes("!"),
            },
            open(settings, place(None, "6046.cfg"), true),
            FileEffect::Append {
                file: settings,
                bytes: bytes("new"),
            },
            open(taken, place(Some("D:\\data"), "taken.s7k"), false),
            FileEffect::Append {
                file: taken,
                bytes: bytes("theirs"),
            },
            FileEffect::Close { file: taken },
            FileEffect::Close { file: log },
            FileEffect::Close { file: settings },
        ] {
            assert_eq!(disk.carry_out(effect), None);
        }
        assert!(disk.finish(Duration::from_secs(20)));
        let read = |name: &str| fs::read_to_string(temporary.path().join(name)).unwrap();
        assert_eq!(
            (read("a.s7k"), read("6046.cfg"), read("taken.s7k")),
            ("HEADER record!".into(), "new".into(), "mine".into())
        );
        let mut failed = Vec::new();
        while let Ok(report) = reported.try_recv() {
            if let Report::Failed(file, failure, text) = report {
                assert!(text.contains("taken.s7k: "), "{text}");
                failed.push((file, failure));
            }
        }
        assert_eq!(failed, [(taken, FileFailure::Exists)], "told once");
    }

    #[test]
    fn a_stuck_disk_loses_a_file_and_waits_for_nothing() {
        // Nobody takes from this queue.
        let (effects, _jobs) = channel();
        let mut disk = Disk {
            effects,
            waiting: Arc::default(),
            lost: BTreeSet::new(),
        };
        let (file, next) = (FileId(1), FileId(2));
        let record = |file| FileEffect::Append {
            file,
            bytes: vec![0; 1 << 20],
        };
        let lost: Vec<FileId> = (0..40).filter_map(|_| disk.carry_out(record(file))).collect();
        assert_eq!(lost, [file], "told once");
        assert!(disk.waiting.load(Ordering::Relaxed) <= WAITING_MAX);
        assert_eq!(disk.carry_out(FileEffect::Close { file }), None);
        assert_eq!(disk.carry_out(record(next)), Some(next));
    }
}
