#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Just, Strategy, any, prop_oneof};

use crate::codes::FrameReceivedStatus;
use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::forms::OrDefault;
use crate::hex;
use crate::packet::{FrameData, ReceivedFrame};

/// The number of a packet's frames. Only 1 to 8 is written. 0 is read too, because a report without frames must not be
/// lost; more than there are places for frames is refused.
pub(crate) struct FrameCount;

impl Field for FrameCount {
    type Value = u32;
    const FORMATS: &'static [&'static str] = u32::FORMATS;
    const RANGE: &'static str = "1..8";

    fn decode(reader: &mut Reader<'_>) -> Result<u32, Fault> {
        match u32::decode(reader)? {
            count @ 0..=8 => Ok(count),
            _ => Err(NOT_A_COUNT),
        }
    }

    fn encode(value: &u32, writer: &mut Writer<'_>) -> Result<(), Fault> {
        match value {
            1..=8 => u32::encode(value, writer),
            _ => Err(NOT_A_COUNT),
        }
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<u32> {
        (1..=8u32).boxed()
    }
}

const NOT_A_COUNT: Fault = Fault::expected("a number of frames from 1 to 8");

/// The eight places for received frames, each with a status and data. Places at the end may be missing.
pub(crate) struct ReceivedFrames;

impl Field for ReceivedFrames {
    type Value = [ReceivedFrame; FrameData::MAX_FRAMES];
    const FORMATS: &'static [&'static str] = &[
        "x", "hex", "x", "hex", "x", "hex", "x", "hex", "x", "hex", "x", "hex", "x", "hex", "x", "hex",
    ];
    const RANGE: &'static str = FrameReceivedStatus::RANGE;

    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault> {
        let mut frames = Self::Value::default();
        for frame in &mut frames {
            frame.status = OrDefault::<FrameReceivedStatus>::decode(reader)?;
            frame.data = data(reader)?;
        }
        Ok(frames)
    }

    fn encode(frames: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault> {
        for frame in frames {
            FrameReceivedStatus::encode(&frame.status, writer)?;
            writer.hex(&frame.data);
        }
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self::Value> {
        let frame = prop_oneof![
            Just(ReceivedFrame::default()),
            (FrameReceivedStatus::strategy(), bytes(0)).prop_map(|(status, data)| ReceivedFrame { status, data }),
        ];
        proptest::collection::vec(frame, FrameData::MAX_FRAMES)
            .prop_map(|frames| frames.try_into().expect("as many as there are places"))
            .boxed()
    }
}

/// The number of frames and the eight places for them. Places at the end may be missing.
impl Field for FrameData {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["x", "hex", "hex", "hex", "hex", "hex", "hex", "hex", "hex"];
    const RANGE: &'static str = "1..8 frames";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        let count = match u32::decode(reader)? {
            count @ 1..=8 => count as usize,
            _ => return Err(NOT_A_COUNT),
        };
        let mut frames = Vec::with_capacity(count);
        for place in 0..Self::MAX_FRAMES {
            let data = data(reader)?;
            match (place < count, data.is_empty()) {
                (true, false) => frames.push(data),
                (true, true) => return Err(Fault::expected("data in as many places as there are frames")),
                (false, false) => return Err(Fault::expected("no data after the last frame")),
                (false, true) => {}
            }
        }
        Self::new(frames).map_err(|_| NOT_A_COUNT)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.integer(u32::try_from(value.count()).map_err(|_| NOT_A_COUNT)?);
        value.frames().for_each(|frame| writer.hex(frame));
        (value.count()..Self::MAX_FRAMES).for_each(|_| writer.empty());
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        proptest::collection::vec(bytes(1), 1..=Self::MAX_FRAMES)
            .prop_map(|frames| Self::new(frames).expect("as many as a packet holds"))
            .boxed()
    }
}

/// The data of one frame; none if its place is missing.
fn data(reader: &mut Reader<'_>) -> Result<Box<[u8]>, Fault> {
    if reader.is_done() {
        return Ok(Box::default());
    }
    hex::decode(reader.bytes()?.trim_ascii())
}

#[cfg(test)]
fn bytes(least: usize) -> BoxedStrategy<Box<[u8]>> {
    proptest::collection::vec(any::<u8>(), least..40)
        .prop_map(Vec::into_boxed_slice)
        .boxed()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{read, written};

    #[test]
    fn places_for_frames_may_be_missing_or_empty() {
        let good = |data: &[u8]| ReceivedFrame {
            status: FrameReceivedStatus::Good,
            data: data.into(),
        };
        for text in [
            "1,0aFF,1,07",
            "1,0AFF,1,07,,,,",
            "1,0AFF,1,07,0,,0,,0,,0,,0,,0,",
            "1, 0AFF ,1,07,0",
        ] {
            let frames = read::<ReceivedFrames>(text).unwrap();
            assert_eq!(frames[..2], [good(&[10, 255]), good(&[7])], "{text}");
            assert!(
                frames[2..].iter().all(|frame| *frame == ReceivedFrame::default()),
                "{text}"
            );
        }
        assert!(read::<ReceivedFrames>("1,0").is_err());
        assert!(read::<ReceivedFrames>("1,0g").is_err());
        assert!(read::<ReceivedFrames>("good,00").is_err());
    }

    #[test]
    fn the_number_of_frames_must_match_the_frames() {
        assert_eq!(
            read::<FrameData>("2,0a,FF").unwrap(),
            FrameData::new([[10u8], [255]]).unwrap()
        );
        assert_eq!(read::<FrameData>("1,0a,,,,,,,").unwrap().count(), 1);
        for bad in [
            "0,,,,,,,,",
            "9,0A",
            ",0A",
            "2,0A",
            "2,0A,",
            "2,,0A",
            "1,0A,0B",
            "1,0",
            "-1,0A",
        ] {
            assert!(read::<FrameData>(bad).is_err(), "{bad}");
        }
        assert_eq!(
            written::<FrameData>(&FrameData::new([[10u8], [255]]).unwrap()).unwrap(),
            ",2,0A,FF,,,,,,"
        );
    }

    #[test]
    fn there_are_never_more_frames_than_places() {
        assert_eq!((read::<FrameCount>("0"), read::<FrameCount>("8")), (Ok(0), Ok(8)));
        assert!(read::<FrameCount>("9").is_err() && read::<FrameCount>("").is_err());
        assert!(written::<FrameCount>(&0).is_err() && written::<FrameCount>(&9).is_err());
    }
}
