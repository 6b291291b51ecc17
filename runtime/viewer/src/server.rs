use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use std::{io, thread};

use backseat_recorder::schema_of;
use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer, WebSocketServerHandle};
use tokio::net::TcpListener;
use tokio::runtime;
use tokio::sync::mpsc::Receiver;
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;
use tracing::warn;

use crate::door::Door;
use crate::feed::{Feed, Told};

/// The port at which viewers look first.
pub const PORT: u16 = 8765;
/// How many messages may wait for one viewer. The oldest give way.
const BACKLOG: usize = 512;
/// How long viewers have to take the goodbye at the end.
const GOODBYE: Duration = Duration::from_secs(1);
/// A message that is larger is not kept for viewers that come later, bytes.
const KEPT_BYTES: usize = 1 << 20;

/// Why viewers cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// Viewers have no token, so they are served on this computer alone.
    #[error(
        "{0}: viewers are served on this computer alone: expected a loopback address, such as 127.0.0.1:{PORT}; from elsewhere come by ssh -L"
    )]
    Address(SocketAddr),
    /// The port is taken, for example.
    #[error("{address}: {source}: give another port, or 0 for a free one")]
    Listen {
        /// Where it should listen.
        address: SocketAddr,
        /// Why it cannot.
        source: io::Error,
    },
    /// No thread can be started.
    #[error("viewers cannot be served: {0}")]
    Thread(#[from] io::Error),
}

/// A port that is open, so that a wrong one is found before a run begins.
#[derive(Debug)]
pub struct Port {
    listener: std::net::TcpListener,
    address: SocketAddr,
}

impl Port {
    /// Opens a port of this computer. Port 0 is any free one.
    ///
    /// # Errors
    ///
    /// [`ViewerError::Address`] if the address is no loopback address, [`ViewerError::Listen`].
    pub fn open(address: SocketAddr) -> Result<Self, ViewerError> {
        if !address.ip().is_loopback() {
            return Err(ViewerError::Address(address));
        }
        let opened = std::net::TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok(Self { listener, address })
        });
        opened.map_err(|source| ViewerError::Listen { address, source })
    }

    /// The address with its port.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

/// Serves viewers at this port until the feed is dropped. `name` is the run's, and `began_ns` its beginning, UTC in
/// nanoseconds since 1970.
///
/// # Errors
///
/// [`ViewerError`] if it cannot.
pub fn serve(port: Port, name: &str, began_ns: u64) -> Result<Feed, ViewerError> {
    let Port { listener, address } = port;
    let (feed, heard) = Feed::new();
    let (tell, told) = sync_channel(1);
    let name = name.to_owned();
    // Everything runs on this one thread. The library advertises a channel before it notes that a client knows it, so that
    // with a second thread the answer of a quick client comes too early and is refused.
    let runtime = runtime::Builder::new_current_thread().enable_all().build()?;
    thread::Builder::new().name("viewer".to_owned()).spawn(move || {
        runtime.block_on(served(listener, &name, began_ns, &tell, heard));
    })?;
    let started = told
        .recv()
        .unwrap_or_else(|_| Err("its thread has panicked".to_owned()));
    match started {
        Ok(()) => Ok(feed),
        Err(message) => Err(ViewerError::Listen {
            address,
            source: io::Error::other(message),
        }),
    }
}

/// Serves until the feed is dropped. Whoever asked for it waits until it is told whether it serves.
///
/// Viewers come through a [`Door`] at this port.
async fn served(
    listener: std::net::TcpListener,
    name: &str,
    began_ns: u64,
    tell: &SyncSender<Result<(), String>>,
    heard: Receiver<Told>,
) {
    let started = async {
        let listener = TcpListener::from_std(listener).map_err(|error| error.to_string())?;
        let live = Live::start(name, began_ns).await.map_err(|error| error.to_string())?;
        Ok((listener, live))
    };
    match started.await {
        Ok((listener, live)) => {
            let (place, server) = watch::channel(live.address());
            let (gone, is_gone) = mpsc::channel(1);
            let door = tokio::spawn(Door::new(listener, server, gone).run());
            let _asked = tell.send(Ok(()));
            live.run(heard, is_gone, place).await;
            door.abort();
        }
        Err(message) => {
            let _asked = tell.send(Err(message));
        }
    }
}

