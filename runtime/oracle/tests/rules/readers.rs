//! Compares the oracle's reader with that of `backseat-spi`, which shares nothing with it: on every example of the
//! catalogue, on drawn sentences, and where the two differ on purpose.

use backseat_oracle::Position;
use backseat_oracle::wire::{
    Answer, Element, Fix, Modify, Ours, Outcome, Request, Said, Setpoint, Speed, Trackcircle, Trackline, Velocities,
    read_ours, read_vehicle,
};
use backseat_spi::{
    AckStatus, BehaviorId, ChecksumState, Direction, Entry, EntryField, FromVehicle, HorizontalMode, Interrupt,
    ModifySpeedMode, ModifyVerticalMode, PositionQuality, Sentence, SpeedMode, ToVehicle, VerticalMode,
    VerticalReference, catalogue,
};
use proptest::prelude::*;

use crate::scenario::sentence;

/// A position, rounded to a tenth of a millimetre, so that the last bit of a conversion makes no difference.
fn place(latitude_deg: f64, longitude_deg: f64) -> Position {
    let round = |deg: f64| (deg * 1e9).round() / 1e9 + 0.0;
    Position {
        latitude_deg: round(latitude_deg),
        longitude_deg: round(longitude_deg),
    }
}

fn place_of(position: backseat_units::Position) -> Position {
    place(position.latitude.as_deg(), position.longitude.as_deg())
}

fn rounded(position: Position) -> Position {
    place(position.latitude_deg, position.longitude_deg)
}

fn nanos(time: backseat_units::TimeOfDay) -> u64 {
    time.as_nanos()
}

