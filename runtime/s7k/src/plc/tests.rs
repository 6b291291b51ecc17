use super::*;
use crate::record::Action;

/// Tables 16 to 19, typed off the specification: number and format. Lists stand as this crate writes them.
const TABLES: [(TextKind, &[(i32, &str)]); 4] = [
    (
        TextKind::Command,
        &[
            (0, "%s"),
            (1, "%d"),
            (2, "%s"),
            (3, "%s"),
            (4, "-"),
            (5, "-"),
            (6, "-"),
            (7, "%d, %lu"),
            (8, "%d, %lu"),
            (9, "%d, %d"),
            (10, "%d"),
            (11, "%d"),
            (12, "%d"),
            (13, "%d"),
            (14, "-"),
            (15, "-"),
            (16, "%d, %d, %d, %s"),
            (17, "%d"),
            (18, "-"),
            (19, "%s"),
            (20, "%04u/%02u/%02u,%02u:%02u:%08.5f"),
            (21, "-"),
            (22, "%lu"),
            (23, "%d, %lu"),
            (24, "%d"),
            (25, "-"),
            (26, "%lu, %lu"),
            (27, "%s"),
            (28, "%lu"),
        ],
    ),
    (
        TextKind::Generic,
        &[
            (0, "Range = %.2f"),
            (1, "Pulse = %s"),
            (2, "Ping = %d"),
            (3, "TxPower = %.2f"),
            (4, "RxGain = %d"),
            (5, "Duration = %.2f"),
            (6, "PulseFiles"),
            (7, "DefaultState"),
        ],
    ),
    (
        TextKind::Status,
        &[
            (0, "%0.4f"),
            (1, "Modules: %d N x (, Module = %d, %s, %0.4f)"),
            (2, "Sensors: %d N x (, Sensor = %d, %d, %d, %d, %d, %d, %s)"),
            (3, "Logging = %d, %s, %0.3lf"),
            (4, "PulseFiles: %d, N x (, %s)"),
            (5, "LoggingSetup = %lu, %lu, %s"),
            (6, "Sensors: %lu N x (, %d, %d)"),
            (7, "-"),
        ],
    ),
    (
        TextKind::Alarm,
        &[
            (0, "-"),
            (1, "%s"),
            (2, "%d, %s"),
            (3, "%d, %ld, %ld"),
            (4, "%d, %d, %d, %s"),
            (5, "%d, %s"),
            (6, "%d, %s"),
            (7, "%d, %s"),
            (8, "%d, %s"),
            (9, "%d, %s"),
            (10, "%d, %d, %s"),
            (11, "%d, %d, %s"),
            (12, "%d, %s"),
            (13, "%d, %s"),
            (14, "%d, %d, %s"),
            (15, "\"%s\""),
        ],
    ),
];

#[test]
fn every_row_of_appendix_c_is_there_with_its_format() {
    for (kind, rows) in TABLES {
        let ours: Vec<(i32, String)> = texts()
            .filter(|entry| entry.kind == kind)
            .map(|entry| (entry.id, entry.format()))
            .collect();
        let theirs: Vec<(i32, String)> = rows.iter().map(|(id, format)| (*id, (*format).to_owned())).collect();
        assert_eq!(ours, theirs, "{kind:?}");
    }
}

fn order(id: u32, text: &str) -> Order {
    Order::read(CommandId::from(id), Action::Set, text).unwrap()
}

#[test]
fn a_command_is_read_with_and_without_its_name() {
    let on = Order::Do(Command::Logging { on: true });
    for text in ["1", " 1 ", "7", "Logging,1", "Logging , 1"] {
        assert_eq!(order(1, text), on, "{text:?}");
    }
    assert_eq!(order(4, "Version"), order(4, ""));
    assert_eq!(order(7, "0,3000"), order(7, "Subscribe, 0, 3000"));
    // A file may be named after the command.
    assert_eq!(
        order(2, "Switchboard.s7k"),
        Order::Do(Command::Switch {
            name: Box::from("Switchboard.s7k")
        })
    );
}

#[test]
fn parameters_that_begin_as_the_commands_name_are_written_behind_it() {
    for (id, text) in [
        (0, "Generic, Generic,"),
        (0, "Generic, Generic"),
        (2, "Switch, Switch, 2"),
    ] {
        let order = order(id, text);
        let mut written = "before: ".to_owned();
        order.write(&mut written).unwrap();
        assert_eq!(written, format!("before: {text}"));
        assert_eq!(
            Order::read(order.command(), Action::Set, &written["before: ".len()..]),
            Ok(order)
        );
    }
}

#[test]
fn a_value_is_retrieved_by_a_command_without_parameters() {
    let get = |id: u32| Order::read(CommandId::from(id), Action::Get, "").unwrap();
    assert_eq!(get(22), Order::Get(CommandId::AutoStart));
    assert_eq!(get(15), Order::Do(Command::RunList {}));
    // Table 16: "%lu, %lu or none".
    assert_eq!(order(26, ""), Order::Get(CommandId::LoggingSetup));
    assert_eq!(order(99, "what"), Order::Unknown(CommandId::Other(99)));
}

