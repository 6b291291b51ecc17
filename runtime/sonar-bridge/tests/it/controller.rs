//! The bridge with the mock payload controller: what core wants reaches the sensors, and what they say reaches core.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_core::plugin::{PluginId, SonarEvent, SonarPing, SonarSetting, SonarSide};
use backseat_core::{FromSonar, SonarOrder, SonarOutcome, StatusCondition, ToSonar};
use backseat_plc::{ClientId, Ping, Plc, PlcConfig, Pose, SensorKind, Sonar as Acoustics, Stored};
use backseat_sonar::{Decimation, Input, PingGrant, SonarConfig};
use backseat_sonar_bridge::{Act, Bridge, PINGS_PER_S_MAX, PluginPing};
use backseat_units::{LocalFrame, Position, Timestamp, Utc};

const UTC: u64 = 1_780_000_000_000_000_000;

/// A flat picture whose brightness is the gain.
struct Flat;

impl Acoustics for Flat {
    fn side_scan(&mut self, _: SensorKind, ping: &Ping, port: &mut Vec<u16>, starboard: &mut Vec<u16>) {
        port.resize(ping.samples, u16::try_from(ping.gain_steps).unwrap());
        starboard.resize(ping.samples, 7);
    }

    fn sub_bottom(&mut self, ping: &Ping, out: &mut Vec<[i16; 2]>) {
        out.resize(ping.samples, [3, 4]);
    }
}

struct Rig {
    bridge: Bridge,
    plc: Plc,
    now: Timestamp,
    client: u32,
    connected: bool,
    reports: VecDeque<FromSonar>,
}

impl Rig {
    fn new(sonar: &str, plc: &str) -> Self {
        let config: SonarConfig = toml::from_str(sonar).unwrap();
        let plc: PlcConfig = toml::from_str(plc).unwrap();
        let ping = |plugin, sensor| PluginPing {
            plugin: PluginId(plugin),
            grant: PingGrant {
                sensor,
                samples: 16,
                decimation: Decimation::Maximum,
            },
        };
        let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).unwrap());
        let utc = Utc::from_unix_nanos(UTC);
        Self {
            bridge: Bridge::new(config, vec![ping(0, 0), ping(4, 1)], frame, utc).unwrap(),
            plc: Plc::new(&plc, 1, utc, &Stored::default()).unwrap(),
            now: Timestamp::ZERO,
            client: 0,
            connected: false,
            reports: VecDeque::new(),
        }
    }

    fn run_for(&mut self, seconds: f64) {
        let until = self.now + Duration::from_secs_f64(seconds);
        loop {
            self.drain();
            let due = [self.bridge.poll_timeout(), self.plc.poll_timeout()];
            let Some(at) = due.into_iter().flatten().min().filter(|at| *at <= until) else {
                break;
            };
            self.now = self.now.max(at);
            self.plc.truth(self.now, Pose::default());
            self.plc.handle_timeout(self.now, &mut Flat);
            self.bridge.handle(self.now, Input::Timeout);
        }
        self.now = until;
    }

    fn drain(&mut self) {
        let mut buffer = Vec::new();
        loop {
            let mut idle = true;
            while let Some(act) = self.bridge.poll() {
                idle = false;
                match act {
                    Act::Connect => {
                        self.client += 1;
                        self.connected = true;
                        self.plc.connect(self.now, ClientId(self.client));
                        self.bridge.handle(self.now, Input::Connected);
                    }
                    Act::Disconnect => self.cut(),
                    Act::Send(bytes) => self.plc.receive(self.now, ClientId(self.client), &bytes),
                    Act::Report(report) => self.reports.push_back(report),
                    Act::Finished => {}
                }
            }
            while let Some(client) = self.plc.poll_transmit(&mut buffer) {
                idle = false;
                if client == ClientId(self.client) {
                    self.bridge.handle(self.now, Input::Received(&buffer));
                }
            }
            while self.plc.poll_file().is_some() || self.plc.poll_event().is_some() {}
            while self.plc.poll_disconnect().is_some() {
                self.cut();
            }
            if idle {
                return;
            }
        }
    }

    fn cut(&mut self) {
        if std::mem::take(&mut self.connected) {
            self.plc.disconnect(self.now, ClientId(self.client));
            self.bridge.handle(self.now, Input::Lost);
        }
    }

    fn order(&mut self, request: u64, order: SonarOrder) -> Vec<SonarOutcome> {
        self.reports.clear();
        self.bridge.tell(self.now, ToSonar::Order { request, order });
        self.run_for(40.0);
        let of = |report: &FromSonar| match report {
            FromSonar::Outcome { request: of, outcome } if *of == request => Some(outcome.clone()),
            _ => None,
        };
        self.reports.iter().filter_map(of).collect()
    }

    fn set(&mut self, request: u64, sensor: i32, setting: SonarSetting) -> Vec<SonarOutcome> {
        self.order(request, SonarOrder::Set { sensor, setting })
    }

    fn pings(&self) -> Vec<(PluginId, SonarPing)> {
        let of = |report: &FromSonar| match report {
            FromSonar::Ping(plugin, ping) => Some((*plugin, ping.clone())),
            _ => None,
        };
        self.reports.iter().filter_map(of).collect()
    }

    fn events(&self) -> Vec<SonarEvent> {
        let of = |report: &FromSonar| match report {
            FromSonar::Event(event) => Some(event.clone()),
            _ => None,
        };
        self.reports.iter().filter_map(of).collect()
    }
}

