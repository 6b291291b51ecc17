//! The seeds of the 7k targets: each record type, each text of appendix C, files and streams. They are generated, and
//! this test holds them to the code.

use std::fs;
use std::path::Path;

use backseat_s7k::file::{FileInfo, FileWriter};
use backseat_s7k::plc::{TextKind, texts};
use backseat_s7k::record::{BluefinRecord, HeaderLayout, NavigationFrame};
use backseat_s7k::record::{Channel, ChannelHeader, Imagery, ImageryHeader, SampleFormat, SideScanHeader};
use backseat_s7k::{BluefinChecksum, DeviceId, Frame, FrameHeader, FrameWriter, NetworkHeader, Time7k};

/// Writes the seeds in place of comparing them: `BACKSEAT_WRITE_SEEDS=1 cargo test -p backseat-fuzz`.
const WRITE: &str = "BACKSEAT_WRITE_SEEDS";

fn seed(target: &str, name: &str, bytes: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("corpus")
        .join(target)
        .join(name);
    if std::env::var_os(WRITE).is_some() {
        fs::write(&path, bytes).expect("the corpus can be written");
    }
    assert_eq!(fs::read(&path).expect(name), bytes, "{target}/{name}");
}

fn framed(record_type: u32, body: &[u8], optional: Option<(u32, &[u8])>) -> Vec<u8> {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(record_type, DeviceId(11_001)), &mut out);
    frame.bytes().extend_from_slice(body);
    if let Some((id, bytes)) = optional {
        frame.begin_optional(id);
        frame.bytes().extend_from_slice(bytes);
    }
    frame.finish(1 << 20).expect("it is short");
    out
}

/// Imagery of two channels of six samples.
fn imagery(layout: HeaderLayout, format: SampleFormat, bytes_per_sample: u8) -> Vec<u8> {
    let header = ImageryHeader {
        time_ms: 1,
        ping: 2,
        channels: 0,
        channel_bytes: 0,
        data_format: format,
    };
    let mut channel = ChannelHeader::read(&[0; ChannelHeader::SIZE]).expect("it is whole");
    (channel.samples, channel.bytes_per_sample) = (6, bytes_per_sample);
    let bytes: Vec<u8> = (0..6 * bytes_per_sample).collect();
    let channels = [Channel {
        header: channel,
        bytes: &bytes,
    }; 2];
    let mut body = Vec::new();
    Imagery::compose(header, layout, &channels, 160, &mut body).expect("the channels fit");
    body
}

/// A record of each type.
fn bodies() -> Vec<(u32, &'static str, Vec<u8>)> {
    let mut navigation = Vec::new();
    let frames = [(Time7k::NONE, NavigationFrame::default()); 2];
    BluefinRecord::compose_navigation(5, &frames, BluefinChecksum::WholePacket, &mut navigation).expect("two are few");
    vec![
        (3000, "sidescan", imagery(HeaderLayout::Spec, SampleFormat::Envelope, 2)),
        (
            3000,
            "sidescan_padded",
            imagery(HeaderLayout::Padded, SampleFormat::Envelope, 1),
        ),
        (
            3001,
            "sub_bottom",
            imagery(HeaderLayout::Spec, SampleFormat::Complex, 4),
        ),
        (3100, "bluefin", navigation),
        (7200, "file_header", vec![0; 316]),
        (7300, "catalog", vec![0; 14]),
        (7400, "time", vec![0; 16]),
        (
            11_000,
            "command",
            [&[255, 255, 255, 255, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0][..], b"1"].concat(),
        ),
        (11_001, "acknowledge", vec![1, 0, 0, 0, 255, 255, 255, 255, 1, 0, 0, 0]),
        (11_002, "message", [&[0; 12][..], &[6, 0, 0, 0], b"1.0203"].concat()),
        (9000, "other", b"another record".to_vec()),
    ]
}

#[test]
fn each_record_type_has_a_seed() {
    for (record_type, name, body) in bodies() {
        let optional = matches!(record_type, 3000 | 3001).then_some((1, &[7; SideScanHeader::SIZE * 2][..]));
        seed("s7k_frame", name, &framed(record_type, &body, optional));
        seed("s7k_record", name, &[&[0][..], &body].concat());
    }
}

#[test]
fn each_text_of_appendix_c_has_a_seed() {
    for entry in texts() {
        let kind = match entry.kind {
            TextKind::Command => "command",
            TextKind::Generic => "generic",
            TextKind::Status => "status",
            TextKind::Alarm => "alarm",
        };
        let id = u8::try_from(entry.id).expect("numbers are below 32");
        let name = format!("{kind}_{id:02}_{}", entry.name.to_ascii_lowercase());
        seed("s7k_text", &name, &[&[id][..], entry.example.as_bytes()].concat());
    }
}

#[test]
fn files_and_streams_have_seeds() {
    let records: Vec<Vec<u8>> = bodies()
        .iter()
        .filter(|(number, _, _)| *number < 7000 || *number > 8000)
        .map(|(number, _, body)| framed(*number, body, None))
        .collect();
    let mut writer =
        FileWriter::create(std::io::Cursor::new(Vec::new()), FileInfo::default(), Time7k::NONE).expect("memory");
    for record in &records {
        writer
            .write(&Frame::read(record, 1 << 20).expect("it was written as one"))
            .expect("memory");
    }
    let file = writer.finish(Time7k::NONE).expect("memory").into_inner();
    seed("s7k_file", "closed", &file);
    seed("s7k_file", "cut", &file[..file.len() - 300]);
    let mut damaged = file.clone();
    damaged[500..520].fill(0xAA);
    seed("s7k_file", "damaged", &damaged);
    for (name, packet_max) in [("whole", 4000), ("fragmented", 100), ("tiny", 41)] {
        let mut stream = b"\x03\x50\x07\xFF\x01\x20\x90\x11".to_vec();
        for (number, record) in (0..).zip(&records) {
            NetworkHeader::new(DeviceId(1), number)
                .enclose(record, packet_max, &mut stream)
                .expect("it is short");
        }
        seed("s7k_stream", name, &stream);
    }
    seed("s7k_stream", "bare", &[&[9; 8][..], &records.concat()].concat());
}
