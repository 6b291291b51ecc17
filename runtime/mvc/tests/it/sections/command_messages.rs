use super::Step::{Hear, Never, Say, Until};
use super::{Section, World};

/// Section 5: command messages from the vehicle.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "5.2",
        says: "at least 1 minute before the payload will be electrically shut down",
        world: World::With(&[("[mission]", "shutdown_after_s = 62")]),
        on: &["NVG"],
        talk: &[
            Until(1.9),
            Never("$BFSHT"),
            Until(2.0),
            Hear("$BFSHT,080002.000"),
            Until(80.0),
            Hear("$BFNVG,080101.900,"),
            Never("$BFNVG,080102.1"),
        ],
    },
    Section {
        number: "5.7",
        says: "The vehicle will send this message at the beginning of communications with the payload",
        world: World::Calm,
        on: &[],
        // It was heard at the connection, before the conversation; a payload's own is answered by nothing but its
        // acknowledgement.
        talk: &[
            Say("$BPLOG,ACK,ON"),
            Say("$BPVER,070000.000,1.12"),
            Hear("$BFACK,080000.000,VER,070000.000,0,2,0,"),
        ],
    },
];