const SONAR: &str = "
    [[sensor]]
    index = 0
    device = 11001
    records = [3000]
    [[sensor]]
    index = 1
    device = 11000
    records = [3001]
";

const PLC: &str = r#"
    [[sensor]]
    kind = "sidescan_low"
    name = "SSL"
    port = 1
    [[sensor]]
    kind = "sub_bottom"
    name = "SBP"
    port = 2
"#;

#[test]
fn core_learns_that_the_client_is_ready_and_how_the_sonars_are() {
    let mut rig = Rig::new(SONAR, PLC);
    rig.run_for(30.0);
    assert!(rig.events().contains(&SonarEvent::Ready(true)));
    let last = rig.reports.iter().rev().find_map(|report| match report {
        FromSonar::Status { text, conditions } => Some((text.clone(), conditions.clone())),
        _ => None,
    });
    let (text, conditions) = last.unwrap();
    assert!(text.starts_with("sonar ready"), "{text}");
    assert!(!conditions.contains(&StatusCondition::SonarNotReady), "{conditions:?}");
    rig.reports.clear();
    rig.cut();
    rig.run_for(0.5);
    assert_eq!(rig.events().first(), Some(&SonarEvent::Ready(false)));
    assert!(rig.reports.iter().any(|report| matches!(
        report,
        FromSonar::Status { conditions, .. } if conditions.contains(&StatusCondition::SonarNotReady)
    )));
}

#[test]
fn each_setting_reaches_its_sensor_and_pings_come_back_to_their_plugin() {
    let mut rig = Rig::new(SONAR, PLC);
    rig.run_for(30.0);
    for (request, setting) in (1..).zip([
        SonarSetting::RangeM(50.0),
        SonarSetting::PowerPercent(80.0),
        SonarSetting::Gain(9),
        SonarSetting::PeriodMs(500.0),
        SonarSetting::Ping(true),
    ]) {
        assert_eq!(rig.set(request, 0, setting), [SonarOutcome::Accepted]);
    }
    rig.reports.clear();
    rig.run_for(10.0);
    let pings = rig.pings();
    assert_eq!(pings.len(), 20, "one each half second");
    for (plugin, ping) in &pings {
        assert_eq!((plugin.0, ping.sensor, ping.sub_bottom), (0, 0, false));
        let [port, starboard] = &ping.channels[..] else {
            panic!("{ping:?}");
        };
        assert_eq!((port.side, starboard.side), (SonarSide::Port, SonarSide::Starboard));
        assert_eq!((&port.samples, &starboard.samples), (&vec![9.0; 16], &vec![7.0; 16]));
        assert!((port.range_m - 50.0).abs() < 1.0, "{}", port.range_m);
    }
    assert!(pings.windows(2).all(|pair| {
        let apart = pair[1].1.time.since(pair[0].1.time);
        apart > Duration::from_millis(450) && apart < Duration::from_millis(550)
    }));
    rig.set(9, 1, SonarSetting::Ping(true));
    assert!(
        rig.pings()
            .iter()
            .any(|(plugin, ping)| plugin.0 == 4 && ping.sub_bottom)
    );
}

