use std::io::IsTerminal;
use std::time::Duration;

use backseat_mvc::{Activity, Behavior, ClientId, Mvc, MvcEvent, MvcEventKind};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use tracing::{debug, info};

use crate::events::Events;

/// How often the vehicle's state is shown, real time: on a terminal as a status line, else as a line of text.
const REDRAW_EVERY: Duration = Duration::from_millis(250);
const LINE_EVERY: Duration = Duration::from_secs(60);

/// What the screen shows about the vehicle.
pub(crate) struct Status {
    /// Present on a terminal.
    bar: Option<ProgressBar>,
    next: Duration,
    behavior: Option<Behavior>,
    last_command: Option<String>,
    events: Events,
    quiet: bool,
}

impl Status {
    pub(crate) fn new() -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(8));
            bar.set_style(ProgressStyle::with_template("{wide_msg}\n{prefix}").expect("the template is valid"));
            bar
        });
        Self {
            bar,
            next: Duration::ZERO,
            behavior: None,
            last_command: None,
            events: Events::default(),
            quiet: false,
        }
    }

    /// Shows nothing, unless BACKSEAT_LOG=debug: somebody else has the screen.
    pub(crate) fn quiet() -> Self {
        Self {
            bar: None,
            quiet: true,
            ..Self::new()
        }
    }

    /// Prints a line of text.
    pub(crate) fn say(&mut self, now: Duration, text: &str) {
        if self.quiet {
            debug!("vehicle: {text}");
            return;
        }
        let bar = self.bar.as_ref();
        self.events.show(now, text, |text| match bar {
            Some(bar) => bar.suspend(|| info!("{text}")),
            None => info!("{text}"),
        });
    }

    pub(crate) fn event(&mut self, now: Duration, event: &MvcEvent) {
        if let MvcEventKind::BehaviorBegan(behavior) = &event.kind {
            self.behavior = Some(*behavior);
        }
        self.say(now, &event.to_string());
    }

    /// Notes a client's command.
    pub(crate) fn command(&mut self, client: ClientId, line: &[u8]) {
        let name: String = line
            .trim_ascii_start()
            .iter()
            .skip(1)
            .take_while(|byte| byte.is_ascii_alphanumeric())
            .take(5)
            .map(|byte| char::from(*byte))
            .collect();
        if !name.is_empty() {
            self.last_command = Some(format!("{name} of {client}"));
        }
    }

    /// Shows where the vehicle is, if an update is due.
    pub(crate) fn update(&mut self, now: Duration, vehicle: &Mvc, clients: usize) {
        if self.quiet || now < self.next {
            return;
        }
        let (doing, place) = (self.doing(vehicle, clients), place(vehicle));
        match &self.bar {
            Some(bar) => {
                self.next = now + REDRAW_EVERY;
                bar.set_message(doing);
                bar.set_prefix(place);
                bar.tick();
            }
            None => {
                self.next = now + LINE_EVERY;
                info!("{doing} | {place}");
            }
        }
    }

    pub(crate) fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn doing(&self, vehicle: &Mvc, clients: usize) -> String {
        let truth = vehicle.truth();
        let seconds = truth.time.as_nanos() / 1_000_000_000;
        let doing = match truth.activity {
            Activity::Waiting => String::new(),
            Activity::Plan { .. } | Activity::Insert { .. } => self.behavior(""),
            Activity::Modified { .. } => self.behavior(" (modified)"),
            Activity::Suspended => self.behavior(" (suspended)"),
            Activity::WrappingUp => ", climbing".to_owned(),
            Activity::Stopped => ", drifting".to_owned(),
        };
        let plural = if clients == 1 { "" } else { "s" };
        let control = if truth.control { "payload" } else { "vehicle" };
        let last = self.last_command.as_deref().unwrap_or("none");
        format!(
            "{}:{:02}:{:02} {}{doing} | control: {control} | {clients} client{plural}, last command: {last}",
            seconds / 3600,
            seconds / 60 % 60,
            seconds % 60,
            vehicle.mission_status().name(),
        )
    }

    fn behavior(&self, how: &str) -> String {
        self.behavior
            .map_or_else(String::new, |behavior| format!(", {behavior}{how}"))
    }
}

/// Where the vehicle is, and how it moves.
pub(crate) fn place(vehicle: &Mvc) -> String {
    let truth = vehicle.truth();
    let (east, north) = (truth.local.east_m, truth.local.north_m);
    format!(
        "{:.0} m {} {:.0} m {} of origin | depth {:.1} m, {:.1} m above ground | heading {:03.0}, {:.1} m/s",
        east.abs(),
        if east <= -0.5 { "W" } else { "E" },
        north.abs(),
        if north <= -0.5 { "S" } else { "N" },
        truth.depth_m,
        truth.altitude_m,
        truth.heading_deg,
        truth.speed_mps,
    )
}
