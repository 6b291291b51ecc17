use std::time::Duration;

use backseat_mvc::{Activity, Behavior, ClientId, Mvc, MvcEvent, MvcEventKind};
use tracing::{debug, info};

use crate::events::Events;
use crate::mvc::bar::Bar;

/// How often the vehicle's state is shown, real time: on a terminal as two status lines, else as a line of text.
const REDRAW_EVERY: Duration = Duration::from_millis(250);
const LINE_EVERY: Duration = Duration::from_secs(60);

/// What the screen shows about the vehicle.
pub(crate) struct Status {
    /// Present on a terminal.
    bar: Option<Bar>,
    next: Duration,
    behavior: Option<Behavior>,
    last_command: Option<String>,
    events: Events,
    quiet: bool,
}

impl Status {
    pub(crate) fn new() -> Self {
        Self {
            bar: Bar::start(),
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
            next: Duration::ZERO,
            behavior: None,
            last_command: None,
            events: Events::default(),
            quiet: true,
        }
    }

    /// Prints a line of text.
    pub(crate) fn say(&mut self, now: Duration, text: &str) {
        if self.quiet {
            debug!("vehicle: {text}");
            return;
        }
        self.events.show(now, text, |text| info!("{text}"));
    }

    /// Prints a line that the operator has asked for.
    pub(crate) fn answer(&self, text: &str) {
        info!("{text}");
    }

    /// Leaves a terminal to the operator, who has typed an empty line and will type a command; or takes it back.
    pub(crate) fn prompt(&self, prompts: bool) {
        if let Some(bar) = &self.bar {
            bar.prompt(prompts);
        }
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
        match &self.bar {
            Some(bar) => {
                self.next = now + REDRAW_EVERY;
                bar.set(self.doing(vehicle, clients), place(vehicle));
            }
            None => {
                self.next = now + LINE_EVERY;
                info!("{}", self.state(vehicle, clients));
            }
        }
    }

    /// What the vehicle does and where it is, in one line.
    pub(crate) fn state(&self, vehicle: &Mvc, clients: usize) -> String {
        format!("{} | {}", self.doing(vehicle, clients), place(vehicle))
    }

    pub(crate) fn end(&self) {
        if let Some(bar) = &self.bar {
            bar.end();
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
