//! Breadth first from one state: what was met before is cut, and the first sequence that breaks a rule is a shortest one.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

use serde::Serialize;

use crate::fingerprint::Fingerprint;
use crate::judge::Broken;
use crate::kind::Kind;
use crate::world::{SENTENCES, World};

/// Bits of a kind in a [`Path`].
const BITS: u32 = 5;
/// The deepest that a search can go.
pub const DEPTH_MAX: usize = (u64::BITS / BITS) as usize;
/// So many states of a level are one worker's at a time.
const CHUNK: usize = 64;
/// New states of a worker are sorted, and those that it has twice thrown away, at so many.
const COMPACT: usize = 4_000_000;

/// A sequence of kinds from the prepared state on, the first in the highest bits: neighbours in order have their beginning
/// in common, so that each is reached from the one before in a few steps. Only paths of one length are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Path(u64);

impl Path {
    const fn then(self, depth: usize, kind: usize) -> Self {
        Self(self.0 | (kind as u64) << (u64::BITS - BITS * (depth as u32 + 1)))
    }

    const fn kind(self, depth: usize) -> usize {
        (self.0 >> (u64::BITS - BITS * (depth as u32 + 1))) as usize & ((1 << BITS) - 1)
    }
}

/// How far a search may go.
pub struct Bounds<'a> {
    /// No deeper than this.
    pub depth: usize,
    /// No more states than this.
    pub states: usize,
    /// Threads.
    pub workers: usize,
    /// It is time to end.
    pub is_over: &'a (dyn Fn() -> bool + Sync),
    /// A level is done.
    pub tell: &'a dyn Fn(&Level),
}

/// A level of a search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Level {
    /// How many inputs its sequences have.
    pub depth: usize,
    /// Different states that were first met here.
    pub states: usize,
    /// Sequences that were tried: each state of the level before, with each kind.
    pub transitions: u64,
    /// Those that led to a state that was met before.
    pub cut: u64,
    /// The part of the level before that was gone on from; 1 where the level is whole.
    pub part: f64,
}

/// A broken rule, with a shortest sequence that breaks it.
#[derive(Clone, Debug)]
pub struct Found {
    /// The inputs from the prepared state on.
    pub sequence: Vec<Kind>,
    /// The rule, and how it was broken.
    pub broken: Broken,
}

/// What came of a search.
#[derive(Clone, Debug, Default)]
pub struct Searched {
    /// Level by level.
    pub levels: Vec<Level>,
    /// In how many sequences the last input made core say each of [`SENTENCES`].
    pub said: [u64; SENTENCES.len()],
    /// By rule.
    pub found: BTreeMap<&'static str, Found>,
}

impl Searched {
    /// The deepest level that is whole.
    #[must_use]
    pub fn depth(&self) -> usize {
        let whole = self.levels.iter().take_while(|level| level.part >= 1.0);
        whole.last().map_or(0, |level| level.depth)
    }

    /// Different states, the first among them.
    #[must_use]
    pub fn states(&self) -> usize {
        1 + self.levels.iter().map(|level| level.states).sum::<usize>()
    }

    /// Sequences that were tried.
    #[must_use]
    pub fn transitions(&self) -> u64 {
        self.levels.iter().map(|level| level.transitions).sum()
    }

    /// Sequences that led to a state that was met before.
    #[must_use]
    pub fn cut(&self) -> u64 {
        self.levels.iter().map(|level| level.cut).sum()
    }
}

/// What one worker has found of a level.
#[derive(Default)]
struct Yield {
    new: Vec<(Fingerprint, Path)>,
    found: BTreeMap<&'static str, (Path, Broken)>,
    transitions: u64,
    expanded: usize,
    said: [u64; SENTENCES.len()],
}

impl Yield {
    fn compact(&mut self) {
        self.new.sort_unstable();
        self.new.dedup_by_key(|(fingerprint, _)| *fingerprint);
    }

    fn says(&mut self, said: [bool; SENTENCES.len()]) {
        for (count, said) in self.said.iter_mut().zip(said) {
            *count += u64::from(said);
        }
    }

    fn finds(&mut self, path: Path, broken: Broken) {
        let first = self.found.entry(broken.rule).or_insert_with(|| (path, broken.clone()));
        if path < first.0 {
            *first = (path, broken);
        }
    }
}

