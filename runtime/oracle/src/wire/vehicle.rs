use super::fields::{Fault, Fields, integer, number, whole};
use super::line::checked;
use crate::earth::Position;
use crate::time_of_day::{Echo, TimeOfDay};

/// A sentence of the vehicle, with what the rules need of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Said<'a> {
    /// BFMSC (SPI 5.1) with its text.
    MissionCommand(&'a [u8]),
    /// BFSHT (SPI 5.2): power will go.
    Shutdown,
    /// BFDVT (SPI 5.6).
    DvlTriggering {
        /// Whether the payload may begin to trigger; if not, it must stop.
        begin: bool,
    },
    /// BFNVG (SPI 6.1).
    Navigation(Fix),
    /// BFNVR (SPI 6.2).
    Velocities(Velocities),
    /// BFMBS (SPI 6.9).
    Begins {
        /// The dive file.
        dive: &'a [u8],
        /// Whether it is a behavior of the plan.
        planned: bool,
        /// The identifier, if it is an insert of ours.
        identifier: Option<u32>,
    },
    /// BFMBE (SPI 6.10).
    Ends {
        /// The identifier, if it was an insert of ours.
        identifier: Option<u32>,
    },
    /// BFMIS (SPI 6.11).
    MissionStatus {
        /// The dive file.
        dive: &'a [u8],
        /// Whether its status begins with `Running`.
        running: bool,
    },
    /// BFPLN (SPI 6.20).
    Element(Element),
    /// BFACK (SPI 6.21).
    Answer(Answer),
    /// BFCTL (SPI 6.24).
    Control {
        /// Whether the payload has control from now on.
        granted: bool,
    },
    /// BFCMA (SPI 9.1).
    Window {
        /// When the sentence was made.
        created: TimeOfDay,
        /// When the window ends.
        until: TimeOfDay,
    },
}

/// The velocities that the vehicle reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocities {
    /// When the sentence was made.
    pub created: TimeOfDay,
    /// East, m/s.
    pub east_mps: f64,
    /// North, m/s.
    pub north_mps: f64,
}

/// The position that the vehicle reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// When the sentence was made.
    pub created: TimeOfDay,
    /// When the solution was computed.
    pub solution: TimeOfDay,
    /// The position.
    pub position: Position,
    /// The depth, metres.
    pub depth_m: f64,
    /// Whether it reports an altitude: 0 means that there is none.
    pub locked: bool,
    /// Whether GPS, or a source of a later version, is in the solution.
    pub by_gps: bool,
    /// The heading from grid north, degrees.
    pub heading_deg: f64,
}

/// An element of the vehicle's plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// The behavior's number in the dive file.
    pub number: Option<u32>,
    /// The identifier, if it is an insert of ours.
    pub identifier: Option<u32>,
    /// Its place among the points of its behavior.
    pub index: u32,
    /// The position.
    pub position: Position,
}

/// The outcome of a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// When the answer was made.
    pub created: TimeOfDay,
    /// The three letters of the command's name; `NAK` for something that was no command.
    pub command: [u8; 3],
    /// The command's own time; midnight if it had none.
    pub command_created: Echo,
    /// The identifier of the insert, if the command names one.
    pub identifier: Option<u32>,
    /// The outcome.
    pub outcome: Outcome,
}

/// The status code of an acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// 0: the vehicle could not read it.
    Invalid,
    /// 1: the vehicle refused it, or it failed.
    Failed,
    /// 2: the vehicle did it.
    Succeeded,
    /// 3: not decided yet.
    Pending,
    /// A code of a later version.
    Other,
}

/// Reads a sentence of the vehicle, which begins with its dollar sign. `None` if its checksum is wrong, if a field that
/// the reader checks differs from the specification, or if no rule needs the sentence.
#[must_use]
pub fn read_vehicle(sentence: &[u8]) -> Option<Said<'_>> {
    // No rule needs most sentences: their checksums are not computed.
    let name = sentence.get(1..)?.first_chunk::<5>()?;
    let reader = match name {
        b"BFNVG" => navigation,
        b"BFNVR" => velocities,
        b"BFACK" => answer,
        b"BFMBS" => begins,
        b"BFMBE" => ends,
        b"BFPLN" => element,
        b"BFCTL" => control,
        b"BFMIS" => mission_status,
        b"BFMSC" => mission_command,
        b"BFCMA" => window,
        b"BFDVT" => triggering,
        b"BFSHT" => shutdown,
        _ => return None,
    };
    let (_, rest) = checked(sentence)?;
    reader(&mut Fields::new(rest)).ok()
}

