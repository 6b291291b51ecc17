use clap::{Parser, Subcommand};

#[cfg(feature = "simulation")]
use crate::campaign::Campaign;
use crate::check::Check;
use crate::doctor::Doctor;
use crate::explain::Explain;
#[cfg(feature = "simulation")]
use crate::fly::Fly;
use crate::generate::Generate;
use crate::lock::Key;
use crate::log::Log;
#[cfg(feature = "simulation")]
use crate::mvc::Mvc;
#[cfg(feature = "simulation")]
use crate::plc::Plc;
#[cfg(feature = "plugin")]
use crate::plugin::Plugin;
use crate::replay::Replay;
use crate::run::Run;
use crate::s7k::S7k;
#[cfg(feature = "simulation")]
use crate::sim::Sim;
use crate::spi::Spi;
use crate::swap::Swap;

/// Let plugins steer a Bluefin vehicle inside a geofence, in simulation and at sea.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate a mission: runtime, plugins and mock vehicle on a virtual clock
    #[cfg(feature = "simulation")]
    Sim(Sim),
    /// Simulate a mission by the thousand: over seeds, parameters and variants, in shards on a cluster
    ///
    /// `backseat campaign CAMPAIGN.toml --out DIR` flies every run of a campaign's file on all cores, and `backseat campaign
    /// MISSION --seeds 1..1000 --out DIR` a mission with many seeds. Ctrl-C stops it, and the same command goes on.
    ///
    /// DIR has runs.parquet (a row for each run), timing.parquet, manifest.json and report.html then. runs.parquet has the
    /// same bytes however it was made: at once, in pieces, or in shards on several computers.
    ///
    /// Exit code: 0 if every run met its expectations, 1 if one did not or could not be flown, 2 if the campaign cannot be
    /// flown, 75 if it was stopped before its end.
    #[cfg(feature = "simulation")]
    Campaign(Campaign),
    /// Run a mission on a vehicle over TCP; without --arm nothing that steers is sent
    Run(Run),
    /// Fly a mission in real time, or faster: `mvc` and `run --arm` in one, over TCP
    ///
    /// The runtime is the one that goes to sea, with its threads, its timers and its log. The mock vehicle flies the
    /// plan of the mission's world.toml. Both live by one clock. Faster than real time, only the time in which both wait
    /// is shortened: whatever is in time at --speed 1 is in time at every speed, and a computer that is too slow flies
    /// longer.
    ///
    /// On a terminal two lines show the state; elsewhere a line each ten seconds does. The flight ends some seconds
    /// after the mission. Ctrl-C or SIGTERM ends it before; SIGUSR1 holds the plugins and SIGUSR2 releases them.
    #[cfg(feature = "simulation")]
    Fly(Fly),
    /// Run only the mock vehicle, for any SPI client
    ///
    /// The mock vehicle flies the front seat's plan of a world.toml, and needs nothing else of a mission. It serves the
    /// Standard Payload Interface over TCP to several clients at once. A client that misbehaves loses its own connection
    /// at most, and never disturbs another.
    ///
    /// While it runs you can type commands, or write them into its standard input: `fault stall for_s=10`,
    /// `control take`, `top acoustic-modem come home`, `abort`, `shutdown`, `status`; `help` lists them. The end of
    /// standard input does not end the program. A script (--script) orders the same when something happens.
    ///
    /// On a terminal two lines show the vehicle's state: press Enter, then type a command. Elsewhere the state is
    /// printed once a minute. Ctrl-C or SIGTERM ends the program.
    #[cfg(feature = "simulation")]
    Mvc(Mvc),
    /// Run only the mock payload controller with its sonars, for any 7k client
    ///
    /// The mock payload controller behaves like a RESON 6046 with a sidescan and a sub-bottom profiler, as [plc] of a
    /// world.toml describes it; it needs nothing else of a mission. Its sonars see the seabed and the targets of that
    /// world. Clients report the vehicle's position in records 3100; until one does, the vehicle stands at [start].
    ///
    /// Each event is a line on standard error. Ctrl-C or SIGTERM ends the program, and so does a client's shutdown
    /// command; log files are whole then.
    #[cfg(feature = "simulation")]
    Plc(Plc),
    /// Check a mission before a dive: its files, fence, plugins and plan
    Check(Check),
    /// Check whether this computer and its network are ready for a dive
    ///
    /// That is: clock, disk, processor, permissions, vehicle, payload controller, program and plugins. Each line names one thing that was checked, and its state: `ok`, `odd` (the dive can go on, and somebody should know) or `bad`.
    /// The command connects once to the vehicle and once to the payload controller, and asks both for the time by NTP;
    /// --offline skips this. `check` checks the mission.
    ///
    /// Exit code: 0 if nothing is bad, 1 if something is, 2 if the mission cannot be read.
    Doctor(Doctor),
    /// Replay the log of a run: core and plugins again from the recorded inputs
    ///
    /// Core gets the recorded inputs, and every output must be the recorded one, byte for byte. Each plugin gets the
    /// recorded steps, and must return what it returned then, with the same fuel. The log has all that this needs:
    /// mission, fence and components. A component over 8 MiB is in it by its hash alone; give it with --component.
    ///
    /// With --plugin NAME=FILE another component, such as a new version, takes a plugin's place: the program shows in
    /// which steps it asks for something else, what it knew there, what core made of the recorded request, and what the
    /// safety monitor says of the new one. Nothing that it asks for has an effect: its inputs stay the recorded ones. If
    /// it fails, it is restarted before its next step.
    ///
    /// If a plugin's call was cut off in the dive because it took more than a second, replay cuts off the same call,
    /// however long it takes now. The log of a killed process is
    /// replayed as far as it goes. After a gap, where the disk was too slow, nothing can be replayed.
    ///
    /// Exit code: 0 if all is identical, 1 if not, 2 if the log or a part of it cannot be replayed.
    Replay(Replay),
    #[cfg_attr(feature = "simulation", doc = "Show, judge, join or export the log of a run")]
    #[cfg_attr(not(feature = "simulation"), doc = "Show, sum up or join the log of a run")]
    #[command(subcommand)]
    Log(Log),
    /// Make, build, test, inspect and check a plugin, in any folder
    ///
    /// The program carries the sources of the SDK, so a Rust toolchain (https://rustup.rs) with the target
    /// wasm32-unknown-unknown is all that `new`, `build` and `test` need; for a plugin in Python, Python 3.11 or later, and a
    /// network the first time. `inspect` and `check` need no toolchain.
    #[cfg(feature = "plugin")]
    #[command(subcommand)]
    Plugin(Plugin),
    /// List, decode and encode SPI messages, or watch a live vehicle
    #[command(subcommand)]
    Spi(Spi),
    /// Inspect, check, cut and convert recordings of the sonar payload (.s7k)
    #[command(subcommand)]
    S7k(S7k),
    /// Put another version in the place of a plugin, in the middle of a dive
    ///
    /// The runtime compiles FILE while it keeps steering, and switches to the new version between two steps. The new version
    /// receives the old version's snapshot (`restore`), and the old version's open requests stay in force. In its first steps
    /// the new version is on trial. If it fails, or if the runtime refuses one of its requests because of its content, the
    /// runtime ends the lease and brings back the old version with the state that it had at the swap. The lease starts again
    /// when the old version asks for it. Name the hash of FILE with --sha256; a locked mission allows only what was signed for it
    /// (`check --sign KEY --may-swap NAME=FILE`). The swap lasts as long as the run: a runtime that is started again begins
    /// with the mission's component.
    ///
    /// Exit code: 0 if the version took over, 1 if not, 2 if it could not be tried.
    Swap(Swap),
    /// Make a pair of keys, for `check --sign` and `run --locked`
    Key(Key),
    /// Explain a key of a mission's files, such as turn_rate_dps
    Explain(Explain),
    /// Write man pages and completions of shells, for packages
    #[command(hide = true)]
    Generate(Generate),
}
