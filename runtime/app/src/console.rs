//! The web console of a run or a flight.

use std::net::SocketAddr;

use anyhow::{Context, Result};
use backseat_console::{About, Asked, Hub, Kind, Limits, Listener, Origin, Service, Teller, Token, serve};
use backseat_mission::Mission;
use backseat_units::Utc;
use clap::Args;
use tokio::sync::mpsc::Receiver;
use tracing::info;

use crate::state::State;

/// Where the console is if no address is given.
const ADDRESS: &str = "127.0.0.1:8480";

#[derive(Debug, Args)]
pub(crate) struct ConsoleArguments {
    /// Serve a web console at this address of this computer [without an address: 127.0.0.1:8480; port 0: a free one]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = ADDRESS)]
    console: Option<SocketAddr>,
}

/// A console whose port is open.
pub(crate) struct Console(Option<Listener>);

/// What the console and the loop have of each other.
#[derive(Default)]
pub(crate) struct Attached {
    /// Is told what happens.
    pub(crate) listener: Option<backseat_recorder::Listener>,
    /// What people at the console ask for.
    pub(crate) asked: Option<Receiver<Asked>>,
}

impl ConsoleArguments {
    /// Opens the port, so that a wrong one is found before the run begins.
    pub(crate) fn open(&self) -> Result<Console> {
        let listener = self.console.map(Listener::open).transpose();
        Ok(Console(listener.context("--console")?))
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
        let Some(listener) = self.0 else {
            return Ok(Attached::default());
        };
        let origin = mission.envelope.fence().frame().origin();
        let origin = Origin {
            lat: origin.latitude.as_deg(),
            lon: origin.longitude.as_deg(),
        };
        let about = About {
            armed: Some(armed),
            operator: true,
            ..About::new(
                kind,
                &mission.name,
                utc.as_unix_nanos(),
                origin,
                &mission.resolved,
                &mission.fence_text,
            )
        };
        let path = state.hold_path().with_file_name("console.token");
        let token = Token::create(&path).with_context(|| path.display().to_string())?;
        let hub = Hub::new(&about, Limits::LIVE);
        let feed = hub.listen(Teller::new(about.budgets()))?;
        let address = listener.address();
        let asked = serve(
            listener,
            Service {
                hub,
                token: Some(token),
                live: true,
            },
        )?;
        info!(
            "console: http://{address}; to hold or release there: the token in {}",
            path.display()
        );
        Ok(Attached {
            listener: Some(Box::new(move |now, topic, data| feed.tell(now, topic, data))),
            asked: Some(asked),
        })
    }
}
