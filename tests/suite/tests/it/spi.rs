//! The tools for the interface: its catalogue, recordings, hand-written messages, a live vehicle.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};

use backseat_suite::{Backseat, Mission};
use serde_json::Value;

/// Every kind of fault in recordings of real traffic: text of a console, line ends of all kinds, blank lines, a
/// checksum of one digit, a missing and a wrong one, bytes that are not UTF-8, an unknown name, a sentence cut short by
/// the next one, a value out of range, a line without an end, and a cut at the end.
fn nasty() -> Vec<u8> {
    let mut recording = b"VxWorks login: \r\n\
        $BFVER,081025.000,1.11*4A\r\n\n\
        $BPLOG,NVG,ON\n\
        $BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E\r\n\
        $BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*5b\r\n\
        \xff\xfe\x00$BFCTL,081025.987,1*78\r\r\n\
        $BFMSC,081025.987,lev\xe9\r\n\
        $BFXYZ,1,2,3\r\n\
        $BFNVG,0810$BFSHT,081025.987*71\r\n\
        $BPSPD,081025.987,fast\n"
        .to_vec();
    recording.extend_from_slice(b"$BFIMU,");
    recording.resize(recording.len() + (10 << 20), b'7');
    recording.extend_from_slice(b"\r\n$BPRMP,081025.987*67\r\n$BFMIS,0810");
    recording
}

pub(crate) fn objects(stdout: &str) -> Vec<Value> {
    stdout
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}")))
        .collect()
}

#[test]
fn list_has_a_line_for_each_message_and_says_nothing_else() {
    let list = Backseat::new().args(["spi", "list"]).run().exit(0);
    assert_eq!((list.stdout.lines().count(), list.stderr.as_str()), (71, ""), "{list}");
    let navigation = list.stdout.lines().find(|line| line.starts_with("BFNVG")).unwrap();
    for part in ["6.1", "from vehicle", "navigation update", "depth (m"] {
        assert!(navigation.contains(part), "{navigation}");
    }
    let json = Backseat::new().args(["spi", "list", "--json"]).run().exit(0);
    let rows = objects(&json.stdout);
    assert_eq!(rows.len(), 71);
    assert!(
        rows.iter()
            .all(|row| row["section"].is_string() && row["fields"][0]["unit"].is_string())
    );
}

#[test]
fn list_shows_one_message_whole() {
    let one = Backseat::new().args(["spi", "list", "RMB"]).run().exit(0);
    for part in [
        "BPRMB",
        "SPI 7.12",
        "$BPRMB,081025.987,90,3,0,1.5,1,0*54",
        "vertical_mode",
        "range",
    ] {
        assert!(one.stdout.contains(part), "{part}: {one}");
    }
    let line = Backseat::new().args(["spi", "list", "XYZ"]).run().refusal();
    assert!(
        line.contains("unknown message \"XYZ\"") && line.contains("spi list"),
        "{line}"
    );
}

#[test]
fn decode_drops_no_sentence_of_a_nasty_recording() {
    let mission = Mission::steady();
    let file = mission.beside("recording.raw");
    std::fs::write(&file, nasty()).unwrap();
    let decoded = Backseat::new()
        .args(["spi", "decode", "--json"])
        .arg(&file)
        .run()
        .exit(0);
    let said: Vec<_> = objects(&decoded.stdout)
        .into_iter()
        .map(|object| {
            assert!(object["message"].is_object() != object["error"].is_string(), "{object}");
            let text = |key: &str| object[key].as_str().unwrap_or("").to_owned();
            (text("name"), text("checksum"), text("error"))
        })
        .collect();
    let said: Vec<_> = said
        .iter()
        .map(|(name, sum, error)| (name.as_str(), sum.as_str(), error.as_str()))
        .collect();
    assert_eq!(
        said,
        [
            ("BFVER", "valid", ""),
            ("BPLOG", "absent", ""),
            ("BFNVG", "valid", ""),
            ("BFNVG", "invalid", "checksum \"5b\" is wrong: 4E is right"),
            ("BFCTL", "valid", ""),
            ("BFMSC", "absent", "not utf-8 from byte 21 on"),
            ("BFXYZ", "absent", "unknown message"),
            (
                "BFNVG",
                "absent",
                "cut short: the next sentence begins before the line ends"
            ),
            ("BFSHT", "valid", ""),
            (
                "BPSPD",
                "absent",
                "BPSPD field 2 (speed_mps) \"fast\": expected a plain decimal number of at most 1e9, without exponent"
            ),
            ("BPRMP", "valid", ""),
            ("BFMIS", "absent", "cut off: the input ends before the line does"),
        ]
    );
    let summary = decoded.stderr.trim_end();
    assert!(!summary.contains('\n'), "{summary}");
    for part in [
        "12 sentences, 6 read",
        "1 with a wrong checksum",
        "1 over 4352 bytes",
        "bytes of noise",
    ] {
        assert!(summary.contains(part), "{part}: {summary}");
    }
    let text = Backseat::new()
        .args(["spi", "decode", "-"])
        .stdin(nasty())
        .run()
        .exit(0);
    assert_eq!(text.stdout.lines().count(), 12);
    let depth = "BFNVG  navigation update: created 08:10:25.987, position 42.363515 N 71.114101 W, quality gps, \
                 altitude 45.3 m, depth 20.1 m";
    assert!(text.stdout.contains(depth), "{}", text.stdout);
    assert!(!text.stdout.contains('\u{1b}'), "no colours into a file");
}

