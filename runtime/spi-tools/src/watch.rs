//! The known state of a live vehicle. No I/O and no clock: the caller passes the time.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_spi::{
    AckStatus, Battery, BehaviorBegin, FromVehicle, MissionStatus, Navigation, RelativeNavigation, VelocityAndRates,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::reading::{Message, Reading};
use crate::tally::Tally;

/// Navigation comes at 10 Hz, so a vehicle that sends nothing for this long counts as silent.
pub(crate) const SILENT_AFTER: Duration = Duration::from_secs(5);
/// The number of events that are kept.
const EVENTS: usize = 8;

#[derive(Debug, Default)]
pub(crate) struct Watch {
    pub(crate) up_since: Option<Timestamp>,
    pub(crate) connections: u64,
    pub(crate) tally: Tally,
    pub(crate) events: VecDeque<(Timestamp, String)>,
    pub(crate) version: Option<String>,
    pub(crate) vehicle_time: Option<TimeOfDay>,
    pub(crate) navigation: Option<Navigation>,
    pub(crate) velocity: Option<VelocityAndRates>,
    pub(crate) relative: Option<RelativeNavigation>,
    pub(crate) mission: Option<MissionStatus>,
    pub(crate) control: Option<bool>,
    pub(crate) behavior: Option<BehaviorBegin>,
    pub(crate) battery: Option<Battery>,
    pub(crate) last_fault: Option<String>,
    /// When the solution time of navigation last advanced, and how old the solution was then.
    solution: Option<(Timestamp, Duration)>,
    heard: Option<Timestamp>,
    silence_told: bool,
}

impl Watch {
    pub(crate) fn connected(&mut self, now: Timestamp) {
        self.up_since = Some(now);
        self.heard = None;
        self.silence_told = false;
        self.connections += 1;
    }

    /// Forgets the values that the vehicle sends only when they change.
    pub(crate) fn disconnected(&mut self) {
        self.up_since = None;
        self.control = None;
        self.mission = None;
        self.behavior = None;
    }

    /// Adds an event, and drops the oldest if there are too many.
    pub(crate) fn note(&mut self, now: Timestamp, text: String) {
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back((now, text));
    }

    /// Takes in a sentence. Returns how long the vehicle had been silent, if that had been reported.
    pub(crate) fn take(&mut self, now: Timestamp, reading: &Reading<'_>) -> Option<Duration> {
        self.tally.count(reading);
        let message = match &reading.outcome {
            Ok(Message::FromVehicle(message)) => message,
            // A vehicle that sends what only payloads should send; it is only counted.
            Ok(Message::ToVehicle(_)) => return None,
            Err(error) => {
                let name: String = reading.name.chars().take(12).collect();
                self.last_fault = Some(format!("{name}: {error}"));
                return None;
            }
        };
        if let Some(text) = event(message) {
            self.note(now, text);
        }
        self.learn(now, message);
        // An acknowledgement answers our own sentence; it does not show that the vehicle sends anything else.
        if matches!(message, FromVehicle::Acknowledgement(_)) {
            return None;
        }
        let since = self.heard.replace(now).or(self.up_since).unwrap_or(now);
        std::mem::take(&mut self.silence_told).then(|| now.since(since))
    }

    /// How long the vehicle has been silent; returned once for each silence.
    pub(crate) fn silence(&mut self, now: Timestamp) -> Option<Duration> {
        let silent = self.silent_for(now).filter(|_| !self.silence_told)?;
        self.silence_told = true;
        Some(silent)
    }

    /// How long nothing has been received on a connection, if that is long.
    pub(crate) fn silent_for(&self, now: Timestamp) -> Option<Duration> {
        let since = self.heard.max(self.up_since).filter(|_| self.up_since.is_some())?;
        Some(now.since(since)).filter(|silent| *silent >= SILENT_AFTER)
    }

    /// The age of the newest navigation solution: the time since its solution time last advanced, plus its age at
    /// reception by the vehicle's own times. A solution that is repeated therefore grows old too.
    pub(crate) fn navigation_age(&self, now: Timestamp) -> Option<Duration> {
        self.solution.map(|(at, lag)| now.since(at) + lag)
    }

