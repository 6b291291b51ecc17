//! `backseat spi`: the tools, between files, standard streams and a terminal.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use backseat_spi_tools::{Address, Connection, Decoding, Error, Form, Listing, Subscription, View, connect};
use clap::{Args, Subcommand};
use tokio::signal::unix::{SignalKind, signal};

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

pub(crate) fn spi(command: &Spi) -> Result<bool> {
    match command {
        Spi::List(arguments) => {
            let listing = if arguments.json {
                Listing::Json
            } else {
                Listing::Text { colour: colour() }
            };
            let mut out = BufWriter::new(io::stdout().lock());
            finished(backseat_spi_tools::list(&arguments.names, listing, &mut out))?;
            Ok(true)
        }
        Spi::Decode(arguments) => decode(arguments),
        Spi::Encode(arguments) => {
            let input = open(&arguments.file)?;
            let done = finished(backseat_spi_tools::encode(input, &mut io::stdout().lock()));
            done.with_context(|| place(&arguments.file))?;
            Ok(true)
        }
        Spi::Connect(arguments) => watch(arguments),
    }
}

fn decode(arguments: &SpiDecode) -> Result<bool> {
    let decoding = Decoding {
        form: form(arguments.json),
        ignore_checksum: arguments.ignore_checksum,
    };
    let input = open(&arguments.file)?;
    let done = finished(backseat_spi_tools::decode(input, decoding, &mut io::stdout().lock()));
    if let Some(tally) = done.with_context(|| place(&arguments.file))? {
        crate::terminal::tell(&tally.to_string());
    }
    Ok(true)
}

fn watch(arguments: &SpiConnect) -> Result<bool> {
    let subscription = if arguments.only.is_empty() {
        Subscription::everything()
    } else {
        Subscription::only(arguments.only.iter().map(String::as_str)).context("--only")?
    };
    let connection = Connection {
        address: arguments.address.parse::<Address>()?,
        subscription,
        view: if arguments.json || !io::stdout().is_terminal() {
            View::Lines(form(arguments.json))
        } else {
            View::Panel { colour: colour() }
        },
        seconds: arguments.seconds,
    };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let watched = runtime.block_on(async {
        let mut interrupt = signal(SignalKind::interrupt())?;
        let mut terminate = signal(SignalKind::terminate())?;
        let stop = async {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        };
        anyhow::Ok(connect(&connection, stop, &mut io::stdout()).await?)
    })?;
    crate::terminal::tell(&watched.summary.to_string());
    Ok(watched.heard)
}

/// A reader of the output that has gone away is no error: `None`.
fn finished<T>(result: Result<T, Error>) -> Result<Option<T>, Error> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(error) if error.is_broken_pipe() => Ok(None),
        Err(error) => Err(error),
    }
}

fn form(json: bool) -> Form {
    if json {
        Form::Json
    } else {
        Form::Text { colour: colour() }
    }
}

/// Colours are for a terminal, and for those who have not turned them off.
fn colour() -> bool {
    io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

fn open(file: &Path) -> Result<Box<dyn Read>> {
    if file == Path::new("-") {
        return Ok(Box::new(io::stdin().lock()));
    }
    let opened = File::open(file).with_context(|| place(file))?;
    Ok(Box::new(opened))
}

fn place(file: &Path) -> String {
    if file == Path::new("-") {
        "standard input".to_owned()
    } else {
        file.display().to_string()
    }
}
