use super::Step::{Hear, Never, Say, Until};
use super::{Section, World};

/// Section 9: low-level acoustic communications.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "9.1",
        says: "a timing window available to it for sending data",
        world: World::With(&[
            ("[start]", "depth_m = 10"),
            ("[mission]", "starts_after_s = 5000"),
            ("[acoustic]", "address = 7\nfirst_s = 10\nperiod_s = 60\nlength_s = 20"),
            (
                "[[acoustic.peers]]",
                "address = 3\neast_m = 1500\nnorth_m = 0\ndepth_m = 10\npackets = [{ first_s = 40, mode = 1, frames = [\"00FF\"] }]",
            ),
        ]),
        on: &["CMA"],
        talk: &[
            Until(9.9),
            Never("$BFCMA"),
            Until(10.0),
            Hear("$BFCMA,080010.000,080030.000,7,WHOIPSK"),
        ],
    },
    Section {
        number: "9.2",
        says: "notifying that the specified packet (Request ID) has been sent",
        world: World::With(&[
            ("[start]", "depth_m = 10"),
            ("[mission]", "starts_after_s = 5000"),
            ("[acoustic]", "address = 7\nfirst_s = 10\nperiod_s = 60\nlength_s = 20"),
            (
                "[[acoustic.peers]]",
                "address = 3\neast_m = 1500\nnorth_m = 0\ndepth_m = 10\npackets = [{ first_s = 40, mode = 1, frames = [\"00FF\"] }]",
            ),
        ]),
        on: &["CMA", "CPS", "ACK"],
        talk: &[
            Until(12.0),
            Say("$BPCPD,070000.000,41,3,1,1,1,00FF,,,,,,,"),
            Hear("$BFACK,080012.000,CPD,070000.000,0,2,0,"),
            Until(40.0),
            Hear("$BFCPS,0800"),
        ],
    },
    Section {
        number: "9.3",
        says: "The arrival time of the message as well as the source and destination",
        world: World::With(&[
            ("[start]", "depth_m = 10"),
            ("[mission]", "starts_after_s = 5000"),
            ("[acoustic]", "address = 7\nfirst_s = 10\nperiod_s = 60\nlength_s = 20"),
            (
                "[[acoustic.peers]]",
                "address = 3\neast_m = 1500\nnorth_m = 0\ndepth_m = 10\npackets = [{ first_s = 40, mode = 1, frames = [\"00FF\"] }]",
            ),
        ]),
        on: &["CPR"],
        talk: &[Until(60.0), Hear("$BFCPR,0800")],
    },
    Section {
        number: "9.4",
        says: "Any message sent to the vehicle outside of the provided windows will be ignored",
        world: World::With(&[
            ("[start]", "depth_m = 10"),
            ("[mission]", "starts_after_s = 5000"),
            ("[acoustic]", "address = 7\nfirst_s = 10\nperiod_s = 60\nlength_s = 20"),
            (
                "[[acoustic.peers]]",
                "address = 3\neast_m = 1500\nnorth_m = 0\ndepth_m = 10\npackets = [{ first_s = 40, mode = 1, frames = [\"00FF\"] }]",
            ),
        ]),
        on: &["CPS", "ACK"],
        talk: &[
            Until(5.0),
            Say("$BPCPD,070000.000,41,3,1,1,1,00FF,,,,,,,"),
            Hear("$BFACK,080005.000,CPD,070000.000,0,1,0,"),
            Until(60.0),
            Never("$BFCPS"),
        ],
    },
];