/// What `backseat-spi` reads in a sentence of ours, in the oracle's types. `None` if it reads nothing, or a code that
/// the specification does not define.
fn spi_ours(line: &str) -> Option<(u64, Ours)> {
    let sentence = Sentence::parse(line.trim_end()).ok()?;
    if sentence.checksum() != ChecksumState::Valid {
        return None;
    }
    let vertical = |mode, metres| match mode {
        VerticalMode::Depth => Some(Setpoint::Depth(metres)),
        VerticalMode::Altitude => Some(Setpoint::Altitude(metres)),
        VerticalMode::Other(_) => None,
    };
    let speed = |mode, value| match mode {
        SpeedMode::MetresPerSecond => Some(Speed::MetresPerSecond(value)),
        SpeedMode::Rpm => Some(Speed::Rpm(value)),
        SpeedMode::Other(_) => None,
    };
    let interrupts = |code| match code {
        Interrupt::AfterCurrent => Some(false),
        Interrupt::InterruptCurrent => Some(true),
        Interrupt::Other(_) => None,
    };
    let message = ToVehicle::decode(&sentence).ok()?;
    let created = match sentence.fields().next() {
        Some(time) if sentence.name() != "BPLOG" => time_of(time)?,
        Some(_) | None => 0,
    };
    #[expect(clippy::wildcard_enum_match_arm, reason = "no rule uses the others")]
    let asks = match message {
        ToVehicle::TopsideText(_) => Ours::Topside,
        ToVehicle::DvlTriggerRequest(it) => Ours::DvlTrigger {
            external: it.external,
            triggering: it.triggering,
        },
        ToVehicle::Trackline(it) => Ours::Trackline(Trackline {
            identifier: it.identifier.get(),
            start: place_of(it.start),
            end: place_of(it.end),
            vertical: vertical(it.vertical_mode, it.vertical_m)?,
            speed: speed(it.speed_mode, it.speed)?,
            interrupts: interrupts(it.interrupt)?,
        }),
        ToVehicle::Trackcircle(it) => Ours::Trackcircle(Trackcircle {
            identifier: it.identifier.get(),
            centre: place_of(it.centre),
            radius_m: it.radius_m,
            orbits: it.orbits,
            vertical: vertical(it.vertical_mode, it.vertical_m)?,
            speed: speed(it.speed_mode, it.speed)?,
            interrupts: interrupts(it.interrupt)?,
        }),
        ToVehicle::GpsHit(it) => Ours::GpsHit {
            identifier: it.identifier.get(),
            position: place_of(it.position),
        },
        ToVehicle::CancelBehavior(it) => Ours::Cancel {
            identifier: it.identifier.get(),
        },
        ToVehicle::ModifyBehavior(it) => Ours::Modify(Modify {
            complete: it.horizontal.is_some()
                && it.horizontal_mode.is_some()
                && it.vertical_m.is_some()
                && it.vertical_mode.is_some()
                && it.speed.is_some()
                && it.speed_mode.is_some(),
            heading_deg: it
                .horizontal
                .filter(|_| it.horizontal_mode == Some(HorizontalMode::Heading)),
            vertical: match it.vertical_mode {
                Some(ModifyVerticalMode::Depth) => it.vertical_m.map(Setpoint::Depth),
                Some(ModifyVerticalMode::Altitude) => it.vertical_m.map(Setpoint::Altitude),
                Some(_) | None => None,
            },
            speed_mps: it
                .speed
                .filter(|_| it.speed_mode == Some(ModifySpeedMode::MetresPerSecond)),
        }),
        ToVehicle::EndModify(_) => Ours::EndModify,
        ToVehicle::LogMessage(_) => Ours::LogMessage,
        ToVehicle::RequestPlan(_) => Ours::RequestPlan,
        ToVehicle::SilentMode(it) => Ours::Silent { silent: it.silent },
        ToVehicle::Suspend(_) => Ours::Suspend,
        ToVehicle::Continue(_) => Ours::Continue,
        ToVehicle::Resume(_) => Ours::Resume,
        ToVehicle::HullPosition(it) => Ours::HullPosition([it.horizontal_m, it.vertical_m, it.distance_m]),
        ToVehicle::BottomPosition(it) => Ours::BottomPosition {
            x_m: it.x_m,
            y_m: it.y_m,
            vertical: match it.reference {
                VerticalReference::Depth => Setpoint::Depth(it.vertical_m),
                VerticalReference::Altitude => Setpoint::Altitude(it.vertical_m),
            },
        },
        ToVehicle::RelativeReset(_) | ToVehicle::BearingOffset(_) => Ours::FrameMoves,
        ToVehicle::SonarAngle(_) | ToVehicle::Camera(_) | ToVehicle::Light(_) => Ours::Device,
        ToVehicle::Packet(_) => Ours::Packet,
        ToVehicle::LoggingControl(it) => Ours::Subscribe {
            acknowledgements: it.on && it.message.as_str() == "ACK",
        },
        _ => Ours::Other,
    };
    Some((created, asks))
}

/// A time of day by the letter of the specification, only for comparison.
fn time_of(field: &str) -> Option<u64> {
    let (clock, decimals) = field.split_once('.').unwrap_or((field, ""));
    let clock: u64 = clock.parse().ok()?;
    let seconds = clock / 10_000 * 3600 + clock / 100 % 100 * 60 + clock % 100;
    let nanos: u64 = format!("{decimals:0<9}").get(..9)?.parse().ok()?;
    Some(seconds * 1_000_000_000 + nanos)
}

/// What the oracle reads in a sentence of ours.
fn oracle_ours(line: &str) -> Option<(u64, Ours)> {
    let Request { created, asks, .. } = read_ours(line.trim_end_matches('\n').as_bytes()).ok()?;
    #[expect(clippy::wildcard_enum_match_arm, reason = "the others have no position")]
    let asks = match asks {
        Ours::Trackline(line) => Ours::Trackline(Trackline {
            start: rounded(line.start),
            end: rounded(line.end),
            ..line
        }),
        Ours::Trackcircle(circle) => Ours::Trackcircle(Trackcircle {
            centre: rounded(circle.centre),
            ..circle
        }),
        Ours::GpsHit { identifier, position } => Ours::GpsHit {
            identifier,
            position: rounded(position),
        },
        other => other,
    };
    Some((created.map_or(0, backseat_oracle::TimeOfDay::as_nanos), asks))
}

