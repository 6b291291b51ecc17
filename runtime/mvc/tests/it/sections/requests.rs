use super::Step::{Becomes, Forget, Hear, Is, Never, Say, Until};
use super::{Section, World};

/// A line of 180 m beside the plan's, and one far away.
const LINE_11: &str = "$BPRTK,070000.000,11,4218.05,N,07053.98,W,4218.06,N,07053.98,W,0,10,2,0,0";
const LINE_12: &str = "$BPRTK,070000.000,12,4218.05,N,07053.98,W,4218.06,N,07053.98,W,0,10,2,0,0";
const LINE_13_INTERRUPTS: &str = "$BPRTK,070000.000,13,4218.05,N,07053.98,W,4218.06,N,07053.98,W,0,10,2,0,4";
const LINE_14_INTERRUPTS: &str = "$BPRTK,070000.000,14,4218.05,N,07053.98,W,4218.06,N,07053.98,W,0,10,2,0,4";

/// Section 7: messages from the payload.
pub(crate) const SECTIONS: &[Section] = &[
    Section {
        number: "7.1",
        says: "The special keyword ALL can also be used to turn on or off all messages (with the exception of BFACTION)",
        world: World::Calm,
        on: &[],
        talk: &[
            Say("$BPLOG,ALL,ON"),
            Never("$BFACK"),
            Until(2.0),
            Hear("$BFMIS"),
            Hear("$BFNVG,080001.000"),
            Hear("$BFNVR,080001.000"),
            Say("$BPLOG,ALL,OFF"),
            Forget,
            Until(4.0),
            Never("$BF"),
            Say("$BPLOG,ACK,ON"),
            Hear("$BFACK,080004.000,LOG,000000.000,0,2,0,"),
            Say("$BPLOG,ALL,OFF"),
            Hear("$BFACK,080004.000,LOG,000000.000,0,2,0,"),
        ],
    },
    Section {
        number: "7.2",
        says: "Status flag. 0 = Failed, 1 = All OK",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPSTS,070000.000,0,the sonar is off"),
            Hear("$BFACK,080000.000,STS,070000.000,0,2,0,"),
            Say("$BPSTS,070000.000,2,what"),
            Hear("$BFACK,080000.000,STS,000000.000,0,0,0,"),
        ],
    },
    Section {
        number: "7.5",
        says: "the new trackline will be inserted at the end of the current planned (not dynamic) survey leg",
        world: World::Calm,
        on: &["ACK", "MBS", "MBE"],
        talk: &[
            Until(5.0),
            Say(LINE_11),
            Hear("$BFACK,080005.000,RTK,070000.000,11,2,0,"),
            Until(195.0),
            Forget,
            Until(450.0),
            Hear("$BFMBE,0803"),
            Hear("$BFMBS,0803"),
            Hear("$BFMBE,080"),
            Hear("$BFMBS,080"),
        ],
    },
    Section {
        number: "7.5",
        says: "it is not possible to interrupt an interruption",
        world: World::Calm,
        on: &["ACK", "MBS", "MBE"],
        talk: &[
            Until(5.0),
            Say(LINE_13_INTERRUPTS),
            Hear("$BFMBE,080005.000,survey.dive,1,,trackline"),
            Hear("$BFMBS,080005.000,,,13,trackline"),
            Say(LINE_14_INTERRUPTS),
            Hear("$BFACK,080005.000,RTK,070000.000,14,1,0,"),
            Say(LINE_12),
            Hear("$BFACK,080005.000,RTK,070000.000,12,2,0,"),
            Until(300.0),
            // The remaining ones are completed as well, then the vehicle proceeds to the next behavior.
            Hear("$BFMBS,080"),
            Hear("$BFMBS,080"),
        ],
    },
    Section {
        number: "7.6",
        says: "Positive indicates clockwise traversal, negative indicates counterclockwise",
        world: World::Calm,
        on: &["ACK", "MBS"],
        talk: &[
            Until(5.0),
            Say("$BPRTC,070000.000,21,4218.05,N,07054.0,W,30,-1.5,0,10,2,0,90,4"),
            Hear("$BFACK,080005.000,RTC,070000.000,21,2,0,"),
            Hear("$BFMBS,080005.000,,,21,trackcircle"),
            Becomes(120.0, "flies north at the circle's east", |truth| {
                truth.local.east_m > 20.0 && truth.heading_deg.min(360.0 - truth.heading_deg) < 40.0
            }),
        ],
    },
    Section {
        number: "7.8",
        says: "If the behavior has already begun executing, it is not possible to cancel it in this way",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Until(5.0),
            Say(LINE_11),
            Say("$BPRCN,070000.001,11"),
            Hear("$BFACK,080005.000,RCN,070000.001,11,2,0,"),
            Say("$BPRCN,070000.002,11"),
            Hear("$BFACK,080005.000,RCN,070000.002,11,1,0,"),
            Say(LINE_13_INTERRUPTS),
            Say("$BPRCN,070000.003,13"),
            Hear("$BFACK,080005.000,RCN,070000.003,13,1,0,"),
        ],
    },
    Section {
        number: "7.9",
        says: "Cancel All Requested Behaviors",
        world: World::Calm,
        on: &["ACK", "MBS"],
        talk: &[
            Until(5.0),
            Say(LINE_11),
            Say(LINE_12),
            Say("$BPRCA,070000.001"),
            Hear("$BFACK,080005.000,RCA,070000.001,0,2,0,"),
            Until(260.0),
            Never("$BFMBS,0803:"),
            Hear("$BFMBS,0803"),
        ],
    },
    Section {
        number: "7.10",
        says: "Control passes immediately to the next behavior in the mission",
        world: World::Calm,
        on: &["ACK", "MBS", "MBE"],
        talk: &[
            Until(5.0),
            Say("$BPRCB,070000.001,"),
            Hear("$BFMBE,080005.000,survey.dive,1,,trackline"),
            Hear("$BFMBS,080005.000,survey.dive,2,,waypoint"),
            Say("$BPRCB,070000.002,3"),
            Hear("$BFACK,080005.000,RCB,"),
        ],
    },
    Section {
        number: "7.11",
        says: "Control passes immediately to the next element in the mission",
        world: World::Calm,
        on: &["ACK", "MBS", "MBE"],
        talk: &[
            Until(5.0),
            Say("$BPRCE,070000.001,0"),
            Hear("$BFMBE,080005.000,survey.dive,1,,trackline"),
            Hear("$BFMBS,080005.000,survey.dive,2,,waypoint"),
        ],
    },
    Section {
        number: "7.12",
        says: "must be sent at least every 5 seconds or the Bluefin vehicle will resume control of the mission",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Until(10.0),
            Say("$BPRMB,070000.001,90,15,0,1.5,1,0"),
            Hear("$BFACK,080010.000,RMB,070000.001,0,2,0,"),
            Until(14.9),
            Say("$BPRMB,070000.002,90,15,0,1.5,1,0"),
            Until(19.8),
            Is("it heads east", |truth| (truth.heading_deg - 90.0).abs() < 10.0),
            Until(40.0),
            Is("it is back on its way north", |truth| {
                truth.heading_deg > 270.0 || truth.heading_deg < 45.0
            }),
        ],
    },
    Section {
        number: "7.12",
        says: "acknowledged with a failure response if acknowledgements are enabled",
        world: World::With(&[("[mission]", "starts_after_s = 60")]),
        on: &["ACK"],
        talk: &[
            Say("$BPRMB,070000.001,90,15,0,1.5,1,0"),
            Hear("$BFACK,080000.000,RMB,070000.001,0,1,0,"),
        ],
    },
    Section {
        number: "7.13",
        says: "it no longer intends to modify the current behavior",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Until(10.0),
            Say("$BPRMB,070000.001,90,15,0,1.5,1,0"),
            Until(13.0),
            Say("$BPEMB,070000.002"),
            Hear("$BFACK,080013.000,EMB,070000.002,0,2,0,"),
            Is("nobody modifies it", |truth| {
                matches!(truth.activity, backseat_mvc::Activity::Plan { number: 1 })
            }),
        ],
    },
    Section {
        number: "7.18",
        says: "This command causes the vehicle to log a text message in its logs",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPMSG,070000.000,the plume is found"),
            Hear("$BFACK,080000.000,MSG,070000.000,0,2,0,"),
        ],
    },
    Section {
        number: "7.19",
        says: "followed by the BFPLN messages, followed by the final success/failure acknowledgement",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPRMP,070000.001"),
            Hear("$BFACK,080000.000,RMP,070000.001,0,3,0,"),
            Until(2.0),
            Hear("$BFPLN,"),
            Hear("$BFPLN,"),
            Hear("$BFPLN,"),
            Hear("$BFACK,"),
        ],
    },
    Section {
        number: "7.25",
        says: "The payload must send this message at the beginning of communications",
        world: World::Calm,
        on: &["ACK"],
        talk: &[
            Say("$BPVER,070000.000,1.12"),
            Hear("$BFACK,080000.000,VER,070000.000,0,2,0,"),
        ],
    },
];
