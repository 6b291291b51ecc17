//! A seabed from a grid, the tide over it, and plans that have too little water.

use backseat_mvc::{Activity, Mvc, MvcError, WorldFile};
use backseat_units::Timestamp;
use backseat_units::math::cos;
use backseat_world::Grid;

use crate::files::CALM;
use crate::payload::{Payload, done};
use crate::sentences::{field, heard, with};

/// Six by six cells of 100 m about the origin: 40 m of water, and a bank in the north-east.
const BED: &str = "ncols 6\nnrows 6\nxllcorner -300\nyllcorner -100\ncellsize 100\n\
                   40 40 40 40 40 40\n40 40 40 40 2 2\n40 40 40 40 9 9\n40 40 40 40 40 40\n40 40 40 40 40 40\n\
                   40 40 40 40 40 40\n";

fn charted(text: &str) -> String {
    text.replace("depth_m = 60\nslope = 0\nmeanders = 0", "grid = \"bed.asc\"")
}

fn over(text: &str, bed: &str) -> Result<Mvc, MvcError> {
    let file = WorldFile::from_toml(text)?;
    Mvc::with_grid(&file, 1, Some(Grid::from_bytes(bed.as_bytes())?))
}

fn plan(text: &str, elements: &str) -> String {
    let (before, _) = text.split_once("[[plan]]").expect("the file has a plan");
    format!("{before}{elements}")
}

fn waypoint(east_m: i32, north_m: i32, vertical: &str) -> String {
    format!(
        "[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = {east_m}, north_m = {north_m} }}\n{vertical}\nspeed_mps = 2\n"
    )
}

#[test]
fn the_vehicle_flies_over_the_grids_bottom() {
    let text = charted(&plan(
        CALM,
        &format!(
            "{}{}",
            waypoint(0, 300, "altitude_m = 8"),
            waypoint(-150, 300, "depth_m = 10")
        ),
    ));
    // The grid's values have a slope of 1 in 10 to the north.
    let rows: String = (0..6)
        .map(|row| format!("{0} {0} {0} {0} {0} {0}\n", 70 - 10 * row))
        .collect();
    let (header, _) = BED.split_once("40 40").expect("the grid has rows");
    let mvc = over(&text, &format!("{header}{rows}")).expect("there is water");
    let mut payload = Payload::of(mvc);
    payload.connect(crate::payload::ME);
    payload.say("$BPLOG,NVG,ON");
    payload.until(120.0);
    let truth = payload.mvc.truth();
    let expected_m = 25.0 + 0.1 * (truth.local.north_m + 50.0) - 5.0;
    assert!((truth.water_depth_m - expected_m).abs() < 0.01, "{truth:?}");
    assert!((truth.altitude_m - 8.0).abs() < 1.5, "{truth:?}");
    let heard = payload.heard();
    let line = heard.last().expect("navigation");
    assert!((field(line, 7) - truth.altitude_m).abs() < 0.01, "{line}");
    done(&mut payload);
}

