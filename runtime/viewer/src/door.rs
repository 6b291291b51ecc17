use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::{AbortHandle, yield_now};
use tokio::time::sleep;
use tracing::warn;

/// Viewers at once. Each takes two sockets of the process, which also needs some for the vehicle, its log and its state.
pub(crate) const VIEWERS_MAX: usize = 16;
/// After an error of the listener, such as too many open files.
const PAUSE: Duration = Duration::from_millis(200);

/// The port that viewers reach. The library's server takes any number of viewers, and ends when it cannot accept one: so it
/// listens behind this one, which leads a bounded number to it and has it started anew when it is gone.
pub(crate) struct Door {
    listener: TcpListener,
    /// Where the library's server listens now.
    server: watch::Receiver<SocketAddr>,
    /// Where to say that it does not.
    gone: mpsc::Sender<()>,
}

impl Door {
    pub(crate) const fn new(
        listener: TcpListener,
        server: watch::Receiver<SocketAddr>,
        gone: mpsc::Sender<()>,
    ) -> Self {
        Self { listener, server, gone }
    }

    /// Lets viewers in until it is dropped. Where there are too many, the oldest goes: a viewer that hangs keeps nobody out.
    pub(crate) async fn run(self) {
        let mut inside: VecDeque<Visit> = VecDeque::new();
        let mut told = false;
        loop {
            let viewer = match self.listener.accept().await {
                Ok((viewer, _)) => viewer,
                Err(error) => {
                    if !std::mem::replace(&mut told, true) {
                        warn!("viewers: no further connections for now: {error}");
                    }
                    sleep(PAUSE).await;
                    continue;
                }
            };
            inside.retain(|visit| !visit.0.is_finished());
            while inside.len() >= VIEWERS_MAX {
                inside.pop_front();
                // Its sockets close when its task, and the server's, have their turn.
                yield_now().await;
            }
            let (server, gone) = (*self.server.borrow(), self.gone.clone());
            let visit = tokio::spawn(async move {
                if lead(viewer, server)
                    .await
                    .is_err_and(|error| error.kind() == io::ErrorKind::ConnectionRefused)
                {
                    // If it is being started already, the word is there too.
                    let _told = gone.try_send(());
                }
            });
            inside.push_back(Visit(visit.abort_handle()));
        }
    }
}

/// A viewer that is let in, until this is dropped.
struct Visit(AbortHandle);

impl Drop for Visit {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Carries the words of a viewer and of the server to each other until one of them ends.
async fn lead(mut viewer: TcpStream, server: SocketAddr) -> io::Result<()> {
    let mut server = TcpStream::connect(server).await?;
    for stream in [&viewer, &server] {
        stream.set_nodelay(true)?;
    }
    // Who goes away in mid-sentence is no news.
    let _bytes = copy_bidirectional(&mut viewer, &mut server).await;
    Ok(())
}