    fn learn(&mut self, now: Timestamp, message: &FromVehicle) {
        if let Some(created) = message.created() {
            self.vehicle_time = Some(created);
        }
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "all messages are counted; only these change the view"
        )]
        match message {
            FromVehicle::VehicleVersion(version) => self.version = Some(version.version.to_string()),
            FromVehicle::Navigation(navigation) => {
                let advanced = self
                    .navigation
                    .as_ref()
                    .is_none_or(|last| last.solution != navigation.solution);
                if advanced {
                    let lag = navigation.created.nanos_since(navigation.solution);
                    self.solution = Some((now, Duration::from_nanos(u64::try_from(lag).unwrap_or(0))));
                }
                self.navigation = Some(navigation.clone());
            }
            FromVehicle::VelocityAndRates(velocity) => self.velocity = Some(velocity.clone()),
            FromVehicle::RelativeNavigation(relative) => self.relative = Some(relative.clone()),
            FromVehicle::MissionStatus(mission) => self.mission = Some(mission.clone()),
            FromVehicle::BackseatControl(control) => self.control = Some(control.granted),
            FromVehicle::BehaviorBegin(behavior) => self.behavior = Some(behavior.clone()),
            FromVehicle::BehaviorEnd(_) => self.behavior = None,
            // 0 is all batteries together. For a vehicle that never sends 0, the newest message of any battery counts.
            FromVehicle::Battery(battery)
                if battery.number == 0 || self.battery.as_ref().is_none_or(|known| known.number != 0) =>
            {
                self.battery = Some(battery.clone());
            }
            _ => {}
        }
    }
}

/// The text for a message that counts as an event.
fn event(message: &FromVehicle) -> Option<String> {
    let quoted = |what: &str, text: &str| {
        if text.is_empty() {
            what.to_owned()
        } else {
            format!("{what} {text:?}")
        }
    };
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "messages that come all the time are not events"
    )]
    Some(match message {
        FromVehicle::VehicleVersion(version) => format!("the vehicle speaks SPI {}", version.version),
        FromVehicle::MissionCommand(command) => quoted("mission command", command.text.as_str()),
        FromVehicle::Shutdown(_) => "the payload is to shut down".to_owned(),
        FromVehicle::LoggingBegin(begin) => quoted("begin logging", begin.text.as_str()),
        FromVehicle::LoggingEnd(end) => quoted("stop logging", end.text.as_str()),
        FromVehicle::TopsideMessage(message) => quoted("from topside", message.text.as_str()),
        FromVehicle::DvlTriggering(triggering) if triggering.begin => "begin external DVL triggering".to_owned(),
        FromVehicle::DvlTriggering(_) => "end external DVL triggering".to_owned(),
        FromVehicle::MissionStatus(status) => {
            quoted(&quoted("mission", status.status.as_str()), status.details.as_str())
        }
        FromVehicle::BackseatControl(control) if control.granted => "control handed to the backseat".to_owned(),
        FromVehicle::BackseatControl(_) => "control taken back by the vehicle".to_owned(),
        FromVehicle::BehaviorBegin(begin) => format!("begins: {}", behavior(begin.kind.as_str(), begin.number, begin)),
        FromVehicle::BehaviorEnd(end) => {
            let identifier = end
                .identifier
                .map_or(String::new(), |identifier| format!(", requested as {identifier}"));
            let number = end.number.map_or(String::new(), |number| format!(" {number}"));
            format!("ends: {}{number}{identifier}", end.kind)
        }
        // Our own subscriptions, mostly.
        FromVehicle::Acknowledgement(ack) if ack.status == AckStatus::Succeeded && ack.command.as_str() == "LOG" => {
            return None;
        }
        FromVehicle::Acknowledgement(ack) => {
            let status = match ack.status {
                AckStatus::Invalid => "invalid".to_owned(),
                AckStatus::Failed => "failed".to_owned(),
                AckStatus::Succeeded => "done".to_owned(),
                AckStatus::Pending => "pending".to_owned(),
                AckStatus::Other(code) => format!("status {code}"),
            };
            quoted(&format!("answer to {}: {status}", ack.command), ack.text.as_str())
        }
        FromVehicle::MediumAccess(access) => format!("acoustic window until {}", access.until),
        FromVehicle::PacketReceived(packet) => format!("acoustic packet from {}", packet.source),
        _ => return None,
    })
}