/// What the vehicle said: a text for comparison, and the times in nanoseconds.
type Heard = (String, Vec<u64>);

/// What `backseat-spi` reads in a sentence of the vehicle's, in the same form.
fn spi_heard(line: &str) -> Option<Heard> {
    let sentence = Sentence::parse(line.trim_end()).ok()?;
    if sentence.checksum() != ChecksumState::Valid {
        return None;
    }
    let id = |identifier: Option<BehaviorId>| identifier.map(BehaviorId::get);
    let mut times = Vec::new();
    #[expect(clippy::wildcard_enum_match_arm, reason = "no rule needs the others")]
    let text = match FromVehicle::decode(&sentence).ok()? {
        FromVehicle::MissionCommand(it) => format!("command {:?}", it.text.as_str()),
        FromVehicle::Shutdown(_) => "shutdown".to_owned(),
        FromVehicle::DvlTriggering(it) => format!("trigger {}", it.begin),
        FromVehicle::Navigation(it) => {
            times.extend([nanos(it.created), nanos(it.solution)]);
            format!(
                "fix {:?} {} {} {} {}",
                place_of(it.position),
                it.depth.as_m(),
                it.altitude.is_some(),
                it.quality != PositionQuality::NoGps,
                it.heading.as_deg()
            )
        }
        FromVehicle::VelocityAndRates(it) => {
            times.push(nanos(it.created));
            format!("velocities {} {}", it.east_mps + 0.0, it.north_mps + 0.0)
        }
        FromVehicle::BehaviorBegin(it) => format!("begins {} {:?}", it.number.is_some(), id(it.identifier)),
        FromVehicle::BehaviorEnd(it) => format!("ends {:?}", id(it.identifier)),
        FromVehicle::MissionStatus(it) => format!("running {}", it.is_running()),
        FromVehicle::PlanElement(it) => format!(
            "element {:?} {:?} {} {:?}",
            it.number,
            id(it.identifier),
            it.index,
            place_of(it.position)
        ),
        FromVehicle::Acknowledgement(it) => {
            times.extend([nanos(it.created), nanos(it.command_created.time())]);
            let outcome = match it.status {
                AckStatus::Invalid => Outcome::Invalid,
                AckStatus::Failed => Outcome::Failed,
                AckStatus::Succeeded => Outcome::Succeeded,
                AckStatus::Pending => Outcome::Pending,
                AckStatus::Other(_) => Outcome::Other,
            };
            format!("answer {} {:?} {outcome:?}", it.command, id(it.behavior))
        }
        FromVehicle::BackseatControl(it) => format!("control {}", it.granted),
        FromVehicle::MediumAccess(it) => {
            times.extend([nanos(it.created), nanos(it.until)]);
            "window".to_owned()
        }
        _ => return None,
    };
    Some((text, times))
}

/// What the oracle reads in a sentence of the vehicle's.
fn oracle_heard(line: &str) -> Option<Heard> {
    let mut times = Vec::new();
    let text = match read_vehicle(line.trim_end_matches('\n').as_bytes())? {
        Said::MissionCommand(text) => format!("command {:?}", String::from_utf8_lossy(text)),
        Said::Shutdown => "shutdown".to_owned(),
        Said::DvlTriggering { begin } => format!("trigger {begin}"),
        Said::Velocities(Velocities {
            created,
            east_mps,
            north_mps,
        }) => {
            times.push(created.as_nanos());
            format!("velocities {} {}", east_mps + 0.0, north_mps + 0.0)
        }
        Said::Navigation(Fix {
            created,
            solution,
            position,
            depth_m,
            locked,
            by_gps,
            heading_deg,
        }) => {
            times.extend([created.as_nanos(), solution.as_nanos()]);
            format!(
                "fix {:?} {} {locked} {by_gps} {}",
                rounded(position),
                depth_m + 0.0,
                heading_deg % 360.0 + 0.0
            )
        }
        Said::Begins {
            planned, identifier, ..
        } => format!("begins {planned} {identifier:?}"),
        Said::Ends { identifier } => format!("ends {identifier:?}"),
        Said::MissionStatus { running, .. } => format!("running {running}"),
        Said::Element(Element {
            number,
            identifier,
            index,
            position,
        }) => format!("element {number:?} {identifier:?} {index} {:?}", rounded(position)),
        Said::Answer(Answer {
            created,
            command,
            command_created,
            identifier,
            outcome,
        }) => {
            times.extend([created.as_nanos(), command_created.time().as_nanos()]);
            let command = String::from_utf8_lossy(&command).into_owned();
            format!("answer {command} {identifier:?} {outcome:?}")
        }
        Said::Control { granted } => format!("control {granted}"),
        Said::Window { created, until } => {
            times.extend([created.as_nanos(), until.as_nanos()]);
            "window".to_owned()
        }
    };
    Some((text, times))
}