/// Tries all sequences of `kinds` from `start` on.
#[must_use]
pub fn search(start: &World, kinds: &[Kind], bounds: &Bounds<'_>) -> Searched {
    assert!(kinds.len() <= 1 << BITS, "a path has room for {} kinds", 1 << BITS);
    let mut searched = Searched::default();
    let mut seen = vec![start.fingerprint()];
    let mut frontier = vec![Path(0)];
    for depth in 0..bounds.depth.min(DEPTH_MAX) {
        if frontier.is_empty() || (bounds.is_over)() || seen.len() >= bounds.states {
            break;
        }
        let all = expand(start, kinds, depth, &frontier, &seen, bounds);
        let states = all.new.len();
        for (count, new) in searched.said.iter_mut().zip(all.said) {
            *count += new;
        }
        for (rule, (path, broken)) in all.found {
            searched.found.entry(rule).or_insert_with(|| Found {
                sequence: (0..=depth).map(|at| kinds[path.kind(at)]).collect(),
                broken,
            });
        }
        let level = Level {
            depth: depth + 1,
            states,
            transitions: all.transitions,
            cut: all.transitions - states as u64,
            part: all.expanded as f64 / frontier.len() as f64,
        };
        (bounds.tell)(&level);
        searched.levels.push(level);
        seen.extend(all.new.iter().map(|(fingerprint, _)| *fingerprint));
        seen.sort_unstable();
        frontier = all.new.into_iter().map(|(_, path)| path).collect();
        frontier.sort_unstable();
        if level.part < 1.0 {
            break;
        }
    }
    searched
}

/// Goes on from each state of a level. What comes of it does not hang on the number of workers.
fn expand(
    start: &World,
    kinds: &[Kind],
    depth: usize,
    frontier: &[Path],
    seen: &[Fingerprint],
    bounds: &Bounds<'_>,
) -> Yield {
    let next = AtomicUsize::new(0);
    let over = AtomicBool::new(false);
    let all = Mutex::new(Yield::default());
    let room = bounds.states.saturating_sub(seen.len());
    thread::scope(|scope| {
        for _ in 0..bounds.workers.max(1) {
            scope.spawn(|| {
                let mut own = Yield::default();
                let mut way = Way::new(start, kinds);
                loop {
                    if (bounds.is_over)() || own.new.len() / 2 > room {
                        over.store(true, Ordering::Relaxed);
                    }
                    let first = next.fetch_add(1, Ordering::Relaxed) * CHUNK;
                    if first >= frontier.len() || over.load(Ordering::Relaxed) {
                        break;
                    }
                    for path in &frontier[first..frontier.len().min(first + CHUNK)] {
                        let from = way.to(*path, depth);
                        for (index, kind) in kinds.iter().enumerate() {
                            let path = path.then(depth, index);
                            let mut world = from.clone();
                            own.transitions += 1;
                            let stepped = world.step(*kind);
                            own.says(world.said());
                            match stepped {
                                Err(broken) => own.finds(path, broken),
                                Ok(()) => {
                                    let fingerprint = world.fingerprint();
                                    if seen.binary_search(&fingerprint).is_err() {
                                        own.new.push((fingerprint, path));
                                    }
                                }
                            }
                        }
                        own.expanded += 1;
                    }
                    if own.new.len() > COMPACT && own.new.len() == own.new.capacity() {
                        own.compact();
                    }
                }
                own.compact();
                let mut all = all.lock().expect("no worker panics while it adds up");
                all.transitions += own.transitions;
                all.expanded += own.expanded;
                for (count, own) in all.said.iter_mut().zip(own.said) {
                    *count += own;
                }
                all.new.append(&mut own.new);
                for (path, broken) in own.found.into_values() {
                    all.finds(path, broken);
                }
            });
        }
    });
    let mut all = all.into_inner().expect("no worker has panicked");
    all.compact();
    all
}

/// The states on the way to the one that is gone on from: the next in order is few steps away.
struct Way<'a> {
    kinds: &'a [Kind],
    worlds: Vec<World>,
    path: Path,
}

impl<'a> Way<'a> {
    fn new(start: &World, kinds: &'a [Kind]) -> Self {
        Self {
            kinds,
            worlds: vec![start.clone()],
            path: Path(0),
        }
    }

    fn to(&mut self, path: Path, depth: usize) -> &World {
        let known = self.worlds.len() - 1;
        let shared = (0..known.min(depth))
            .take_while(|at| self.path.kind(*at) == path.kind(*at))
            .count();
        self.worlds.truncate(shared + 1);
        for at in shared..depth {
            let mut world = self.worlds[at].clone();
            world
                .step(self.kinds[path.kind(at)])
                .expect("what was met before broke nothing");
            self.worlds.push(world);
        }
        self.path = path;
        &self.worlds[depth]
    }
}