#[test]
fn a_plan_without_enough_water_is_refused_with_its_element_and_the_place() {
    let fault = |elements: &str| over(&charted(&plan(CALM, elements)), BED).unwrap_err().to_string();
    // The bank is 2 m under water, its southern shoulder 9 m.
    let there = waypoint(0, 350, "depth_m = 8");
    assert_eq!(
        fault(&format!("{there}{}", waypoint(200, 350, "depth_m = 1"))),
        "plan element 2: the water is 2.00 m deep at 150 m east, 350 m north (latitude 42.30315, longitude -70.89818), \
         expected at least 2.50 m: vehicle.altitude_min_m plus 0.5 m"
    );
    // A line across the shoulder at 12 m leads into the ground.
    let line = "[[plan]]\nkind = \"trackline\"\nstart = { east_m = -100, north_m = 250 }\nend = { east_m = 280, north_m = 250 }\n\
                depth_m = 12\nspeed_mps = 2\n";
    let message = fault(line);
    assert!(message.starts_with("plan element 1: the water is 1"), "{message}");
    assert!(
        message.ends_with("expected at least 12.00 m: the element's depth"),
        "{message}"
    );
    // At 5 m the line is accepted. So is an altitude, because the vehicle holds it over the bank as far as there is
    // room.
    assert!(over(&charted(&plan(CALM, &line.replace("depth_m = 12", "depth_m = 5"))), BED).is_ok());
    assert!(
        over(
            &charted(&plan(CALM, &line.replace("depth_m = 12", "altitude_m = 12"))),
            BED
        )
        .is_ok()
    );
    // What reaches the bank here is a lead-in, the far side of a circle, the way to an element, or the vehicle's start.
    let led = "[[plan]]\nkind = \"trackline\"\nlead_in_m = 200\nstart = { east_m = -50, north_m = 350 }\n\
               end = { east_m = -250, north_m = 350 }\ndepth_m = 1\nspeed_mps = 2\n";
    assert!(
        over(
            &charted(&plan(CALM, &led.replace("lead_in_m = 200", "lead_in_m = 20"))),
            BED
        )
        .is_ok()
    );
    assert!(fault(led).starts_with("plan element 1: the water is 2."));
    let circle = "[[plan]]\nkind = \"trackcircle\"\ncentre = { east_m = 50, north_m = 350 }\nradius_m = 100\norbits = 0.1\n\
                  entry_angle_deg = 270\ndepth_m = 1\nspeed_mps = 2\n";
    assert!(fault(circle).starts_with("plan element 1: the water is 2."));
    let started = charted(&plan(CALM, &waypoint(0, 0, "depth_m = 1")))
        .replace("[origin]", "east_m = 200\nnorth_m = 350\n[origin]");
    assert!(
        over(&started, BED)
            .unwrap_err()
            .to_string()
            .starts_with("plan element 1: the water is 2.00 m deep at 200 m east")
    );
    // Nobody knows where a setpoint ends, so the element after it is checked only from its own place on.
    let setpoint = "[[plan]]\nkind = \"setpoint\"\nheading_deg = 90\nduration_s = 900\ndepth_m = 1\nspeed_mps = 2\n";
    assert!(over(&charted(&plan(CALM, &format!("{there}{setpoint}{there}"))), BED).is_ok());
}

/// Beyond its edge a grid does not define the seabed.
#[test]
fn a_plan_or_a_start_off_the_grid_is_refused() {
    let fault = |text: &str| over(&charted(text), BED).unwrap_err().to_string();
    let far = plan(CALM, &waypoint(0, 600, "depth_m = 8"));
    assert!(fault(&far).starts_with("plan element 1: it leads off the grid of the seabed at 0 m east, 50"));
    let away = plan(CALM, &waypoint(0, 0, "depth_m = 8")).replace("[origin]", "east_m = 301\n[origin]");
    assert!(fault(&away).starts_with("start is 301 m east, 0 m north"));
    assert!(over(&charted(&away.replace("east_m = 301", "east_m = 299")), BED).is_ok());
}

/// A drawn seabed is checked as this seed has it.
#[test]
fn a_plan_without_enough_water_over_a_drawn_seabed_is_refused() {
    let shallow = |depth: &str| {
        let low = CALM.replace("depth_m = 10", "depth_m = 2");
        let file = WorldFile::from_toml(&low.replace("depth_m = 60", depth)).expect("a file");
        Mvc::new(&file, 1)
    };
    assert!(shallow("depth_m = 8").is_ok());
    assert!(shallow("depth_m = 2.5\ndepth_min_m = 1").is_ok());
    let message = shallow("depth_m = 2.4\ndepth_min_m = 1").unwrap_err().to_string();
    assert!(
        message.starts_with("plan element 1: the water is 2.40 m deep at 0 m east, 0 m north"),
        "{message}"
    );
    // With some seeds a bank is in the way, and the plan is refused.
    let banks = CALM.replace("depth_m = 10", "depth_m = 2").replace(
        "depth_m = 60",
        "depth_m = 10\ndepth_min_m = 1\nbanks = 3\nbank_height_m = 9\nbank_east_m = [-300, 300]\nbank_north_m = [0, 400]\n\
         bank_radius_m = 60",
    );
    let file = WorldFile::from_toml(&banks).expect("the file is right for all seeds");
    let refused = (0..40).filter(|seed| Mvc::new(&file, *seed).is_err()).count();
    assert!((1..40).contains(&refused), "{refused}");
}

