use std::time::Duration;

use backseat_core::plugin::{Event, Request};
use backseat_core::{ControlHook, Operator, Settings, Start};
use backseat_spi::{MissionCommand, Text};
use backseat_units::{Timestamp, Utc};

use crate::course::{good_line, modify};
use crate::scene::hands_over;
use crate::trial::{Seen, Setup, Trial};

/// Lets the vehicle say something, and waits until it has arrived.
fn tell(trial: &mut Trial, say: impl FnOnce(&mut crate::vehicle::Vehicle, Timestamp)) {
    let now = trial.now;
    say(&mut trial.vehicle, now);
    trial.run_for(0.2);
}

#[test]
fn sr_001_each_condition_of_control_is_needed() {
    type Loss = fn(&mut Trial);
    let losses: [(&str, Loss, Loss); 5] = [
        (
            "the vehicle has control",
            |trial| tell(trial, |vehicle, now| vehicle.set_control(now, false)),
            |trial| tell(trial, |vehicle, now| vehicle.set_control(now, true)),
        ),
        (
            "the mission is not running",
            |trial| tell(trial, |vehicle, now| vehicle.set_status(now, "Aborting")),
            |trial| tell(trial, |vehicle, now| vehicle.set_status(now, "Running /logs/1")),
        ),
        (
            "navigation is stale",
            |trial| trial.vehicle.navigates = false,
            |trial| trial.vehicle.navigates = true,
        ),
        (
            "the operator's hold is set",
            |trial| trial.operator(Operator::Hold),
            |trial| trial.operator(Operator::Release),
        ),
        ("the link is down", Trial::cut, |_| {}),
    ];
    for (reason, lose, regain) in losses {
        let mut trial = Trial::steering();
        let lost = trial.now;
        lose(&mut trial);
        trial.run_for(0.25);
        if reason == "navigation is stale" {
            trial.run_for(1.0);
        }
        assert!(!trial.core.has_control(), "{reason}");
        assert_eq!(trial.lease_ends().len(), 1, "{reason}");
        let quiet = trial.now;
        trial.ask(0, [Request::Modify(modify(2)), good_line(3)]);
        if reason != "the link is down" {
            trial.run_for(2.0);
            assert!(trial.rejection(2).contains(reason), "{reason}: {}", trial.rejection(2));
            assert!(trial.rejection(3).contains(reason), "{reason}: {}", trial.rejection(3));
            assert_eq!(trial.sent_since("EMB", lost).len(), 1, "{reason}");
        }
        assert!(
            trial.sent_since("RMB", quiet).is_empty() && trial.sent_since("RTK", quiet).is_empty(),
            "{reason}"
        );
        regain(&mut trial);
        trial.run_for(3.0);
        assert!(trial.core.has_control(), "regained after: {reason}");
        trial.ask(0, [Request::Modify(modify(4))]);
        trial.run_for(0.5);
        assert!(trial.core.is_steering(), "regained after: {reason}");
        let told: Vec<bool> = trial
            .events(0)
            .into_iter()
            .filter_map(|event| match event {
                Event::Control(granted) => Some(granted),
                _ => None,
            })
            .collect();
        assert_eq!(told, [true, false, true], "{reason}");
    }
}

#[test]
fn sr_001_any_status_other_than_running_takes_control_away() {
    for junk in ["", " ", "running", "Not Running", "WrappingUp"] {
        let mut trial = Trial::steering();
        tell(&mut trial, |vehicle, now| vehicle.set_status(now, junk));
        assert!(!trial.core.has_control() && !trial.core.is_steering(), "{junk:?}");
    }
}

#[test]
fn sr_001_after_a_link_loss_control_is_unknown_until_the_vehicle_says_it_again() {
    let mut trial = Trial::steering();
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(30.0);
    assert!(!trial.core.has_control());
    tell(&mut trial, |vehicle, now| vehicle.set_control(now, true));
    assert!(!trial.core.has_control(), "the mission's status is still unknown");
    tell(&mut trial, |vehicle, now| vehicle.set_status(now, "Running"));
    assert!(trial.core.has_control());
}

