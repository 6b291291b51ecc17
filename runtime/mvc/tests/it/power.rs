use crate::fields::{field, number, of, seconds};
use crate::files::CALM;
use crate::payload::{ME, Payload};

fn with(power: &str) -> String {
    CALM.replace("[spi]", &format!("[power]\n{power}\n[spi]"))
}

// SPI 6.8: "A separate message will be sent for each battery. A special pseudo battery 0 will be sent for systems with
// multiple batteries."
#[test]
fn each_battery_reports_and_so_does_a_pseudo_battery_for_all() {
    let mut payload = Payload::connected(&with(""), 1, &["RBS"]);
    payload.until(25.0);
    let heard = payload.heard();
    let numbers: Vec<&str> = heard.iter().map(|line| field(line, 2)).collect();
    assert_eq!(numbers, ["0", "1", "2", "3", "0", "1", "2", "3", "0", "1", "2", "3"]);
    assert!((seconds(&heard[4]) - seconds(&heard[0]) - 10.0).abs() < 0.01);
    let (all, one) = (&heard[0], &heard[1]);
    assert_eq!((field(all, 7), field(one, 7)), ("4.5", "1.5"));
    for line in &heard {
        let (stack, weakest, strongest) = (number(line, 3), number(line, 4), number(line, 5));
        assert!(
            weakest <= stack / 8.0 + 1e-4 && stack / 8.0 <= strongest + 1e-4,
            "{line}"
        );
        assert!(
            (31.0..33.0).contains(&stack) && (99.0..=100.0).contains(&number(line, 8)),
            "{line}"
        );
    }
    let mut payload = Payload::connected(&with("batteries = 1\nstatus_period_s = 1"), 1, &["RBS"]);
    payload.until(5.0);
    assert!(payload.heard().iter().all(|line| field(line, 2) == "1"));
    let mut payload = Payload::connected(&with(""), 1, &[]);
    payload.until(25.0);
    assert_eq!(payload.heard(), Vec::<String>::new());
}

#[test]
fn the_battery_runs_down_with_the_cube_of_the_speed() {
    let used = |power: &str| {
        let text = with(&format!(
            "capacity_wh = 100\nbatteries = 1\nstatus_period_s = 1\n{power}"
        ));
        let mut payload = Payload::connected(&text, 1, &["RBS"]);
        payload.until(160.0);
        let heard = payload.heard();
        let at = |second: usize| (number(&heard[second], 8), number(&heard[second], 3));
        (at(60).0 - at(150).0, at(60).1 > at(150).1)
    };
    // 360 W over 90 s: 9 Wh of 100.
    let (percent, voltage_falls) = used("hotel_w = 360\npropulsion_w_at_1_mps = 0");
    assert!((percent - 9.0).abs() < 0.02 && voltage_falls, "{percent}");
    // 2 m/s: eight times 45 W.
    let (percent, voltage_falls) = used("hotel_w = 0\npropulsion_w_at_1_mps = 45");
    assert!((percent - 9.0).abs() < 0.1 && voltage_falls, "{percent}");
}

// 5.2: "This message is sent by the Bluefin vehicle at least 1 minute before the payload will be electrically shut
// down."
#[test]
fn an_empty_battery_shuts_the_payload_down_with_a_minutes_notice() {
    // A watt-hour a second: the battery is half empty at 50 s.
    let text = with("capacity_wh = 100\nhotel_w = 3600\npropulsion_w_at_1_mps = 0\nshutdown_below_percent = 50");
    let mut payload = Payload::connected(&text, 1, &[]);
    payload.until(49.8);
    assert_eq!(payload.heard(), Vec::<String>::new());
    payload.until(51.0);
    let said = payload.heard();
    assert_eq!(of(&said, "BFSHT").len(), 1);
    let at = seconds(&said[0]);
    payload.until(at + 59.8);
    assert!(payload.cut_off.is_empty());
    payload.until(at + 60.1);
    assert_eq!(payload.cut_off, [ME]);
    // A new client gets no power either.
    payload.connect(ME);
    assert_eq!(payload.cut_off, [ME, ME]);
}

#[test]
fn the_notice_is_never_shorter_than_a_minute() {
    for after_s in ["60", "60.05", "60.1", "99.95"] {
        let text = CALM.replace("[mission]", &format!("[mission]\nshutdown_after_s = {after_s}"));
        let mut payload = Payload::connected(&text, 1, &[]);
        let mut said = None;
        for tick in 1..2000 {
            payload.until(f64::from(tick) * 0.1);
            if said.is_none() && !of(&payload.heard(), "BFSHT").is_empty() {
                said = Some(tick);
            }
            if !payload.cut_off.is_empty() {
                let notice = tick - said.unwrap();
                assert!((600..=602).contains(&notice), "{after_s}: {notice}");
                break;
            }
        }
        assert_eq!(payload.cut_off, [ME]);
    }
}

#[test]
fn without_a_threshold_the_payload_keeps_its_power() {
    let text = with("capacity_wh = 1\nhotel_w = 3600\nbatteries = 1");
    let mut payload = Payload::connected(&text, 1, &["RBS"]);
    payload.until(200.0);
    let heard = payload.heard();
    assert_eq!(number(heard.last().unwrap(), 8), 0.0);
    assert!(payload.cut_off.is_empty());
}
