//! A live vehicle's state in one view, as lines of a terminal.

use std::time::Duration;

use backseat_spi::{Battery, Navigation, PositionQuality};
use backseat_units::{Altitude, Timestamp};

use crate::paint::Paint;
use crate::text::place;
use crate::watch::{SILENT_AFTER, Watch, behavior};

/// Navigation older than this is shown as an alarm, because a runtime ends its leases at this age by default.
const NAVIGATION_OLD: Duration = Duration::from_secs(1);
const UNKNOWN: &str = "unknown";

/// The lines, each at most `width` characters wide.
pub(crate) fn lines(watch: &Watch, address: &str, now: Timestamp, width: usize, paint: Paint) -> Vec<String> {
    let mut panel = Panel {
        lines: Vec::new(),
        width,
        paint,
    };
    let link = watch.up_since.map_or_else(
        || panel.alarm("not connected"),
        |since| match watch.silent_for(now) {
            Some(silent) => panel.alarm(&format!("connected, silent for {}", duration(silent))),
            None => format!("connected for {}", duration(now.since(since))),
        },
    );
    let version = watch
        .version
        .as_ref()
        .map_or(String::new(), |version| format!(", SPI {version}"));
    let clock = watch
        .vehicle_time
        .map_or(String::new(), |time| format!(", vehicle's clock {time} UTC"));
    panel.row("vehicle", &format!("{address}, {link}{version}{clock}"));
    navigation(&mut panel, watch, now);
    let mission = watch.mission.as_ref().map_or_else(
        || UNKNOWN.to_owned(),
        |mission| {
            words([
                mission.status.as_str(),
                mission.dive_file.as_str(),
                mission.details.as_str(),
            ])
        },
    );
    panel.row("mission", &mission);
    let begun = watch
        .behavior
        .as_ref()
        .map(|begin| behavior(begin.kind.as_str(), begin.number, begin));
    panel.row("behavior", begun.as_deref().unwrap_or(UNKNOWN));
    let control = match watch.control {
        Some(true) => "the backseat's",
        Some(false) => "the vehicle's",
        // Vehicles send it only when it changes.
        None => "unknown until the vehicle reports it",
    };
    panel.row("control", control);
    panel.row(
        "battery",
        &watch.battery.as_ref().map_or_else(|| UNKNOWN.to_owned(), battery),
    );
    counts(&mut panel, watch);
    for (index, (at, text)) in watch.events.iter().enumerate() {
        let label = if index == 0 { "events" } else { "" };
        panel.row(label, &format!("{} ago: {text}", duration(now.since(*at))));
    }
    panel.lines
}

fn navigation(panel: &mut Panel, watch: &Watch, now: Timestamp) {
    let age = watch.navigation_age(now).map(|age| {
        let text = format!("{} old", duration(age));
        if age > NAVIGATION_OLD { panel.alarm(&text) } else { text }
    });
    match (&watch.navigation, age) {
        (Some(navigation), Some(age)) => {
            panel.row("position", &format!("{}, {age}", position(navigation)));
            let altitude = navigation
                .altitude
                .map_or("no bottom lock".to_owned(), |altitude| metres(Altitude::as_m(altitude)));
            panel.row(
                "depth",
                &format!("{}, altitude {altitude}", metres(navigation.depth.as_m())),
            );
            panel.row(
                "attitude",
                &format!(
                    "heading {:.1} deg of the grid, pitch {:.1} deg, roll {:.1} deg",
                    navigation.heading.as_deg(),
                    navigation.pitch_deg,
                    navigation.roll_deg
                ),
            );
        }
        (Some(_) | None, _) => panel.row("position", UNKNOWN),
    }
    if let Some(relative) = &watch.relative {
        panel.row(
            "relative",
            &format!(
                "horizontal {:.2} m, vertical {:.2} m, distance {:.2} m, heading {:.1} deg, depth {:.2} m",
                relative.horizontal_m, relative.vertical_m, relative.distance_m, relative.heading_deg, relative.depth_m
            ),
        );
    }
    let speed = watch.velocity.as_ref().map_or_else(
        || UNKNOWN.to_owned(),
        |velocity| {
            let over_ground = backseat_units::math::hypot(velocity.east_mps, velocity.north_mps);
            format!("{over_ground:.2} m/s over ground, {:.2} m/s down", velocity.down_mps)
        },
    );
    panel.row("speed", &speed);
}

