//! The heartbeat on a modelled link, with a modelled vehicle: whenever core says that the vehicle hears us, it does.

use std::collections::BTreeMap;
use std::ops::Range;

use backseat_spi::{AckStatus, EchoedTime, Text};
use proptest::prelude::*;

use super::*;

const DELAY_MAX: Duration = Duration::from_secs(1);

/// One way of the link.
#[derive(Clone, Copy, Debug)]
struct Way {
    delay_ms: u64,
    /// The delay grows by so much each second.
    grows_ms: u64,
    /// From this time on the delay is 20 ms.
    good_from_ms: u64,
    lost: f64,
    doubled: f64,
    /// How long after the first copy of a sentence the second one comes, at most.
    spread_ms: u64,
}

impl Way {
    fn delay(&self, at: u64) -> u64 {
        if at >= self.good_from_ms {
            20
        } else {
            self.delay_ms + self.grows_ms * at / 1000
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Vehicle {
    answers_status: bool,
    answers_logging: bool,
    /// The vehicle never answers the last BPLOG of a subscription to everything.
    leaves_one_out: bool,
    decimals: u8,
    rounds: bool,
}

#[derive(Clone, Debug)]
struct Case {
    /// The vehicle refuses everything that it hears meanwhile, and says so.
    refuses_ms: Range<u64>,
    up: Way,
    down: Way,
    vehicle: Vehicle,
    /// When the connection is made anew, if at all.
    reset_at_ms: u64,
    /// For so long before that, nothing comes through either way.
    outage_ms: u64,
    /// The answers on the old connection come on the new one.
    relayed: bool,
    seed: u64,
}

struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn is(&mut self, probability: f64) -> bool {
        (self.next() % 1_000_000) as f64 <= probability * 1e6 - 1.0
    }

    fn up_to(&mut self, most: u64) -> u64 {
        self.next() % (most + 1)
    }
}

#[derive(Clone, Copy, Debug)]
struct Command {
    at: u64,
    letters: &'static str,
    answered: bool,
}

/// What flies: commands to the vehicle, and its answers.
struct Model {
    case: Case,
    random: Random,
    heartbeat: Heartbeat,
    commands: Vec<Command>,
    connection_began: u64,
    /// Arrivals at the vehicle: the index of a command.
    up: BTreeMap<(u64, usize), usize>,
    /// Arrivals of answers: the index of the command, when the vehicle wrote the answer, and what it says.
    down: BTreeMap<(u64, usize), (usize, u64, AckStatus)>,
    count: usize,
    /// When the last sentence arrived on each way: the first copies arrive in order.
    arrived: [u64; 2],
    /// When the commands left whose answers have come in time.
    good: Vec<u64>,
    heard_ms: u64,
    unsafe_at: Option<u64>,
}

fn stamp(millis: u64) -> TimeOfDay {
    TimeOfDay::from_nanos((10_000_000 + millis) * 1_000_000).unwrap()
}

impl Model {
    fn new(case: &Case) -> Self {
        Self {
            case: case.clone(),
            random: Random(case.seed),
            heartbeat: Heartbeat::new(DELAY_MAX),
            commands: Vec::new(),
            connection_began: 0,
            up: BTreeMap::new(),
            down: BTreeMap::new(),
            count: 0,
            arrived: [0; 2],
            good: Vec::new(),
            heard_ms: 0,
            unsafe_at: None,
        }
    }

    /// When the copies of a sentence arrive that leaves now.
    fn arrivals(&mut self, now: u64, is_down: bool) -> Vec<u64> {
        let way = if is_down { self.case.down } else { self.case.up };
        let last = &mut self.arrived[usize::from(is_down)];
        let arrives = (now + way.delay(now)).max(*last);
        *last = arrives;
        let mut arrivals = Vec::new();
        let outage = self.case.reset_at_ms.saturating_sub(self.case.outage_ms)..self.case.reset_at_ms;
        if outage.contains(&now) {
            return arrivals;
        }
        if !self.random.is(way.lost) {
            arrivals.push(arrives);
        }
        if self.random.is(way.doubled) {
            arrivals.push(arrives + self.random.up_to(way.spread_ms));
        }
        arrivals
    }

    fn send(&mut self, now: u64, letters: &'static str, answered: bool) {
        let created = (letters != "LOG").then(|| stamp(now));
        self.heartbeat
            .left(Timestamp::from_millis(now), name(letters), created, false);
        let index = self.commands.len();
        self.commands.push(Command {
            at: now,
            letters,
            answered,
        });
        for arrives in self.arrivals(now, false) {
            self.count += 1;
            self.up.insert((arrives, self.count), index);
        }
    }

    fn begin(&mut self, now: u64) {
        self.heartbeat.begin(Timestamp::from_millis(now));
        if !self.case.relayed {
            self.up.clear();
            self.down.clear();
            self.arrived = [now; 2];
        }
        self.connection_began = now;
        let answered = self.case.vehicle.answers_logging;
        for topic in 0..6 {
            self.send(now, "LOG", answered && (topic < 5 || !self.case.vehicle.leaves_one_out));
        }
        self.send(now, "VER", true);
    }

    fn echo(&self, created: u64) -> EchoedTime {
        let vehicle = self.case.vehicle;
        let unit = 10u64.pow(3 - u32::from(vehicle.decimals));
        let shown = if vehicle.rounds { created + unit / 2 } else { created };
        EchoedTime::with_decimals(stamp(shown), vehicle.decimals)
    }

    fn vehicle_hears(&mut self, now: u64) {
        let refuses = self.case.refuses_ms.contains(&now);
        let status = if refuses {
            AckStatus::Invalid
        } else {
            AckStatus::Succeeded
        };
        while let Some(entry) = self.up.first_entry().filter(|entry| entry.key().0 <= now) {
            let index = entry.remove();
            if self.commands[index].answered || refuses {
                for arrives in self.arrivals(now, true) {
                    self.count += 1;
                    self.down.insert((arrives, self.count), (index, now, status));
                }
            }
        }
    }

    fn answers_come(&mut self, now: u64) {
        while let Some(entry) = self.down.first_entry().filter(|entry| entry.key().0 <= now) {
            let (index, written, status) = entry.remove();
            let command = self.commands[index];
            if now - command.at <= 1000 && command.at >= self.connection_began {
                self.good.push(command.at);
            }
            let echo = if command.letters == "LOG" {
                EchoedTime::NONE
            } else {
                self.echo(command.at)
            };
            let ack = Acknowledgement {
                created: stamp(written),
                command: name(command.letters),
                command_created: echo,
                behavior: None,
                status,
                text: Text::cleaned(""),
            };
            self.heartbeat.acknowledged(Timestamp::from_millis(now), &ack);
        }
    }

    fn run(mut self, until: u64) -> Self {
        self.begin(0);
        let mut beat_at = Timestamp::from_millis(500);
        for now in (10..until).step_by(10) {
            let at = Timestamp::from_millis(now);
            self.vehicle_hears(now);
            self.answers_come(now);
            match self.heartbeat.remedy(at) {
                Some(Remedy::Subscribe) => self.send(now, "LOG", self.case.vehicle.answers_logging),
                Some(Remedy::Reset) => self.begin(now),
                None => {}
            }
            if now == self.case.reset_at_ms {
                self.begin(now);
            }
            if at >= beat_at {
                beat_at = self.heartbeat.next_beat(at, stamp(now));
                if self.heartbeat.needs_log(at) {
                    self.send(now, "LOG", self.case.vehicle.answers_logging);
                }
                self.send(now, "STS", self.case.vehicle.answers_status);
            }
            if self.heartbeat.is_heard(at) {
                self.heard_ms += 10;
                // The model's own steps take 10 ms.
                if self.unsafe_at.is_none() && !self.good.iter().any(|sent| now - sent <= 3020) {
                    self.unsafe_at = Some(now);
                }
            }
        }
        self
    }
}

fn way(delays: impl Strategy<Value = u64>, lost: f64, doubled: f64, spread_ms: u64) -> impl Strategy<Value = Way> {
    let often = move |most: f64| prop_oneof![Just(0.0), Just(most), 0.0..=most];
    let good = prop_oneof![Just(u64::MAX), 0..200_000u64];
    (delays, 0..=100u64, good, often(lost), often(doubled)).prop_map(
        move |(delay_ms, grows_ms, good_from_ms, lost, doubled)| Way {
            delay_ms,
            grows_ms: if grows_ms > 50 { 0 } else { grows_ms },
            good_from_ms,
            lost,
            doubled,
            spread_ms,
        },
    )
}

fn vehicle() -> impl Strategy<Value = Vehicle> {
    (any::<bool>(), any::<bool>(), any::<bool>(), 0..=3u8, any::<bool>()).prop_map(
        |(answers_status, answers_logging, leaves_one_out, decimals, rounds)| Vehicle {
            answers_status,
            answers_logging,
            leaves_one_out,
            decimals,
            rounds,
        },
    )
}

fn refusals() -> impl Strategy<Value = Range<u64>> {
    let lasts = prop_oneof![Just(0), 0..3000u64, 0..60_000u64];
    (0..200_000u64, lasts).prop_map(|(from, lasts)| from..from + lasts)
}

fn cases(delay_max_ms: u64, lost: f64, doubled: f64, spread_ms: u64) -> impl Strategy<Value = Case> {
    let delays = move || prop_oneof![0..=700u64, 0..=delay_max_ms];
    (
        way(delays(), lost, doubled, spread_ms),
        way(delays(), lost, doubled, spread_ms),
        vehicle(),
        refusals(),
        (0..240_000u64, prop_oneof![Just(0), 0..60_000u64]),
        any::<bool>(),
        any::<u64>(),
    )
        .prop_map(
            |(up, down, vehicle, refuses_ms, (reset_at_ms, outage_ms), relayed, seed)| Case {
                refuses_ms,
                up,
                down,
                vehicle,
                reset_at_ms: reset_at_ms / 10 * 10,
                outage_ms,
                relayed,
                seed,
            },
        )
}

fn assert_safe(case: &Case) -> Result<(), TestCaseError> {
    let flown = Model::new(case).run(240_000);
    prop_assert_eq!(flown.unsafe_at, None);
    Ok(())
}

/// Links on which the vehicle was once taken to hear us.
#[test]
fn sr_023_links_on_which_the_vehicle_was_once_taken_to_hear_us() {
    let way = |delay_ms, grows_ms, good_from_ms| Way {
        delay_ms,
        grows_ms,
        good_from_ms,
        lost: 0.0,
        doubled: 0.0,
        spread_ms: 0,
    };
    let case = |up, down, reset_at_ms, answers_logging, rounds| Case {
        refuses_ms: 0..0,
        up,
        down,
        vehicle: Vehicle {
            answers_status: true,
            answers_logging,
            leaves_one_out: false,
            decimals: 0,
            rounds,
        },
        reset_at_ms,
        outage_ms: 0,
        relayed: true,
        seed: 0,
    };
    let never = u64::MAX;
    let cases = [
        // A BPLOG left in the moment of the reset, and the answer to one of before came on the new connection.
        case(way(8141, 32, never), way(0, 0, 0), 132_000, true, false),
        // The answer to a BPSTS of before the reset was taken for the answer to the next one, and so on to the last.
        case(way(371, 0, never), way(7121, 0, 381), 2500, false, true),
    ];
    for case in cases {
        assert_eq!(Model::new(&case).run(240_000).unsafe_at, None, "{case:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, max_shrink_iters: 2000, ..ProptestConfig::default() })]

    #[test]
    fn sr_023_on_a_late_link_the_vehicle_is_never_taken_to_hear_us(case in cases(12_000, 0.0, 0.0, 0)) {
        assert_safe(&case)?;
    }

    #[test]
    fn sr_023_on_a_link_that_doubles_the_vehicle_is_never_taken_to_hear_us(case in cases(12_000, 0.0, 1.0, 400)) {
        assert_safe(&case)?;
    }

    #[test]
    fn sr_023_on_a_link_that_loses_the_vehicle_is_never_taken_to_hear_us(case in cases(12_000, 0.1, 0.0, 0)) {
        assert_safe(&case)?;
    }

    #[test]
    fn sr_023_on_a_good_link_a_vehicle_that_answers_something_is_heard_all_the_time(
        (up, down) in (0..=450u64, 0..=450u64),
        vehicle in vehicle(),
        refuses_ms in refusals(),
        (reset_at_s, outage_s) in (70..150u64, prop_oneof![Just(0), 0..60u64]),
        seed in any::<u64>(),
    ) {
        let way = |delay_ms| Way {
            delay_ms,
            grows_ms: 0,
            good_from_ms: u64::MAX,
            lost: 0.0,
            doubled: 0.0,
            spread_ms: 0,
        };
        let case = Case {
            refuses_ms,
            up: way(up),
            down: way(down),
            vehicle: Vehicle { answers_logging: true, ..vehicle },
            reset_at_ms: reset_at_s * 1000,
            outage_ms: outage_s * 1000,
            relayed: false,
            seed,
        };
        let flown = Model::new(&case).run(240_000);
        // If BPLOG is the beat, answers may come as late as the outage was long.
        let waits_s = if vehicle.answers_status { 6 } else { 40 + 2 * outage_s };
        let heard_s = flown.heard_ms / 1000;
        prop_assert!(heard_s + outage_s + waits_s >= 240, "{heard_s} of {} s", 240 - outage_s);
    }
}
