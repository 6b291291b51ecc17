use backseat_mvc::{Mvc, WorldFile};

use crate::files::CALM;
use crate::payload::{ME, Payload};

fn sandshark() -> Payload {
    let mut file = WorldFile::from_toml(CALM).expect("the test's file is right");
    file.like_sandshark();
    Payload::of(Mvc::new(&file, 1).expect("the test's world is possible"))
}

/// Each line is a habit that the recordings show.
#[test]
fn a_sandshark_speaks_as_recorded() {
    let mut payload = sandshark();
    payload.connect(ME);
    // Its clock is hours away from the payload's, 08:00.
    assert_eq!(payload.heard(), ["$BFVER,040000.000,1.11"]);
    payload.say("$BPLOG,ALL,ON");
    payload.say("$BPSTS,080000.25,1,all ok");
    payload.bytes(ME, b"$BPSTS,080000.50,1,all ok\n \n$BPRMB,080000.75,90,3,0,1.5,1,0\n");
    assert_eq!(
        payload.heard(),
        [
            "$BFACK,040000.000,LOG,000000.000,0,2,0,request successfully processed",
            "$BFACK,040000.000,STS,080000.250,0,2,0,request successfully processed",
            "$BFACK,040000.000,STS,080000.500,0,2,0,request successfully processed",
            "$BFACK,040000.000,NAK,000000.000,0,0,0,no header of a command matches this line",
            "$BFACK,040000.000,RMB,080000.750,0,1,0,dynamic requests are not allowed now",
        ]
    );
    payload.until(1.0);
    let names: Vec<String> = payload.heard().iter().map(|line| line[3..6].to_owned()).collect();
    let mut expected = ["NVG", "NVR"].repeat(10);
    // BFMIS and BFCTL are on from the start, and come on the transition.
    expected.splice(18..18, ["MIS", "CTL"]);
    assert_eq!(names, expected);
    assert!(payload.blank_lines > 20, "{}", payload.blank_lines);
    payload.say("$BPRMB,080001.75,90,3,0,1.5,1,0");
    assert_eq!(
        payload.heard(),
        ["$BFACK,040001.000,RMB,080001.750,0,2,0,request successfully processed"]
    );
    // Who subscribes late hears no more of the hand-over.
    payload.say("$BPLOG,CTL,ON");
    assert_eq!(payload.heard().len(), 1);
}

/// A payload whose CTD counts from the pressure of the air gives the same speed of sound as one that does not, to a
/// vehicle that reads it so.
#[test]
fn the_pressure_of_a_payload_s_ctd_counts_from_where_the_vehicle_reads_it() {
    let sound = |reading: &str, pressure_kpa: f64| {
        let text = CALM
            .replace("[sensors.sound]", "[sensors.sound]\nfitted = false")
            .replace(
                "[spi]",
                &format!("[interpretation]\nctd_pressure = \"{reading}\"\n[spi]"),
            );
        let mut payload = Payload::connected(&text, 1, &["SVS"]);
        payload.say(&format!("$BPCTD,080000.000,40000,12,{pressure_kpa},080000.000"));
        payload.until(2.0);
        let heard = payload.heard();
        let line = heard.iter().find(|line| line.starts_with("$BFSVS")).expect("BFSVS");
        line.split(',')
            .nth(2)
            .expect("a speed")
            .parse::<f64>()
            .expect("a number")
    };
    let absolute = sound("absolute", 3000.0);
    assert!((sound("gauge", 3000.0 - 101.325) - absolute).abs() < 1e-3);
    assert!((sound("gauge", 3000.0) - absolute).abs() > 0.05);
}

/// Fixing one reading, or adding those of answers, moves no other.
#[test]
fn readings_of_answers_do_not_move_the_other_draws() {
    let drawn = |keys: &str| {
        let file = WorldFile::from_toml(&CALM.replace("[spi]", &format!("[interpretation]\n{keys}\n[spi]")));
        let file = file.expect("the test's file is right");
        (1..40)
            .map(|seed| {
                Mvc::new(&file, seed)
                    .expect("a world")
                    .interpretation()
                    .drawn(&file.interpretation)
            })
            .collect::<Vec<_>>()
    };
    let old = "after_interrupt = \"seed\"\nlead_in_m = \"seed\"\necho_decimals = \"seed\"";
    let new = "unknown_command = \"seed\"\nbroken_line = \"seed\"\nctd_pressure = \"seed\"\nall_topics = \"seed\"";
    let (alone, together) = (drawn(old), drawn(&format!("{old}\n{new}")));
    for (alone, together) in alone.iter().zip(&together) {
        assert_eq!(alone[..], together[..3]);
        assert_eq!(together.len(), 7);
    }
    assert!(together.iter().any(|all| all != &together[0]));
    assert_eq!(alone[0][0].0, "after_interrupt");
}
