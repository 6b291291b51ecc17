//! The mock payload controller as a separate program: clients, log files, disks that are full or stuck, and the mock
//! vehicle beside it.

mod client;

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::Duration;

use backseat_s7k::SensorIndex;
use backseat_s7k::plc::{Alarm, Command, CommandId, Generic, Status};
use backseat_s7k::record::{AlarmMode, CommandStatus};
use backseat_suite::{Backseat, Mission, Process, Signal, Stall, Stopwatch, Vehicle, eventually, settle};

use client::{Client, HIGH, LOW, SUB_BOTTOM, navigation};

const SOON: Duration = Duration::from_secs(30);

/// The steady mission with a controller whose sensors start at once, and which does not mind how full this computer's disk
/// is, as long as there is room. Its seabed is level and 50 m deep.
fn mission() -> Mission {
    let at_once = "start_s = 0\n";
    let sonars: String = ["sub_bottom", "sidescan_low", "sidescan_high"]
        .map(|sonar| format!("[plc.{sonar}]\n{at_once}"))
        .concat();
    Mission::steady()
        .edit("world.toml", "depth_m = 50", "depth_m = 50\nslope = 0\nmeanders = 0")
        .append(
            "world.toml",
            &format!("[plc]\nclients_max = 64\n[plc.disk]\ncritical_percent = 0\n{sonars}"),
        )
}

/// The controller alone.
struct Controller {
    process: Process,
    address: String,
    folder: PathBuf,
}

impl Controller {
    fn start(mission: &Mission) -> Self {
        Self::spawn(mission, Backseat::new())
    }

    fn spawn(mission: &Mission, program: Backseat) -> Self {
        let folder = mission.beside("logs");
        let process = program
            .args(["plc", "--listen", "127.0.0.1:0", "--folder"])
            .arg(&folder)
            .mission(mission)
            .spawn();
        let line = process.says("payload controller at ", SOON);
        let (_, rest) = line.split_once("payload controller at ").expect("it was waited for");
        let (address, _) = rest.split_once(';').expect("what becomes of files");
        Self {
            process,
            address: address.to_owned(),
            folder,
        }
    }

    fn client(&self) -> Client {
        Client::connect(&self.address)
    }

    /// The log files, in the order of their names.
    fn logs(&self) -> Vec<PathBuf> {
        logs(&self.folder)
    }

    fn ends(&mut self) -> String {
        assert_eq!(self.process.wait(SOON), Some(0), "{}", self.process.stderr());
        let said = self.process.stderr();
        assert!(!said.contains("panicked"), "{said}");
        said
    }
}

fn logs(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .expect("it was made")
        .map(|entry| entry.expect("it is listed").path());
    let mut logs: Vec<PathBuf> = entries
        .filter(|path| path.extension().is_some_and(|extension| extension == "s7k"))
        .collect();
    logs.sort();
    logs
}

/// How many records a file has in which `backseat s7k verify` finds nothing wrong.
fn verified(file: &Path) -> u64 {
    verified_with(file, "\n")
}

/// The same for a file that was not ended in order: it has no catalogue.
fn verified_up_to_the_cut(file: &Path) -> u64 {
    verified_with(file, "; no catalogue\n")
}

fn verified_with(file: &Path, end: &str) -> u64 {
    let done = Backseat::new().args(["s7k", "verify"]).arg(file).run().exit(0);
    let (count, rest) = done
        .stderr
        .split_once(" records: nothing wrong")
        .expect("nothing wrong");
    // No client of these tests says where the vehicle is, or hardly.
    let (rest, _) = rest
        .split_once("; warning: the pings have no navigation")
        .unwrap_or((rest, ""));
    assert_eq!(rest.trim_end(), end.trim_end(), "{done}");
    count.parse().expect("a number")
}

/// Waits until so many bytes are in the folder's log files.
fn wait_for_bytes(controller: &Controller, bytes: u64) {
    let length = || -> u64 {
        controller
            .logs()
            .iter()
            .map(|log| fs::metadata(log).map_or(0, |log| log.len()))
            .sum()
    };
    eventually(
        SOON,
        || (length() >= bytes).then_some(()),
        || format!("{} bytes of logs\n{}", length(), controller.process.stderr()),
    );
}

