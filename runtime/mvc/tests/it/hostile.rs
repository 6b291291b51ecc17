//! At worst a hostile client loses its own connection, and no other client loses anything (SPI 4.1: clients connect and
//! disconnect "whenever and as often as they wish without causing errors").

use backseat_mvc::ClientId;

use crate::files::CALM;
use crate::payload::{ME, Payload};

const FOE: ClientId = ClientId(66);

/// How many BFNVG the other client receives until then.
fn navigation(payload: &mut Payload, until_s: f64) -> usize {
    payload.heard();
    payload.until(until_s);
    payload.heard().iter().filter(|line| line.starts_with("$BFNVG")).count()
}

#[test]
fn ten_megabytes_without_a_line_end_are_noise() {
    let mut payload = Payload::connected(CALM, 1, &["NVG"]);
    payload.connect(FOE);
    payload.say_as(FOE, "$BPLOG,ACK,ON");
    payload.heard_by(FOE);
    payload.bytes(FOE, &vec![b'A'; 10 << 20]);
    let mut line = b"$BPMSG,070000.000,".to_vec();
    line.resize(10 << 20, b'x');
    payload.bytes(FOE, &line);
    assert_eq!(payload.heard_by(FOE), Vec::<String>::new());
    // The vehicle still understands the client after that, from the next dollar sign on.
    payload.bytes(FOE, b"\n$BPMSG,070000.000,sorry\n");
    assert_eq!(payload.heard_by(FOE).len(), 1);
    assert_eq!(navigation(&mut payload, 1.0), 10);
}

#[test]
fn oversized_fields_are_answered_and_not_obeyed() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.until(5.0);
    let (digits, letters) = ("9".repeat(4000), "x".repeat(4000));
    for sentence in [
        format!("$BPRMB,070000.000,{digits},3,0,1.5,1,0"),
        format!("$BPRTK,070000.000,{digits},4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0"),
        format!("$BPLOG,{letters},ON"),
        format!("$BP{letters},070000.000"),
        format!("$BPMSG,{letters}"),
        format!("$BPRMB{}", ",".repeat(4000)),
    ] {
        payload.say(&sentence);
        let heard = payload.heard();
        assert!(
            heard.len() == 1 && heard[0].starts_with("$BFACK"),
            "{sentence:.40}: {heard:?}"
        );
        let status = heard[0].split(',').nth(5).unwrap();
        assert!(status == "0" && heard[0].len() < 300, "{sentence:.40}: {heard:?}");
    }
}

#[test]
fn thousands_of_requests_of_one_client_do_not_block_the_others() {
    let text = CALM.replace("acknowledge = \"immediate\"", "pending_s = 1.9");
    let mut payload = Payload::connected(&text, 1, &["ACK"]);
    payload.connect(FOE);
    payload.say_as(FOE, "$BPLOG,ACK,ON");
    payload.until(5.0);
    for id in 0..5000 {
        payload.say_as(FOE, &format!("$BPRCN,070000.000,{}", id + 1));
    }
    let answers = payload.heard_by(FOE);
    let refused = answers
        .iter()
        .filter(|line| line.ends_with("too many requests are pending"));
    assert_eq!(refused.count(), 5000 - 64);
    payload.heard();
    payload.say("$BPRTK,070000.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0");
    assert_eq!(payload.heard(), ["$BFACK,080005.000,RTK,070000.000,11,3,0,"]);
    // SPI 4.4: the outcome comes within 2 s, however much others ask.
    payload.until(7.0);
    assert_eq!(payload.heard(), ["$BFACK,080006.900,RTK,070000.000,11,2,0,"]);
}

#[test]
fn storms_of_connections_leave_nothing_behind() {
    let mut payload = Payload::connected(CALM, 1, &["NVG"]);
    for count in 0..20_000 {
        let client = ClientId(100 + count);
        payload.connect(client);
        payload.bytes(client, b"$BPLOG,ALL,ON\r\n$BPRMP,070000.000\r\n$BPLO");
        if count % 3 != 0 {
            payload.mvc.disconnect(payload.now, client);
        }
        if count % 3 == 0 {
            // The same client number connects again: the old connection is forgotten.
            payload.connect(client);
            payload.mvc.disconnect(payload.now, client);
        }
        payload.heard_by(client);
    }
    assert_eq!(payload.cut_off, []);
    assert_eq!(navigation(&mut payload, 1.0), 10);
    payload.connect(FOE);
    assert_eq!(payload.heard_by(FOE).len(), 1);
}

#[test]
fn every_byte_value_between_sentences_does_no_harm() {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    for byte in 0..=255u8 {
        payload.bytes(ME, &[byte, byte, b'\n']);
        payload.bytes(ME, &[b'$', byte, b',', byte, b'\n']);
        payload.heard();
        payload.say("$BPMSG,070000.000,x");
        assert_eq!(payload.heard(), ["$BFACK,080000.000,MSG,070000.000,0,2,0,"], "{byte}");
    }
}
