//! Dollar signs inside what a client sends: in a text, or because the next sentence cut one short.

use crate::files::CALM;
use crate::payload::{ME, Payload};

/// The test computes the checksum itself, because it shares no code with the reader.
fn checked(body: &str) -> String {
    format!("${body}*{:02X}", body.bytes().fold(0, |sum, byte| sum ^ byte))
}

fn connected() -> Payload {
    let mut payload = Payload::connected(CALM, 1, &["ACK"]);
    payload.log();
    payload
}

// SPI 4.2 reserves comma and asterisk, but not the dollar sign, and operators write it.
#[test]
fn a_status_with_a_dollar_sign_is_acknowledged_in_pieces_of_any_size() {
    let status = checked("BPSTS,070000.000,1,battery $2 of $5");
    for piece in [1, 2, 7, status.len() + 2] {
        let mut payload = connected();
        for bytes in format!("{status}\r\n").as_bytes().chunks(piece) {
            payload.bytes(ME, bytes);
        }
        assert_eq!(payload.heard(), ["$BFACK,080000.000,STS,070000.000,0,2,0,"], "{piece}");
        assert!(
            !payload.log().iter().any(|line| line.contains("cut short")),
            "nothing was lost"
        );
    }
}

#[test]
fn a_status_that_follows_a_cut_sentence_is_acknowledged() {
    let status = checked("BPSTS,070000.000,1,battery $2 of $5");
    let mut payload = connected();
    payload.say(&format!("$BPRMB,0700$BPRMB,070000.000,90{status}"));
    assert_eq!(payload.heard(), ["$BFACK,080000.000,STS,070000.000,0,2,0,"]);
    let log = payload.log();
    assert!(log.iter().any(|line| line.contains("2 cut short")), "{log:?}");
}

// Nothing shows that this is one sentence: what begins at its last dollar sign is answered.
#[test]
fn without_a_checksum_a_dollar_sign_begins_a_new_sentence() {
    let mut payload = connected();
    payload.say("$BPSTS,070000.000,1,battery $5");
    let heard = payload.heard();
    assert_eq!(heard.len(), 1);
    assert!(
        heard[0].starts_with("$BFACK,080000.000,NAK,000000.000,0,0,0,"),
        "{heard:?}"
    );
}

// 7.14: a line of the payload's modem, with a checksum of its own.
#[test]
fn a_relayed_modem_line_is_accepted_as_a_whole() {
    let line = "$CCRXD,1,2,0,48656C6C6F*5B";
    let mut payload = connected();
    payload.say(&checked(&format!("BPTMR,070000.000,3,{line}")));
    assert_eq!(payload.heard(), ["$BFACK,080000.000,TMR,070000.000,0,2,0,"]);
    assert_eq!(
        payload.log(),
        [format!(
            "0.000 s: {ME} relays from the topside by acoustic modem: {line}"
        )]
    );
}
