//! Serves the page and the items, over HTTP/1.1 on a thread and a runtime of its own.

mod api;
mod assets;
mod conversation;
mod guard;
mod socket;
mod tls;

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::thread;
use std::time::Duration;

use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use axum::routing::{any, get, post};
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::task::yield_now;
use tokio::time::timeout;
use tracing::warn;

use crate::hub::Hub;
use crate::operator::{Asked, Desk};
use crate::pace::Pace;
use crate::token::Token;

use self::conversation::{Conversations, Peer, Trust};
use self::socket::Feeds;
pub use self::tls::Tls;

/// A client that has not sent the head of its request after this is cut off.
const HEAD_WITHIN: Duration = Duration::from_secs(5);
/// The largest body of a request, bytes.
pub(crate) const BODY_MAX: usize = 4096;
/// The largest head of a request, bytes.
const HEAD_MAX: usize = 16 << 10;
/// A connection that is no feed is closed after this, also if nobody reads what it sends. Browsers open another.
const CONNECTION_MAX: Duration = Duration::from_secs(120);
/// After an error of the listener, such as too many open files.
const PAUSE: Duration = Duration::from_millis(200);
/// A connection that is accepted within this has waited while none could be accepted.
const AT_ONCE: Duration = Duration::from_millis(1);

/// Why the console cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The address is not of this computer alone.
    #[error(
        "{address}: without TLS the console listens on this computer alone: give 127.0.0.1:PORT or [::1]:PORT, and reach it \
         through ssh -L; or give `run` or `fly` --console-cert and --console-key"
    )]
    NotLoopback {
        /// The address.
        address: SocketAddr,
    },
    /// The address is in use, or not this computer's.
    #[error("{address}: {source}: give another port, or 127.0.0.1:0 for a free one")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// The reason.
        source: std::io::Error,
    },
    /// A certificate or its key cannot be used.
    #[error("{}: {reason}", path.display())]
    Tls {
        /// The file.
        path: std::path::PathBuf,
        /// The reason.
        reason: String,
    },
    /// A thread or a runtime cannot start.
    #[error("the console cannot start: {0}")]
    Start(std::io::Error),
}

/// A port that is open, so that a wrong one is found before a run begins.
#[derive(Debug)]
pub struct Listener {
    listener: std::net::TcpListener,
    address: SocketAddr,
    tls: Option<Tls>,
}

impl Listener {
    /// Opens a port of this computer. Port 0 is any free one.
    ///
    /// # Errors
    ///
    /// [`ServerError::NotLoopback`], [`ServerError::Bind`].
    pub fn open(address: SocketAddr) -> Result<Self, ServerError> {
        if ![IpAddr::V4(Ipv4Addr::LOCALHOST), IpAddr::V6(Ipv6Addr::LOCALHOST)].contains(&address.ip()) {
            return Err(ServerError::NotLoopback { address });
        }
        Self::bind(address, None)
    }

    /// Opens a port, which may be one that other computers reach. Everything that is asked there must come through TLS and
    /// with the token, as the password of HTTP's basic authentication.
    ///
    /// # Errors
    ///
    /// [`ServerError::Bind`].
    pub fn open_to_all(address: SocketAddr, tls: Tls) -> Result<Self, ServerError> {
        Self::bind(address, Some(tls))
    }

    fn bind(address: SocketAddr, tls: Option<Tls>) -> Result<Self, ServerError> {
        let bound = std::net::TcpListener::bind(address).and_then(|listener| {
            listener.set_nonblocking(true)?;
            let address = listener.local_addr()?;
            Ok(Self { listener, address, tls })
        });
        bound.map_err(|source| ServerError::Bind { address, source })
    }

    /// The address with its port.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// What a browser opens. At all addresses of this computer, a name of it stands for `HOST`.
    #[must_use]
    pub fn url(&self) -> String {
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        if self.address.ip().is_unspecified() {
            format!(
                "{scheme}://HOST:{}, where HOST is a name or an address of this computer",
                self.address.port()
            )
        } else {
            format!("{scheme}://{}", self.address)
        }
    }
}

