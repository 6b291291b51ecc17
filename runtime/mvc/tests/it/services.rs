use std::collections::BTreeMap;

use proptest::prelude::*;

use crate::fields::{field, of, seconds};
use crate::files::CALM;
use crate::payload::Payload;

/// All services at once, with short times and every chance of failure.
fn world() -> String {
    let lists = r#"
[[topside.messages]]
at_s = 30
transport = "rf-modem"
text = "hello"
[[acoustic.peers]]
address = 3
east_m = 700
north_m = 100
[[acoustic.peers.packets]]
first_s = 11
period_s = 7
frames = ["0A", "0B"]
"#;
    let sections = r#"[silence]
timeout_s = 15
failure_chance = 0.2
[adjustment]
implicit_at_s = [20, 60, 100]
trim_rate_dps = 0.5
buoyancy_rate_n_per_s = 3
failure_chance = 0.2
[dvl]
stop_at_s = [25, 50, 75]
line_faults = [{ at_s = 40, for_s = 8 }]
[acoustic]
period_s = 30
first_s = 5
own_period_s = 13
loss_chance = 0.3
corrupted_chance = 0.2
[interpretation]
adjustment_when_silenced = "seed"
dvl_timeout_announced = "seed"
unacked_frames = "seed"
[spi]"#;
    CALM.replace("[spi]", sections)
        .replace("[start]", "[start]\ndepth_m = 10")
        .replace("starts_after_s = 1", "starts_after_s = 40")
        + lists
}

const TOPICS: &[&str] = &["ACK", "MBS", "MBE", "TRM", "BOY", "CMA", "CPS", "CPR", "RBS"];

fn command(index: usize, number: usize) -> String {
    let time = format!("07{:02}{:02}.000", number / 60, number % 60);
    match index {
        0 | 1 => format!("$BPSIL,{time},1"),
        2 => format!("$BPSIL,{time},0"),
        3 => format!("$BPTRM,{time}"),
        4 => format!("$BPBOY,{time}"),
        5 => format!("$BPRCB,{time},0"),
        6 | 7 => format!("$BPRMB,{time},,,,0,0,"),
        8 => format!("$BPDVR,{time},1,0"),
        9 => format!("$BPDVR,{time},1,1"),
        10 => format!("$BPDVR,{time},0,1"),
        11 => format!("$BPDVR,{time},0,0"),
        12 => format!("$BPTOP,{time},3,hello,0"),
        13 => format!("$BPCPD,{time},{number},3,1,1,2,0A,0B,,,,,,"),
        14 => format!("$BPCPD,{time},{number},4,5,0,1,0A,,,,,,,"),
        _ => format!("$BPTMR,{time},3,hello"),
    }
}

fn run(said: &[(u32, usize)], seed: u64) -> Vec<String> {
    let mut payload = Payload::connected(&world(), seed, TOPICS);
    let mut at_s = 0.0;
    for (number, (wait, index)) in said.iter().enumerate() {
        at_s += f64::from(*wait) * 0.13;
        payload.until(at_s);
        payload.say(&command(*index, number));
    }
    // By then everything that was open has ended.
    payload.until(at_s + 120.0);
    payload.heard()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn whatever_is_requested_everything_ends_once(
        said in proptest::collection::vec((0u32..40, 0usize..16), 1..80),
        seed in 0u64..1000,
    ) {
        let heard = run(&said, seed);
        prop_assert_eq!(&heard, &run(&said, seed));
        // Each command has one acknowledgement, or one that is pending and one more: within 4 s (7.22) at most.
        let mut answers: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
        for line in of(&heard, "BFACK") {
            let key = (field(&line, 2).to_owned(), field(&line, 3).to_owned());
            answers.entry(key).or_default().push(line);
        }
        prop_assert_eq!(answers.len(), said.len());
        for lines in answers.values() {
            let pending = field(&lines[0], 5) == "3";
            prop_assert_eq!(lines.len(), if pending { 2 } else { 1 }, "{:?}", lines);
            prop_assert!(field(lines.last().unwrap(), 5) != "3");
            let took = seconds(lines.last().unwrap()) - seconds(&lines[0]);
            prop_assert!(took <= 4.0, "{:?}", lines);
        }
        // Adjustments begin and end in turn.
        let mut running = false;
        for line in heard.iter().filter(|line| line.ends_with(",,,,trim") || line.ends_with(",,,,buoyancy")) {
            prop_assert_eq!(line.starts_with("$BFMBS"), !running, "{}", line);
            running = !running;
        }
        prop_assert!(!running);
        // Each packet that was queued has one status.
        let sent = of(&heard, "BFCPS");
        let queued = answers.iter().filter(|((name, _), lines)| name == "CPD" && field(&lines[0], 5) == "2");
        for ((_, created), _) in queued {
            let number = 60 * created[2..4].parse::<u32>().unwrap() + created[4..6].parse::<u32>().unwrap();
            let statuses = sent.iter().filter(|line| field(line, 3) == number.to_string()).count();
            prop_assert_eq!(statuses, 1, "packet {}", number);
        }
    }
}
