//! Prints the row of the mock vehicle with six degrees of freedom.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Duration;

use backseat_bench::{HEADER, in_turn, row};
use backseat_mvc::{ClientId, MotionModel, Mvc, WorldFile};
use backseat_units::Timestamp;

const WORLD: &str = "
[start]
utc = 2026-06-01T08:00:00Z
[origin]
latitude_deg = 42.3
longitude_deg = -70.9
[current]
speed_mps = 0.2
";

pub(crate) fn print() {
    println!("{HEADER}");
    let mut file = survey();
    let mut kinematic = Vehicle::new(&file);
    file.vehicle.model = MotionModel::SixDof;
    let mut body = Vehicle::new(&file);
    // 15 rounds make an hour.
    let calls = 3600 * file.vehicle.tick_hz / 15;
    let times = in_turn(calls, || body.step(), || kinematic.step());
    let step = Duration::from_nanos(1_000_000_000 / u64::from(file.vehicle.tick_hz));
    let life = step.as_nanos() as f64 / times.0;
    row(
        &format!("step of the mock, 6-DOF at 50 Hz: {life:.0} x life"),
        times,
        "the same mission, kinematic",
        "2000 x life",
    );
}

/// More than an hour of legs of 300 m, to and fro.
fn survey() -> WorldFile {
    let mut text = WORLD.to_owned();
    for leg in 0..24 {
        let (from, to) = if leg % 2 == 0 { (0, 300) } else { (300, 0) };
        write!(
            text,
            "[[plan]]\nkind = \"trackline\"\nstart = {{ east_m = {from}, north_m = {north} }}\n\
             end = {{ east_m = {to}, north_m = {north} }}\ndepth_m = 10\nspeed_mps = 1.6\n",
            north = 50 * leg - 600,
        )
        .expect("a string");
    }
    WorldFile::from_toml(&text).expect("this is a world")
}

/// A vehicle whose BFNVG and BFNVR are built in each step for a client in the same process, and dropped.
struct Vehicle {
    mvc: Mvc,
    out: Vec<u8>,
}

impl Vehicle {
    fn new(file: &WorldFile) -> Self {
        let mut mvc = Mvc::new(file, 1).expect("a vehicle");
        let client = ClientId(1);
        mvc.connect(Timestamp::ZERO, client);
        mvc.receive(Timestamp::ZERO, client, b"$BPLOG,NVG,ON\r\n$BPLOG,NVR,ON\r\n");
        Self {
            mvc,
            out: Vec::with_capacity(4096),
        }
    }

    fn step(&mut self) {
        if let Some(at) = self.mvc.poll_timeout() {
            self.mvc.handle_timeout(at);
            while self.mvc.poll_transmit(&mut self.out).is_some() {
                black_box(self.out.len());
            }
            while self.mvc.poll_event().is_some() {}
        }
    }
}
