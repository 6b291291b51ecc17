use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use anyhow::Result;
use backseat_console::{About, Hub, Item, Kind, Limits, Listener, Origin, Service, Teller, serve, wants};
use backseat_recorder::LogReader;
use clap::Args;
use serde::Deserialize;
use tracing::warn;

use super::expected_log;
use crate::console::address;
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct LogView {
    /// The log, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap")]
    log: PathBuf,
    /// Serve the page at this address of this computer; port 0 is a free one
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:8480", value_parser = address)]
    listen: SocketAddr,
}

pub(super) fn view(arguments: &LogView) -> Result<bool> {
    let listener = Listener::open(arguments.listen)?;
    let mut reader = expected_log(LogReader::open(&arguments.log))?;
    let run = reader.run();
    let attached = |name: &str| String::from_utf8_lossy(reader.attachment(name).unwrap_or_default()).into_owned();
    let origin = Origin {
        lat: run.origin.latitude.as_deg(),
        lon: run.origin.longitude.as_deg(),
    };
    let about = About::new(
        Kind::Recorded,
        &run.mission,
        run.utc_at_start.as_unix_nanos(),
        origin,
        &attached("mission.toml"),
        &attached("fence.geojson"),
    );
    let about = About {
        version: run.version.clone(),
        armed: armed(&arguments.log),
        ..about
    };
    let hub = Hub::new(&about, Limits::RECORDED);
    let mut teller = Teller::new(about.budgets());
    let mut damaged = false;
    loop {
        let message = match reader.next_message() {
            Ok(Some(message)) => message,
            Ok(None) => break,
            // What comes before is whole.
            Err(error) => {
                warn!("shown up to here: {error}");
                damaged = true;
                break;
            }
        };
        if wants(&message.topic, &message.data) {
            let tell = |t, item, keep| {
                if keep {
                    hub.add(t, &item, true);
                }
            };
            teller.hear(message.now, &message.topic, &message.data, tell);
        }
    }
    let text = if damaged {
        "the log is damaged: what follows cannot be read"
    } else if reader.is_complete() {
        "the log ends here"
    } else {
        warn!(
            "the log has no end: the process was killed, its disk was full, or it still writes; the log is shown up to its \
             last whole chunk"
        );
        "the log has no end: the process was killed, its disk was full, or it still writes"
    };
    hub.add(teller.newest_s(), &Item::End { text: text.to_owned() }, true);
    let address = listener.address();
    let service = Service {
        hub,
        token: None,
        live: false,
        pace: None,
    };
    // Nobody can ask for anything, and the thread serves until the process ends.
    let _asked = serve(listener, service)?;
    say!("http://{address} shows {}; Ctrl-C ends this", arguments.log.display());
    loop {
        std::thread::park();
    }
}

/// Whether the runtime might steer, as the start of the run has it. `None` if the log begins later: a part of one.
fn armed(log: &Path) -> Option<bool> {
    #[derive(Deserialize)]
    struct Input {
        start: Option<Start>,
    }
    #[derive(Deserialize)]
    struct Start {
        armed: bool,
    }
    let mut reader = LogReader::open(log).ok()?;
    while let Ok(Some(message)) = reader.next_message() {
        if &*message.topic == "/core/input" {
            let input: Input = serde_json::from_slice(&message.data).ok()?;
            return input.start.map(|start| start.armed);
        }
    }
    None
}