#[test]
fn the_running_hook_gives_control_with_the_mission_and_ignores_bfctl() {
    let settings = Settings {
        control: ControlHook::Running,
        ..Settings::default()
    };
    let mut trial = Trial::with(Setup {
        settings,
        ..Setup::default()
    });
    trial.vehicle.control = false;
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    tell(&mut trial, |vehicle, now| vehicle.set_status(now, "Completed"));
    assert!(!trial.core.has_control());
}

#[test]
fn the_mission_command_hook_gives_control_only_on_its_exact_text() {
    let hook = ControlHook::MissionCommand {
        grant: "backseat go".to_owned(),
        revoke: "backseat stop".to_owned(),
    };
    let settings = Settings {
        control: hook,
        ..Settings::default()
    };
    let mut trial = Trial::with(Setup {
        settings,
        ..Setup::default()
    });
    trial.run_for(2.0);
    assert!(!trial.core.has_control(), "BFCTL is ignored");
    let command = |trial: &mut Trial, text: &str| {
        let created = trial.vehicle.clock(trial.now);
        let text = Text::cleaned(text);
        tell(trial, |vehicle, now| vehicle.say(now, MissionCommand { created, text }));
    };
    command(&mut trial, "backseat gone");
    assert!(!trial.core.has_control());
    command(&mut trial, "backseat go");
    assert!(trial.core.has_control());
    command(&mut trial, "backseat stop");
    assert!(!trial.core.has_control());
    let heard = trial
        .events(0)
        .into_iter()
        .filter(|event| matches!(event, Event::MissionCommand(_)))
        .count();
    assert_eq!(heard, 3);
}

#[test]
fn sr_014_control_taken_and_given_back_in_one_read_ends_the_lease() {
    let mut trial = Trial::steering();
    let read = trial.now;
    let control = |granted| {
        backseat_spi::BackseatControl {
            created: trial.vehicle.clock(trial.now),
            granted,
        }
        .into()
    };
    let both = [control(false), control(true)];
    trial.hear_now(both);
    trial.run_for(0.5);
    assert_eq!(trial.sent_since("EMB", read), [read]);
    assert_eq!(trial.lease_ends().len(), 1);
    assert!(trial.core.has_control() && !trial.core.is_steering());
}

#[test]
fn sr_014_without_control_only_permitted_messages_leave() {
    let mut trial = Trial::steering();
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    tell(&mut trial, |vehicle, now| vehicle.set_control(now, false));
    let lost = trial.now;
    for step in 0..300 {
        trial.ask(
            0,
            [
                Request::Modify(modify(100 + step)),
                good_line(1000 + step),
                Request::Message("hm".to_owned()),
            ],
        );
        trial.run_for(0.1);
    }
    for name in trial.names_since(lost) {
        assert!(["VER", "LOG", "STS", "MSG", "RMP", "RCN"].contains(&name), "{name}");
    }
}

#[test]
fn an_unarmed_runtime_sends_everything_except_what_steers() {
    let setup = Setup::default();
    let start = Start {
        armed: false,
        ..setup.start
    };
    let mut trial = Trial::with_under_way(Setup { start, ..setup });
    trial.ask(0, [Request::Modify(modify(1)), good_line(2)]);
    trial.run_for(0.3);
    trial.ask(0, [Request::Message("here".to_owned())]);
    trial.run_for(15.0);
    assert!(trial.rejection(1).contains("not armed") && trial.rejection(2).contains("not armed"));
    let names = trial.names_since(Timestamp::ZERO);
    for name in ["VER", "LOG", "RMP", "MSG", "STS"] {
        assert!(names.contains(&name), "{name}");
    }
    for name in ["RMB", "RTK", "RTC", "EMB", "RCN"] {
        assert!(!names.contains(&name), "{name}");
    }
}

