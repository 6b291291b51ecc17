use super::Step::{Forget, Hear, Never, Say, Until};
use super::{Section, World};

/// Section 4: the session.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "4.1",
        says: "all of which can connect to and disconnect from the server whenever and as often as they wish",
        world: World::Calm,
        on: &[],
        talk: &[
            Until(0.5),
            Never("$BFNVG"),
            Say("$BPLOG,NVG,ON"),
            Until(1.0),
            Hear("$BFNVG,080000.600,"),
            Hear("$BFNVG,080001.000,"),
        ],
    },
    Section {
        number: "4.2",
        says: "Messages sent by the payload may or may not include the checksum",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPMSG,070000.000,a"),
            Hear("$BFACK,080000.000,MSG,070000.000,0,2,0,"),
            Say("$BPMSG,070000.000,a*33"),
            Hear("$BFACK,080000.000,MSG,070000.000,0,2,0,"),
            Say("$BPMSG,070000.000,a*34"),
            Never("$BFACK"),
            // The vehicle ignores a field that the section does not have.
            Say("$BPEMB,070000.000,what may come one day"),
            Hear("$BFACK,080000.000,EMB,070000.000,0,2,0,"),
        ],
    },
    Section {
        number: "4.3",
        says: "By default, only command messages are sent from the vehicle to the payload",
        world: World::With(&[("[mission]", "shutdown_after_s = 62")]),
        on: &[],
        talk: &[Until(20.0), Hear("$BFSHT,080002.000"), Hear("$BFBDL,"), Never("$BF")],
    },
    Section {
        number: "4.4",
        says: "The second acknowledgement, which will be returned in at most 2 seconds",
        world: World::With(&[("[spi]", "acknowledge = \"pending\""), ("[spi]", "pending_s = 1.9")]),
        on: &["ACK"],
        talk: &[
            Until(5.0),
            Say("$BPRTK,070000.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0"),
            Hear("$BFACK,080005.000,RTK,070000.000,11,3,0,"),
            Until(7.0),
            Hear("$BFACK,080006.900,RTK,070000.000,11,2,0,"),
            Forget,
            Until(20.0),
            Never("$BFACK"),
        ],
    },
];
