//! How the mock vehicle starts and what it leaves: with a world alone, when enough clients are there, its map and truth.

use std::time::Duration;

use backseat_suite::{Backseat, Mission, Stopwatch, Vehicle, settle};

use super::mvc::Client;

const SOON: Duration = Duration::from_secs(20);

#[test]
fn the_vehicle_s_clock_stands_until_two_clients_are_connected() {
    let mission = Mission::steady();
    let vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &["--wait", "2", "--speed", "10"]);
    vehicle.process.says("the vehicle's clock waits for 2 clients", SOON);
    let mut first = Client::connect(&vehicle.address);
    first.hears("$BFVER,080000.000");
    vehicle
        .process
        .says("the vehicle's clock waits: 1 of 2 clients connected", SOON);
    settle(Duration::from_millis(700));
    // It answers meanwhile, at its time zero.
    first.say("$BPLOG,ACK,ON");
    first.hears("$BFACK,080000.000,LOG");
    first.say("$BPLOG,NVG,ON");
    let mut second = Client::connect(&vehicle.address);
    second.hears("$BFVER,080000.000");
    vehicle.process.says("the vehicle's clock begins", SOON);
    first.hears("$BFNVG,0800");
    let navigation = first.lines().into_iter().find(|line| line.starts_with("$BFNVG"));
    assert!(navigation.expect("it was heard").starts_with("$BFNVG,080000.1"));
    // It goes at its speed from then on, and never stands again.
    drop(second);
    let watch = Stopwatch::start();
    first.hears("$BFNVG,080030.000");
    assert!(watch.elapsed() < Duration::from_secs(10), "{:?}", watch.elapsed());
}

#[test]
fn at_the_greatest_speed_it_waits_for_as_many_as_it_is_told() {
    let mission = Mission::steady();
    let flags = ["--wait", "2", "--speed", "max", "--duration", "100"];
    let mut vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &flags);
    let mut first = Client::connect(&vehicle.address);
    first.hears("$BFVER,080000.000");
    settle(Duration::from_millis(500));
    assert_eq!(vehicle.process.ended(), None);
    let mut second = Client::connect(&vehicle.address);
    second.hears("$BFVER,080000.000");
    assert_eq!(vehicle.process.wait(SOON), Some(0));
    // Without clients it need not wait.
    let flags = ["--wait", "0", "--speed", "max", "--duration", "100"];
    let mut alone = Vehicle::start_with(&mission, "127.0.0.1:0", &flags);
    assert_eq!(alone.process.wait(SOON), Some(0));
}

#[test]
fn at_the_greatest_speed_the_first_words_of_a_client_arrive_in_time() {
    let mission = Mission::steady();
    let flags = ["--speed", "max", "--duration", "2000"];
    let vehicle = Vehicle::start_with(&mission, "127.0.0.1:0", &flags);
    let mut client = Client::connect(&vehicle.address);
    client.hears("$BFVER,080000.000");
    // One after the other, as a program that thinks between them.
    for name in ["ACK", "CTL", "NVG"] {
        settle(Duration::from_millis(100));
        client.say(&format!("$BPLOG,{name},ON"));
    }
    client.hears("$BFACK,080000.000,LOG");
    client.hears("$BFNVG,080000.1");
    // It says who has control when its leg begins, and the client hears that.
    client.hears("$BFCTL,0800");
}

#[test]
fn a_world_is_enough_and_control_is_the_whole_mission_s_without_an_edit() {
    let mission =
        Mission::steady()
            .without("mission.toml")
            .without("fence.geojson")
            .edit("world.toml", "dynamic = true\n", "");
    let world = mission.path().join("world.toml");
    let other = mission.path().join("steady sea.toml");
    std::fs::rename(&world, &other).expect("the folder is ours");
    let file = other.to_str().expect("a path of ASCII");
    let missing = Backseat::new()
        .args(["mvc", "--listen", "127.0.0.1:0"])
        .mission(&mission)
        .run()
        .refusal();
    assert!(
        missing
            .ends_with("a folder without world.toml: expected a folder with world.toml, or the path of a world.toml"),
        "{missing}"
    );
    let out = mission.beside("run.log");
    let run = |place: &str, control: &str| {
        let run = Backseat::new()
            .args([
                "mvc",
                "--listen",
                "127.0.0.1:0",
                "--wait",
                "0",
                "--speed",
                "max",
                "--duration",
                "60",
            ])
            .args(["--control", control, place, "--log"])
            .arg(&out)
            .run();
        let _ended = run.exit(0);
        std::fs::read_to_string(&out)
            .expect("it was written")
            .contains("control given to the payload")
    };
    assert!(run(file, "mission"));
    assert!(!run(file, "plan"));
    std::fs::rename(&other, &world).expect("the folder is ours");
    assert!(run(mission.path().to_str().expect("a path of ASCII"), "mission"));
}

#[test]
fn it_leaves_a_map_and_the_truth_of_each_second() {
    let mission = Mission::steady();
    let (map, truth) = (mission.beside("map.svg"), mission.beside("truth.csv"));
    let flags = [
        "--speed",
        "20",
        "--wait",
        "1",
        "--duration",
        "120",
        "--control",
        "mission",
        "--profile",
        "field",
    ];
    let mut vehicle = Vehicle::start_with(
        &mission,
        "127.0.0.1:0",
        &[
            &flags[..],
            &[
                "--map",
                map.to_str().expect("ASCII"),
                "--truth",
                truth.to_str().expect("ASCII"),
            ],
        ]
        .concat(),
    );
    let mut client = Client::connect(&vehicle.address);
    client.hears("$BFCTL,080002.000,1");
    client.say("$BPRTK,080000.000,7,4221.000,N,07042.2,W,4221.000,N,07042.0,W,0,8,1.5,0,4");
    assert_eq!(vehicle.process.wait(SOON), Some(0));
    vehicle.process.says("map: ", SOON);
    let text = std::fs::read_to_string(truth).expect("it was written");
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().expect("the columns").split(',').collect();
    let column = |name: &str| columns.iter().position(|column| *column == name).expect(name);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 121, "from second 0 to 120");
    let number = |row: usize, name: &str| rows[row][column(name)].parse::<f64>().expect("a number");
    assert_eq!((number(0, "time_s"), number(120, "time_s")), (0.0, 120.0));
    assert_eq!(rows[60][column("utc")], "08:01:00.000");
    // It flies east at 1.5 m/s, 8 m deep in 50 m of water.
    assert!(
        (number(100, "east_m") - number(60, "east_m") - 60.0).abs() < 3.0,
        "{text}"
    );
    assert!(
        (number(100, "depth_m") - 8.0).abs() < 0.5 && number(100, "altitude_m") > 20.0,
        "{text}"
    );
    assert!((number(100, "heading_deg") - 90.0).abs() < 5.0, "{text}");
    assert_eq!(
        (rows[1][column("activity")], rows[100][column("activity")]),
        ("waiting", "insert")
    );
    assert_eq!(
        (rows[1][column("control")], rows[100][column("control")]),
        ("vehicle", "payload")
    );
    let map = std::fs::read_to_string(map).expect("it was drawn");
    for part in [
        "<svg",
        ">steady<",
        "insert as asked",
        "flown: client&apos;s insert",
        "planned",
    ] {
        let also = part.replace("&apos;", "'");
        assert!(map.contains(part) || map.contains(&also), "no {part}\n{map}");
    }
    assert!(!map.contains("stay inside"), "there is no fence");
}