#[test]
fn sr_011_before_power_off_plugins_are_informed_and_the_logs_close_within_ten_seconds() {
    let mut trial = Trial::steering();
    let told = trial.now;
    for _ in 0..15 {
        let created = trial.vehicle.clock(trial.now);
        // A vehicle may repeat its announcement.
        tell(&mut trial, |vehicle, now| {
            vehicle.say(now, backseat_spi::Shutdown { created })
        });
        trial.run_for(0.8);
    }
    let finish = trial
        .seen
        .iter()
        .find(|(_, seen)| *seen == Seen::Finish)
        .expect("the logs are closed")
        .0;
    assert!(finish.since(told) <= Duration::from_secs(10), "{finish}");
    for plugin in 0..2 {
        assert!(trial.events(plugin).contains(&Event::Shutdown));
    }
    assert!(!trial.core.has_control() && trial.sent_since("EMB", told).len() == 1);
}

#[test]
fn sr_011_a_runtime_that_wakes_after_the_shutdown_time_sends_nothing() {
    let mut trial = Trial::under_way();
    let created = trial.vehicle.clock(trial.now);
    tell(&mut trial, |vehicle, now| {
        vehicle.say(now, backseat_spi::Shutdown { created })
    });
    trial.run_for(3.3);
    let asleep = trial.now;
    trial.asleep_until = asleep + Duration::from_secs(9);
    trial.run_for(9.5);
    let finish = trial.seen.iter().find(|(_, seen)| *seen == Seen::Finish);
    assert!(finish.is_some_and(|(at, _)| at.since(asleep) < Duration::from_secs(10)));
    assert_eq!(trial.names_since(asleep), Vec::<&str>::new(), "{:#?}", trial.notes());
}

/// A line of the vehicle with a right checksum, whatever is in it.
fn hear_line(trial: &mut Trial, body: &str) {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    trial.hear_bytes(format!("${body}*{sum:02X}\r\n").as_bytes());
}

#[test]
fn sr_011_a_shutdown_whose_time_cannot_be_read_is_a_shutdown() {
    for body in ["BFSHT,", "BFSHT", "BFSHT,081099.000"] {
        let mut trial = Trial::steering();
        let told = trial.now;
        hear_line(&mut trial, body);
        trial.run_for(10.0);
        let finish = trial.seen.iter().find(|(_, seen)| *seen == Seen::Finish);
        assert!(
            finish.is_some_and(|(at, _)| at.since(told) <= Duration::from_secs(10)),
            "{body}"
        );
        assert!(
            !trial.core.has_control() && trial.sent_since("EMB", told).len() == 1,
            "{body}"
        );
    }
}

/// Steers under control that a mission command has given.
fn steering_by_mission_command() -> Trial {
    let settings = Settings {
        control: ControlHook::MissionCommand {
            grant: "backseat go".to_owned(),
            revoke: "backseat stop".to_owned(),
        },
        ..Settings::default()
    };
    let mut trial = Trial::with(Setup {
        settings,
        ..Setup::default()
    });
    trial.run_for(2.0);
    says(&mut trial, "backseat go");
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
    trial
}

fn says(trial: &mut Trial, text: &str) {
    let created = trial.vehicle.clock(trial.now);
    let text = Text::cleaned(text);
    trial.hear_now([MissionCommand { created, text }.into()]);
}

#[test]
fn sr_001_a_mission_command_that_cannot_be_read_may_have_taken_control_away() {
    for line in ["BFMSC,,backseat stop", "BFMSC"] {
        let mut trial = steering_by_mission_command();
        hear_line(&mut trial, line);
        assert!(!trial.core.has_control() && !trial.core.is_steering(), "{line}");
        trial.run_for(1.0);
        says(&mut trial, "backseat go");
        assert!(trial.core.has_control(), "{line}");
        // With another hook it says nothing about control.
        let mut trial = Trial::steering();
        hear_line(&mut trial, line);
        assert!(trial.core.is_steering(), "{line}");
    }
}

