use std::future::{Future, pending};
use std::io::{self, Write};
use std::pin::{Pin, pin};
use std::time::Duration;

use backseat_units::Timestamp;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep_until, timeout};
use tracing::{info, warn};

use crate::address::Address;
use crate::error::Error;
use crate::paint::Paint;
use crate::panel;
use crate::reading::Reading;
use crate::sheet::{Form, write_reading};
use crate::splitter::Splitter;
use crate::subscription::Subscription;
use crate::watch::Watch;

/// What to watch, and how to show it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The vehicle.
    pub address: Address,
    /// The messages to subscribe to.
    pub subscription: Subscription,
    /// How they are shown.
    pub view: View,
    /// How long to watch, seconds; `None` until it is stopped.
    pub seconds: Option<u64>,
}

/// How a live vehicle is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// A panel that is redrawn in place on a terminal.
    Panel {
        /// Whether the terminal supports colours.
        colour: bool,
    },
    /// One line for each message. Events of the connection go to the program's own log.
    Lines(Form),
}

/// The result of a watch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Watched {
    /// One line: the duration and the counts of messages and faults.
    pub summary: String,
    /// Whether any message was received.
    pub heard: bool,
}

const CONNECT_WITHIN: Duration = Duration::from_secs(5);
const WRITE_WITHIN: Duration = Duration::from_secs(1);
const RETRY_MIN: Duration = Duration::from_millis(500);
const RETRY_MAX: Duration = Duration::from_secs(10);
/// How long a vehicle may stay silent before the subscription is sent again.
const ASK_AGAIN: Duration = Duration::from_secs(10);
const REDRAW: Duration = Duration::from_millis(200);
const READ: usize = 1 << 14;

/// Watches a vehicle until `stop` completes or the time is over: connects, subscribes, shows the messages, and
/// reconnects with back-off when the link is lost.
///
/// It sends BPLOG and nothing else. Without BPVER the vehicle does not regard it as a payload. A closed output ends the
/// watch too, without an error.
///
/// # Errors
///
/// [`Error::Output`]. A vehicle that cannot be reached is not an error; the connection is tried again.
pub async fn connect(
    connection: &Connection,
    stop: impl Future<Output = ()>,
    out: &mut impl Write,
) -> Result<Watched, Error> {
    let mut driver = Driver::new(connection, out);
    match driver.drive(stop).await {
        Ok(()) => {}
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        Err(error) => return Err(Error::Output(error)),
    }
    driver.count_passed();
    let now = driver.now();
    Ok(Watched {
        summary: panel::summary(&driver.watch, now),
        heard: driver.watch.tally.read() > 0,
    })
}

struct Driver<'a, W> {
    connection: &'a Connection,
    address: String,
    out: &'a mut W,
    start: Instant,
    watch: Watch,
    splitter: Splitter,
    lines: Vec<u8>,
    /// The number of lines of the panel that are on the terminal.
    drawn: usize,
    retry: Duration,
    ask_again: Option<Timestamp>,
}

enum Phase {
    Waiting(Instant),
    Connecting(Pin<Box<dyn Future<Output = io::Result<TcpStream>>>>),
    Up(TcpStream),
}

enum Step {
    Retry,
    Connected(TcpStream),
    Read(usize),
    Lost(String),
}

impl Phase {
    /// Waits for the next event. Dropping the future before it completes loses nothing.
    async fn step(&mut self, buffer: &mut [u8]) -> Step {
        match self {
            Self::Waiting(until) => {
                sleep_until(*until).await;
                Step::Retry
            }
            Self::Connecting(connecting) => match connecting.await {
                Ok(stream) => Step::Connected(stream),
                Err(error) => Step::Lost(format!("no connection: {error}")),
            },
            Self::Up(stream) => match stream.read(buffer).await {
                Ok(0) => Step::Lost("the vehicle closed the connection".to_owned()),
                Ok(read) => Step::Read(read),
                Err(error) => Step::Lost(format!("connection lost: {error}")),
            },
        }
    }
}

fn connecting(address: &Address) -> Phase {
    let Address { host, port } = address.clone();
    Phase::Connecting(Box::pin(async move {
        let stream = timeout(CONNECT_WITHIN, TcpStream::connect((host.as_str(), port)))
            .await
            .map_err(|_| io::Error::new(io::ErrorKind::TimedOut, "no answer within 5 s"))??;
        stream.set_nodelay(true)?;
        Ok(stream)
    }))
}

impl<'a, W: Write> Driver<'a, W> {
    fn new(connection: &'a Connection, out: &'a mut W) -> Self {
        Self {
            address: connection.address.to_string(),
            connection,
            out,
            start: Instant::now(),
            watch: Watch::default(),
            splitter: Splitter::default(),
            lines: Vec::new(),
            drawn: 0,
            retry: RETRY_MIN,
            ask_again: None,
        }
    }

    fn now(&self) -> Timestamp {
        Timestamp::ZERO + self.start.elapsed()
    }

