use std::f64::consts::LN_10;

use backseat_units::math::ln;
use serde::Deserialize;

use crate::item::{Item, PING_BINS};
use crate::teller::thin::Thin;

/// Pings are shown at most this often, seconds.
const SHOWN_EVERY_S: f64 = 0.2;
/// Pings in the history.
const KEPT_EVERY_S: f64 = 1.0;
/// The swath in the history.
const SWATHS_KEPT_EVERY_S: f64 = 2.0;
/// A swath is placed where the vehicle was no longer ago than this, seconds.
const PLACED_WITHIN_S: f64 = 2.0;

/// What the sonars show.
#[derive(Debug, Default)]
pub(super) struct Sonar {
    thin: Thin,
    /// When, and latitude, longitude and heading, degrees.
    here: Option<(f64, [f64; 3])>,
    /// The sensor and the number of the last ping: several plugins get the same one.
    last: Option<(i64, u64)>,
}

#[derive(Deserialize)]
struct PingInput {
    report_ping: Report,
}

#[derive(Deserialize)]
struct Report {
    #[serde(rename = "2")]
    ping: Ping,
}

#[derive(Deserialize)]
struct Ping {
    sub_bottom: bool,
    sensor: i64,
    number: u64,
    channels: Vec<Channel>,
}

#[derive(Deserialize)]
struct Channel {
    side: String,
    range_m: f64,
    samples: Vec<f64>,
}

#[derive(Deserialize)]
struct EventInput {
    report_event_swath: Option<Swath>,
}

#[derive(Deserialize)]
struct Swath {
    port_m: f64,
    starboard_m: f64,
}

impl Sonar {
    pub(super) const fn navigated(&mut self, t: f64, here: [f64; 3]) {
        self.here = Some((t, here));
    }

    pub(super) fn ping(&mut self, t: f64, data: &[u8], tell: &mut impl FnMut(f64, Item, bool)) {
        // A ping is long to read, and most are not shown.
        if !self.thin.is_due("ping", t) {
            return;
        }
        let Ok(PingInput {
            report_ping: Report { ping },
        }) = serde_json::from_slice(data)
        else {
            return;
        };
        let this = (ping.sensor, ping.number);
        if ping.sub_bottom || self.last == Some(this) {
            return;
        }
        let side = |name: &str| ping.channels.iter().find(|channel| channel.side == name);
        let (port, starboard) = (side("port"), side("starboard"));
        let range_m = [port, starboard].into_iter().flatten().map(|side| side.range_m);
        let range_m = range_m.filter(|range_m| range_m.is_finite()).fold(0.0, f64::max);
        if range_m <= 0.0 || !self.thin.takes("ping", t, SHOWN_EVERY_S) {
            return;
        }
        self.last = Some(this);
        let keep = self.thin.takes("ping kept", t, KEPT_EVERY_S);
        let item = Item::Ping {
            sensor: ping.sensor,
            port: port.map(|side| bins(&side.samples)),
            starboard: starboard.map(|side| bins(&side.samples)),
            range_m,
        };
        tell(t, item, keep);
    }

    pub(super) fn event(&mut self, t: f64, data: &[u8], tell: &mut impl FnMut(f64, Item, bool)) {
        let swath = serde_json::from_slice::<EventInput>(data).map(|event| event.report_event_swath);
        let (Ok(Some(swath)), Some((seen, [lat, lon, heading_deg]))) = (swath, self.here) else {
            return;
        };
        if t - seen > PLACED_WITHIN_S {
            return;
        }
        let keep = self.thin.takes("swath", t, SWATHS_KEPT_EVERY_S);
        let item = Item::Swath {
            lat,
            lon,
            heading_deg,
            port_m: swath.port_m,
            starboard_m: swath.starboard_m,
        };
        tell(t, item, keep);
    }
}

/// The greatest sample of each bin, in half decibels over one step.
fn bins(samples: &[f64]) -> String {
    let of = |place: usize| place * samples.len() / PING_BINS;
    let bins = (0..PING_BINS).map(|bin| {
        let first = of(bin).min(samples.len().saturating_sub(1));
        let last = of(bin + 1).max(first + 1).min(samples.len());
        let greatest = samples[first..last].iter().copied().fold(0.0, f64::max);
        (40.0 / LN_10 * ln(1.0 + greatest)).round().clamp(0.0, 255.0) as u8
    });
    bins.map(|value| format!("{value:02x}")).collect()
}

