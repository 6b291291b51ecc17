use super::fields::{Fault, Fields, Setpoint, Speed, integer, whole};
use super::line::{is_checksum, split_checksum};
use crate::earth::Position;
use crate::time_of_day::TimeOfDay;

/// A sentence of ours, with what the rules need of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The five letters of its name.
    pub name: [u8; 5],
    /// When it says that it was made; BPLOG has no time (SPI 7.1).
    pub created: Option<TimeOfDay>,
    /// What it asks for.
    pub asks: Ours,
}

/// What a sentence of ours asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ours {
    /// BPLOG (SPI 7.1).
    Subscribe {
        /// Whether it asks for acknowledgements.
        acknowledgements: bool,
    },
    /// BPTOP (SPI 7.3).
    Topside,
    /// BPDVR (SPI 7.4).
    DvlTrigger {
        /// Whether we ask for external triggering; if not, we ask to end it.
        external: bool,
        /// Whether we trigger the DVL now.
        triggering: bool,
    },
    /// BPRTK (SPI 7.5).
    Trackline(Trackline),
    /// BPRTC (SPI 7.6).
    Trackcircle(Trackcircle),
    /// BPRGP (SPI 7.7).
    GpsHit {
        /// The identifier that we give it.
        identifier: u32,
        /// Where to surface.
        position: Position,
    },
    /// BPRCN (SPI 7.8).
    Cancel {
        /// The insert's identifier.
        identifier: u32,
    },
    /// BPRMB (SPI 7.12).
    Modify(Modify),
    /// BPEMB (SPI 7.13).
    EndModify,
    /// BPMSG (SPI 7.18).
    LogMessage,
    /// BPRMP (SPI 7.19).
    RequestPlan,
    /// BPSIL (SPI 7.22).
    Silent {
        /// Silent mode, or normal mode.
        silent: bool,
    },
    /// BPSUS (SPI 8.1).
    Suspend,
    /// BPCON (SPI 8.2).
    Continue,
    /// BPRES (SPI 8.3).
    Resume,
    /// BPGHP (SPI 8.6): metres along the hull, up or down the hull, and away from it.
    HullPosition([f64; 3]),
    /// BPGBP (SPI 8.7).
    BottomPosition {
        /// Metres over the bottom.
        x_m: f64,
        /// Metres over the bottom.
        y_m: f64,
        /// The depth or altitude.
        vertical: Setpoint,
    },
    /// BPRNS or BPRBO (SPI 8.8, 8.9): we tell the vehicle that it is, or looks, elsewhere.
    FrameMoves,
    /// BPSAN, BPPTZ or BPLIT (SPI 8.5, 8.10, 8.11).
    Device,
    /// BPCPD (SPI 9.4).
    Packet,
    /// A sentence whose fields no rule needs, such as one of a later version.
    Other,
}

impl Ours {
    /// Whether it cannot be taken back once it is sent: a GPS hit (SPI 7.8), and an insert that interrupts at once.
    pub(crate) fn is_irrevocable(&self) -> bool {
        matches!(
            self,
            Self::GpsHit { .. }
                | Self::Trackline(Trackline { interrupts: true, .. })
                | Self::Trackcircle(Trackcircle { interrupts: true, .. })
        )
    }
}

/// A line that the vehicle is asked to fly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trackline {
    /// The identifier that we give it.
    pub identifier: u32,
    /// Where it starts.
    pub start: Position,
    /// Where it ends.
    pub end: Position,
    /// The depth or altitude.
    pub vertical: Setpoint,
    /// The speed.
    pub speed: Speed,
    /// Whether it interrupts the current behavior.
    pub interrupts: bool,
}

/// A circle that the vehicle is asked to fly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trackcircle {
    /// The identifier that we give it.
    pub identifier: u32,
    /// Its centre.
    pub centre: Position,
    /// Its radius, metres.
    pub radius_m: f64,
    /// The number of orbits, clockwise if positive.
    pub orbits: f64,
    /// The depth or altitude.
    pub vertical: Setpoint,
    /// The speed.
    pub speed: Speed,
    /// Whether it interrupts the current behavior.
    pub interrupts: bool,
}

/// A change of the current behavior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modify {
    /// Whether no field is empty, so that nothing is left to the current behavior.
    pub complete: bool,
    /// The heading, in degrees from a north that the specification does not name, if the horizontal mode is 0.
    pub heading_deg: Option<f64>,
    /// The depth or altitude, if the vertical mode is 0 or 1.
    pub vertical: Option<Setpoint>,
    /// The speed, m/s, if the speed mode is 1. (BPRTK numbers its speed modes the other way round.)
    pub speed_mps: Option<f64>,
}

