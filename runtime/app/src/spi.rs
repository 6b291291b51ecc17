//! `backseat spi`: connects the SPI tools to files, standard streams and the terminal.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use backseat_recorder::{LoggedInput, Record};
use backseat_spi_tools::{
    Address, Connection, Decoding, Error, Form, Listing, Subscription, Traffic, View, connect, decode_traffic,
};
use clap::{Args, Subcommand};
use tokio::signal::unix::{SignalKind, signal};

use crate::terminal::tell;

#[derive(Debug, Subcommand)]
pub(crate) enum Spi {
    /// List the messages of the interface, or describe some in full
    ///
    /// Each row has the message's name, its section in SPI 1.12a, its sender, its title, and its fields with unit and
    /// range.
    List(SpiList),
    /// Decode a recording or the log of a run: one line or JSON object for each sentence
    ///
    /// A recording may hold any bytes: sentences of both directions, any line ends, text in front of a `$`, broken
    /// lines. A sentence begins with `$` and a name. Every sentence is shown; one that cannot be read is shown with its
    /// error. Other bytes (noise, lines over 4352 bytes) are counted, and the counts are printed on standard error at
    /// the end.
    ///
    /// With --json each object has `name`, `checksum` (valid, invalid, absent), and one of `message`, with the typed
    /// fields that `backseat spi list` describes, or `error`, with the `line` of the input. A sentence with a wrong
    /// checksum has an `error` that gives the right checksum, because any of its values may be wrong; --ignore-checksum
    /// decodes it nevertheless.
    ///
    /// The log of a run (.mcap, by `run`, `fly` or `sim --log`) has the bytes of both directions, and its sentences are
    /// shown in its order. In front of each sentence is the time at which its last byte was read or written, in seconds
    /// since the start of the run; with --json that time is in `received_s`.
    ///
    /// Exit code: 0 even if some sentences were faulty, 2 if the input cannot be read.
    Decode(SpiDecode),
    /// Encode JSON objects, one a line, as sentences; the reverse of `decode --json`
    ///
    /// An object is {"name":"BPLOG","message":{"message":"NVG","on":true}}. The output is always valid: it has checksum
    /// and CRLF, every value is within its range, and no text contains a reserved character. The first invalid line
    /// ends the command with exit code 2 and an error that gives the line, the field and what was expected. The
    /// sentences before it have been written by then.
    Encode(SpiEncode),
    /// Watch a live vehicle: subscribe to its messages and show them
    ///
    /// On a terminal the vehicle's state is shown in one view. Into a pipe or with --json, each sentence is printed on
    /// one line, with the seconds since the start. The command sends subscriptions (BPLOG) and nothing else, not even
    /// BPVER: it is no payload and takes no part in the mission. It reconnects with back-off when the link is lost.
    ///
    /// Ctrl-C ends the command and prints a summary on standard error. Exit code: 0 if a message was received, 1 if
    /// none was.
    Connect(SpiConnect),
}

#[derive(Debug, Args)]
pub(crate) struct SpiList {
    /// Describe these messages in full: BFNVG, or just NVG
    pub(crate) names: Vec<String>,
    /// Print a JSON object for each message, one a line
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SpiDecode {
    /// The recording or log, or - for standard input
    #[arg(default_value = "-")]
    pub(crate) file: PathBuf,
    /// Print a JSON object for each sentence, one a line
    #[arg(long)]
    pub(crate) json: bool,
    /// Decode sentences with a wrong checksum too; the checksum is still reported as invalid
    #[arg(long)]
    pub(crate) ignore_checksum: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SpiEncode {
    /// A file of JSON objects, or - for standard input
    #[arg(default_value = "-")]
    pub(crate) file: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct SpiConnect {
    /// The vehicle's address [default port: 29500]
    #[arg(value_name = "HOST[:PORT]")]
    pub(crate) address: String,
    /// Print a JSON object for each sentence, one a line
    #[arg(long)]
    pub(crate) json: bool,
    /// Subscribe to these messages only; what a vehicle sends unasked is shown too [default: all]
    #[arg(long, value_name = "NVG,CTL", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// End after this many seconds
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
    let mut input = open(&arguments.file)?;
    let start = start(&mut input).with_context(|| place(&arguments.file))?;
    if start == LOG {
        return decode_log(input, &arguments.file, decoding);
    }
    let input = start.as_slice().chain(input);
    let done = finished(backseat_spi_tools::decode(input, decoding, &mut io::stdout().lock()));
    if let Some(tally) = done.with_context(|| place(&arguments.file))? {
        tell(&tally.to_string());
    }
    Ok(true)
}

/// With these bytes a log begins, and no recording that has a sentence at its start (<https://mcap.dev/spec#magic>).
const LOG: &[u8] = b"\x89MCAP0\r\n";

/// The first bytes of an input, as many as show that it is no log: one, for a live pipe.
fn start(input: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    while start.len() < LOG.len() && LOG.starts_with(&start) {
        let wanted = LOG.len() - start.len();
        let mut more = [0; LOG.len()];
        match input.read(&mut more[..wanted]) {
            Ok(0) => break,
            Ok(read) => start.extend_from_slice(&more[..read]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(start)
}

/// Decodes the link's bytes in a log.
fn decode_log(mut input: impl Read, file: &Path, decoding: Decoding) -> Result<bool> {
    let mut bytes = LOG.to_vec();
    input.read_to_end(&mut bytes).with_context(|| place(file))?;
    let log = backseat_recorder::parse(&bytes).with_context(|| place(file))?;
    drop(bytes);
    let traffic = log
        .entries
        .iter()
        .filter_map(|entry| traffic(entry.now.as_secs_f64(), &entry.record));
    let done = finished(decode_traffic(traffic, decoding, &mut io::stdout().lock()))?;
    if let Some(tally) = done {
        if !log.complete {
            tell("cut short: the log does not end properly, and its last sentences may be missing");
        }
        tell(&tally.to_string());
    }
    Ok(true)
}

fn traffic(at_s: f64, record: &Record) -> Option<Traffic<'_>> {
    match record {
        Record::Input(LoggedInput::Received(bytes)) => Some(Traffic::FromVehicle { at_s, bytes }),
        Record::Sent(bytes) => Some(Traffic::ToVehicle { at_s, bytes }),
        Record::Input(LoggedInput::LinkDown) | Record::Gap { .. } => Some(Traffic::Break { at_s }),
        Record::Start(_)
        | Record::Input(_)
        | Record::Output(_)
        | Record::Note(_)
        | Record::Request(_)
        | Record::Control(_)
        | Record::Navigation(_)
        | Record::Truth(_)
        | Record::Vehicle(_) => None,
    }
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
    tell(&watched.summary.to_string());
    Ok(watched.heard)
}

/// `None` where the reader of the output has closed it, which is no error.
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

/// Whether to use colours: on a terminal, unless the user has turned them off.
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