/// The vehicle's sentences that a rule needs.
const HEARD: [&str; 12] = [
    "BFNVG", "BFNVR", "BFACK", "BFMBS", "BFMBE", "BFPLN", "BFCTL", "BFMIS", "BFMSC", "BFCMA", "BFDVT", "BFSHT",
];

#[test]
fn both_readers_agree_on_every_example_of_the_catalogue() {
    let mut heard = 0;
    for entry in catalogue() {
        let line = format!("{}\r\n", entry.example);
        match entry.direction {
            Direction::ToVehicle => {
                let read = oracle_ours(&line);
                assert!(
                    read.is_some(),
                    "{line} {:?}",
                    read_ours(line.trim_end_matches('\n').as_bytes())
                );
                assert_eq!(read, spi_ours(&line), "{line}");
            }
            Direction::FromVehicle if HEARD.contains(&entry.name) => {
                assert!(oracle_heard(&line).is_some(), "{line}");
                assert_eq!(oracle_heard(&line), spi_heard(&line), "{line}");
                heard += 1;
            }
            Direction::FromVehicle => assert_eq!(read_vehicle(entry.example.as_bytes()), None, "{line}"),
        }
    }
    assert_eq!(heard, HEARD.len());
}

/// Draws the fields on the wire of one value of a sentence, as the specification writes them, from its entry in the
/// catalogue.
fn fields_of(field: &'static EntryField) -> BoxedStrategy<Vec<String>> {
    if field.range == "1..8 frames" {
        return (1..9usize)
            .prop_flat_map(|count| (Just(count), proptest::collection::vec("([0-9A-F]{2}){1,6}", count)))
            .prop_map(|(count, mut frames)| {
                frames.resize(8, String::new());
                frames.insert(0, count.to_string());
                frames
            })
            .boxed();
    }
    let format = |format: &'static str| field_of(format, field.range);
    field.formats.iter().copied().map(format).collect::<Vec<_>>().boxed()
}

/// Draws one field on the wire.
fn field_of(format: &'static str, range: &'static str) -> BoxedStrategy<String> {
    match format {
        "x.x" => {
            let (least, most) = bounds(range).unwrap_or((-1e6, 1e6));
            (least..most, 0..5usize)
                .prop_map(|(value, decimals)| format!("{value:.decimals$}"))
                .boxed()
        }
        "x" | "iiii" => {
            if let Some(codes) = range.strip_prefix("code ") {
                let codes: Vec<_> = codes
                    .split(' ')
                    .filter(|code| *code != "…")
                    .map(str::to_owned)
                    .collect();
                return proptest::sample::select(codes).boxed();
            }
            match bounds(range) {
                Some((least, most)) => (least as i64..=most as i64).prop_map(|value| value.to_string()).boxed(),
                // A reserved field.
                None => Just("0".to_owned()).boxed(),
            }
        }
        "0/1" => prop_oneof!["0", "1"].boxed(),
        "D/A" => prop_oneof!["D", "A"].boxed(),
        "N/S" => prop_oneof!["N", "S"].boxed(),
        "E/W" => prop_oneof!["E", "W"].boxed(),
        "ON/OFF" => prop_oneof!["ON", "OFF"].boxed(),
        "rrr" => prop_oneof!["NVG", "ALL", "RTK", "RMB", "RCN", "NAK"].boxed(),
        "c--c" => prop_oneof!["", "Running", "Running 7", "Ready", "[ -~&&[^,*$]]{0,12}"].boxed(),
        "ddmm.mmmmmm" => angle(90, 2).boxed(),
        "dddmm.mmmmmm" => angle(180, 3).boxed(),
        "hhmmss.sss" => (0..24u32, 0..60u32, 0..60u32, 0..1_000_000u32, 3..7usize)
            .prop_map(|(hour, minute, second, micros, decimals)| {
                let micros = format!("{micros:06}");
                format!("{hour:02}{minute:02}{second:02}.{}", &micros[..decimals])
            })
            .boxed(),
        _ => Just(String::new()).boxed(),
    }
}