#[test]
fn what_is_wrong_with_a_text_is_named() {
    let fault = |id: u32, text: &str| {
        Order::read(CommandId::from(id), Action::Set, text)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(fault(1, ""), "Logging parameter on: it is missing");
    assert_eq!(
        fault(1, "on"),
        "Logging parameter on: expected a whole number, found \"on\""
    );
    assert_eq!(fault(7, "0"), "Subscribe parameter record_type: it is missing");
    assert_eq!(
        fault(7, "0, 3000, 1"),
        "Subscribe parameter end: nothing may follow, found \" 1\""
    );
    assert_eq!(
        fault(7, "0, -1"),
        "Subscribe parameter record_type: expected a whole number, 0 or more, found \"-1\""
    );
    assert!(fault(20, "2026/02/29,00:00:00.00000").starts_with("TimeSync parameter time: expected a date and time"));
    assert!(fault(20, "2026/02/28,00:00:nan").contains("expected a date and time"));
    assert!(fault(1, &"9".repeat(9000)).len() < 120);
    let generic = |text: &str| Generic::read(text).unwrap_err().to_string();
    assert_eq!(
        generic("range = 10"),
        "Generic parameter text: expected a generic command of Table 19, found \"range = 10\""
    );
    assert_eq!(
        generic("Range = far"),
        "Range parameter range_m: expected a number, found \"far\""
    );
    assert_eq!(
        generic("Range = inf"),
        "Range parameter range_m: expected a number, found \"inf\""
    );
}

#[test]
fn spaces_do_not_count_and_letters_do() {
    assert_eq!(Generic::read("Range=75"), Ok(Generic::Range { range_m: 75.0 }));
    assert_eq!(Generic::read("PulseFiles"), Ok(Generic::PulseFiles {}));
    assert_eq!(
        Generic::read("Pulse = Files"),
        Ok(Generic::Pulse {
            name: Box::from("Files")
        })
    );
    let status = |id: i32, text: &str| Status::read(id, text).unwrap().unwrap();
    assert_eq!(status(6, "Sensors:2,0,1,1,0"), status(6, "Sensors: 2, 0, 1, 1, 0"));
    // As the format of status 4 is printed, with two commas.
    assert_eq!(status(4, "PulseFiles: 1,, a"), status(4, "PulseFiles: 1, a"));
    assert_eq!(status(3, "Logging = 0"), status(3, "Logging = 0, , 0.000"));
}

#[test]
fn a_count_that_lies_is_an_error_and_takes_no_memory() {
    let error = Status::read(6, "Sensors: 4000000000, 0, 1").unwrap().unwrap_err();
    assert_eq!(error.to_string(), "Health parameter sensors: it is missing");
    let error = Status::read(6, "Sensors: 1, 0, 1, 1, 1").unwrap().unwrap_err();
    assert_eq!(
        error.to_string(),
        "Health parameter end: nothing may follow, found \" 1, 1\""
    );
}

#[test]
fn what_cannot_be_read_back_is_not_written() {
    let refused = |command: Command| {
        let mut out = String::from("before");
        let error = command.write(&mut out).unwrap_err();
        assert_eq!(out, "before");
        error.to_string()
    };
    assert!(
        refused(Command::Switch {
            name: Box::from("a\nb")
        })
        .contains("without control characters")
    );
    assert_eq!(
        refused(Command::Switch { name: Box::from("") }),
        "Switch parameter name: it is missing"
    );
    let mut out = String::new();
    let pulses = Status::SensorReply {
        pulses: vec![status::PulseName(Box::from("a,b"))],
    };
    assert!(
        pulses
            .write(&mut out)
            .unwrap_err()
            .to_string()
            .contains("text without commas")
    );
    assert!(Generic::Range { range_m: f64::NAN }.write(&mut out).is_err());
    for (range_m, text) in [
        (-0.0, "Range = 0.00"),
        (-0.001, "Range = 0.00"),
        (-0.02, "Range = -0.02"),
    ] {
        out.clear();
        Generic::Range { range_m }.write(&mut out).unwrap();
        assert_eq!(out, text);
    }
}

#[test]
fn a_version_reads_as_three_numbers() {
    let version = |text: &str| match Status::read(0, text).unwrap() {
        Ok(Status::Version { version }) => version.to_string(),
        other => format!("{other:?}"),
    };
    assert_eq!(version("1.0203"), "1.02.03");
    assert_eq!(version("12.5"), "12.50.00");
    assert_eq!(version("3"), "3.00.00");
    assert!(version("1.02034").contains("Malformed"));
    assert!(version("1.-203").contains("Malformed"));
}