fn position(navigation: &Navigation) -> String {
    let Navigation { position, quality, .. } = navigation;
    let gps = match quality {
        PositionQuality::Gps => "with GPS",
        PositionQuality::NoGps => "without GPS",
        PositionQuality::Other(_) => "of unknown quality",
    };
    format!(
        "{}  {}, {gps}",
        place(position.latitude.as_deg(), ["N", "S"]),
        place(position.longitude.as_deg(), ["E", "W"])
    )
}

fn battery(battery: &Battery) -> String {
    let part = |value: Option<f64>, unit: &str| value.map(|value| format!("{value:.1} {unit}"));
    let which = (battery.number != 0).then(|| format!("number {}", battery.number));
    let parts = [
        part(battery.charge_percent, "%"),
        part(battery.voltage_v, "V"),
        part(battery.capacity_kwh, "kWh"),
        part(battery.temperature_c, "degC"),
        which,
    ];
    let known: Vec<String> = parts.into_iter().flatten().collect();
    if known.is_empty() {
        UNKNOWN.to_owned()
    } else {
        known.join(", ")
    }
}

fn counts(panel: &mut Panel, watch: &Watch) {
    let counted: Vec<String> = watch
        .tally
        .by_message()
        .map(|(name, count)| format!("{} {count}", &name[2..]))
        .collect();
    panel.wrapped(
        "messages",
        if counted.is_empty() {
            vec!["none".to_owned()]
        } else {
            counted
        },
    );
    let mut faults = watch.tally.faults();
    if faults.is_empty() {
        panel.row("faults", "none");
        return;
    }
    if let Some(last) = &watch.last_fault {
        faults.push(format!("the last: {last}"));
    }
    let text = panel.alarm(&faults.join(", "));
    panel.row("faults", &text);
}

/// The one-line summary at the end.
pub(crate) fn summary(watch: &Watch, now: Timestamp) -> String {
    let connections = watch.connections;
    let plural = if connections == 1 { "" } else { "s" };
    let counted: Vec<String> = watch
        .tally
        .by_message()
        .map(|(name, count)| format!("{name} {count}"))
        .collect();
    let counted = if counted.is_empty() {
        String::new()
    } else {
        format!(": {}", counted.join(" "))
    };
    format!(
        "{} watched, {connections} connection{plural}, {}{counted}",
        duration(now.since(Timestamp::ZERO)),
        watch.tally
    )
}

pub(crate) fn duration(duration: Duration) -> String {
    let seconds = duration.as_secs();
    match seconds {
        0..10 => format!("{:.1} s", duration.as_secs_f64()),
        10..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds / 60 % 60),
    }
}

fn metres(value: f64) -> String {
    format!("{value:.1} m")
}

fn words<'a>(parts: impl IntoIterator<Item = &'a str>) -> String {
    let parts: Vec<&str> = parts
        .into_iter()
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .collect();
    if parts.is_empty() {
        UNKNOWN.to_owned()
    } else {
        parts.join(", ")
    }
}

struct Panel {
    lines: Vec<String>,
    width: usize,
    paint: Paint,
}

const LABEL: usize = 10;

impl Panel {
    fn row(&mut self, label: &str, text: &str) {
        let (quiet, plain) = (self.paint.quiet(), self.paint.plain());
        let line = format!("{quiet}{label:<LABEL$}{plain}{text}");
        self.lines
            .push(console::truncate_str(&line, self.width, "…").into_owned());
    }

    /// Adds as many rows as the items need.
    fn wrapped(&mut self, label: &str, items: Vec<String>) {
        let mut row = String::new();
        let mut label = label;
        for item in items {
            if !row.is_empty() && LABEL + row.len() + 2 + item.len() > self.width {
                self.row(label, &row);
                label = "";
                row.clear();
            }
            if !row.is_empty() {
                row.push_str("  ");
            }
            row.push_str(&item);
        }
        self.row(label, &row);
    }