/// The ends of a range of the catalogue.
fn bounds(range: &str) -> Option<(f64, f64)> {
    let (least, most) = range.split_once("..")?;
    Some((least.parse().ok()?, most.parse().ok()?))
}

fn angle(max: u32, width: usize) -> impl Strategy<Value = String> {
    (0..max, 0..60_000_000u32, 0..7usize).prop_map(move |(degrees, millionths, decimals)| {
        let minutes = f64::from(millionths.min(59_000_000)) / 1e6;
        let places = if decimals == 0 { 2 } else { decimals + 3 };
        format!("{degrees:0width$}{minutes:0places$.decimals$}")
    })
}

/// Draws a field as real vehicles, other payloads or damage may leave it.
fn odd_field() -> impl Strategy<Value = String> {
    prop_oneof![
        Just(String::new()),
        "[0-9]{1,7}",
        "-?[0-9]{0,5}\\.?[0-9]{0,5}",
        " {0,2}[0-9]{0,3} {0,2}",
        "[ -~&&[^,*$]]{0,8}",
        "[0-9]{6}(\\.[0-9]{0,4})?",
    ]
}

/// A sentence's name and its fields.
type Drawn = (&'static str, Vec<String>);

/// Draws a sentence as the specification writes it.
fn drawn(direction: Direction) -> impl Strategy<Value = Drawn> {
    let judged = |entry: &&Entry| match direction {
        Direction::ToVehicle => entry.direction == direction,
        Direction::FromVehicle => HEARD.contains(&entry.name),
    };
    let entries: Vec<&'static Entry> = catalogue().iter().filter(judged).collect();
    proptest::sample::select(entries).prop_flat_map(|entry| {
        let values: Vec<_> = entry.fields.iter().map(fields_of).collect();
        (Just(entry.name), values.prop_map(|values| values.concat()))
    })
}

/// Draws a sentence in which a field is odd, missing or one too many.
fn odd(direction: Direction) -> impl Strategy<Value = Drawn> {
    let change = (any::<proptest::sample::Index>(), 0..5u8, odd_field());
    (drawn(direction), change).prop_map(|((name, mut fields), (at, what, text))| {
        let at = at.index(fields.len());
        match what {
            0 => fields.truncate(at),
            1 => fields.push(text),
            _ => fields[at] = text,
        }
        (name, fields)
    })
}

fn line((name, fields): &Drawn) -> String {
    let body = if fields.is_empty() {
        (*name).to_owned()
    } else {
        format!("{name},{}", fields.join(","))
    };
    sentence(&body)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn both_readers_agree_on_every_sentence_of_ours(drawn in drawn(Direction::ToVehicle)) {
        let line = line(&drawn);
        let read = oracle_ours(&line);
        prop_assert!(read.is_some(), "{line} {:?}", read_ours(line.trim_end_matches('\n').as_bytes()));
        prop_assert_eq!(read, spi_ours(&line), "{}", line);
    }

    #[test]
    fn both_readers_agree_on_every_sentence_of_the_vehicle(drawn in drawn(Direction::FromVehicle)) {
        let line = line(&drawn);
        prop_assert!(oracle_heard(&line).is_some(), "{line}");
        prop_assert_eq!(oracle_heard(&line), spi_heard(&line), "{}", line);
    }

    /// Of our sentences the oracle reads only what `backseat-spi` reads too, and in the same way.
    #[test]
    fn the_oracle_is_the_stricter_reader_of_our_sentences(odd in odd(Direction::ToVehicle)) {
        let line = line(&odd);
        let read = oracle_ours(&line);
        prop_assert!(read.is_none() || read == spi_ours(&line), "{line} {read:?} {:?}", spi_ours(&line));
    }

    /// Both read an odd sentence of the vehicle in the same way. A sentence with a position may be read by only one of
    /// them, but if both read it, they read the same.
    #[test]
    fn both_readers_agree_on_odd_sentences_of_the_vehicle(odd in odd(Direction::FromVehicle)) {
        let line = line(&odd);
        let (read, other) = (oracle_heard(&line), spi_heard(&line));
        if !matches!(odd.0, "BFNVG" | "BFPLN") || read.is_some() && other.is_some() {
            prop_assert_eq!(read, other, "{}", line);
        }
    }

    #[test]
    fn no_bytes_make_a_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200), name in 0..30usize) {
        const NAMES: [&str; 30] = [
            "BFNVG", "BFACK", "BFMBS", "BFMBE", "BFPLN", "BFCTL", "BFMIS", "BFMSC", "BFCMA", "BFDVT", "BFSHT", "BPLOG",
            "BPTOP", "BPDVR", "BPRTK", "BPRTC", "BPRGP", "BPRCN", "BPRCB", "BPRMB", "BPCTD", "BPABT", "BPNPU", "BPSIL",
            "BPGHP", "BPGBP", "BPPTZ", "BPLIT", "BPCPD", "BPXYZ",
        ];
        let mut body = NAMES[name].as_bytes().to_vec();
        body.extend(&bytes);
        let sum = body.iter().fold(0, |sum, byte| sum ^ byte);
        let mut line = b"$".to_vec();
        line.extend(body);
        line.extend(format!("*{sum:02X}\r").into_bytes());
        let _read = (read_ours(&line), read_vehicle(&line), read_ours(&bytes), read_vehicle(&bytes));
    }
}

