//! An external source of the operator, as a separate program that sends the runtime the sentences that it would send
//! the vehicle.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::Duration;

use backseat_suite::{Backseat, Mission, Vehicle, eventually, free_address};

use super::session::{SOON, runtime};

const READ_WITHIN: Duration = Duration::from_secs(10);

fn with_external(address: &str) -> Mission {
    Mission::steady().append(
        "mission.toml",
        &format!("\n[[external]]\nname = \"modem\"\nsends = [\"BPTMR\"]\nlisten = \"{address}\"\n"),
    )
}

fn connect(address: &str) -> BufReader<TcpStream> {
    let stream = eventually(
        SOON,
        || TcpStream::connect(address).ok(),
        || format!("nobody listens on {address}"),
    );
    stream
        .set_read_timeout(Some(READ_WITHIN))
        .expect("a time-out above zero");
    BufReader::new(stream)
}

fn answer(source: &mut BufReader<TcpStream>, line: &str) -> Vec<String> {
    source
        .get_mut()
        .write_all(line.as_bytes())
        .expect("the runtime hears the external source");
    let mut answer = String::new();
    source.read_line(&mut answer).expect("the runtime answers");
    answer.split(',').map(str::to_owned).collect()
}

#[test]
fn what_an_external_source_says_reaches_the_vehicle_and_the_answer_comes_back() {
    let address = free_address();
    let mission = with_external(&address);
    let vehicle = Vehicle::start(&mission);
    let runtime = runtime(&mission, &vehicle.address, &["--arm"]);
    vehicle.receives("BPRMB", 2, SOON);
    let mut source = connect(&address);
    let relayed = answer(&mut source, "$BPTMR,081025.987,3,come home\n");
    assert_eq!(
        (relayed[0].as_str(), relayed[2].as_str(), relayed[3].as_str()),
        ("$BFACK", "TMR", "081025.987")
    );
    let received = vehicle.receives("BPTMR", 1, SOON);
    assert_eq!((received.field(2), received.field(3)), ("3", "come home"));
    assert_ne!(received.field(1), "081025.987", "under the runtime's own stamp");

    let refused = answer(&mut source, "$BPABT,081026.987,for no reason,1\n");
    assert_eq!(
        (refused[2].as_str(), refused[3].as_str(), refused[5].as_str()),
        ("ABT", "081026.987", "0")
    );
    let mut second = connect(&address);
    let mut line = String::new();
    second.read_line(&mut line).unwrap();
    assert_eq!(line, "external source modem is connected already\r\n");

    // However much it sends, the vehicle is steered and no refresh is late.
    let steered = vehicle.received("BPRMB").len();
    let flood = "$BPTMR,081025.987,3,come home\n".repeat(100_000);
    source
        .get_mut()
        .set_write_timeout(Some(Duration::from_secs(2)))
        .unwrap();
    let _blocked = source.get_mut().write_all(flood.as_bytes());
    vehicle.receives("BPRMB", steered + 3, SOON);
    let times: Vec<f64> = vehicle.received("BPRMB").iter().map(|line| line.at_s).collect();
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] < 2.5), "{times:?}");
    assert!(vehicle.received("BPABT").is_empty());
    assert!(!runtime.stderr().contains("late"), "{}", runtime.stderr());
}

#[test]
fn an_address_that_is_taken_is_refused_at_the_start() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let mission = with_external(&address);
    let refusal = Backseat::new()
        .args(["run", "--connect", "127.0.0.1:1", "--log"])
        .arg(mission.beside("logs"))
        .arg("--state")
        .arg(mission.beside("state"))
        .mission(&mission)
        .run()
        .refusal_for_now();
    assert!(
        refusal.contains(&format!("external source `modem`: cannot listen on {address}")),
        "{refusal}"
    );
}
