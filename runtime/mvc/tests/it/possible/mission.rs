//! Drawn missions and payloads, with everything that makes a vehicle change its motion.

use backseat_world::Stream;

use crate::payload::{Payload, line};

/// Which vehicle is flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    NineInch,
    TwelveInch,
    TwentyOneInch,
    SixDof,
    Hovering,
}

impl Kind {
    fn keys(self) -> &'static str {
        match self {
            Self::NineInch => "class = \"9-inch\"",
            Self::TwelveInch => "class = \"12-inch\"",
            Self::TwentyOneInch => "class = \"21-inch\"",
            Self::SixDof => "class = \"12-inch\"\nmodel = \"6-dof\"",
            Self::Hovering => "class = \"hovering\"\naltitude_min_m = 1",
        }
    }

    /// The slowest and the fastest speed of its plans, in metres a second.
    fn speeds(self) -> (f64, f64) {
        match self {
            Self::NineInch | Self::TwelveInch | Self::TwentyOneInch => (0.5, 2.3),
            Self::SixDof => (1.0, 2.3),
            Self::Hovering => (0.1, 0.75),
        }
    }
}

/// Draws one of a list.
fn one<T: Copy>(stream: &mut Stream, of: &[T]) -> T {
    of[(stream.uniform() * of.len() as f64) as usize % of.len()]
}

/// The `[sensors]` of a vehicle whose navigation is exact, so that only its motion is left.
const EXACT: &str = "[sensors]\nposition_noise_m = 0\nposition_drift_m_per_sqrt_h = 0\ndepth_noise_m = 0
heading_noise_deg = 0\nattitude_noise_deg = 0\nvelocity_noise_mps = 0\naltitude_noise_m = 0
altitude_dropouts_per_h = 60\n[sensors.ins]\nheading_bias_deg = 0\nvelocity_walk_mps_per_sqrt_s = 0\n[sensors.dvl]\nscale_error = 0
misalignment_deg = 0\nvelocity_noise_mps = 0\nrange_noise_m = 0\n[sensors.gps]\nerror_m = 0\n[sensors.depth]\nbias_kpa = 0\n";

/// A world, a vehicle and a plan.
pub(super) fn world(kind: Kind, exact: bool, hz: u32, seed: u64) -> String {
    let mut stream = Stream::new(seed, "possible mission");
    let stream = &mut stream;
    let hovers = kind == Kind::Hovering;
    let water_m = if hovers { 14.0 } else { stream.uniform_in(25.0, 60.0) };
    let start_m = if hovers { 3.0 } else { one(stream, &[0.0, 0.0, 5.0]) };
    let profile = one(
        stream,
        &["", "decay_depth_m = 4", "bottom_boundary_m = 6", "rotation_h = 0.2"],
    );
    let current_mps = if hovers { 0.25 } else { 0.5 };
    let mut text = format!(
        "[start]\nutc = 2026-06-01T08:00:00Z\nnorth_m = -12\ndepth_m = {start_m}\nheading_deg = {:.0}\n[origin]\nlatitude_deg \
         = 42.3\nlongitude_deg = -70.9\n[seabed]\ndepth_m = {water_m:.1}\nslope = {:.3}\nmeanders = {}\n[current]\nspeed_mps = \
         {:.2}\ntowards_deg = {:.0}\n{profile}\n[vehicle]\n{}\ntick_hz = {hz}\n",
        stream.uniform_in(0.0, 360.0),
        if hovers { 0.01 } else { 0.04 },
        if hovers { 0 } else { 2 },
        stream.uniform_in(0.0, current_mps),
        stream.uniform_in(0.0, 360.0),
        kind.keys(),
    );
    if hovers {
        text.push_str("[hovering]\ndrift_m_per_sqrt_h = 0\nbearing_drift_deg_per_sqrt_h = 0\nposition_noise_m = 0\n");
        text.push_str("range_noise_m = 0\n");
        if stream.uniform() < 0.8 {
            text.push_str("[hovering.hull]\neast_m = 0\nnorth_m = 0\nheading_deg = 90\nlength_m = 30\nbeam_m = 10\n");
            text.push_str("draft_m = 5\n");
        }
    }
    if exact {
        text.push_str(EXACT);
    } else if stream.uniform() < 0.3 {
        let without = one(stream, &["inertial", "water"]);
        text.push_str(&format!(
            "[sensors]\naltitude_range_m = 15\n[sensors.ins]\nwithout_lock = \"{without}\"\nvelocity_walk_mps_per_sqrt_s = 0.02\n"
        ));
    }
    text.push_str(&format!(
        "[silence]\nsettle_s = 0.5\n[mission]\nstarts_after_s = 3\ngps_fix_s = 12\ngps_within_s = 90\ntime_limit_s = 420\nwrap_up = \"{}\"\n[spi]\n\
         acknowledge = \"immediate\"\npending_s = 0.5\n[interpretation]\nmodify_beyond = \"clip\"\nafter_suspension = \"seed\"\nmodify_fins = \
         \"seed\"\nafter_interrupt = \"seed\"\n",
        one(stream, &["none", "surface"]),
    ));
    for _ in 0..8 {
        text.push_str(&element(stream, kind));
    }
    text
}