/// The two readers differ on purpose here. `backseat-spi` reads what other payloads and vehicles may send; of our own
/// sentences the oracle accepts only the exact form of the specification.
#[test]
fn the_oracle_accepts_our_sentences_only_in_the_form_of_the_specification() {
    let checked = |body: &str| sentence(body);
    let lower = (0..16)
        .map(|identifier| checked(&format!("BPRCN,000001.000,{identifier}")))
        .map(|line| line[..line.len() - 4].to_owned() + &line[line.len() - 4..].to_lowercase())
        .find(|line| line[line.len() - 4..].contains(|digit: char| digit.is_ascii_lowercase()))
        .unwrap();
    for (what, line) in [
        ("no checksum", "$BPEMB,000001.000\r\n".to_owned()),
        ("a checksum in lower case", lower),
        ("a line feed alone", checked("BPEMB,000001.000").replace('\r', "")),
        ("one field too many", checked("BPEMB,000001.000,0")),
        ("no milliseconds", checked("BPEMB,000001")),
        ("two decimals", checked("BPEMB,000001.50")),
        ("a topic of two letters", checked("BPLOG,NV,ON")),
        ("a code of a later version", checked("BPTOP,000001.000,4,x,0")),
        ("a reserved value", checked("BPRCB,000001.000,1")),
        ("no reserved field", checked("BPRCB,000001.000")),
        (
            "no interrupt code",
            checked("BPRTK,000001.000,7,4200,N,07000,W,4201,N,07000,W,0,5,1.5,0"),
        ),
        (
            "an interrupt code of a later version",
            checked("BPRTK,000001.000,7,4200,N,07000,W,4201,N,07000,W,0,5,1.5,0,1"),
        ),
        (
            "a speed mode of a later version",
            checked("BPRTK,000001.000,7,4200,N,07000,W,4201,N,07000,W,0,5,1.5,2,0"),
        ),
        ("a field of blanks", checked("BPRMB,000001.000, ,5,0,1.5,1,0")),
        ("no abort reason", checked("BPABT,000001.000,leak")),
    ] {
        assert!(read_ours(line.trim_end_matches('\n').as_bytes()).is_err(), "{what}");
        let spi = Sentence::parse(line.trim_end()).ok();
        assert!(
            spi.is_some_and(|sentence| ToVehicle::decode(&sentence).is_ok()),
            "{what}"
        );
    }
    // And both refuse these.
    for line in [
        checked("BPEMB"),
        checked("BPEMB,"),
        checked("BPRMB,000001.000,90,10,0,1.5,1"),
        checked("BPRCN,000001.000,-5"),
        checked("BPRMB,000001.000,9e1,10,0,1.5,1,0"),
        checked("BFCTL,000001.000,1"),
        checked("BPMSG,000001.000,a,b"),
    ] {
        assert!(read_ours(line.trim_end_matches('\n').as_bytes()).is_err(), "{line}");
    }
}