#[test]
fn a_client_subscribes_pings_logs_and_shuts_the_controller_down() {
    let mission = mission();
    let mut controller = Controller::start(&mission);
    let mut client = controller.client();
    client.tell(Command::Verbose { on: true });
    client.answers(CommandId::Verbose, CommandStatus::Accepted);
    for sensor in [SUB_BOTTOM, LOW, HIGH] {
        client.subscribe(sensor);
        client.set(sensor, &Generic::Ping { on: true });
    }
    client.tell(Command::Logging { on: true });
    client.answers(CommandId::Logging, CommandStatus::Accepted);
    for sensor in [SUB_BOTTOM, LOW, HIGH] {
        client.hears(sensor, 10);
    }
    // The vehicle stands at its start, 8 m deep over 50 m.
    let (bed_m, steps) = client.brightest(SUB_BOTTOM);
    assert!((bed_m - 42.0).abs() < 0.5 && steps > 500.0, "{bed_m} m, {steps} steps");
    client.tell(Command::ReportLogging {});
    let (on, file) = client.solicits(|status| {
        if let Status::FileDetails { on, file, .. } = status {
            Some((*on, file.to_string()))
        } else {
            None
        }
    });
    let name = file.rsplit('\\').next().unwrap().to_owned();
    assert!(on && controller.folder.join(&name).is_file(), "{file}");
    client.tell(Command::Shutdown { kind: 0 });
    client.solicits(|status| matches!(status, Status::Shutdown {}).then_some(()));
    client.is_cut_off();
    let said = controller.ends();
    for text in [
        "client 1 connected",
        "sensor 2 (sidescan, high frequency) works",
        "client 1: Logging to sensor -1",
        "logging to D:\\data\\",
        "shutting down",
        "1 clients served",
    ] {
        assert!(said.contains(text), "{text}: {said}");
    }
    assert_eq!(controller.logs(), [controller.folder.join(name)]);
    let records = verified(&controller.logs()[0]);
    assert!(records > 30, "{records}");
}

#[test]
fn the_vehicle_is_where_clients_say_that_it_is() {
    let mission = mission();
    let controller = Controller::start(&mission);
    let mut client = controller.client();
    client.subscribe(SUB_BOTTOM);
    client.set(SUB_BOTTOM, &Generic::Ping { on: true });
    client.hears(SUB_BOTTOM, 1);
    assert!((client.brightest(SUB_BOTTOM).0 - 42.0).abs() < 0.5);
    let frame = navigation(42.35, -70.70, 30.0);
    eventually(
        SOON,
        || {
            // The sensor that takes it may still be starting.
            client.send(&frame);
            client.hears(SUB_BOTTOM, 1);
            ((client.brightest(SUB_BOTTOM).0 - 20.0).abs() < 0.5).then_some(())
        },
        || "the bed is not 20 m below".to_owned(),
    );
}

#[test]
fn a_signal_ends_it_with_whole_files_and_the_next_start_goes_on() {
    let mission = mission();
    for (signal, runs) in [(Signal::TERM, 1), (Signal::INT, 2)] {
        let mut controller = Controller::start(&mission);
        let mut client = controller.client();
        client.tell(Command::AutoStart { on: true });
        client.tell(Command::Remove { sensor: SensorIndex(1) });
        client.tell(Command::Save {});
        if runs == 1 {
            for sensor in [LOW, HIGH] {
                client.set(sensor, &Generic::Ping { on: true });
            }
            client.tell(Command::Logging { on: true });
        }
        // The second time logging and pinging begin by themselves.
        eventually(
            SOON,
            || (controller.logs().len() == runs).then_some(()),
            || controller.process.stderr(),
        );
        settle(Duration::from_secs(1));
        controller.process.signal(signal);
        client.solicits(|status| matches!(status, Status::Shutdown {}).then_some(()));
        controller.ends();
        for log in controller.logs() {
            assert!(verified(&log) > 3, "{}", log.display());
        }
        let saved = fs::read_to_string(controller.folder.join("6046.sav")).unwrap();
        assert!(saved.starts_with("6046 run list 1\n"), "{saved}");
    }
}

