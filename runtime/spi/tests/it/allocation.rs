use allocation_counter::measure;
use backseat_spi::{Framer, FromVehicle, Policy, Sentence, ToVehicle, catalogue};

use crate::Message;

/// Messages with a text or with frames: keeping those needs memory of its own.
const WITH_TEXT: [&str; 22] = [
    "BFMSC", "BFBDL", "BFSDL", "BFTOP", "BFVER", "BFMBS", "BFMBE", "BFMIS", "BFACK", "BFTRM", "BFBOY", "BFCMA",
    "BFCPR", "BPLOG", "BPSTS", "BPTOP", "BPTMR", "BPABT", "BPKIL", "BPMSG", "BPVER", "BPCPD",
];

#[test]
fn messages_without_text_are_decoded_without_allocation() {
    for entry in catalogue() {
        let sentence = Sentence::parse(entry.example).unwrap();
        let (mut from, mut to) = (None, None);
        let taken = measure(|| {
            from = Some(FromVehicle::decode(&sentence).is_ok());
            to = Some(ToVehicle::decode(&sentence).is_ok());
        });
        let own = measure(|| match entry.direction {
            backseat_spi::Direction::FromVehicle => drop(FromVehicle::decode(&sentence)),
            backseat_spi::Direction::ToVehicle => drop(ToVehicle::decode(&sentence)),
        });
        assert_eq!((from, to), (Some(true), Some(true)));
        // For the other direction the message is unknown, and it is kept.
        assert!(taken.count_total > 0);
        assert_eq!(
            own.count_total > 0,
            WITH_TEXT.contains(&entry.name),
            "{}: {own:?}",
            entry.name
        );
    }
}

#[test]
fn no_message_allocates_when_it_is_encoded_into_a_buffer_with_room() {
    let mut out = Vec::with_capacity(4096);
    for entry in catalogue() {
        let message = Message::example(entry);
        out.clear();
        let taken = measure(|| message.encode(&mut out));
        assert_eq!(taken.count_total, 0, "{}", entry.name);
        assert_eq!(out, format!("{}\r\n", entry.example).as_bytes());
    }
}

#[test]
fn a_framer_that_has_grown_takes_no_more_memory() {
    let stream: String = catalogue()
        .iter()
        .map(|entry| format!("{}\r\n", entry.example))
        .collect();
    let mut framer = Framer::new(Policy::FromVehicle);
    let mut sentences = 0;
    let mut pass = || {
        for piece in stream.as_bytes().chunks(700) {
            framer.push(piece);
            while framer.next_sentence().is_some() {
                sentences += 1;
            }
        }
    };
    pass();
    assert_eq!(measure(pass).count_total, 0);
    assert_eq!(sentences, 2 * catalogue().len());
}
