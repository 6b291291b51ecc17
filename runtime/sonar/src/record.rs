//! Records that the client writes, and texts that it reads.

use backseat_s7k::plc::Order as Text;
use backseat_s7k::record::CommandHeader;
use backseat_s7k::{DeviceId, FrameHeader, FrameWriter, NetworkHeader, SensorIndex, Time7k};

/// More than every record that the client writes.
const LIMIT: usize = 1 << 16;

/// Writes records in their network frames.
#[derive(Debug, Default)]
pub(crate) struct RecordWriter {
    record: Vec<u8>,
    commands: u32,
    vehicle: u32,
    transmission: u16,
}

impl RecordWriter {
    /// A command (record 11000).
    pub(crate) fn command(&mut self, time: Time7k, target: SensorIndex, text: &Text) -> Result<Vec<u8>, Box<str>> {
        let mut words = String::new();
        text.write(&mut words)
            .map_err(|error| error.to_string().into_boxed_str())?;
        let header = CommandHeader {
            sensor: target,
            command: text.command(),
            action: text.action(),
            bytes: u32::try_from(words.len()).unwrap_or(u32::MAX),
        };
        let frame = FrameHeader::new(11_000, DeviceId::UNSPECIFIED)
            .at(time)
            .counted(self.commands);
        self.commands = self.commands.wrapping_add(1);
        self.enclose(frame, |out| {
            header.write(out);
            out.extend_from_slice(words.as_bytes());
        })
    }

    /// Vehicle data (record 3100), whose body `write` appends.
    pub(crate) fn vehicle(&mut self, time: Time7k, write: impl FnOnce(&mut Vec<u8>)) -> Result<Vec<u8>, Box<str>> {
        let frame = FrameHeader::new(3100, DeviceId::BLUEFIN).at(time).counted(self.vehicle);
        self.vehicle = self.vehicle.wrapping_add(1);
        self.enclose(frame, write)
    }

    fn enclose(&mut self, frame: FrameHeader, write: impl FnOnce(&mut Vec<u8>)) -> Result<Vec<u8>, Box<str>> {
        self.record.clear();
        let mut writer = FrameWriter::begin(frame, &mut self.record);
        write(writer.bytes());
        writer
            .finish(LIMIT)
            .map_err(|error| error.to_string().into_boxed_str())?;
        let mut out = Vec::with_capacity(NetworkHeader::SIZE + self.record.len());
        let header = NetworkHeader::new(frame.device, self.transmission);
        self.transmission = self.transmission.wrapping_add(1);
        header
            .enclose(&self.record, LIMIT, &mut out)
            .map_err(|error| error.to_string().into_boxed_str())?;
        Ok(out)
    }
}

/// The text before a NUL, of at most so many bytes. Bytes that are not UTF-8 become replacement characters.
pub(crate) fn text_of(bytes: &[u8], most: usize) -> String {
    let bytes = bytes.get(..most).unwrap_or(bytes);
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// The first bytes of a text, at most so many, whole characters.
pub(crate) fn first(text: &str, most: usize) -> Box<str> {
    let mut end = most.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    Box::from(&text[..end])
}
