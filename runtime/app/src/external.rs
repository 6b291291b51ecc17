//! The TCP side of external sources. Each source has its own listener and one connected program at a time. Lines go to
//! core, and answers go back. A program that misbehaves delays neither the vehicle's link nor another source.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use anyhow::{Context, Result};
use backseat_core::ExternalId;
use backseat_mission::ExternalTable;
use socket2::{SockRef, TcpKeepalive};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tracing::{info, warn};

/// Bytes of one read at most: about forty sentences.
const READ_MAX: usize = 4096;
/// Bytes a second that are read at most. Anything faster waits in the program's own socket.
const BYTES_PER_S: f64 = 65_536.0;
/// How many reads of all external sources may wait for core.
const READS_MAX: usize = 16;
/// How many answers may wait for a program that reads slowly; further answers are dropped.
const ANSWERS_MAX: usize = 256;
/// A program that takes no answer for this long is disconnected.
const WRITE_WITHIN: Duration = Duration::from_secs(2);
/// A program whose machine has vanished is disconnected after about this time.
const KEEPALIVE: Duration = Duration::from_secs(10);
/// Sent to core when a program has disconnected, so that the first line of the next program cannot complete the
/// sentence that this one had begun.
const CUT: &[u8] = b"$\n";

/// What external sources have sent, for core.
pub(crate) type Heard = Receiver<(ExternalId, Vec<u8>)>;

/// The way for answers back to the external sources.
pub(crate) struct Ports {
    answers: Vec<Sender<Vec<u8>>>,
}

impl Ports {
    /// Opens a listener for each external source. Call it within the tokio runtime that will serve them.
    ///
    /// # Errors
    ///
    /// If an address cannot be listened on.
    pub(crate) fn open(externals: &[ExternalTable]) -> Result<(Self, Heard)> {
        let (heard, reads) = channel(READS_MAX);
        let mut answers = Vec::new();
        for (index, source) in externals.iter().enumerate() {
            let name = source.name.clone();
            let listener = listen(&source.listen)
                .with_context(|| format!("external source `{name}`: cannot listen on {}", source.listen))?;
            let address = listener.local_addr()?;
            info!("listening for external source {name} on {address}");
            if !address.ip().is_loopback() {
                warn!(
                    "external source {name}: any machine that can reach {address} may send {:?}",
                    source.sends
                );
            }
            let (sender, receiver) = channel(ANSWERS_MAX);
            answers.push(sender);
            let port = Port {
                id: ExternalId(index),
                name,
                heard: heard.clone(),
                answers: receiver,
            };
            tokio::spawn(port.serve(listener));
        }
        Ok((Self { answers }, reads))
    }

    /// Sends an external source its answer. The answer is dropped where no program is connected to take it.
    pub(crate) fn tell(&self, source: ExternalId, line: Vec<u8>) {
        if let Some(answers) = self.answers.get(source.0) {
            // The queue is full where a program does not read; further answers are of no use to it.
            let _dropped = answers.try_send(line);
        }
    }
}

fn listen(address: &str) -> io::Result<TcpListener> {
    let listener = std::net::TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    TcpListener::from_std(listener)
}

struct Port {
    id: ExternalId,
    name: String,
    heard: Sender<(ExternalId, Vec<u8>)>,
    answers: Receiver<Vec<u8>>,
}

impl Port {
    /// Serves one program after the other, until core has ended.
    async fn serve(mut self, listener: TcpListener) {
        loop {
            tokio::select! {
                accepted = listener.accept() => match accepted {
                    Ok((stream, peer)) => {
                        if self.attend(&listener, stream, peer).await.is_err() {
                            return;
                        }
                    }
                    Err(error) => {
                        // No file descriptors are left, or the program has disconnected already. Both pass.
                        warn!("external source {}: {error}", self.name);
                        tokio::time::sleep(Duration::from_secs(1)).await;
                    }
                },
                // No program is connected to receive it.
                answer = self.answers.recv() => if answer.is_none() { return },
            }
        }
    }

    /// Serves one program until it disconnects. A second one is told that the source is taken, and turned away.
    async fn attend(&mut self, listener: &TcpListener, mut stream: TcpStream, peer: SocketAddr) -> Result<(), Closed> {
        info!("external source {} connected from {peer}", self.name);
        let options = stream.set_nodelay(true).and_then(|()| {
            SockRef::from(&stream).set_tcp_keepalive(&TcpKeepalive::new().with_time(KEEPALIVE).with_interval(KEEPALIVE))
        });
        if let Err(error) = options {
            warn!("external source {}: {error}", self.name);
        }
        let mut buffer = vec![0; READ_MAX];
        let mut resume = tokio::time::Instant::now();
        let why = loop {
            tokio::select! {
                biased;
                answer = self.answers.recv() => {
                    let Some(line) = answer else { return Err(Closed) };
                    match tokio::time::timeout(WRITE_WITHIN, stream.write_all(&line)).await {
                        Ok(Ok(())) => {}
                        Ok(Err(error)) => break error.to_string(),
                        Err(_) => break "it takes no answers".to_owned(),
                    }
                }
                accepted = listener.accept() => if let Ok((second, peer)) = accepted {
                    warn!("external source {}: turned {peer} away, because a program is connected", self.name);
                    turn_away(second, &self.name);
                },
                read = async {
                    tokio::time::sleep_until(resume).await;
                    stream.read(&mut buffer).await
                } => match read {
                    Ok(0) => break "it closed the connection".to_owned(),
                    Ok(read) => {
                        resume = tokio::time::Instant::now() + Duration::from_secs_f64(read as f64 / BYTES_PER_S);
                        self.hear(buffer[..read].to_vec()).await?;
                    }
                    Err(error) => break error.to_string(),
                },
            }
        };
        info!("external source {} disconnected: {why}", self.name);
        self.hear(CUT.to_vec()).await
    }

