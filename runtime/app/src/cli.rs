use std::path::PathBuf;

use backseat_mission::Layers;
use backseat_mvc::RoleConfig;
use backseat_units::Utc;
use clap::{Args, Parser, Subcommand, ValueEnum};

/// Fly adaptive-survey plugins on a Bluefin vehicle: in simulation, and at sea.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fly a mission in simulation: runtime, plugins and mock vehicle on a virtual clock
    Sim(Sim),
    /// Fly a mission on a vehicle, over TCP; without --arm it sends nothing that steers
    Run(Run),
    /// Run the mock vehicle alone, for any SPI client
    ///
    /// It flies the front seat's plan of the mission's world.toml and serves the Standard Payload Interface over TCP to
    /// several clients at once. Nothing that a client sends harms another: at most it loses its own connection.
    ///
    /// On a terminal a status line shows the vehicle at a glance; elsewhere a line a minute. Ctrl-C or SIGTERM ends it.
    Mvc(Mvc),
    /// Check a mission before a dive: its files, fence, plugins and plan
    Check(Check),
    /// Look at the log of a run
    #[command(subcommand)]
    Log(Log),
    /// Look at the Standard Payload Interface: its messages, recordings of it, a live vehicle
    #[command(subcommand)]
    Spi(Spi),
}

/// What all commands that read a mission share.
#[derive(Debug, Args)]
pub(crate) struct MissionArguments {
    /// The mission's folder, with mission.toml, its fence (fence.geojson, fence.plan or fence.kml) and, to simulate it,
    /// world.toml
    pub(crate) mission: PathBuf,
    /// Look for plugins given by bare name in this folder first
    #[arg(long, value_name = "DIR", value_parser = folder)]
    pub(crate) plugins: Option<PathBuf>,
    /// Set a key of mission.toml, over the file and the environment, such as limits.speed_max_mps=1.8
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

impl MissionArguments {
    pub(crate) fn layers(&self) -> Layers {
        Layers {
            set: self.set.clone(),
            environment: true,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Sim {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Draws the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Let go wrong what this file says and when, instead of the [faults] of world.toml
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) faults: Option<PathBuf>,
    /// Write the log here
    #[arg(long, value_name = "FILE.mcap")]
    pub(crate) log: Option<PathBuf>,
    /// Draw the run here
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) map: Option<PathBuf>,
    /// How many times faster than life, or `max`
    #[arg(long, default_value = "max", value_name = "X|max")]
    pub(crate) speed: Speed,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// The vehicle's address, instead of the mission's
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) connect: Option<String>,
    /// Send what steers the vehicle; without it all else is done
    #[arg(long)]
    pub(crate) arm: bool,
    /// Write logs into this folder
    #[arg(long, value_name = "DIR", default_value = "logs")]
    pub(crate) log: PathBuf,
    /// Keep identifiers and the operator's hold in this folder [default: the user's state folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
    /// Start a new record of SPI identifiers at this number, which no payload of this vehicle's mission has used
    // 0 means none on the wire (SPI 6.21); the end leaves room for every request of a mission.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=2_000_000_000))]
    pub(crate) first_identifier: Option<u32>,
}

#[derive(Debug, Args)]
pub(crate) struct Mvc {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Where to listen
    #[arg(long, default_value = "127.0.0.1:29500", value_name = "ADDR:PORT")]
    pub(crate) listen: String,
    /// How many times faster than life, or `max`: as fast as its clients read
    #[arg(long, default_value = "1", value_name = "X|max")]
    pub(crate) speed: Speed,
    /// Whose habits: the specification's, or real vehicles' [default: the world's]
    #[arg(long)]
    pub(crate) profile: Option<Profile>,
    /// Give a role to the client that connects from this address, as in 192.168.10.10::sonar; where there are roles, who
    /// gets none is turned away. Repeat it or write a list with commas [default: the world's roles]
    #[arg(long, value_name = "ADDRESS:PORT:ROLE", value_delimiter = ',')]
    pub(crate) iprole: Vec<RoleConfig>,
    /// Play these faults of vehicle and links, instead of the world's
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) faults: Option<PathBuf>,
    /// Draws the world, the noise and what the specification leaves open
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write every sentence both ways and every event here, with the vehicle's clock
    #[arg(long, value_name = "FILE")]
    pub(crate) log: Option<PathBuf>,
    /// End after so many seconds of the vehicle's time
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(crate) duration: Option<f64>,
}

fn folder(text: &str) -> Result<PathBuf, String> {
    let folder = PathBuf::from(text);
    if folder.is_dir() {
        Ok(folder)
    } else {
        Err("no such folder".to_owned())
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1e-3..=1e9).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, from 0.001 to 1e9".to_owned()),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Print mission.toml as it is after all layers, and stop
    #[arg(long)]
    pub(crate) resolved: bool,
    /// Hold this plan of the front seat against the fence, [[plan]] as in world.toml [default: the mission's [plan], then
    /// its world.toml's]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) plan: Option<PathBuf>,
    /// When the dive begins, as 2026-06-01T08:00:00Z: which zones are valid [default: now, and in simulation's world.toml]
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) at: Option<Utc>,
    /// Where the dive will write its logs
    #[arg(long, value_name = "DIR", default_value = "logs")]
    pub(crate) log: PathBuf,
    /// Where the dive will keep identifiers and the operator's hold [default: the user's state folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
}