#[test]
fn what_the_controller_refuses_fails_with_a_reason() {
    let mut rig = Rig::new(SONAR, PLC);
    rig.run_for(30.0);
    let failed = |outcomes: Vec<SonarOutcome>| match &outcomes[..] {
        [SonarOutcome::Failed(text)] => text.clone(),
        other => panic!("{other:?}"),
    };
    assert_eq!(
        failed(rig.set(1, 0, SonarSetting::RangeM(99_999.0))),
        "rejected by the controller"
    );
    assert_eq!(
        failed(rig.set(2, 0, SonarSetting::Pulse("no such pulse".to_owned()))),
        "rejected by the controller"
    );
    let log = |on, file: Option<&str>| SonarOrder::Log {
        on,
        file: file.map(str::to_owned),
    };
    assert!(failed(rig.order(3, log(false, Some("x")))).contains("a file name needs logging on"));
    assert!(failed(rig.order(4, log(true, Some("../x")))).contains("no path separators"));
    assert_eq!(rig.order(5, log(true, Some("survey"))), [SonarOutcome::Accepted]);
    assert!(
        rig.events()
            .iter()
            .any(|event| matches!(event, SonarEvent::Logging(logging) if logging.on && !logging.missing))
    );
}

#[test]
fn a_request_that_waits_without_a_connection_times_out() {
    let mut rig = Rig::new(SONAR, &format!("shutdown_s = 0.5\n{PLC}"));
    rig.run_for(30.0);
    rig.bridge.tell(rig.now, ToSonar::Shutdown);
    rig.run_for(15.0);
    let mut gone = Rig::new(SONAR, PLC);
    // The client has not been told yet that there is a connection.
    while let Some(act) = gone.bridge.poll() {
        if act == Act::Connect {
            break;
        }
    }
    let order = SonarOrder::Log { on: true, file: None };
    gone.bridge.tell(gone.now, ToSonar::Order { request: 8, order });
    while let Some(at) = gone.bridge.poll_timeout().filter(|at| *at < Timestamp::from_secs(30)) {
        gone.now = at;
        gone.bridge.handle(at, Input::Timeout);
    }
    while let Some(act) = gone.bridge.poll() {
        if let Act::Report(report) = act {
            gone.reports.push_back(report);
        }
    }
    assert!(gone.reports.contains(&FromSonar::Outcome {
        request: 8,
        outcome: SonarOutcome::TimedOut
    }));
    // After a shutdown nothing is sent any more, and a request says so.
    assert!(matches!(
        &rig.order(9, SonarOrder::Log { on: true, file: None })[..],
        [SonarOutcome::Failed(text)] if text.contains("the client has ended")
    ));
}

#[test]
fn a_flood_of_pings_is_cut_to_so_many_a_second() {
    let mut rig = Rig::new(SONAR, &format!("{PLC}\n[sidescan_low]\nrange_min_m = 1.0"));
    rig.run_for(30.0);
    for (request, setting) in (1..).zip([
        SonarSetting::RangeM(5.0),
        SonarSetting::PeriodMs(10.0),
        SonarSetting::Ping(true),
    ]) {
        assert_eq!(rig.set(request, 0, setting), [SonarOutcome::Accepted]);
    }
    rig.reports.clear();
    rig.run_for(10.0);
    let pings = rig.pings().len();
    let most = 10 * PINGS_PER_S_MAX as usize;
    assert!(pings <= most + PINGS_PER_S_MAX as usize && pings >= most / 2, "{pings}");
}