/// Reads the sentence in a line of ours; `line` has no line feed.
///
/// # Errors
/// [`Fault`] says what differs from the specification. A name that the specification does not have passes with any
/// fields, because later versions may define it (SPI 4.2).
pub fn read_ours(line: &[u8]) -> Result<Request, Fault> {
    let sentence = line.strip_suffix(b"\r").ok_or(Fault::End)?;
    let (body, digits) = split_checksum(sentence).ok_or(Fault::Frame)?;
    let upper = digits.iter().all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F'));
    if !upper || !is_checksum(body, digits) {
        return Err(Fault::Frame);
    }
    if !body
        .iter()
        .all(|byte| matches!(byte, b' '..=b'~') && !matches!(byte, b'*' | b'$'))
    {
        return Err(Fault::Byte);
    }
    let (name, rest) = body.split_first_chunk::<5>().ok_or(Fault::Name)?;
    let named = name.starts_with(b"BP") && name.iter().all(u8::is_ascii_uppercase);
    if !named || !matches!(rest.first(), None | Some(b',')) {
        return Err(Fault::Name);
    }
    let mut fields = Fields::new(rest);
    let (created, asks) = match name {
        b"BPLOG" => {
            let topic = fields.read("three letters", |text| is_topic(text).then_some(text))?;
            let on = fields.read("ON or OFF", |text| {
                matches!(text, b"ON" | b"OFF").then_some(text == b"ON")
            })?;
            let acknowledgements = topic == b"ACK" && on;
            (None, Ours::Subscribe { acknowledgements })
        }
        name => {
            let before = fields;
            match known(name, &mut fields)? {
                Some((created, asks)) => (Some(created), asks),
                None => return Ok(of_later_version(*name, before)),
            }
        }
    };
    fields.end()?;
    Ok(Request {
        name: *name,
        created,
        asks,
    })
}

fn is_topic(text: &[u8]) -> bool {
    text.len() == 3 && text.iter().all(u8::is_ascii_alphanumeric)
}

fn of_later_version(name: [u8; 5], mut fields: Fields<'_>) -> Request {
    Request {
        name,
        created: fields.time().ok(),
        asks: Ours::Other,
    }
}

/// Reads the fields of a sentence that begins with a time. `None` if the specification has no such sentence.
fn known(name: &[u8; 5], fields: &mut Fields<'_>) -> Result<Option<(TimeOfDay, Ours)>, Fault> {
    if !is_known(name) {
        return Ok(None);
    }
    let created = fields.precise_time()?;
    let asks = match name {
        b"BPSTS" => {
            fields.flag()?;
            fields.text()?;
            Ours::Other
        }
        b"BPTOP" => {
            fields.code(3)?;
            fields.text()?;
            fields.reserved()?;
            Ours::Topside
        }
        b"BPDVR" => Ours::DvlTrigger {
            external: fields.flag()?,
            triggering: fields.flag()?,
        },
        b"BPRTK" => Ours::Trackline(Trackline {
            identifier: fields.whole()?,
            start: fields.position()?,
            end: fields.position()?,
            vertical: fields.setpoint()?,
            speed: fields.speed()?,
            interrupts: interrupts(fields)?,
        }),
        b"BPRTC" => Ours::Trackcircle(trackcircle(fields)?),
        b"BPRGP" => {
            let (identifier, position) = (fields.whole()?, fields.position()?);
            fields.number_or_empty()?;
            fields.whole_or_empty()?;
            fields.code(2)?;
            Ours::GpsHit { identifier, position }
        }
        b"BPRCN" => Ours::Cancel {
            identifier: fields.whole()?,
        },
        b"BPRCB" | b"BPRCE" => {
            fields.reserved()?;
            Ours::Other
        }
        b"BPRMB" => Ours::Modify(modify(fields)?),
        b"BPTMR" => {
            fields.code(3)?;
            fields.text()?;
            Ours::Other
        }
        b"BPCTD" => {
            numbers::<3>(fields)?;
            fields.precise_time()?;
            Ours::Other
        }
        b"BPABT" => {
            fields.text()?;
            fields.code(1)?;
            Ours::Other
        }
        b"BPMSG" => {
            fields.text()?;
            Ours::LogMessage
        }
        b"BPKIL" | b"BPVER" => {
            fields.text()?;
            Ours::Other
        }
        b"BPSEM" => {
            fields.number()?;
            fields.code(2)?;
            Ours::Other
        }
        b"BPNPU" => {
            fields.position()?;
            numbers::<2>(fields)?;
            fields.flag()?;
            fields.precise_time()?;
            Ours::Other
        }
        b"BPSIL" => Ours::Silent { silent: fields.flag()? },
        b"BPEMB" => Ours::EndModify,
        b"BPRMP" => Ours::RequestPlan,
        b"BPSUS" => Ours::Suspend,
        b"BPCON" => Ours::Continue,
        b"BPRES" => Ours::Resume,
        b"BPSPD" => {
            fields.number()?;
            Ours::Other
        }
        b"BPSAN" => {
            fields.number()?;
            Ours::Device
        }
        b"BPGHP" => Ours::HullPosition(numbers(fields)?),
        b"BPGBP" => {
            let [x_m, y_m] = numbers(fields)?;
            let depth = fields.read("D or A", |text| match text {
                b"D" => Some(true),
                b"A" => Some(false),
                _ => None,
            })?;
            let metres = fields.number()?;
            Ours::BottomPosition {
                x_m,
                y_m,
                vertical: if depth {
                    Setpoint::Depth(metres)
                } else {
                    Setpoint::Altitude(metres)
                },
            }
        }
        b"BPRNS" => {
            numbers::<3>(fields)?;
            Ours::FrameMoves
        }
        b"BPRBO" => {
            fields.number()?;
            Ours::FrameMoves
        }
        b"BPPTZ" => {
            for _ in 0..3 {
                fields.read("a whole number from -9 to 9", |text| {
                    integer(text).filter(|value| (-9..=9).contains(value))
                })?;
            }
            Ours::Device
        }
        b"BPLIT" => {
            fields.read("a whole number", integer)?;
            fields.flag()?;
            Ours::Device
        }
        b"BPCPD" => {
            packet(fields)?;
            Ours::Packet
        }
        // BPRCA, BPTRM, BPBOY: a time and nothing else.
        _ => Ours::Other,
    };
    Ok(Some((created, asks)))
}

