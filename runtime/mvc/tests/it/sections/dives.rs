use super::Step::{Forget, Hear, Is, Never, Operate, Say, Until};
use super::{Section, World};

/// A dive that is loaded a second after the one before and starts a second later, with a short plan of its own.
const FIRST: (&str, &str) = (
    "[[dive]]",
    "file = \"first.dive\"
load_after_s = 1
start_after_s = 1
log_dir = \"/logs/1\"
end_after_s = 20",
);
const SECOND: (&str, &str) = (
    "[[dive]]",
    "file = \"second.dive\"
load_after_s = 2
start_after_s = 3
log_dir = \"/logs/2\"
wrap_up = \"surface\"
abort_after_s = 20
[[dive.plan]]
kind = \"waypoint\"
at = { east_m = 50, north_m = 20 }
depth_m = 5
speed_mps = 2
[[dive.plan]]
kind = \"trackline\"
start = { east_m = 50, north_m = 20 }
end = { east_m = 350, north_m = 20 }
depth_m = 5
speed_mps = 2
dynamic = true",
);
/// Dives that only an operator loads and starts.
const ASKED: (&str, &str) = (
    "[[dive]]",
    "file = \"asked.dive\"
log_dir = \"/logs/asked\"",
);
const OTHER: (&str, &str) = (
    "[[dive]]",
    "file = \"other.dive\"
log_dir = \"\"
[[dive.plan]]
kind = \"waypoint\"
at = { east_m = 50, north_m = 20 }
depth_m = 5
speed_mps = 2",
);

