use super::Step::{Hear, Never, Say, Until};
use super::{Section, World};

/// What the specification leaves open, or what vehicles in the field do against it.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "6.21",
        says: "Invalid Request (unknown message, or improper parameters)",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPXYZ,070000.000,1"),
            Hear("$BFACK,080000.000,NAK,000000.000,0,0,0,BPXYZ is no command"),
        ],
    },
    Section {
        number: "6.21",
        says: "Name of payload command being acknowledged",
        world: World::With(&[("[interpretation]", "unknown_command = \"name\"")]),
        on: &["ACK"],
        talk: &[
            Say("$BPXYZ,070000.25,1"),
            Hear("$BFACK,080000.000,XYZ,070000.250,0,0,0,BPXYZ is no command"),
            Say("$BPXYZ"),
            Hear("$BFACK,080000.000,XYZ,000000.000,0,0,0,BPXYZ is no command"),
            Say("$BPXYZ,what"),
            Hear("$BFACK,080000.000,XYZ,000000.000,0,0,0,BPXYZ is no command"),
            // A name of other than three letters does not fit there.
            Say("$GPGGA,070001.000"),
            Hear("$BFACK,080000.000,NAK,000000.000,0,0,0,GPGGA is no command"),
        ],
    },
    Section {
        number: "6.21",
        says: "the Bluefin vehicle will respond to each payload command with an acknowledgement",
        world: World::With(&[("[interpretation]", "broken_line = \"nak\"")]),
        on: &["ACK"],
        talk: &[
            // Each broken line is answered in its turn between the good ones; an empty line is not one.
            Say("$BPMSG,070000.000,a\r\n \r\nBPMSG,070001.000,b\r\n$,c\r\n\r\n\n$BPMSG,070002.000,d"),
            Hear("$BFACK,080000.000,MSG,070000.000,0,2,0,"),
            Hear("$BFACK,080000.000,NAK,000000.000,0,0,0,no header of a command matches this line"),
            Hear("$BFACK,080000.000,NAK,000000.000,0,0,0,no header of a command matches this line"),
            Hear("$BFACK,080000.000,NAK,000000.000,0,0,0,no header of a command matches this line"),
            Hear("$BFACK,080000.000,MSG,070002.000,0,2,0,"),
            Never("$BFACK"),
            // What is before a sentence on its line, and a wrong checksum, are not answered.
            Say("noise $BPMSG,070003.000,e"),
            Hear("$BFACK,080000.000,MSG,070003.000,0,2,0,"),
            Say("$BPMSG,070004.000,f*00"),
            Never("$BFACK"),
        ],
    },
    Section {
        number: "7.1",
        says: "The special keyword ALL can also be used to turn on or off all messages",
        world: World::With(&[("[interpretation]", "all_topics = \"navigation\"")]),
        on: &[],
        talk: &[
            Say("$BPLOG,ALL,ON"),
            Hear("$BFACK,080000.000,LOG,000000.000,0,2,0,"),
            Until(0.1),
            Hear("$BFNVG,080000.100"),
            Hear("$BFNVR,080000.100"),
            Until(2.0),
            Never("$BFCTD"),
            Never("$BFMIS"),
            Never("$BFCTL"),
            Say("$BPLOG,ALL,OFF"),
            Until(2.1),
            Never("$BFNVG,080002.1"),
        ],
    },
    Section {
        number: "7.2",
        says: "Variable length textual status message",
        world: World::With(&[("[spi]", "acknowledge_text = \"request successfully processed\"")]),
        on: &["ACK"],
        talk: &[
            Say("$BPSTS,070000.25,1,all ok"),
            Hear("$BFACK,080000.000,STS,070000.250,0,2,0,request successfully processed"),
            // What has a text of its own keeps it.
            Say("$BPRCA,070001.000"),
            Hear("$BFACK,080000.000,RCA,070001.000,0,2,0,0 cancelled"),
        ],
    },
    Section {
        number: "6.16",
        says: "Variable precision pressure (kPa)",
        world: World::With(&[("[sensors]", "ctd_period_s = 2"), ("[start]", "depth_m = 10")]),
        on: &["CTD"],
        talk: &[Until(2.0), Hear("$BFCTD,080002.000,40000,12,202.")],
    },
    Section {
        number: "6.16",
        says: "Variable precision pressure (kPa)",
        world: World::With(&[
            ("[sensors]", "ctd_period_s = 2"),
            ("[start]", "depth_m = 10"),
            ("[interpretation]", "ctd_pressure = \"gauge\""),
        ]),
        on: &["CTD"],
        talk: &[Until(2.0), Hear("$BFCTD,080002.000,40000,12,100.")],
    },
    Section {
        number: "7.15",
        says: "so that the payload can send CTD data to the vehicle to aid in navigation",
        world: World::With(&[("[interpretation]", "ctd_pressure = \"gauge\"")]),
        on: &["ACK"],
        talk: &[
            // At the surface the noise of a sensor makes it less than nothing.
            Say("$BPCTD,080000.000,40000,12,-0.5,080000.000"),
            Hear("$BFACK,080000.000,CTD,080000.000,0,2,0,"),
        ],
    },
    Section {
        number: "7.15",
        says: "so that the payload can send CTD data to the vehicle to aid in navigation",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPCTD,080000.000,40000,12,-0.5,080000.000"),
            Hear("$BFACK,080000.000,CTD,080000.000,0,0,0,pressure -0.5: expected 0 to 150000 kPa"),
        ],
    },
];