fn utc(text: &str) -> Result<Utc, String> {
    backseat_fence::utc(text)
        .ok_or_else(|| "expected a date and time with its offset, as 2026-06-01T08:00:00Z".to_owned())
}

#[derive(Debug, Subcommand)]
pub(crate) enum Log {
    /// Judge a recorded run by the safety requirements, as simulations are judged
    ///
    /// The oracle that judges simulations reads the link's bytes in the log of a dive, with the mission's limits and the
    /// fence that are attached to it. A line for each rule says whether it held and how often there was something to judge,
    /// or why it could not be judged. The word before that is the side that the rule looks at: `sent` our sentences
    /// alone, `heard` our sentences after what the runtime had read from the vehicle, `operator` our sentences after what
    /// the operator did, `arrived` and `truth` what only a simulation knows: these are never judged here, even in the log
    /// of a simulation. Where a rule broke, time, rule, text and sentence follow.
    ///
    /// Where the disk was too slow, records are missing. Past such a gap nothing is claimed that hangs on what was before
    /// it, until the log tells it again.
    ///
    /// Exit code 0 where nothing broke, 1 where something did, 2 where the file cannot be judged.
    Judge(LogJudge),
}

#[derive(Debug, Args)]
pub(crate) struct LogJudge {
    /// The log, as `run` or `sim --log` writes it
    #[arg(value_name = "DIVE.mcap")]
    pub(crate) file: PathBuf,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Spi {
    /// Show the messages of the interface, one a line; or one message whole
    ///
    /// A row has the message's name, its section in SPI 1.12a, who sends it, its title, and its fields with unit and range.
    List(SpiList),
    /// Show what a recording says, one line or JSON object for each sentence
    ///
    /// Bytes of any kind are taken: sentences of both directions, line ends of all kinds, text before a `$`, broken lines.
    /// A sentence begins with `$` and a name, and no sentence is dropped: what cannot be read is shown with its error.
    /// What is no sentence (noise, lines over 4352 bytes) is counted on standard error at the end.
    ///
    /// With --json an object has `name`, `checksum` (valid, invalid, absent), and either `message`, the typed fields that
    /// `backseat spi list` names, or `error`, with the `line` of the input. Of a sentence with a wrong checksum nothing is
    /// sure, so that it has an `error`, which names the right checksum; --ignore-checksum reads it all the same.
    ///
    /// Exit code 0 also where sentences were faulty; 2 where the input cannot be read.
    Decode(SpiDecode),
    /// Make sentences of JSON objects, one a line, as `decode --json` writes them
    ///
    /// An object is {"name":"BPLOG","message":{"message":"NVG","on":true}}. What comes out is valid: checksum, CRLF, every
    /// value within its range, no reserved character in a text. The first wrong line ends it, with exit code 2 and an error
    /// that names line, field and what was expected; the sentences before it have been written.
    Encode(SpiEncode),
    /// Watch a live vehicle: subscribe to what it tells, and show it
    ///
    /// On a terminal it shows the vehicle at a glance; into a pipe or with --json a line for each sentence, with the
    /// seconds since the start. It sends the subscriptions (BPLOG) and nothing else, not even BPVER: it is no payload, and
    /// takes no part in the mission. A lost link is made again with back-off.
    ///
    /// Ctrl-C ends it with a summary on standard error. Exit code 0 where a message was read, 1 where none was.
    Connect(SpiConnect),
}

#[derive(Debug, Args)]
pub(crate) struct SpiList {
    /// Show these whole: BFNVG, or its last three letters
    pub(crate) names: Vec<String>,
    /// Print a JSON object for each message, one a line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SpiDecode {
    /// The recording, or - for standard input
    pub(crate) file: PathBuf,
    /// Print a JSON object for each sentence, one a line
    #[arg(long)]
    pub(crate) json: bool,
    /// Read sentences whose checksum is wrong; it is still told to be
    #[arg(long)]
    pub(crate) ignore_checksum: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SpiEncode {
    /// The objects, or - for standard input
    #[arg(default_value = "-")]
    pub(crate) file: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct SpiConnect {
    /// Where the vehicle listens [default port: 29500]
    #[arg(value_name = "HOST[:PORT]")]
    pub(crate) address: String,
    /// Print a JSON object for each sentence, one a line
    #[arg(long)]
    pub(crate) json: bool,
    /// Subscribe to these only; what a vehicle sends unasked is shown too [default: everything]
    #[arg(long, value_name = "NVG,CTL", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// End after so many seconds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) seconds: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Profile {
    /// As the specification has it: all status messages off
    Spec,
    /// As real vehicles are: CTL and MIS on from the start
    Field,
}

/// A factor on real time, or as fast as it goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Speed {
    Times(f64),
    Max,
}

impl std::str::FromStr for Speed {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "max" {
            return Ok(Self::Max);
        }
        match text.parse::<f64>() {
            // Beyond these the wall clock's own figures would overflow.
            Ok(times) if (1e-3..=1e6).contains(&times) => Ok(Self::Times(times)),
            _ => Err("expected a number from 0.001 to 1000000, or `max`".to_owned()),
        }
    }
}