/// What is served.
#[derive(Debug)]
pub struct Service {
    /// What is shown.
    pub hub: Hub,
    /// With it the operator can hold and release; without it nobody can.
    pub token: Option<Token>,
    /// Whether items follow: a log that was read has none.
    pub live: bool,
    /// How fast a simulation goes. Anybody who sees the page can change it; it is no matter of safety.
    pub pace: Option<Pace>,
}

pub(crate) struct Shared {
    pub(crate) hub: Hub,
    pub(crate) token: Option<Token>,
    pub(crate) live: bool,
    pub(crate) pace: Option<Pace>,
    /// Whether other computers can reach it.
    pub(crate) is_open: bool,
    pub(crate) desk: Desk,
    pub(crate) feeds: Feeds,
    /// Wrong tokens so far.
    pub(crate) wrong: AtomicU32,
}

/// Serves on a thread of its own until the process ends. Returns what the operator asks for.
///
/// # Errors
///
/// [`ServerError::Start`].
pub fn serve(listener: Listener, service: Service) -> Result<tokio::sync::mpsc::Receiver<Asked>, ServerError> {
    let (desk, asked) = Desk::new();
    let shared = Arc::new(Shared {
        hub: service.hub,
        token: service.token,
        live: service.live,
        pace: service.pace,
        is_open: listener.tls.is_some(),
        desk,
        feeds: Feeds::default(),
        wrong: AtomicU32::new(0),
    });
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(ServerError::Start)?;
    let tls = listener.tls;
    let listener = {
        let _within = runtime.enter();
        TcpListener::from_std(listener.listener).map_err(ServerError::Start)?
    };
    thread::Builder::new()
        .name("console".to_owned())
        .spawn(move || runtime.block_on(accept(listener, tls, router(shared))))
        .map_err(ServerError::Start)?;
    Ok(asked)
}

fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/api/about", get(api::about))
        .route("/api/history", get(api::history))
        .route("/api/feed", any(socket::feed))
        .route("/api/operator", post(api::operator))
        .route("/api/pace", post(api::pace))
        .route("/metrics", get(api::metrics))
        .fallback(get(assets::file))
        .layer(DefaultBodyLimit::max(BODY_MAX))
        .layer(from_fn_with_state(Arc::clone(&shared), guard::guard))
        .with_state(shared)
}

async fn accept(listener: TcpListener, tls: Option<Tls>, router: Router) {
    let mut open = Conversations::default();
    let (mut told, mut waited) = (false, false);
    loop {
        let accepted = if waited {
            match timeout(AT_ONCE, listener.accept()).await {
                // It may have given up long ago: a release that comes late would undo a newer hold.
                Ok(Ok(_)) => continue,
                Ok(Err(error)) => Err(error),
                Err(_) => {
                    waited = false;
                    continue;
                }
            }
        } else {
            listener.accept().await
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                if !std::mem::replace(&mut told, true) {
                    warn!("console: no further connections for now: {error}");
                }
                tokio::time::sleep(PAUSE).await;
                waited = true;
                continue;
            }
        };
        match open.make_room() {
            None => {}
            // Its socket closes when it has its turn.
            Some(true) => yield_now().await,
            Some(false) => continue,
        }
        let trust = Trust::default();
        let router = router
            .clone()
            .layer(Extension(trust.clone()))
            .layer(Extension(Peer(peer.ip())));
        let task = match tls.clone() {
            None => tokio::spawn(converse(stream, router)),
            Some(Tls(acceptor)) => tokio::spawn(async move {
                // Who does not speak TLS is cut off.
                if let Ok(Ok(stream)) = timeout(HEAD_WITHIN, acceptor.accept(stream)).await {
                    converse(stream, router).await;
                }
            }),
        };
        open.add(peer.ip(), trust, task.abort_handle());
    }
}

async fn converse(stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static, router: Router) {
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_WITHIN)
        .max_buf_size(HEAD_MAX)
        .keep_alive(true)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
        .with_upgrades();
    // A browser that goes away in mid-sentence is no news, and a feed goes on by itself.
    drop(timeout(CONNECTION_MAX, served).await);
}
