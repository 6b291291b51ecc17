//! Flies missions with a log, and replays logs.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use backseat_mission::{Layers, Mission};
use backseat_plugin_host::{Cache, Host};
use backseat_plugin_loader::load_plugins;
use backseat_recorder::{Header, LogReader, Message, Rate, Recorder, Sources};
use backseat_replay::{Configs, Flow, Given, Replay, ReplayError, Report, Task};
use backseat_scenario::Scenario;
use backseat_sim::{Simulation, Step};
use backseat_test_support::plugins;
use backseat_units::Timestamp;

/// A log in memory.
pub(crate) struct Log(pub(crate) Vec<u8>);

/// What is changed in a log before it is replayed.
pub(crate) type Change<'a> = &'a mut dyn FnMut(Message) -> Vec<Message>;

/// Nothing is changed.
pub(crate) fn unchanged(message: Message) -> Vec<Message> {
    vec![message]
}

impl Log {
    /// Reads a file.
    pub(crate) fn read(path: &Path) -> Self {
        Self(fs::read(path).unwrap())
    }

    /// Changes the attachment of this name, or leaves it out.
    pub(crate) fn edit_attachment(&mut self, name: &str, edit: impl Fn(Vec<u8>) -> Option<Vec<u8>>) {
        const MAGIC: usize = 8;
        const HEAD: usize = 9;
        const ATTACHMENT: u8 = 9;
        let (magic, mut rest) = self.0.split_at(MAGIC);
        let mut edited = magic.to_vec();
        while rest.len() > HEAD {
            let length = u64::from_le_bytes(rest[1..HEAD].try_into().unwrap()) as usize;
            let (record, after) = rest.split_at(HEAD + length);
            let names_it = record
                .windows(name.len())
                .take(64)
                .any(|bytes| bytes == name.as_bytes());
            if record[0] == ATTACHMENT && names_it {
                edited.extend(edit(record.to_vec()).unwrap_or_default());
            } else {
                edited.extend(record);
            }
            rest = after;
            // The end of the messages; an index follows, whose places are no longer true.
            if record[0] == 0x0f {
                break;
            }
        }
        self.0 = edited;
    }

    pub(crate) fn reader(&self) -> LogReader<Cursor<&[u8]>> {
        LogReader::new(Cursor::new(self.0.as_slice()), "in memory".to_owned()).unwrap()
    }

    /// Replays it as it is.
    pub(crate) fn replay(&self) -> Report {
        self.replay_with(Vec::new(), Configs::default(), &mut unchanged)
            .unwrap()
    }

    /// Replays it with other plugins, other configs, and changed messages.
    pub(crate) fn replay_with(
        &self,
        given: Vec<Given>,
        configs: Configs<'_>,
        change: Change<'_>,
    ) -> Result<Report, ReplayError> {
        let mut log = self.reader();
        let task = Task::of(&log, configs)?;
        let mut replay = Replay::new(task, &host(), given, 3)?;
        while let Some(message) = log.next_message().unwrap() {
            for message in change(message) {
                if replay.take(message)? == Flow::Over {
                    return Ok(replay.finish(log.is_complete()));
                }
            }
        }
        Ok(replay.finish(log.is_complete()))
    }
}

/// A host with the cache of the tests.
pub(crate) fn host() -> Host {
    let cache = Cache::new(backseat_test_support::cache(), |_| {});
    Host::new().unwrap().with_cache(Some(cache))
}

/// A component of the project for a plugin.
pub(crate) fn given(plugin: &str, component: &str) -> Given {
    let file = plugins().join(format!("{component}.wasm"));
    Given {
        plugin: plugin.to_owned(),
        file: format!("{component}.wasm"),
        bytes: fs::read(file).unwrap(),
    }
}

/// A flight of a mission.
pub(crate) struct Flight {
    mission: PathBuf,
    seed: u64,
    seconds: u64,
    /// Whether the log has what a replay needs and earlier versions did not write.
    sources: bool,
}

impl Flight {
    pub(crate) fn of(mission: impl Into<PathBuf>) -> Self {
        Self {
            mission: mission.into(),
            seed: 1,
            seconds: 24 * 3600,
            sources: true,
        }
    }

    pub(crate) fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// At most so long.
    pub(crate) fn seconds(self, seconds: u64) -> Self {
        Self { seconds, ..self }
    }

    /// With a log as earlier versions wrote it.
    pub(crate) fn of_earlier_version(self) -> Self {
        Self { sources: false, ..self }
    }

    /// Flies it.
    pub(crate) fn log(&self) -> Log {
        self.log_with(&mut |_| {})
    }

    /// Flies it; `interfere` is called between two events.
    pub(crate) fn log_with(&self, interfere: &mut dyn FnMut(&mut Simulation)) -> Log {
        let mission = Mission::load(&self.mission, &Layers::default()).unwrap();
        let scenario = Scenario::load(&mission).unwrap();
        let loaded = load_plugins(&host(), &mission, Some(plugins())).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        let header = Header {
            utc_at_start: scenario.world.start.utc,
            rate: Rate::Simulation,
            mission: &mission.name,
            seed: Some(self.seed),
            resolved_mission: &mission.resolved,
            fence: &mission.fence_text,
            origin: mission.envelope.fence().frame().origin(),
            world: Some(&scenario.text),
            components: &loaded.components,
            version: env!("CARGO_PKG_VERSION"),
            sources: if self.sources {
                Sources {
                    plan: mission.plan.as_ref().map(|plan| plan.text.as_str()),
                    fence: mission.other_fence(),
                    plugins: &loaded.setups,
                }
            } else {
                Sources::default()
            },
        };
        let recorder = Recorder::create(&path, &header).unwrap();
        let mut simulation = Simulation::new(&mission, &scenario, self.seed, loaded, Some(recorder)).unwrap();
        while simulation.advance_until(Timestamp::from_secs(self.seconds)).unwrap() == Step::Went {
            interfere(&mut simulation);
        }
        simulation.finish().unwrap();
        Log::read(&path)
    }
}

/// A copy of one of the project's missions, to change.
pub(crate) fn copied(mission: &Path) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in fs::read_dir(mission).unwrap() {
        let file = file.unwrap();
        if file.path().is_file() {
            fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
        }
    }
    folder
}
