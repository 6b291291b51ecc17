use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, copy};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::{AbortHandle, yield_now};
use tokio::time::{sleep, timeout};
use tracing::warn;

use crate::words::{Bounds, Unfit, look};

/// Viewers at once. Each takes two sockets of the process, which also needs some for the vehicle, its log and its state.
pub(crate) const VIEWERS_MAX: usize = 16;
/// After an error of the listener, such as too many open files.
const PAUSE: Duration = Duration::from_millis(200);
/// A viewer that has not sent its request after this is cut off.
const HEAD_WITHIN: Duration = Duration::from_secs(5);
/// How long a viewer has to take what was said last.
const PARTING: Duration = Duration::from_secs(1);
/// What is read of a viewer's words at once, bytes.
const CHUNK: usize = 4096;

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

/// Carries the words of a viewer and of the server to each other until one of them ends, or the viewer says what no viewer
/// says: then it is answered in plain text, or cut off.
async fn lead(mut viewer: TcpStream, server: SocketAddr) -> io::Result<()> {
    viewer.set_nodelay(true)?;
    let asked = match timeout(HEAD_WITHIN, read_request(&mut viewer)).await {
        Ok(read) => read?,
        Err(_late) => return Ok(()),
    };
    let (head, mut words) = match asked {
        Ok(split) => split,
        Err(unfit) => {
            let address = viewer.local_addr()?;
            viewer.write_all(unfit.answer(address).as_bytes()).await?;
            return part(&mut viewer).await;
        }
    };
    let mut server = TcpStream::connect(server).await?;
    server.set_nodelay(true)?;
    server.write_all(&head).await?;
    let (mut from_viewer, mut to_viewer) = viewer.split();
    let (mut from_server, mut to_server) = server.split();
    let heard = async {
        let mut bounds = Bounds::default();
        // Who goes away in mid-sentence is no news.
        loop {
            if words.is_empty() {
                words.resize(CHUNK, 0);
                let read = from_viewer.read(&mut words).await.unwrap_or(0);
                words.truncate(read);
            }
            if words.is_empty() || bounds.admit(&words).is_err() || to_server.write_all(&words).await.is_err() {
                return;
            }
            words.clear();
        }
    };
    let has_ended = tokio::select! {
        () = heard => false,
        _bytes = copy(&mut from_server, &mut to_viewer) => true,
    };
    if has_ended {
        part(&mut viewer).await?;
    }
    Ok(())
}

/// Ends a conversation so that what was said last arrives: a socket that is closed while words wait in it resets the
/// connection, and takes back what is on its way.
async fn part(viewer: &mut TcpStream) -> io::Result<()> {
    viewer.shutdown().await?;
    let mut words = [0; CHUNK];
    let hears = async { while viewer.read(&mut words).await.is_ok_and(|read| read > 0) {} };
    let _late = timeout(PARTING, hears).await;
    Ok(())
}

/// Reads until the request is whole: its head, and what the viewer has sent after it.
async fn read_request(viewer: &mut TcpStream) -> io::Result<Result<(Vec<u8>, Vec<u8>), Unfit>> {
    let mut read = Vec::new();
    loop {
        if viewer.read_buf(&mut read).await? == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        match look(&read) {
            Ok(None) => {}
            Ok(Some(head)) => {
                let words = read.split_off(head);
                return Ok(Ok((read, words)));
            }
            Err(unfit) => return Ok(Err(unfit)),
        }
    }
}