/// A BFNVG has the position that the vehicle believes. A damaged one whose checksum is right by chance moves nothing.
#[test]
fn a_fix_is_read_as_the_specification_writes_it() {
    let body = "BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980";
    let read = |body: &str| match read_vehicle(sentence(body).trim_end().as_bytes()) {
        Some(Said::Navigation(fix)) => Some(fix),
        Some(_) | None => None,
    };
    let fix = read(body).unwrap();
    assert_eq!(fix.solution.to_string(), "08:10:25.980");
    assert_eq!(rounded(fix.position), place(42.363_515_333, -71.114_100_5));
    assert_eq!((fix.depth_m, fix.heading_deg, fix.locked), (20.1, 203.1, true));
    assert!(!read(&body.replace(",45.3,", ",,")).unwrap().locked);
    assert!(!read(&body.replace(",45.3,", ",0.000,")).unwrap().locked);
    assert!(read(&body.replace(",1,45", ",4,45")).is_some(), "a code");
    assert!(read(&format!("{body},7")).is_some(), "a field of a later version");
    assert_eq!(
        read_vehicle(sentence(body).trim_end().replace("*4", "*5").as_bytes()),
        None
    );
    for (right, damaged) in [
        ("081025.987", "0810:5.987"),
        ("4221.81092", "4271.81092"),
        (",N,", ",F,"),
        (",N,", "N"),
        (",W,", ",G,"),
        (",1,", ",q,"),
        (",1,", ",11,"),
        ("45.3", "4u.3"),
        ("20.1", "2>.1"),
        ("203.1", "403.1"),
        ("-3.4", "-3&4"),
        (",4.5", ",t.5"),
        ("081025.980", "081025.9x0"),
    ] {
        assert_eq!(read(&body.replacen(right, damaged, 1)), None, "{damaged}");
    }
    // `backseat-spi` wraps a heading into the circle, reads codes with more digits, and refuses a depth that no sea
    // has.
    let spi = |body: &str| spi_heard(&sentence(body)).is_some();
    for (changed, oracle_reads) in [
        (body.replace("203.1", "403.1"), false),
        (body.replace(",1,45", ",11,45"), false),
        (body.replace(",20.1,", ",20000,"), true),
    ] {
        assert_eq!(
            (read(&changed).is_some(), spi(&changed)),
            (oracle_reads, !oracle_reads),
            "{changed}"
        );
    }
    // It also accepts a blank as a digit of the degrees.
    let element = "BFPLN,000000.000,3,,0,1,4200,N,07000,W,,,";
    assert!(spi_heard(&sentence(element)).is_some() && oracle_heard(&sentence(element)).is_some());
    let blank = sentence(&element.replace(",4200,", ", 000,"));
    assert!(spi_heard(&blank).is_some() && oracle_heard(&blank).is_none());
}