/// A drawn place: for a hovering vehicle one beside the ship, for the others any.
fn place(stream: &mut Stream, kind: Kind) -> String {
    let (east_m, north_m) = match kind {
        Kind::Hovering => (stream.uniform_in(-25.0, 25.0), stream.uniform_in(-25.0, -8.0)),
        Kind::NineInch | Kind::TwelveInch | Kind::TwentyOneInch | Kind::SixDof => {
            (stream.uniform_in(-80.0, 80.0), stream.uniform_in(-80.0, 80.0))
        }
    };
    format!("{{ east_m = {east_m:.1}, north_m = {north_m:.1} }}")
}

fn element(stream: &mut Stream, kind: Kind) -> String {
    let (slowest, fastest) = kind.speeds();
    let depth_m = if kind == Kind::Hovering { 8.0 } else { 18.0 };
    let vertical = if stream.uniform() < 0.6 {
        format!("depth_m = {:.1}", stream.uniform_in(0.0, depth_m))
    } else {
        format!("altitude_m = {:.1}", stream.uniform_in(3.0, 12.0))
    };
    let speed_mps = stream.uniform_in(slowest, fastest);
    let shape = match one(stream, &[0, 1, 2, 3]) {
        0 => format!("kind = \"waypoint\"\nat = {}", place(stream, kind)),
        1 => {
            let (start, end) = (place(stream, kind), place(stream, kind));
            format!("kind = \"trackline\"\nstart = {start}\nend = {end}")
        }
        2 => format!(
            "kind = \"trackcircle\"\ncentre = {}\nradius_m = {:.0}\norbits = {}",
            place(stream, kind),
            if kind == Kind::Hovering {
                5.0
            } else {
                stream.uniform_in(8.0, 40.0)
            },
            one(stream, &[1.0, -1.0, 0.5]),
        ),
        _ => format!(
            "kind = \"setpoint\"\nheading_deg = {:.0}\nduration_s = 30",
            stream.uniform_in(0.0, 360.0)
        ),
    };
    format!("[[plan]]\n{shape}\n{vertical}\nspeed_mps = {speed_mps:.2}\ntimeout_s = 90\ndynamic = true\n")
}

/// What a payload says from now on, and for how many seconds it keeps saying it once a second.
#[derive(Clone, Debug)]
pub(super) struct Said {
    pub(super) sentence: String,
    pub(super) for_s: u32,
    /// Whether the sentence moves the navigation.
    pub(super) fixes: bool,
}