/// The contact of which a line tells: `contact NAME ... at LATITUDE LONGITUDE ...`, degrees.
pub(super) fn contact(plugin: &str, line: &str) -> Option<Item> {
    let (before, place) = line.strip_prefix("contact ")?.split_once(" at ")?;
    let name = before.split([' ', ':']).next().filter(|name| !name.is_empty())?;
    let mut words = place.split([' ', ',', ':']).filter(|word| !word.is_empty());
    let mut degrees = |most: f64| {
        let value: f64 = words.next()?.parse().ok()?;
        (value.abs() <= most).then_some(value)
    };
    let (lat, lon) = (degrees(90.0)?, degrees(180.0)?);
    Some(Item::Contact {
        plugin: plugin.to_owned(),
        name: name.to_owned(),
        lat,
        lon,
        text: line.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_a_contact_is_a_place_on_the_map() {
        let place = |line: &str| match contact("reinspect", line) {
            Some(Item::Contact { name, lat, lon, .. }) => Some((name, lat, lon)),
            _ => None,
        };
        let confirmed = "contact 12 confirmed at 42.301503 -70.847676 by 8 of 8 aspects";
        assert_eq!(place(confirmed), Some(("12".to_owned(), 42.301503, -70.847676)));
        let seen = "contact 1: 1.2 m high at 42.3, -70.8, seen from 1 lines";
        assert_eq!(place(seen), Some(("1".to_owned(), 42.3, -70.8)));
        for line in [
            "contact 1: 1.2 m high, 1.1 m long",
            "contact lost at noon today",
            "contact 7 at 95.0 10.0",
            "contact 7 at NaN 10.0",
            "no contact 7 at 42.0 -70.0",
            "contact  at 42.0 -70.0",
        ] {
            assert_eq!(place(line), None, "{line}");
        }
    }

    #[test]
    fn a_ping_is_told_once_in_bins_and_a_swath_where_the_vehicle_is() {
        let samples = |first: f64| {
            let mut samples = vec![0.0; 512];
            samples[0] = first;
            samples[511] = 999.0;
            samples
        };
        let ping = |number: u64, side: &str| {
            let channel = serde_json::json!({"side": side, "range_m": 60.0, "samples": samples(9.0)});
            let ping = serde_json::json!({"sub_bottom": false, "sensor": 0, "number": number, "channels": [channel]});
            format!(r#"{{"input":"sonar","report":"ping","report_ping":{{"1":0,"2":{ping}}}}}"#)
        };
        let mut sonar = Sonar::default();
        let mut told = Vec::new();
        for (t, number) in [(1.0, 7), (1.05, 8), (1.3, 7), (1.4, 9), (2.1, 10)] {
            sonar.ping(t, ping(number, "port").as_bytes(), &mut |t, item, keep| {
                told.push((t, item, keep))
            });
        }
        let times: Vec<(f64, bool)> = told.iter().map(|(t, _, keep)| (*t, *keep)).collect();
        assert_eq!(times, [(1.0, true), (1.4, false), (2.1, true)]);
        let Item::Ping {
            port: Some(port),
            starboard: None,
            range_m: 60.0,
            ..
        } = &told[0].1
        else {
            panic!("{:?}", told[0]);
        };
        // 20 dB and 60 dB.
        assert_eq!(port.len(), 2 * PING_BINS);
        assert!(port.starts_with("2800") && port.ends_with("0078"), "{port}");

        let mut swaths = Vec::new();
        let event = br#"{"input":"sonar","report":"event","report_event":"swath","report_event_swath":{"sensor":0,"number":1,"port_m":52.5,"starboard_m":40.0,"altitude_m":28.9,"source":"bottom-lock"}}"#;
        sonar.event(3.0, event, &mut |_, item, _| swaths.push(item));
        assert_eq!(swaths, [], "nobody knows where");
        sonar.navigated(3.0, [42.0, -70.0, 90.0]);
        sonar.event(4.0, event, &mut |_, item, _| swaths.push(item));
        sonar.event(6.0, event, &mut |_, item, _| swaths.push(item));
        let expected = Item::Swath {
            lat: 42.0,
            lon: -70.0,
            heading_deg: 90.0,
            port_m: 52.5,
            starboard_m: 40.0,
        };
        assert_eq!(swaths, [expected]);
    }

    #[test]
    fn a_ping_without_samples_is_dark() {
        assert_eq!(bins(&[]), "00".repeat(PING_BINS));
        assert_eq!(bins(&[9.0]), "28".repeat(PING_BINS));
    }
}