/// `trackline 3`, `trackline, requested as 1001`.
pub(crate) fn behavior(kind: &str, number: Option<u32>, begin: &BehaviorBegin) -> String {
    let number = number.map_or(String::new(), |number| format!(" {number}"));
    let identifier = begin
        .identifier
        .map_or(String::new(), |identifier| format!(", requested as {identifier}"));
    format!("{kind}{number}{identifier}")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::splitter::{End, Piece};

    pub(crate) fn at(seconds: f64) -> Timestamp {
        Timestamp::ZERO + Duration::from_secs_f64(seconds)
    }

    pub(crate) fn take(watch: &mut Watch, seconds: f64, line: &str) -> Option<Duration> {
        let piece = Piece {
            bytes: line.as_bytes(),
            end: End::Line,
            line: 1,
        };
        watch.take(at(seconds), &Reading::of(piece, false).unwrap())
    }

    fn navigation(watch: &mut Watch, seconds: f64, created: &str, solution: &str) {
        let line = format!("$BFNVG,{created},4221.81,N,07106.84,W,1,45.3,20.1,203.1,-3.4,4.5,{solution}");
        let _ended = take(watch, seconds, &line);
    }

    #[test]
    fn a_silent_vehicle_is_told_once_and_its_return_too() {
        let mut watch = Watch::default();
        assert_eq!(watch.silence(at(100.0)), None, "not connected");
        watch.connected(at(100.0));
        assert_eq!(watch.silence(at(104.9)), None);
        assert_eq!(watch.silence(at(105.0)), Some(Duration::from_secs(5)));
        assert_eq!(watch.silence(at(106.0)), None, "once");
        assert_eq!(
            take(&mut watch, 107.0, "$BFACK,081025.987,LOG,000000.000,0,2,0,ok"),
            None
        );
        assert_eq!(
            watch.silent_for(at(107.0)),
            Some(Duration::from_secs(7)),
            "an answer is no sign of life"
        );
        assert_eq!(
            take(&mut watch, 108.0, "$BFCTL,081025.987,1"),
            Some(Duration::from_secs(8))
        );
        assert_eq!(watch.silence(at(112.9)), None);
        assert_eq!(watch.silence(at(113.0)), Some(Duration::from_secs(5)));
    }

    #[test]
    fn navigation_ages_by_its_solution_and_not_by_its_arrival() {
        let mut watch = Watch::default();
        assert_eq!(watch.navigation_age(at(1.0)), None);
        navigation(&mut watch, 1.0, "235959.900", "235959.800");
        assert_eq!(watch.navigation_age(at(1.0)), Some(Duration::from_millis(100)));
        navigation(&mut watch, 2.0, "000000.900", "235959.800");
        assert_eq!(
            watch.navigation_age(at(2.0)),
            Some(Duration::from_millis(1100)),
            "the same solution"
        );
        navigation(&mut watch, 3.0, "000001.000", "235959.900");
        assert_eq!(
            watch.navigation_age(at(3.0)),
            Some(Duration::from_millis(1100)),
            "across midnight"
        );
    }

    #[test]
    fn what_comes_only_on_change_is_unknown_after_a_loss() {
        let mut watch = Watch::default();
        watch.connected(at(0.0));
        for line in [
            "$BFCTL,081025.987,1",
            "$BFMIS,081025.987,a.dive,Running,",
            "$BFMBS,081025.987,,,1001,trackline",
            "$BFRBS,081025.987,0,29.85,,,,,87.5",
            "$BFRBS,081025.987,2,3.85,,,,,",
        ] {
            take(&mut watch, 1.0, line);
        }
        assert_eq!(
            (watch.control, watch.battery.as_ref().map(|battery| battery.number)),
            (Some(true), Some(0))
        );
        let told: Vec<_> = watch.events.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(
            told,
            [
                "control handed to the backseat",
                "mission \"Running\"",
                "begins: trackline, requested as 1001"
            ]
        );
        watch.disconnected();
        assert!(watch.control.is_none() && watch.mission.is_none() && watch.behavior.is_none());
        assert!(watch.battery.is_some());
    }

    #[test]
    fn events_and_faults_are_bounded() {
        let mut watch = Watch::default();
        for number in 0..100 {
            take(&mut watch, 1.0, &format!("$BFMSC,081025.987,line {number}"));
            take(&mut watch, 1.0, &format!("$BF{},1", "X".repeat(number + 1)));
        }
        assert_eq!(watch.events.len(), EVENTS);
        assert_eq!(watch.events.back().unwrap().1, "mission command \"line 99\"");
        assert_eq!(watch.last_fault.as_deref(), Some("BFXXXXXXXXXX: unknown message"));
    }
}