    fn alarm(&self, text: &str) -> String {
        format!("{}{text}{}", self.paint.alarm(), self.paint.plain())
    }
}

/// The message about a silence.
pub(crate) fn silence(silent: Duration) -> String {
    format!(
        "the vehicle has been silent for {} ({} s are too long): subscribing again",
        duration(silent),
        SILENT_AFTER.as_secs()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::tests::{at, take};

    const PLAIN: Paint = Paint::new(false);

    #[test]
    fn the_picture_of_a_running_vehicle() {
        let mut watch = Watch::default();
        watch.connected(at(0.0));
        for line in [
            "$BFVER,081025.987,1.12",
            "$BFCTL,081025.987,1",
            "$BFMIS,081025.987,survey.dive,Running,",
            "$BFMBS,081025.987,survey.dive,3,,trackline",
            "$BFNVG,081025.987,4221.810920,N,07106.846030,W,0,,20.1,203.1,-3.4,4.5,081025.887",
            "$BFNVR,081025.987,0.9,-1.2,0.02,0.1,-0.25,1.5",
            "$BFRBS,081025.987,0,29.85,,,18.5,,87.5",
            "$BFXYZ,1",
        ] {
            take(&mut watch, 60.0, line);
        }
        let expected = "\
vehicle   auv:29500, connected for 1 min 02 s, SPI 1.12, vehicle's clock 08:10:25.987 UTC
position  42.363515 N  71.114101 W, without GPS, 2.1 s old
depth     20.1 m, altitude no bottom lock
attitude  heading 203.1 deg of the grid, pitch 4.5 deg, roll -3.4 deg
speed     1.50 m/s over ground, 0.02 m/s down
mission   Running, survey.dive
behavior  trackline 3
control   the backseat's
battery   87.5 %, 29.9 V, 18.5 degC
messages  VER 1  NVG 1  NVR 1  RBS 1  MBS 1  MIS 1  CTL 1
faults    1 unknown, the last: BFXYZ: unknown message
events    2.0 s ago: the vehicle speaks SPI 1.12
          2.0 s ago: control handed to the backseat
          2.0 s ago: mission \"Running\"
          2.0 s ago: begins: trackline 3";
        assert_eq!(lines(&watch, "auv:29500", at(62.0), 100, PLAIN).join("\n"), expected);
        assert_eq!(
            summary(&watch, at(62.0)),
            "1 min 02 s watched, 1 connection, 8 sentences, 7 read, 1 unknown: BFVER 1 BFNVG 1 BFNVR 1 BFRBS 1 BFMBS 1 \
             BFMIS 1 BFCTL 1"
        );
    }

    #[test]
    fn what_is_not_known_is_said_to_be() {
        let lines = lines(&Watch::default(), "auv:29500", at(1.0), 100, PLAIN);
        assert_eq!(lines[0], "vehicle   auv:29500, not connected");
        assert_eq!(
            lines.iter().filter(|line| line.contains("unknown")).count(),
            6,
            "{lines:?}"
        );
        let mut silent = Watch::default();
        silent.connected(at(1.0));
        let lines = super::lines(&silent, "auv:29500", at(7.0), 100, PLAIN);
        assert_eq!(lines[0], "vehicle   auv:29500, connected, silent for 6.0 s");
    }

    #[test]
    fn no_line_is_wider_than_the_terminal() {
        let mut watch = Watch::default();
        for entry in backseat_spi::catalogue() {
            take(&mut watch, 1.0, entry.example);
        }
        take(&mut watch, 1.0, &format!("$BFMSC,081025.987,{}", "a".repeat(500)));
        for width in [10, 40, 80] {
            for colour in [false, true] {
                for line in lines(&watch, "auv:29500", at(2.0), width, Paint::new(colour)) {
                    assert!(console::measure_text_width(&line) <= width, "{line}");
                }
            }
        }
    }
}