/// Dives one after the other.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "6.11",
        says: "Currently defined mission status types include, but are not limited to “Offline”, “Waiting”",
        world: World::With(&[
            ("[mission]", "online_after_s = 2"),
            ("[interpretation]", "control_replay = true"),
            FIRST,
        ]),
        on: &[],
        talk: &[
            Until(1.0),
            Say("$BPLOG,MIS,ON"),
            Hear("$BFMIS,080001.000,,Offline,"),
            Until(2.0),
            Hear("$BFMIS,080002.000,,Waiting,"),
            Until(3.0),
            Hear("$BFMIS,080003.000,first.dive,Ready,"),
            Until(4.0),
            Hear("$BFMIS,080004.000,first.dive,Running /logs/1,"),
        ],
    },
    Section {
        number: "6.11",
        says: "“Invalid Dive File”, “Invalid Wrapup File”, “Ready”",
        world: World::With(&[
            (
                "[[dive]]",
                "file = \"broken.dive\"\nload_after_s = 1\ninvalid = \"dive\"",
            ),
            (
                "[[dive]]",
                "file = \"home.dive\"\nload_after_s = 2\ninvalid = \"wrapup\"",
            ),
            FIRST,
        ]),
        on: &["MIS", "ACK"],
        talk: &[
            Until(1.0),
            Hear("$BFMIS,080001.000,broken.dive,Invalid Dive File,the dive file cannot be read"),
            // There is no plan of it, and it never starts.
            Say("$BPRMP,070000.000"),
            Hear("$BFACK,080001.000,RMP,070000.000,0,3,0,"),
            Until(3.0),
            Hear("$BFACK,"),
            Forget,
            Until(3.1),
            Hear("$BFMIS,080003.100,home.dive,Invalid Wrapup File,the wrapup file cannot be read"),
            Until(4.2),
            Hear("$BFMIS,080004.200,first.dive,Ready,"),
            Until(5.2),
            Hear("$BFMIS,080005.200,first.dive,Running /logs/1,"),
        ],
    },
    Section {
        number: "6.11",
        says: "This message is sent when the mission status changes, such as when a mission starts or stops",
        world: World::With(&[FIRST, SECOND]),
        on: &["MIS"],
        talk: &[
            Until(60.0),
            Hear("$BFMIS,080001.000,first.dive,Ready,"),
            Hear("$BFMIS,080002.000,first.dive,Running /logs/1,"),
            Hear("$BFMIS,080022.000,first.dive,Completed,ended by the operator"),
            Hear("$BFMIS,080024.100,second.dive,Ready,"),
            Hear("$BFMIS,080027.100,second.dive,Running /logs/2,"),
            Hear("$BFMIS,080047.100,second.dive,Aborting,aborted by the operator"),
            Hear("$BFMIS,0800"),
            Never("$BFMIS,"),
        ],
    },
    Section {
        number: "6.9",
        says: "Current dive file. If current behavior has been requested by the payload, this field will be empty",
        world: World::With(&[FIRST, SECOND]),
        on: &["MBS", "MBE", "CTL"],
        talk: &[
            Until(60.0),
            Hear("$BFMBS,080002.000,first.dive,1,,trackline"),
            Hear("$BFCTL,080002.000,1"),
            Hear("$BFMBE,080022.000,first.dive,1,,trackline"),
            Hear("$BFCTL,080022.000,0"),
            Hear("$BFMBS,080027.100,second.dive,1,,waypoint"),
            Hear("$BFMBE,080047.100,second.dive,1,,waypoint"),
        ],
    },
    Section {
        number: "7.19",
        says: "request the currently-executing mission plan",
        world: World::With(&[FIRST, SECOND]),
        on: &["ACK"],
        talk: &[
            Until(5.0),
            Say("$BPRMP,070000.000"),
            Until(7.0),
            Hear("$BFPLN,080006"),
            Hear("$BFPLN,080006"),
            Hear("$BFPLN,080006"),
            Never("$BFPLN"),
            Hear("$BFACK,080006"),
            // The second dive has another plan, of which the payload can have the points before it starts.
            Until(25.0),
            Say("$BPRMP,070020.000"),
            Until(27.0),
            Hear("$BFPLN,08002"),
            Hear("$BFPLN,08002"),
            Hear("$BFPLN,08002"),
            Never("$BFPLN"),
        ],
    },
    Section {
        number: "6.11",
        says: "sent when the mission status changes",
        world: World::With(&[ASKED, OTHER]),
        on: &["MIS"],
        talk: &[
            Until(20.0),
            Never("$BFMIS"),
            Operate("load asked.dive", |mvc, now| mvc.load_dive(now, "asked.dive")),
            Hear("$BFMIS,080020.000,asked.dive,Ready,"),
            Until(30.0),
            Never("$BFMIS"),
            // Another one takes its place before it has started.
            Operate("load other.dive", |mvc, now| mvc.load_dive(now, "other.dive")),
            Hear("$BFMIS,080030.000,other.dive,Ready,"),
            Operate("start", |mvc, now| mvc.start_dive(now)),
            Hear("$BFMIS,080030.000,other.dive,Running,"),
            Until(40.0),
            Is("on its way to the east", |truth| truth.local.east_m > 2.0),
            Operate("abort", |mvc, now| mvc.abort_dive(now)),
            Hear("$BFMIS,080040.000,other.dive,Aborted,aborted by the operator"),
            Operate("load asked.dive", |mvc, now| mvc.load_dive(now, "asked.dive")),
            Operate("start", |mvc, now| mvc.start_dive(now)),
            Hear("$BFMIS,080040.000,asked.dive,Ready,"),
            Hear("$BFMIS,080040.000,asked.dive,Running /logs/asked,"),
            Until(60.0),
            Operate("end", |mvc, now| mvc.end_dive(now)),
            Hear("$BFMIS,080100.000,asked.dive,Completed,ended by the operator"),
            // The same dive once more.
            Operate("load asked.dive", |mvc, now| mvc.load_dive(now, "asked.dive")),
            Hear("$BFMIS,080100.000,asked.dive,Ready,"),
            Operate("take back", |mvc, now| mvc.abort_dive(now)),
            Hear("$BFMIS,080100.000,asked.dive,Aborted,aborted by the operator"),
        ],
    },
    Section {
        number: "7.5",
        says: "must be unique for all commands sent by the payload in this mission",
        world: World::With(&[ASKED]),
        on: &["ACK"],
        talk: &[
            Operate("load", |mvc, now| mvc.load_dive(now, "asked.dive")),
            Operate("start", |mvc, now| mvc.start_dive(now)),
            Until(5.0),
            Say("$BPRTK,070000.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0"),
            Hear("$BFACK,080005.000,RTK,070000.000,11,2,0,"),
            Operate("end", |mvc, now| mvc.end_dive(now)),
            Operate("load", |mvc, now| mvc.load_dive(now, "asked.dive")),
            Operate("start", |mvc, now| mvc.start_dive(now)),
            Until(6.0),
            // In another mission the identifier is free again.
            Say("$BPRTK,070001.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0"),
            Hear("$BFACK,080006.000,RTK,070001.000,11,2,0,"),
            Say("$BPRTK,070002.000,11,4218.1,N,07054.0,W,4218.2,N,07054.0,W,0,10,1.5,0,0"),
            Hear("$BFACK,080006.000,RTK,070002.000,11,1,0,the identifier has been used in this mission"),
        ],
    },
    Section {
        number: "7.20",
        says: "Start Empty Mission",
        world: World::With(&[
            ("[mission]", "empty_allowed = true"),
            ("[mission]", "online_after_s = 2"),
            ASKED,
        ]),
        on: &["ACK", "MIS"],
        talk: &[
            Until(1.0),
            Say("$BPSEM,070000.000,10,2"),
            Hear("$BFACK,080001.000,SEM,070000.000,0,1,0,the vehicle is offline"),
            Until(3.0),
            Hear("$BFMIS,080002.000,,Waiting,"),
            Say("$BPSEM,070003.000,10,2"),
            Hear("$BFMIS,080003.000,,Running /logs/survey,"),
            Until(14.0),
            Hear("$BFMIS,0800"),
            Operate("load", |mvc, now| mvc.load_dive(now, "asked.dive")),
            Hear("$BFMIS,080014.000,asked.dive,Ready,"),
        ],
    },
];