/// The reader checks every field, even those that no rule needs: damage that the checksum does not reveal is seldom in
/// one field alone.
fn navigation<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    let created = fields.time()?;
    let position = fields.position()?;
    // An unknown code is no reason to doubt the position.
    let code = fields.read("a digit", |text| match text {
        [digit @ b'0'..=b'9'] => Some(digit),
        _ => None,
    })?;
    let altitude_m = fields.read_or_empty("an altitude", |text| number(text).filter(|metres| *metres >= 0.0))?;
    let depth_m = fields.number()?;
    let heading_deg = fields.read("a heading", |text| {
        number(text).filter(|deg| (0.0..=360.0).contains(deg))
    })?;
    let (_roll, _pitch) = (fields.number()?, fields.number()?);
    Ok(Said::Navigation(Fix {
        created,
        solution: fields.time()?,
        position,
        depth_m,
        locked: altitude_m.is_some_and(|metres| metres > 0.0),
        by_gps: *code != b'0',
        heading_deg,
    }))
}

fn velocities<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    let created = fields.time()?;
    let (east_mps, north_mps, _down_mps) = (fields.number()?, fields.number()?, fields.number()?);
    let (_pitch, _roll, _yaw) = (fields.number()?, fields.number()?, fields.number()?);
    Ok(Said::Velocities(Velocities {
        created,
        east_mps,
        north_mps,
    }))
}

fn answer<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    let created = fields.time()?;
    // The three letters of the name, or the whole name.
    let command = fields.read("a command's name", |text| {
        let text = text.trim_ascii();
        let letters = if text.len() == 5 {
            text.strip_prefix(b"BP")?
        } else {
            text
        };
        let letters = <[u8; 3]>::try_from(letters).ok()?;
        let named = |byte: &u8| byte.is_ascii_uppercase() || byte.is_ascii_digit();
        letters.iter().all(named).then_some(letters)
    })?;
    let command_created = fields.echo()?;
    let identifier = identifier(fields)?;
    let outcome = match fields.read("a status", integer)? {
        0 => Outcome::Invalid,
        1 => Outcome::Failed,
        2 => Outcome::Succeeded,
        3 => Outcome::Pending,
        _ => Outcome::Other,
    };
    Ok(Said::Answer(Answer {
        created,
        command,
        command_created,
        identifier,
        outcome,
    }))
}

/// Reads a number that may be missing. Some vehicles leave blanks in its place.
fn count(fields: &mut Fields<'_>) -> Result<Option<u32>, Fault> {
    fields.read("a whole number, or nothing", |text| match text.trim_ascii() {
        b"" => Some(None),
        text => whole(text).map(Some),
    })
}

/// Reads the identifier of an insert of ours. Vehicles write 0 if there is none, as they do in acknowledgements.
fn identifier(fields: &mut Fields<'_>) -> Result<Option<u32>, Fault> {
    count(fields).map(|identifier| identifier.filter(|identifier| *identifier != 0))
}

/// Reads the dive file, and the number and identifier of a behavior. The kind, which comes last, may be missing.
fn behavior<'a>(fields: &mut Fields<'a>) -> Result<(&'a [u8], bool, Option<u32>), Fault> {
    fields.time()?;
    let dive = fields.text()?;
    let planned = count(fields)?.is_some();
    let identifier = identifier(fields)?;
    Ok((dive, planned, identifier))
}

fn begins<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    let (dive, planned, identifier) = behavior(fields)?;
    Ok(Said::Begins {
        dive,
        planned,
        identifier,
    })
}

fn ends<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    let (_, _, identifier) = behavior(fields)?;
    Ok(Said::Ends { identifier })
}

fn element<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    fields.time()?;
    let (number, identifier, index) = (count(fields)?, identifier(fields)?, fields.whole()?);
    // A waypoint, the start or end of a line, a circle, or a kind of a later version.
    fields.read("an element's kind", integer)?;
    Ok(Said::Element(Element {
        number,
        identifier,
        index,
        position: fields.position()?,
    }))
}

fn control<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    fields.time()?;
    Ok(Said::Control {
        granted: fields.flag()?,
    })
}

fn mission_status<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    fields.time()?;
    Ok(Said::MissionStatus {
        dive: fields.text()?,
        running: fields.text()?.starts_with(b"Running"),
    })
}

fn mission_command<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    fields.time()?;
    fields.text().map(Said::MissionCommand)
}

fn window<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    let (created, until) = (fields.time()?, fields.time()?);
    // The modem's address; its kind may be missing.
    fields.whole()?;
    Ok(Said::Window { created, until })
}

fn triggering<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    fields.time()?;
    Ok(Said::DvlTriggering { begin: fields.flag()? })
}

fn shutdown<'a>(fields: &mut Fields<'a>) -> Result<Said<'a>, Fault> {
    fields.time()?;
    Ok(Said::Shutdown)
}