#[test]
fn a_controller_that_is_killed_leaves_a_file_that_reads_up_to_the_cut() {
    let mission = mission();
    let mut controller = Controller::start(&mission);
    let mut client = controller.client();
    for sensor in [SUB_BOTTOM, LOW, HIGH] {
        client.set(sensor, &Generic::Ping { on: true });
    }
    client.tell(Command::Logging { on: true });
    wait_for_bytes(&controller, 500_000);
    controller.process.kill();
    let logs = controller.logs();
    assert_eq!(logs.len(), 1);
    assert!(verified_up_to_the_cut(&logs[0]) > 20);
    // The folder is free for another one, which does not touch that file.
    let length = fs::metadata(&logs[0]).unwrap().len();
    let again = Controller::start(&mission);
    let mut client = again.client();
    client.set(HIGH, &Generic::Ping { on: true });
    client.tell(Command::Logging { on: true });
    eventually(
        SOON,
        || (again.logs().len() == 2).then_some(()),
        || again.process.stderr(),
    );
    assert_eq!(fs::metadata(&logs[0]).unwrap().len(), length);
}

#[test]
fn a_full_disk_gives_the_alarm_and_leaves_the_files_before_whole() {
    let mission = mission();
    let program = Backseat::new().file_max_kib(800);
    let mut controller = Controller::spawn(&mission, program);
    let mut client = controller.client();
    client.set(HIGH, &Generic::Ping { on: true });
    client.tell(Command::Switch {
        name: Box::from("before"),
    });
    client.tell(Command::Logging { on: true });
    wait_for_bytes(&controller, 100_000);
    client.tell(Command::Switch {
        name: Box::from("after"),
    });
    let (mode, alarm) = client.alarm(|alarm| matches!(alarm, Alarm::DiskSpaceCritical { .. }));
    assert_eq!(mode, AlarmMode::Active, "{alarm:?}");
    controller.process.says("logging ended: the disk is full", SOON);
    let told = controller.process.says("after.s7k: ", SOON);
    assert!(told.contains("File too large"), "{told}");
    // It pings on, and takes commands.
    client.subscribe(HIGH);
    client.hears(HIGH, 3);
    controller.process.signal(Signal::TERM);
    controller.ends();
    assert!(verified(&controller.folder.join("before.s7k")) > 3);
    // The other one has all records that found room, and nothing behind them.
    assert!(verified_up_to_the_cut(&controller.folder.join("after.s7k")) > 10);
}

#[test]
fn a_stuck_disk_stalls_neither_the_controller_nor_its_clients() {
    let mission = mission();
    let stall = Stall::new();
    let folder = mission.beside("logs");
    let program = Backseat::new().stalled(&stall, &[folder.as_path()]);
    let mut controller = Controller::spawn(&mission, program);
    let mut client = controller.client();
    client.subscribe(HIGH);
    client.set(HIGH, &Generic::Ping { on: true });
    client.tell(Command::Logging { on: true });
    wait_for_bytes(&controller, 50_000);
    stall.begin();
    stall.holds("write", ".s7k", SOON);
    let watch = Stopwatch::start();
    client.tell(Command::Version {});
    client.solicits(|status| matches!(status, Status::Version { .. }).then_some(()));
    assert!(watch.elapsed() < Duration::from_secs(5), "{:?}", watch.elapsed());
    let before = client.count(HIGH);
    client.hears(HIGH, before + 20);
    stall.end();
    controller.process.signal(Signal::TERM);
    controller.ends();
    // Nothing that waited is lost.
    let records = verified(&controller.logs()[0]);
    assert!(records > 20, "{records}");
}

#[test]
fn fifty_clients_and_a_flood_of_commands_cost_nobody_else_anything() {
    let mission = mission();
    let controller = Controller::start(&mission);
    let mut good = controller.client();
    good.subscribe(HIGH);
    good.set(HIGH, &Generic::Ping { on: true });
    good.hears(HIGH, 5);
    let memory = controller.process.memory_kib();
    let mut others: Vec<Client> = (0..50).map(|_| controller.client()).collect();
    for other in &mut others {
        other.subscribe(HIGH);
    }
    // One sends commands as fast as it can; one sends bytes that are no records; the others never read.
    let flood = others.pop().unwrap().floods(Client::command(&Command::Modules {}));
    let garbage = others.pop().unwrap().floods(vec![0x55; 4096]);
    let watch = Stopwatch::start();
    let before = good.count(HIGH);
    while watch.elapsed() < Duration::from_secs(6) {
        good.hears(HIGH, good.count(HIGH) + 1);
    }
    // Nine pings a second; none was lost.
    let heard = good.count(HIGH) - before;
    assert!(heard >= 40, "{heard} pings in 6 s\n{}", controller.process.stderr());
    assert!(good.pings_are_in_a_row(HIGH));
    let asked = Stopwatch::start();
    good.tell(Command::Version {});
    good.solicits(|status| matches!(status, Status::Version { .. }).then_some(()));
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    let grown = controller.process.memory_kib().saturating_sub(memory);
    assert!(grown < 400_000, "{grown} KiB");
    drop((flood, garbage, others));
    let mut last = controller.client();
    last.tell(Command::Version {});
    last.solicits(|status| matches!(status, Status::Version { .. }).then_some(()));
}

