//! `backseat spi`: the tools, between files, standard streams and a terminal.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read};
use std::path::Path;

use anyhow::{Context, Result};
use backseat_spi_tools::{Address, Connection, Decoding, Error, Form, Listing, Subscription, View, connect};
use tokio::signal::unix::{SignalKind, signal};

use crate::cli::{Spi, SpiConnect, SpiDecode};

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