#[test]
fn sr_001_a_text_that_takes_control_away_may_have_blanks_around_it() {
    for text in ["backseat stop ", " backseat stop"] {
        let mut trial = steering_by_mission_command();
        says(&mut trial, text);
        assert!(!trial.core.has_control(), "{text:?}");
        says(&mut trial, "backseat go ");
        assert!(!trial.core.has_control(), "the text that gives it may not");
    }
}

/// A message about control whose checksum is wrong may have been the revocation. Core ends the lease, resets the
/// connection, and has control again when the vehicle has told its state to the new subscriber.
#[test]
fn sr_001_a_damaged_message_about_control_takes_it_away_until_the_vehicle_says_it_again() {
    for line in [
        "$BFCTL,081025.987,0*00\r\n",
        "$BFCTL,081025.987,0\r\n",
        "$BFMIS,081025.987,survey.dive,Stop",
    ] {
        let mut trial = Trial::steering();
        let at = trial.now;
        trial.hear_bytes(line.as_bytes());
        // The begin of another line shows that one was cut short.
        hear_line(&mut trial, "BFXYZ,1");
        assert!(!trial.core.has_control() && !trial.core.is_steering(), "{line}");
        assert_eq!(trial.sent_since("EMB", at).len(), 1, "{line}");
        trial.run_for(2.9);
        assert_eq!((resets(&trial), trial.core.has_control()), (0, false), "{line}");
        trial.run_for(4.0);
        assert_eq!(
            (resets(&trial), trial.core.has_control()),
            (1, true),
            "{line}: {:#?}",
            trial.notes()
        );
    }
}

fn resets(trial: &Trial) -> usize {
    trial.seen.iter().filter(|(_, seen)| *seen == Seen::Reset).count()
}

/// The vehicle says it by itself before core resets the connection.
#[test]
fn sr_001_what_the_vehicle_says_again_needs_no_new_connection() {
    let mut trial = Trial::under_way();
    hear_line(&mut trial, "BFCTL,,0");
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.set_control(now, true);
    trial.run_for(60.0);
    assert_eq!((resets(&trial), trial.core.has_control()), (0, true));
}

#[test]
fn sr_001_a_damaged_mission_command_takes_control_away_if_it_can() {
    let damaged = b"$BFMSC,081025.987,backseat stop*00\r\n";
    let mut trial = steering_by_mission_command();
    trial.hear_bytes(damaged);
    assert!(!trial.core.has_control());
    let mut trial = Trial::steering();
    trial.hear_bytes(damaged);
    assert!(trial.core.has_control());
}

/// The vehicle tells each state once, to a new subscriber. Here the line is damaged from its first byte, so nobody can see
/// what it was.
#[test]
fn sr_001_what_was_lost_before_the_vehicle_has_said_who_has_control_is_asked_for() {
    for name in ["BFCTL", "BFMIS"] {
        let mut trial = Trial::under_way();
        trial.cut();
        trial.way = Some(Box::new(move |bytes| {
            let text = String::from_utf8(bytes).unwrap();
            text.replace(&format!("${name}"), name).into_bytes()
        }));
        trial.run_for(2.0);
        assert!(trial.is_connected() && !trial.core.has_control(), "{name}");
        trial.way = None;
        trial.run_for(70.0);
        assert!(trial.core.has_control(), "{name}: {:#?}", trial.notes().last());
    }
}