/// Whether the specification has a sentence of this name that begins with a time.
fn is_known(name: &[u8; 5]) -> bool {
    const LETTERS: [&[u8; 3]; 36] = [
        b"STS", b"TOP", b"DVR", b"RTK", b"RTC", b"RGP", b"RCN", b"RCA", b"RCB", b"RCE", b"RMB", b"EMB", b"TMR", b"CTD",
        b"ABT", b"KIL", b"MSG", b"RMP", b"SEM", b"NPU", b"SIL", b"TRM", b"BOY", b"VER", b"SUS", b"CON", b"RES", b"SPD",
        b"SAN", b"GHP", b"GBP", b"RNS", b"RBO", b"PTZ", b"LIT", b"CPD",
    ];
    name.last_chunk::<3>().is_some_and(|letters| LETTERS.contains(&letters))
}

fn numbers<const N: usize>(fields: &mut Fields<'_>) -> Result<[f64; N], Fault> {
    let mut values = [0.0; N];
    for value in &mut values {
        *value = fields.number()?;
    }
    Ok(values)
}

/// Reads the interrupt code: after the current behavior, or at once.
fn interrupts(fields: &mut Fields<'_>) -> Result<bool, Fault> {
    fields.read("0 or 4", |text| match text {
        b"0" => Some(false),
        b"4" => Some(true),
        _ => None,
    })
}

/// The format line of SPI 7.6 lacks the entry angle that its table has. A sentence with an entry angle has one more
/// field.
fn trackcircle(fields: &mut Fields<'_>) -> Result<Trackcircle, Fault> {
    let mut circle = Trackcircle {
        identifier: fields.whole()?,
        centre: fields.position()?,
        radius_m: fields.number()?,
        orbits: fields.number()?,
        vertical: fields.setpoint()?,
        speed: fields.speed()?,
        interrupts: false,
    };
    let mut short = *fields;
    circle.interrupts = match interrupts(&mut short) {
        Ok(interrupts) if short.end().is_ok() => {
            *fields = short;
            interrupts
        }
        Ok(_) | Err(_) => {
            fields.number_or_empty()?;
            interrupts(fields)?
        }
    };
    Ok(circle)
}

fn modify(fields: &mut Fields<'_>) -> Result<Modify, Fault> {
    let horizontal = fields.number_or_empty()?;
    let vertical = fields.number_or_empty()?;
    let vertical_mode = fields.code_or_empty(3)?;
    let speed = fields.number_or_empty()?;
    let speed_mode = fields.code_or_empty(1)?;
    let horizontal_mode = fields.code_or_empty(1)?;
    Ok(Modify {
        complete: horizontal.is_some()
            && vertical.is_some()
            && speed.is_some()
            && vertical_mode.is_some()
            && speed_mode.is_some()
            && horizontal_mode.is_some(),
        heading_deg: horizontal.filter(|_| horizontal_mode == Some(0)),
        vertical: match vertical_mode {
            Some(0) => vertical.map(Setpoint::Depth),
            Some(1) => vertical.map(Setpoint::Altitude),
            Some(_) | None => None,
        },
        speed_mps: speed.filter(|_| speed_mode == Some(1)),
    })
}

/// Reads the request, the destination, the telemetry mode, whether an answer is wanted, the number of frames, and eight
/// frames of hexadecimal digits. Frames beyond the number are empty (SPI 9.4).
fn packet(fields: &mut Fields<'_>) -> Result<(), Fault> {
    fields.whole()?;
    fields.whole()?;
    fields.read("a telemetry mode", integer)?;
    fields.flag()?;
    let count = fields.read("from 1 to 8 frames", |text| {
        whole(text).filter(|count| (1..=8).contains(count))
    })?;
    for frame in 0..8 {
        fields.read("a frame in upper-case hexadecimal digits", |text| {
            let digits = text.iter().all(|byte| matches!(byte, b'0'..=b'9' | b'A'..=b'F'));
            (digits && text.len() % 2 == 0 && text.is_empty() == (frame >= count)).then_some(())
        })?;
    }
    Ok(())
}
