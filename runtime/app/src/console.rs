//! The web console of a run or a flight.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::{Context, Result};
use backseat_console::{About, Asked, Hub, Kind, Limits, Listener, Origin, Service, Teller, Tls, Token, serve};
use backseat_mission::Mission;
use backseat_units::Utc;
use backseat_viewer::{Feed, Port};
use clap::Args;
use tokio::sync::mpsc::Receiver;
use tracing::{error, info};

use crate::service::{is_managed, may_pass};
use crate::state::State;

/// Where the console is if no address is given.
const ADDRESS: &str = "127.0.0.1:8480";
/// Where viewers are served if no address is given: where Foxglove looks first.
const VIEWERS: &str = "127.0.0.1:8765";

#[derive(Debug, Args)]
pub(crate) struct ConsoleArguments {
    /// Serve a web console at this address of this computer [without an address: 127.0.0.1:8480; port 0: a free one]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = ADDRESS, value_parser = address)]
    console: Option<SocketAddr>,
    /// Serve the console through TLS with this certificate (PEM); then ADDRESS may be one that other computers reach, such
    /// as 0.0.0.0:8480, and whoever looks needs the token
    #[arg(long, value_name = "FILE", requires = "console_key", requires = "console")]
    console_cert: Option<PathBuf>,
    /// The private key of that certificate (PEM), which nobody else may read
    #[arg(long, value_name = "FILE", requires = "console_cert")]
    console_key: Option<PathBuf>,
    /// Serve the log's channels live to Foxglove and Lichtblick at this address of this computer [without an address:
    /// 127.0.0.1:8765]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = VIEWERS, value_parser = address)]
    foxglove: Option<SocketAddr>,
}

#[cfg(feature = "simulation")]
#[derive(Debug, Args)]
pub(crate) struct WatchArguments {
    /// Show the run in a web console of this computer, and go on showing it until Ctrl-C [without an address:
    /// 127.0.0.1:8480]; --speed 20 is fast enough to see something, and slow enough to watch
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = ADDRESS, value_parser = address)]
    pub(crate) watch: Option<SocketAddr>,
}

#[cfg(feature = "simulation")]
impl WatchArguments {
    /// Opens the port.
    pub(crate) fn open(&self) -> Result<Console> {
        let listener = self.watch.map(Listener::open).transpose();
        Ok(Console {
            page: listener.context("--watch")?,
            viewers: None,
        })
    }
}

/// Serves the log's channels to viewers.
fn viewers(port: Port, mission: &Mission, utc: Utc) -> Result<Feed> {
    let address = port.address();
    let feed = backseat_viewer::serve(port, &mission.name, utc.as_unix_nanos()).context("--foxglove")?;
    info!("viewers: in Foxglove or Lichtblick open the connection ws://{address}");
    Ok(feed)
}

fn about(kind: Kind, mission: &Mission, utc: Utc) -> About {
    let origin = mission.envelope.fence().frame().origin();
    let origin = Origin {
        lat: origin.latitude.as_deg(),
        lon: origin.longitude.as_deg(),
    };
    let (resolved, fence) = (&mission.resolved, &mission.fence_text);
    About::new(kind, &mission.name, utc.as_unix_nanos(), origin, resolved, fence)
}

/// An address of this computer: `127.0.0.1:8480`, `localhost:8480`, `[::1]:8480`, or a port alone.
pub(crate) fn address(text: &str) -> Result<SocketAddr, String> {
    let whole = match text.parse::<u16>() {
        Ok(port) => format!("127.0.0.1:{port}"),
        Err(_) => text.replacen("localhost", "127.0.0.1", 1),
    };
    whole
        .parse()
        .map_err(|_| "expected an address of this computer, such as 127.0.0.1:8480, or a port".to_owned())
}

/// What shows a run as it goes.
pub(crate) struct Console {
    /// The web console, whose port is open.
    page: Option<Listener>,
    /// Where viewers are served. The port is open too.
    viewers: Option<Port>,
}

/// What the console and the loop have of each other.
#[derive(Default)]
pub(crate) struct Attached {
    /// Is told what happens.
    pub(crate) listener: Option<backseat_recorder::Listener>,
    /// What people at the console ask for.
    pub(crate) asked: Option<Receiver<Asked>>,
}