/// The answer to the new subscription is lost too.
#[test]
fn sr_001_a_lost_answer_about_control_is_asked_for_again() {
    let mut trial = Trial::under_way();
    trial.hear_bytes(DAMAGED);
    let mut lost = 0;
    trial.way = Some(Box::new(move |bytes| {
        let text = String::from_utf8(bytes).unwrap();
        let line = |line: &str| {
            let damaged = line.starts_with("$BFCTL") && lost < 1;
            lost += u32::from(damaged);
            if damaged {
                line.replace("$BFCTL", "$BFCTK")
            } else {
                line.to_owned()
            }
        };
        text.split_inclusive('\n').map(line).collect::<String>().into_bytes()
    }));
    trial.run_for(60.0);
    assert_eq!((resets(&trial), trial.core.has_control()), (2, true));
}

/// Whatever comes of it: ten damaged lines a second for an hour.
#[test]
fn sr_001_damaged_messages_about_control_cause_few_new_connections() {
    let mut trial = Trial::under_way();
    trial.vehicle.replays = false;
    let mut hours = [0; 2];
    for resets_then in &mut hours {
        for _ in 0..3600 {
            trial.hear_bytes(DAMAGED);
            assert!(!trial.core.has_control());
            trial.run_for(1.0);
        }
        *resets_then = resets(&trial);
    }
    assert!(hours[0] <= 12 && hours[1] - hours[0] <= 8, "{hours:?}");
    hands_over(&mut trial);
    trial.run_for(1.0);
    assert!(trial.core.has_control());
}

const DAMAGED: &[u8] = b"$BFCTL,081025.987,0*00\r\n";

/// A GPS fix sets the vehicle's clock back between a revocation and the next grant, which then seems the older one.
#[test]
fn sr_001_control_comes_back_although_the_vehicles_clock_was_set_back() {
    for step in [0, -2_000_000_000] {
        let mut trial = Trial::under_way();
        let now = trial.now;
        trial.vehicle.set_control(now, false);
        trial.run_for(0.5);
        trial.vehicle.clock_nanos += step;
        let now = trial.now;
        trial.vehicle.set_control(now, true);
        trial.run_for(20.0);
        assert!(trial.core.has_control(), "{step} {:?}", trial.core.uncontrolled());
    }
}

/// The vehicle made the grant before the revocation, and it comes after it.
#[test]
fn sr_001_an_older_grant_does_not_overrule_a_newer_revocation() {
    // Midnight comes between the two.
    let before_midnight = Utc::from_unix_nanos(1_700_006_400_000_000_000 - 3_500_000_000);
    for utc in [Setup::default().start.utc, before_midnight] {
        let mut setup = Setup::default();
        setup.start.utc = utc;
        let mut trial = Trial::with(setup);
        trial.vehicle.utc = utc;
        trial.run_for(2.5);
        assert!(trial.core.has_control());
        let control = |trial: &Trial, granted| backseat_spi::BackseatControl {
            created: trial.vehicle.clock(trial.now),
            granted,
        };
        let older = control(&trial, true);
        trial.run_for(2.0);
        trial.vehicle.control = false;
        let revoked = control(&trial, false);
        trial.hear_now([revoked.into()]);
        trial.run_for(0.5);
        trial.hear_now([older.into()]);
        assert!(!trial.core.has_control(), "{utc:?}");
        trial.run_for(10.0);
        assert_eq!((resets(&trial), trial.core.has_control()), (1, false), "{utc:?}");
        let newer = control(&trial, true);
        trial.hear_now([newer.into()]);
        assert!(trial.core.has_control(), "{utc:?}");
    }
}

#[test]
fn sr_001_an_older_mission_command_does_not_overrule_a_newer_one_that_takes_control_away() {
    let mut trial = steering_by_mission_command();
    let says = |trial: &Trial, text: &str| MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned(text),
    };
    let older = says(&trial, "backseat go");
    trial.run_for(1.0);
    let stop = says(&trial, "backseat stop");
    trial.hear_now([stop.into()]);
    trial.run_for(0.5);
    trial.hear_now([older.into()]);
    assert!(!trial.core.has_control());
    let newer = says(&trial, "backseat go");
    trial.hear_now([newer.into()]);
    assert!(trial.core.has_control());
}