#[test]
fn a_grid_that_is_named_must_be_given_and_valid() {
    let file = WorldFile::from_toml(&charted(CALM)).expect("a file is right without its grid");
    assert_eq!(
        Mvc::new(&file, 1).unwrap_err().to_string(),
        "seabed.grid is `bed.asc`, but the caller passed no grid: expected the content of that file"
    );
    let message = over(CALM, BED).unwrap_err().to_string();
    assert!(message.starts_with("seabed.grid: expected"), "{message}");
    let holes = BED.replacen("40", "-9999", 1);
    let message = over(&charted(CALM), &holes).unwrap_err().to_string();
    assert!(message.starts_with("grid, row 1, column 1: no data"), "{message}");
    let both = charted(CALM).replace("grid =", "banks = 2\ngrid =");
    let message = WorldFile::from_toml(&both).unwrap_err().to_string();
    assert_eq!(message, "seabed.banks: expected this key or `seabed.grid`, not both");
}

/// SPI 6.1: the altitude counts from the seabed, and the depth from the surface, wherever the tide has that.
#[test]
fn the_tide_raises_the_surface_over_the_bottom() {
    let text = format!("{CALM}\n[tide]\namplitude_m = 3\nperiod_h = 0.1\n");
    let (payload, lines) = heard(&text, 1, "NVG", 60.0, 185.0);
    let sum = |line: &String| field(line, 7) + field(line, 8);
    let seconds = |line: &String| {
        let stamp = field(line, 1);
        (stamp / 100.0).floor() % 100.0 * 60.0 + stamp % 100.0
    };
    for line in lines.iter().filter(|line| field(line, 7) > 0.0) {
        let tide_m = 3.0 * cos(std::f64::consts::TAU * seconds(line) / 360.0);
        assert!((sum(line) - 60.0 - tide_m).abs() < 0.01, "{line} {tide_m}");
    }
    let truth = payload.mvc.truth();
    let world = payload.mvc.world();
    assert_eq!(world.water_depth_m(truth.local), 60.0);
    assert!((truth.water_depth_m - world.water_depth_at_m(truth.local, truth.time)).abs() < 1e-9);
    // At low water the vehicle is still at the depth that the plan asks for.
    assert!((truth.depth_m - 10.0).abs() < 0.2, "{truth:?}");
}

/// SPI 6.4, 6.6, 6.16: all three sensors measure the same sea water.
#[test]
fn pressure_and_speed_of_sound_are_those_of_the_world() {
    let text = with(CALM, "sensors.sound", "fitted = true");
    let mut payload = Payload::connected(&text, 1, &["CTD", "RDP", "SVS"]);
    payload.until(60.0);
    let truth = payload.mvc.truth();
    let lines = payload.heard();
    let newest = |name: &str| lines.iter().rfind(|line| line.starts_with(name)).expect("it is on");
    let world = payload.mvc.world();
    let now = Timestamp::from_secs(60);
    let pressure_kpa = 101.325 + 10.0 * world.pressure_dbar(truth.depth_m);
    assert!((field(newest("$BFRDP"), 2) - pressure_kpa).abs() < 0.02);
    assert!((field(newest("$BFCTD"), 4) - pressure_kpa).abs() < 0.02);
    let sound_mps = world.sound_speed_mps(truth.local, truth.depth_m, now);
    assert!((field(newest("$BFSVS"), 2) - sound_mps).abs() < 0.01);
    assert!((sound_mps - 1497.0).abs() < 2.0, "{sound_mps}");
    assert!(matches!(truth.activity, Activity::Plan { number: 1 }));
}