#[test]
fn decode_and_encode_are_each_others_reverse_for_every_message() {
    let examples: String = backseat_spi::catalogue()
        .iter()
        .map(|entry| format!("{}\r\n", entry.example))
        .collect();
    let decode = |input: &str| {
        let decoded = Backseat::new()
            .args(["spi", "decode", "--json", "-"])
            .stdin(input)
            .run();
        decoded.exit(0).stdout
    };
    let decoded = decode(&examples);
    assert_eq!(decoded.lines().count(), 71);
    let encoded = Backseat::new()
        .args(["spi", "encode"])
        .stdin(decoded.as_str())
        .run()
        .exit(0);
    assert_eq!(
        (encoded.stdout.as_str(), encoded.stderr.as_str()),
        (examples.as_str(), "")
    );
    assert_eq!(decode(&encoded.stdout), decoded);
}

#[test]
fn encode_stops_at_what_is_wrong_and_says_where() {
    let good = r#"{"name":"BPRMP","message":{"created":"08:10:25.987"}}"#;
    for (bad, said) in [
        (
            r#"{"name":"BPSPD","message":{"created":"08:10:25","speed_mps":"1"}}"#,
            "line 2: BPSPD field speed_mps: ",
        ),
        (
            r#"{"name":"BPMSG","message":{"created":"08:10:25","text":"a,b"}}"#,
            "line 2: BPMSG field text: character ','",
        ),
        (r#"{"name":"BPXYZ","message":{}}"#, "line 2: unknown message \"BPXYZ\""),
        ("rubbish", "line 2 column 1: "),
    ] {
        let input = format!("{good}\n{bad}\n{good}\n");
        let ended = Backseat::new().args(["spi", "encode", "-"]).stdin(input).run().exit(2);
        assert_eq!(ended.stdout, "$BPRMP,081025.987*67\r\n", "{bad}");
        let line = ended.stderr.trim_end();
        assert!(
            line.starts_with("error: standard input: ") && line.contains(said) && !line.contains('\n'),
            "{line}"
        );
    }
}

#[test]
fn what_cannot_be_read_or_reached_is_named() {
    let line = Backseat::new().args(["spi", "decode", "no/such/file"]).run().refusal();
    assert!(line.contains("no/such/file: No such file"), "{line}");
    let line = Backseat::new().args(["spi", "encode", "no/such/file"]).run().refusal();
    assert!(line.contains("no/such/file"), "{line}");
    for (arguments, said) in [
        (
            ["host:port", "--json"],
            "invalid address \"host:port\": expected HOST or HOST:PORT",
        ),
        (["127.0.0.1", "--only=NVX"], "--only: unknown message \"NVX\""),
        (["127.0.0.1", "--only=RMB"], "RMB goes to the vehicle"),
    ] {
        let line = Backseat::new().args(["spi", "connect"]).args(arguments).run().refusal();
        assert!(line.contains(said), "{line}");
    }
}

#[test]
fn a_reader_that_goes_away_ends_decode_quietly() {
    let mut decode = Command::new(backseat_test_support::program())
        .args(["spi", "decode", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = decode.stdin.take().unwrap();
    // Input from a pipe that stays open is shown as it arrives.
    input.write_all(b"$BFCTL,081025.987,1*78\r\n").unwrap();
    let mut output = BufReader::new(decode.stdout.take().unwrap());
    let mut line = String::new();
    output.read_line(&mut line).unwrap();
    assert_eq!(line, "BFCTL  backseat control: created 08:10:25.987, granted yes\n");
    drop(output);
    // It ends by itself at the next line that it cannot write, which may be before it has read all of these.
    let more = "$BFCTL,081025.987,1*78\r\n".repeat(10_000);
    let _it_may_have_ended = input.write_all(more.as_bytes());
    drop(input);
    let status = decode.wait().unwrap();
    let mut said = String::new();
    decode.stderr.unwrap().read_to_string(&mut said).unwrap();
    assert_eq!((status.code(), said.as_str()), (Some(0), ""));
}