/// The next thing that the payload says.
pub(super) fn said(stream: &mut Stream, kind: Kind, id: u32) -> Said {
    let any = stream.uniform();
    let hovers = kind == Kind::Hovering;
    let say = |sentence: String, for_s| Said {
        sentence,
        for_s,
        fixes: false,
    };
    if any < 0.45 {
        return say(modify(stream, kind), 6 + (stream.uniform() * 14.0) as u32);
    }
    if hovers && any < 0.75 {
        let target = hover(stream);
        return say(target, 5 + (stream.uniform() * 25.0) as u32);
    }
    let interrupt = one(stream, &[0, 4]);
    match (any * 1000.0) as u32 % 6 {
        0 => say(line(id, (stream.uniform() * 10.0) as u32, interrupt), 1),
        1 => say(
            format!(
                "$BPRTC,070000.000,{id},4218.00,N,07054.00,W,{:.0},{},0,{:.0},1.5,0,0,{interrupt}",
                stream.uniform_in(8.0, 30.0),
                one(stream, &[1, -1]),
                stream.uniform_in(2.0, 15.0),
            ),
            1,
        ),
        2 => say(
            format!(
                "$BPRGP,070000.000,{id},4218.00,N,07054.00,W,120,5,{}",
                one(stream, &[0, 2])
            ),
            1,
        ),
        3 => Said {
            sentence: "$BPNPU,070000.000,4218.000000,N,07054.000000,W,3,10,1,070000.000".to_owned(),
            for_s: 1,
            fixes: true,
        },
        4 => say("$BPRES,070000.000".to_owned(), 1),
        _ => say("$BPRCB,070000.000,0".to_owned(), 1),
    }
}

fn modify(stream: &mut Stream, kind: Kind) -> String {
    let horizontal = match one(stream, &[0, 0, 1, 2]) {
        0 => format!("{:.0},", stream.uniform_in(0.0, 360.0)),
        1 => format!("{:.0},", stream.uniform_in(-20.0, 20.0)),
        _ => ",".to_owned(),
    };
    let rudder = i32::from(stream.uniform() < 0.3);
    let horizontal = if horizontal == "," {
        ",".to_owned()
    } else {
        format!("{horizontal}{rudder}")
    };
    let vertical = match one(stream, &[0, 0, 1, 2, 3, 4]) {
        0 => format!("{:.1},0", stream.uniform_in(0.0, 15.0)),
        1 => format!("{:.1},1", stream.uniform_in(2.0, 15.0)),
        2 => format!("{:.0},2", stream.uniform_in(-25.0, 25.0)),
        3 => format!("{:.0},3", stream.uniform_in(-20.0, 20.0)),
        _ => ",".to_owned(),
    };
    let (slowest, fastest) = kind.speeds();
    let speed = match one(stream, &[0, 0, 0, 1, 2]) {
        0 => format!("{:.2},1", stream.uniform_in(slowest, fastest)),
        1 => "0,0".to_owned(),
        _ => ",".to_owned(),
    };
    format!("$BPRMB,070000.000,{horizontal},{vertical},{speed}")
}

fn hover(stream: &mut Stream) -> String {
    match one(stream, &[0, 1, 1, 2, 2, 3]) {
        0 => "$BPCON,070000.000".to_owned(),
        1 => format!(
            "$BPGHP,070000.000,{:.1},{:.1},{:.1}",
            stream.uniform_in(-12.0, 12.0),
            stream.uniform_in(0.0, 6.0),
            stream.uniform_in(0.6, 6.0)
        ),
        2 => format!(
            "$BPGBP,070000.000,{:.1},{:.1},{},{:.1}",
            stream.uniform_in(-20.0, 2.0),
            stream.uniform_in(-20.0, 20.0),
            one(stream, &["D", "A"]),
            stream.uniform_in(2.0, 8.0)
        ),
        _ => format!("$BPSPD,070000.000,{:.2}", stream.uniform_in(0.1, 1.5)),
    }
}

/// Sends the sentence, and before it what a hovering vehicle needs first.
pub(super) fn speak(payload: &mut Payload, said: &Said) {
    if said.sentence.starts_with("$BPG") || said.sentence.starts_with("$BPCON") {
        payload.say("$BPSUS,070000.000");
    }
    payload.say(&said.sentence);
}