    async fn hear(&self, bytes: Vec<u8>) -> Result<(), Closed> {
        self.heard.send((self.id, bytes)).await.map_err(|_| Closed)
    }
}

/// Core has ended.
struct Closed;

/// Sends one line and closes. Whether the line arrives does not matter.
fn turn_away(stream: TcpStream, name: &str) {
    let line = format!("external source {name} is connected already\r\n");
    if stream.try_write(line.as_bytes()).is_err() {
        info!("external source {name}: the program that was turned away had already disconnected");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncBufReadExt, BufReader};

    fn table(name: &str, listen: &str) -> ExternalTable {
        ExternalTable {
            name: name.to_owned(),
            sends: vec![backseat_core::ExternalSentence::Relay],
            listen: listen.to_owned(),
            bounds: backseat_core::ExternalBounds::default(),
        }
    }

    /// An address on which nothing listens.
    fn free() -> String {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        listener.local_addr().unwrap().to_string()
    }

    #[tokio::test]
    async fn lines_go_in_and_answers_out_one_program_at_a_time() {
        let address = free();
        let (ports, mut heard) = Ports::open(&[table("pod", &address)]).unwrap();
        // Dropped, because no program is connected yet.
        ports.tell(ExternalId(0), b"$BFACK,early\r\n".to_vec());
        tokio::task::yield_now().await;
        let mut first = BufReader::new(TcpStream::connect(&address).await.unwrap());
        first.write_all(b"$BPTMR,1").await.unwrap();
        assert_eq!(heard.recv().await.unwrap(), (ExternalId(0), b"$BPTMR,1".to_vec()));
        ports.tell(ExternalId(0), b"$BFACK,1\r\n".to_vec());
        let mut line = String::new();
        first.read_line(&mut line).await.unwrap();
        assert_eq!(line, "$BFACK,1\r\n");

        let mut second = BufReader::new(TcpStream::connect(&address).await.unwrap());
        line.clear();
        second.read_line(&mut line).await.unwrap();
        assert_eq!(line, "external source pod is connected already\r\n");
        assert_eq!(second.read_line(&mut line).await.unwrap(), 0, "and no more");

        drop(first);
        assert_eq!(
            heard.recv().await.unwrap(),
            (ExternalId(0), CUT.to_vec()),
            "its half line is cut off"
        );
        let mut third = TcpStream::connect(&address).await.unwrap();
        third.write_all(b"\n").await.unwrap();
        assert_eq!(heard.recv().await.unwrap(), (ExternalId(0), b"\n".to_vec()));
    }

    #[tokio::test]
    async fn a_flood_waits_in_the_programs_own_socket() {
        let address = free();
        let (_ports, mut heard) = Ports::open(&[table("pod", &address)]).unwrap();
        let mut flood = TcpStream::connect(&address).await.unwrap();
        let flooding = tokio::spawn(async move {
            let bytes = vec![b'x'; 1 << 20];
            loop {
                if flood.write_all(&bytes).await.is_err() {
                    return;
                }
            }
        });
        let begun = tokio::time::Instant::now();
        let mut read = 0;
        while begun.elapsed() < Duration::from_millis(700) {
            if let Ok(Some((_, bytes))) = tokio::time::timeout(Duration::from_millis(100), heard.recv()).await {
                assert!(bytes.len() <= READ_MAX);
                read += bytes.len();
            }
        }
        assert!((10_000..80_000).contains(&read), "{read} bytes in 0.7 s");
        flooding.abort();
    }

    #[tokio::test]
    async fn a_program_that_takes_no_answers_is_let_go() {
        let address = free();
        let (ports, mut heard) = Ports::open(&[table("pod", &address)]).unwrap();
        let mut deaf = TcpStream::connect(&address).await.unwrap();
        deaf.write_all(b"x").await.unwrap();
        heard.recv().await.unwrap();
        let begun = tokio::time::Instant::now();
        loop {
            ports.tell(ExternalId(0), vec![b'y'; 1 << 17]);
            if let Ok(gone) = tokio::time::timeout(Duration::from_millis(20), heard.recv()).await {
                assert_eq!(gone.unwrap().1, CUT);
                break;
            }
            assert!(begun.elapsed() < Duration::from_secs(20));
        }
    }

    #[tokio::test]
    async fn an_address_that_is_taken_is_named() {
        let address = free();
        let _open = Ports::open(&[table("pod", &address)]).unwrap();
        let error = Ports::open(&[table("other", &address)]).err().expect("it is taken");
        assert!(
            error
                .to_string()
                .contains(&format!("external source `other`: cannot listen on {address}")),
            "{error}"
        );
    }
}