struct Live {
    name: String,
    context: Arc<Context>,
    server: WebSocketServerHandle,
    /// By topic; `None` for one without a schema.
    channels: BTreeMap<String, Option<Arc<RawChannel>>>,
    kept: Arc<Kept>,
    began_ns: u64,
}

impl Live {
    async fn start(name: &str, began_ns: u64) -> Result<Self, FoxgloveError> {
        let context = Context::new();
        let kept = Arc::new(Kept::default());
        let server = server(name, &context, &kept).await?;
        Ok(Self {
            name: name.to_owned(),
            context,
            server,
            channels: BTreeMap::new(),
            kept,
            began_ns,
        })
    }

    /// Where the library's server listens.
    fn address(&self) -> SocketAddr {
        (Ipv4Addr::LOCALHOST, self.server.port()).into()
    }

    async fn run(mut self, mut heard: Receiver<Told>, mut is_gone: Receiver<()>, place: watch::Sender<SocketAddr>) {
        loop {
            tokio::select! {
                told = heard.recv() => match told {
                    Some(told) => self.log(&told),
                    None => break,
                },
                Some(()) = is_gone.recv() => {
                    // Nobody reaches it any more.
                    match server(&self.name, &self.context, &self.kept).await {
                        Ok(server) => {
                            warn!("viewers could not be served for a while");
                            self.server = server;
                            place.send_replace(self.address());
                        }
                        Err(error) => warn!("viewers cannot be served: {error}"),
                    }
                }
            }
        }
        // The run has ended. A viewer that takes nothing would not take its goodbye either.
        let _told = timeout(GOODBYE, self.server.stop().wait()).await;
    }

    fn log(&mut self, told: &Told) {
        let Some(channel) = self.channel(&told.topic) else {
            return;
        };
        let at_ns = self.began_ns.saturating_add(told.now.as_nanos());
        if lasts(&told.topic) && told.data.len() <= KEPT_BYTES {
            self.kept.keep(channel.clone(), at_ns, &told.data);
        }
        channel.log_with_meta(&told.data, PartialMetadata::with_log_time(at_ns));
    }

    fn channel(&mut self, topic: &str) -> Option<Arc<RawChannel>> {
        if let Some(channel) = self.channels.get(topic) {
            return channel.clone();
        }
        let schema = schema_of(topic).map(|(name, text)| Schema::new(name, "jsonschema", text.into_bytes()));
        let channel = schema.and_then(|schema| {
            let builder = self
                .context
                .channel_builder(topic)
                .message_encoding("json")
                .schema(schema);
            builder
                .build_raw()
                .inspect_err(|error| warn!("viewers do not get {topic}: {error}"))
                .ok()
        });
        self.channels.insert(topic.to_owned(), channel.clone());
        channel
    }
}

/// The library's server, at a free port of this computer.
async fn server(name: &str, context: &Arc<Context>, kept: &Arc<Kept>) -> Result<WebSocketServerHandle, FoxgloveError> {
    WebSocketServer::new()
        .name(name)
        .bind(Ipv4Addr::LOCALHOST.to_string(), 0)
        .context(context)
        .capabilities([])
        .message_backlog_size(BACKLOG)
        .listener(kept.clone())
        .start()
        .await
}

/// Whether the last message of a topic says how things are until the next one.
fn lasts(topic: &str) -> bool {
    topic.starts_with("/map/") || matches!(topic, "/control" | "/position" | "/navigation")
}

/// The last message of each topic that lasts, for viewers that come later.
#[derive(Default)]
struct Kept {
    messages: Mutex<BTreeMap<String, Message>>,
}

struct Message {
    channel: Arc<RawChannel>,
    at_ns: u64,
    data: Vec<u8>,
}

impl Kept {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Message>> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn keep(&self, channel: Arc<RawChannel>, at_ns: u64, data: &[u8]) {
        let topic = channel.topic().to_owned();
        let data = data.to_vec();
        self.lock().insert(topic, Message { channel, at_ns, data });
    }
}

impl ServerListener for Kept {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        if let Some(message) = self.lock().get(channel.topic()) {
            let Message { channel, at_ns, data } = message;
            channel.log_with_meta_to_sink(data, PartialMetadata::with_log_time(*at_ns), client.sink_id());
        }
    }
}
