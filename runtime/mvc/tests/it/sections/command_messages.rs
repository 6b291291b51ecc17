use super::Step::{Hear, Never, Say, Until};
use super::{Section, World};

/// Section 5: command messages from the vehicle.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "5.1",
        says: "Arbitrary textual message. Semantics determined by the payload",
        world: World::With(&[
            ("[[plan]]", "kind = \"command\"\ntext = \"sonar on\""),
            ("[mission]", "time_limit_s = 900"),
        ]),
        on: &[],
        talk: &[Until(1.0), Never("$BFMSC"), Until(400.0), Hear("$BFMSC,08")],
    },
    Section {
        number: "5.3",
        says: "when beginning the lead-in trackline",
        world: World::With(&[("kind = \"trackline\"", "payload_message = \"line 3\"")]),
        on: &["MBS"],
        talk: &[
            Until(0.9),
            Never("$BFBDL"),
            Until(30.0),
            Hear("$BFMBS,080001.000"),
            Hear("$BFBDL,0800"),
        ],
    },
    Section {
        number: "5.4",
        says: "after the lead-out trackline has completed",
        world: World::With(&[("kind = \"trackline\"", "payload_message = \"line 3\"")]),
        on: &["MBE"],
        talk: &[Until(150.0), Never("$BFSDL"), Until(240.0), Hear("$BFSDL,0803")],
    },
    Section {
        number: "5.5",
        says: "Delivery of a message sent from the topside",
        world: World::With(&[(
            "[[topside.messages]]",
            "at_s = 3\ntransport = \"acoustic-modem\"\ntext = \"come home\"",
        )]),
        on: &[],
        talk: &[
            Until(2.9),
            Never("$BFTOP"),
            Until(3.1),
            Hear("$BFTOP,080003.000,3,come home"),
        ],
    },
    Section {
        number: "5.6",
        says: "0 = The payload should cease external triggering 1 = The payload may begin external triggering",
        world: World::With(&[("[dvl]", "safe_after_s = 1\nstop_at_s = [20]")]),
        on: &[],
        talk: &[
            Until(1.0),
            Say("$BPDVR,070000.000,1,0"),
            Until(2.0),
            Hear("$BFDVT,080002.000,1"),
            Say("$BPDVR,070001.000,1,1"),
            Until(20.0),
            Hear("$BFDVT,080020.000,0"),
        ],
    },
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
        talk: &[
            Hear("$BFVER,080000.000,1.12"),
            Say("$BPLOG,ACK,ON"),
            Say("$BPVER,070000.000,1.12"),
            Hear("$BFACK,080000.000,VER,070000.000,0,2,0,"),
        ],
    },
];
