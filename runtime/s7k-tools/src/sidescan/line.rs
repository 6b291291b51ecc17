//! The pings of one sidescan in a recording: where they are, how far they reach, how high the sonar is.

use std::collections::BTreeMap;
use std::io::Read;

use backseat_s7k::record::{Imagery, Record};
use backseat_s7k::{Frame, FrameHeader};

use super::bottom::{Altimeter, AltitudeFrom};
use super::{Sides, reach_m, read_sides};
use crate::error::Error;
use crate::moment::Moment;
use crate::selection::Selection;
use crate::source::Source;
use crate::track::{Pose, Track};
use crate::unmatched::Unmatched;

/// A ping, in a few bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PingPlace {
    offset: u64,
    size: u32,
    /// NaN if it is not known.
    altitude_m: f32,
}

/// The pings of one sidescan, with the navigation.
#[derive(Debug)]
pub(crate) struct Line<'s> {
    source: &'s Source,
    pub(crate) track: Track,
    pub(crate) pings: Vec<PingPlace>,
    pub(crate) sound_speed_mps: f64,
    /// The farthest sample of all pings.
    pub(crate) reach_m: f64,
    /// The most samples of a side.
    pub(crate) samples: usize,
}

/// Sound in sea water, where nothing else says how fast it is.
const SOUND_SPEED_MPS: f64 = 1500.0;

/// The one device of a type in a selection.
///
/// # Errors
/// [`Error::Contents`] if there is none, or more than one.
pub(crate) fn device(source: &Source, selection: &Selection, record_type: u32, what: &str) -> Result<u32, Error> {
    let mut devices: BTreeMap<u32, u64> = BTreeMap::new();
    source.each_record(|_, frame| {
        if frame.header().record_type == record_type && selection.contains(frame.header()) {
            *devices.entry(frame.header().device.0).or_default() += 1;
        }
        Ok(())
    })?;
    let mut found = devices.iter();
    match (found.next(), found.next()) {
        (Some((device, _)), None) => Ok(*device),
        (None, _) => Err(Unmatched::survey(source, record_type)?.refuse(source, selection, record_type, what)),
        (Some(_), Some(_)) => {
            let list: Vec<String> = devices
                .iter()
                .map(|(device, records)| format!("{device} ({records} records)"))
                .collect();
            Err(Error::contents(
                source.path(),
                format!(
                    "{what} of several devices: choose one of {} with --device",
                    list.join(", ")
                ),
            ))
        }
    }
}

impl<'s> Line<'s> {
    /// Finds the pings of a selection, which must be of one device.
    pub(crate) fn survey(
        source: &'s Source,
        selection: &Selection,
        from: AltitudeFrom,
        sound_speed_mps: Option<f64>,
    ) -> Result<Self, Error> {
        let device = device(source, selection, 3000, "sidescan")?;
        let track = Track::read(source)?;
        let sound_speed_mps = sound_speed_mps.or(track.sound_speed_mps).unwrap_or(SOUND_SPEED_MPS);
        let mut line = Self {
            source,
            track,
            pings: Vec::new(),
            sound_speed_mps,
            reach_m: 0.0,
            samples: 0,
        };
        let mut sides = Sides::default();
        let mut altimeter = Altimeter::new(from);
        source.each_record(|offset, frame| {
            let header = frame.header();
            if header.record_type != 3000 || header.device.0 != device || !selection.contains(header) {
                return Ok(());
            }
            let Ok(Record::SideScan(imagery)) = Record::read(frame) else {
                return Ok(());
            };
            read_sides(&imagery, sound_speed_mps, &mut sides);
            let pose = line.pose(header);
            #[expect(clippy::cast_possible_truncation, reason = "an altitude to 1 mm")]
            let altitude_m = altimeter.altitude_m(&sides, &pose).unwrap_or(f64::NAN) as f32;
            line.pings.push(PingPlace {
                offset,
                size: header.size,
                altitude_m,
            });
            line.reach_m = line.reach_m.max(reach_m(&sides));
            line.samples = sides
                .iter()
                .map(|side| side.amplitudes.len())
                .fold(line.samples, usize::max);
            Ok(())
        })?;
        if line.samples == 0 {
            let what = "no ping has samples of 1, 2 or 4 bytes with a sample interval or a range: nothing to draw";
            return Err(Error::contents(source.path(), what));
        }
        Ok(line)
    }

    /// Navigation at a ping.
    pub(crate) fn pose(&self, header: &FrameHeader) -> Pose {
        Moment::of(&header.time).map_or_else(Pose::default, |time| self.track.at(time))
    }

    /// Reads a ping again.
    pub(crate) fn read<T>(
        &self,
        ping: &PingPlace,
        buffer: &mut Vec<u8>,
        sides: &mut Sides,
        use_it: impl FnOnce(&FrameHeader, &Imagery<'_>, &Sides) -> T,
    ) -> Result<Option<T>, Error> {
        buffer.clear();
        let mut part = self.source.part(ping.offset).take(u64::from(ping.size));
        part.read_to_end(buffer)
            .map_err(|error| self.source.read_error(error))?;
        let Ok(frame) = Frame::read(buffer, self.source.limit()) else {
            return Ok(None);
        };
        let Ok(Record::SideScan(imagery)) = Record::read(&frame) else {
            return Ok(None);
        };
        read_sides(&imagery, self.sound_speed_mps, sides);
        Ok(Some(use_it(frame.header(), &imagery, sides)))
    }

    /// How many pings have no altitude.
    pub(crate) fn without_altitude(&self) -> usize {
        self.pings.iter().filter(|ping| ping.altitude_m().is_none()).count()
    }
}

impl PingPlace {
    /// The sonar's altitude, if it is known.
    pub(crate) fn altitude_m(&self) -> Option<f64> {
        Some(f64::from(self.altitude_m)).filter(|altitude| altitude.is_finite())
    }
}