impl ConsoleArguments {
    /// Opens the ports, so that a wrong one is found before the run begins.
    pub(crate) fn open(&self) -> Result<Console> {
        let listener = match (self.console, &self.console_cert, &self.console_key) {
            (None, ..) => None,
            (Some(address), Some(certificate), Some(key)) => match Tls::read(certificate, key) {
                Ok(tls) => Some(Listener::open_to_all(address, tls)),
                // As with a port: whoever changes a file of the console must not end the steering at the next start.
                Err(why) if is_managed() => {
                    error!("the run goes on without --console: --console-cert and --console-key: {why}");
                    None
                }
                Err(why) => return Err(why).context("--console-cert and --console-key"),
            },
            (Some(address), ..) => Some(Listener::open(address)),
        };
        Ok(Console {
            page: opened(listener, "--console")?,
            viewers: opened(self.foxglove.map(Port::open), "--foxglove")?,
        })
    }
}

/// The port of an option. Nobody is there to give a service another port, so it goes on without what only shows it:
/// otherwise whoever takes the port while it starts again would end the steering.
fn opened<T, E>(port: Option<Result<T, E>>, option: &'static str) -> Result<Option<T>>
where
    E: std::error::Error + Send + Sync + 'static,
{
    match port.transpose().map_err(anyhow::Error::new) {
        Err(why) if is_managed() && why.chain().any(may_pass) => {
            error!("the run goes on without {option}: {why}");
            Ok(None)
        }
        port => port.context(option),
    }
}

impl Console {
    /// Starts to serve a run that begins at `utc`, if there is a console. People can hold and release with the token that is
    /// in the state folder.
    pub(crate) fn attach(
        self,
        kind: Kind,
        mission: &Mission,
        armed: bool,
        utc: Utc,
        state: &State,
    ) -> Result<Attached> {
        let viewers = self.viewers.map(|port| viewers(port, mission, utc)).transpose()?;
        let path = state.hold_path().with_file_name("console.token");
        // A full disk stops no run: it goes on without what only shows it.
        let page = self.page.and_then(|page| match Token::create(&path) {
            Ok(token) => Some((page, token)),
            Err(why) => {
                error!("no console, the run goes on without: {}: {why}", path.display());
                None
            }
        });
        let Some((listener, token)) = page else {
            return Ok(Attached {
                listener: viewers.map(|viewers| -> backseat_recorder::Listener {
                    Box::new(move |now, topic, data| viewers.tell(now, topic, data))
                }),
                asked: None,
            });
        };
        let is_open = listener.url().starts_with("https");
        let about = About {
            armed: Some(armed),
            operator: true,
            ..about(kind, mission, utc)
        };
        let hub = Hub::new(&about, Limits::LIVE);
        let feed = hub.listen(Teller::new(about.budgets()))?;
        let url = listener.url();
        let asked = serve(
            listener,
            Service {
                hub,
                token: Some(token),
                live: true,
                pace: None,
            },
        )?;
        info!(
            "console: {url}; to {} there: the token in {}",
            if is_open {
                "look, hold or release"
            } else {
                "hold or release"
            },
            path.display()
        );
        Ok(Attached {
            listener: Some(Box::new(move |now, topic, data| {
                feed.tell(now, topic, data);
                if let Some(viewers) = &viewers {
                    viewers.tell(now, topic, data);
                }
            })),
            asked: Some(asked),
        })
    }

    /// Shows a simulation, which nobody can hold, and whose pace can be changed.
    #[cfg(feature = "simulation")]
    pub(crate) fn show(
        self,
        mission: &Mission,
        utc: Utc,
        pace: &backseat_console::Pace,
    ) -> Result<Option<backseat_recorder::Listener>> {
        let Some(listener) = self.page else { return Ok(None) };
        let about = About {
            armed: Some(true),
            ..about(Kind::Simulated, mission, utc)
        };
        let hub = Hub::new(&about, Limits::LIVE);
        let feed = hub.listen(Teller::new(about.budgets()))?;
        let address = listener.address();
        let service = Service {
            hub,
            token: None,
            live: true,
            pace: Some(pace.clone()),
        };
        // Nobody can hold or release.
        drop(serve(listener, service)?);
        info!("console: http://{address}");
        Ok(Some(Box::new(move |now, topic, data| feed.wait(now, topic, data))))
    }
}