#[test]
fn what_cannot_be_served_is_one_line() {
    let mission = mission();
    let plc = |mission: &Mission| Backseat::new().arg("plc").mission(mission);
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let line = plc(&mission).args(["--listen", &address]).run().refusal();
    assert!(line.contains("is in use") && line.contains("--listen"), "{line}");
    let file = mission.beside("file");
    fs::write(&file, "").unwrap();
    let line = plc(&mission).arg("--folder").arg(&file).run().refusal();
    assert!(line.contains("is not a folder"), "{line}");
    let folder = mission.beside("damaged");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("6046.sav"), "nonsense").unwrap();
    let line = plc(&mission).arg("--folder").arg(&folder).run().refusal();
    assert!(line.contains("damaged: 6046.sav, line 1: expected the title"), "{line}");
    let line = plc(&mission).args(["--listen", "nowhere"]).run().refusal();
    assert!(line.contains("expected ADDRESS:PORT"), "{line}");
    let used = Controller::start(&mission);
    let line = plc(&mission).args(["--listen", "127.0.0.1:0", "--folder"]);
    let line = line.arg(&used.folder).run().refusal();
    assert!(line.contains("another payload controller uses this folder"), "{line}");
    let broken = Mission::steady().append("world.toml", "[plc]\nclients_max = 0\n");
    let line = plc(&broken).run().refusal();
    assert!(line.contains("plc.clients_max is 0, expected 1 to 64"), "{line}");
    let line = plc(&Mission::steady().without("world.toml")).run().refusal();
    assert!(
        line.contains("a folder without world.toml: expected a folder with world.toml"),
        "{line}"
    );
}

#[test]
fn a_mission_without_the_table_has_a_controller_with_the_defaults() {
    let done = Backseat::new()
        .args(["plc", "--listen", "127.0.0.1:0", "--duration", "1"])
        .mission(&Mission::steady())
        .run()
        .exit(0);
    assert!(done.stderr.contains("files are not kept"), "{done}");
    assert!(done.stderr.contains("sensor 0 (sub-bottom profiler) starts"), "{done}");
}

#[test]
fn one_process_serves_the_vehicle_and_the_controller_on_it() {
    let mission = mission().edit(
        "world.toml",
        "depth_m = 8\nspeed_mps = 1.5\ndynamic",
        "altitude_m = 20\nspeed_mps = 1.5\ndynamic",
    );
    let folder = mission.beside("logs");
    let flags = [
        "--speed",
        "10",
        "--with-plc",
        "127.0.0.1:0",
        "--plc-folder",
        folder.to_str().unwrap(),
    ];
    let mut vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &flags);
    let line = vehicle.process.says("payload controller at ", SOON);
    let (_, rest) = line.split_once("payload controller at ").unwrap();
    let mut client = Client::connect(rest.split_once(';').unwrap().0);
    client.subscribe(SUB_BOTTOM);
    client.set(SUB_BOTTOM, &Generic::Ping { on: true });
    client.tell(Command::Logging { on: true });
    client.hears(SUB_BOTTOM, 1);
    // The vehicle dives to 20 m above the seabed, and its profiler sees that.
    eventually(
        SOON,
        || {
            client.hears(SUB_BOTTOM, 1);
            ((client.brightest(SUB_BOTTOM).0 - 20.0).abs() < 1.0).then_some(())
        },
        || format!("the bed is not 20 m below\n{}", vehicle.process.stderr()),
    );
    vehicle.sees("the controller's events", SOON, |line| {
        line.text.contains("plc: logging to ")
    });
    vehicle.process.signal(Signal::TERM);
    assert_eq!(vehicle.process.wait(SOON), Some(0), "{}", vehicle.process.stderr());
    let logs = logs(&folder);
    assert_eq!(logs.len(), 1);
    assert!(verified(&logs[0]) > 10);
    assert!(
        logs[0].file_name().unwrap().to_str().unwrap().starts_with("20260601_"),
        "by the vehicle's clock"
    );
}