    async fn drive(&mut self, stop: impl Future<Output = ()>) -> io::Result<()> {
        let mut stop = pin!(stop);
        let until = self
            .connection
            .seconds
            .and_then(|seconds| self.start.checked_add(Duration::from_secs(seconds)));
        let mut over = pin!(async move {
            match until {
                Some(until) => sleep_until(until).await,
                None => pending().await,
            }
        });
        let mut redraw = interval(REDRAW);
        redraw.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut buffer = vec![0; READ];
        let mut phase = connecting(&self.connection.address);
        loop {
            let step = tokio::select! {
                biased;
                () = &mut stop => return self.draw(),
                () = &mut over => return self.draw(),
                _ = redraw.tick() => None,
                step = phase.step(&mut buffer) => Some(step),
            };
            phase = match step {
                None => {
                    self.listen_for_silence(&mut phase).await;
                    self.draw()?;
                    continue;
                }
                Some(Step::Retry) => connecting(&self.connection.address),
                Some(Step::Connected(stream)) => self.open(stream).await,
                Some(Step::Read(read)) => {
                    self.receive(&buffer[..read])?;
                    continue;
                }
                Some(Step::Lost(why)) => self.lost(&why)?,
            };
        }
    }

    async fn open(&mut self, mut stream: TcpStream) -> Phase {
        let now = self.now();
        self.watch.connected(now);
        self.ask_again = None;
        self.tell(format!("connected to {}", self.address));
        // If this fails, the read that follows reports it.
        let _told_by_read = write(&mut stream, &self.connection.subscription.sentences()).await;
        Phase::Up(stream)
    }

    fn receive(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.splitter.push(bytes);
        self.take_in()
    }

    fn lost(&mut self, why: &str) -> io::Result<Phase> {
        // A partial sentence is reported as cut off.
        self.splitter.end();
        self.take_in()?;
        self.watch.disconnected();
        self.warn(format!(
            "{}: {why}; next attempt in {:.1} s",
            self.address,
            self.retry.as_secs_f64()
        ));
        let until = Instant::now() + self.retry;
        self.retry = (self.retry * 2).min(RETRY_MAX);
        Ok(Phase::Waiting(until))
    }

    fn take_in(&mut self) -> io::Result<()> {
        let now = self.now();
        let mut returned = None;
        while let Some(piece) = self.splitter.next() {
            let length = piece.bytes.len() as u64;
            let Some(reading) = Reading::of(piece, false) else {
                self.splitter.count_noise(length);
                continue;
            };
            if reading.outcome.is_ok() {
                self.retry = RETRY_MIN;
            }
            returned = self.watch.take(now, &reading).or(returned);
            if let View::Lines(form) = self.connection.view {
                write_reading(&mut self.lines, form, &reading, Some(now.as_secs_f64()))?;
            }
        }
        self.count_passed();
        if let Some(silent) = returned {
            self.tell(format!(
                "received from the vehicle again after {} of silence",
                panel::duration(silent)
            ));
        }
        self.out.write_all(&self.lines)?;
        self.lines.clear();
        self.out.flush()
    }

    async fn listen_for_silence(&mut self, phase: &mut Phase) {
        let Phase::Up(stream) = phase else { return };
        let now = self.now();
        if let Some(silent) = self.watch.silence(now) {
            self.warn(panel::silence(silent));
        } else if self.watch.silent_for(now).is_none() || self.ask_again.is_some_and(|at| now < at) {
            return;
        }
        self.ask_again = Some(now + ASK_AGAIN);
        // If this fails, the read that follows reports it.
        let _told_by_read = write(stream, &self.connection.subscription.sentences_again()).await;
    }

    fn count_passed(&mut self) {
        self.watch
            .tally
            .set_passed(self.splitter.too_long, self.splitter.noise_bytes);
    }

    fn tell(&mut self, text: String) {
        match self.connection.view {
            View::Panel { .. } => self.watch.note(self.now(), text),
            View::Lines(_) => info!("{text}"),
        }
    }

    fn warn(&mut self, text: String) {
        match self.connection.view {
            View::Panel { .. } => self.watch.note(self.now(), text),
            View::Lines(_) => warn!("{text}"),
        }
    }

    /// Redraws the panel in place.
    fn draw(&mut self) -> io::Result<()> {
        let View::Panel { colour } = self.connection.view else {
            return Ok(());
        };
        let (height, width) = console::Term::stdout().size();
        let mut lines = panel::lines(
            &self.watch,
            &self.address,
            self.now(),
            usize::from(width),
            Paint::new(colour),
        );
        // The cursor cannot move above the top of the screen, so what does not fit is left out, starting with the
        // newest events.
        lines.truncate(usize::from(height).saturating_sub(1));
        let mut frame = Vec::new();
        if self.drawn > 0 {
            write!(frame, "\x1b[{}A", self.drawn)?;
        }
        for line in &lines {
            writeln!(frame, "{line}\x1b[K")?;
        }
        frame.extend_from_slice(b"\x1b[J");
        self.drawn = lines.len();
        self.out.write_all(&frame)?;
        self.out.flush()
    }
}

async fn write(stream: &mut TcpStream, bytes: &[u8]) -> io::Result<()> {
    timeout(WRITE_WITHIN, stream.write_all(bytes))
        .await
        .map_err(|_| io::Error::from(io::ErrorKind::TimedOut))?
}
