use backseat_oracle::State;
use serde::{Deserialize, Serialize};

use crate::area::Area;
use crate::dice::Dice;

/// The three files of a mission's folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Whether the vehicle hovers.
    pub hovering: bool,
    /// `mission.toml`.
    pub mission: String,
    /// `fence.geojson`.
    pub fence: String,
    /// `world.toml`.
    pub world: String,
}

/// The share of missions with a hovering vehicle.
const HOVERING_SHARE: f64 = 0.1;
/// The points that the specification leaves open, drawn for every world (the keys of `[interpretation]`).
const OPEN: [&str; 22] = [
    "inserts_after_control",
    "after_interrupt",
    "lead_in_m",
    "cancel_all_scope",
    "modify_heading",
    "insert_place",
    "insert_logging",
    "cancel_scope",
    "cancel_all_gps",
    "modify_survives",
    "modify_beyond",
    "modify_fins",
    "suspend_needs_control",
    "after_suspension",
    "hull_vertical",
    "adjustment_when_silenced",
    "adjustment_needs_status",
    "dvl_timeout_announced",
    "unacked_frames",
    "interruption",
    "acknowledged",
    "echo_decimals",
];
/// The limits of every mission.
const LIMITS: &str = "turn_rate_dps = 8.0
seabed_slope_max = 0.03
gps_hits_total_max = 1
gps_hit_duration_max_s = 300.0
silences_total_max = 3
silent_term_s = 300.0
adjustments_total_max = 1
";
const STATION_LIMITS: &str = "
[limits.station]
speed_max_mps = 0.5
sonar_angle_min_deg = -30.0
sonar_angle_max_deg = 30.0

[limits.station.hull_box]
horizontal_min_m = -20.0
horizontal_max_m = 20.0
vertical_min_m = -8.0
vertical_max_m = 8.0
distance_min_m = 1.5
distance_max_m = 12.0

[limits.station.bottom_box]
x_min_m = -60.0
x_max_m = 60.0
y_min_m = -60.0
y_max_m = 60.0
depth_min_m = 0.5
depth_max_m = 14.0
";
const SHIP: &str = "[hovering]
relative_hz = 5

[hovering.hull]
east_m = 0
north_m = 0
heading_deg = 90
length_m = 60
beam_m = 10
draft_m = 5

";
const MODEM: &str = "[acoustic]
device = \"WHOIPSK\"
address = 1
first_s = 20
period_s = 60
length_s = 20

";

/// Limits that leave room to queue inserts.
const DETOUR_CAPS: &str = "inserts_open_max = 3\ninserts_total_max = 60\ninserts_duration_max_s = 9000.0\n";
/// The first plugin leads inserts around obstacles, and then cancels the ones that lead around. The other one steers in
/// between.
const DETOURS: [&str; 2] = [
    "kinds = [\"trackline\"]\nboldness = 0.0\ninsert_every_s = 10.0\n",
    "kinds = [\"modify\"]\nboldness = 0.0\nmodify_share = 0.3\n",
];

impl Scenario {
    /// Draws the scenario of a seed.
    #[must_use]
    pub fn draw(seed: u64) -> Self {
        let mut dice = Dice::new(seed, "scenario");
        let hovering = dice.chance(HOVERING_SHARE);
        // Beside a ship there is no room for lines and circles.
        let ship = hovering && dice.chance(0.2);
        let area = Area::draw(&mut dice, hovering);
        let layout = Layout::draw(seed);
        let operator = Ahead::draw(seed);
        Self {
            hovering,
            mission: mission(&mut dice, (hovering, ship), &area, layout.mission, false) + &operator.mission,
            fence: area.fence(),
            world: world(&mut dice, (hovering, ship), &area, layout.world) + &operator.world,
        }
    }

    /// Like [`Scenario::draw`], with walls between the legs, and a plugin that only leads inserts around obstacles.
    #[must_use]
    pub fn draw_detours(seed: u64) -> Self {
        let mut dice = Dice::new(seed, "detours");
        let area = Area::draw_walled(&mut dice);
        let layout = Layout::draw(seed);
        Self {
            hovering: false,
            mission: mission(&mut dice, (false, false), &area, layout.mission, true),
            fence: area.fence(),
            world: world(&mut dice, (false, false), &area, layout.world),
        }
    }

    /// The states that a mission of this kind reaches, in proportion to how often faults begin in them.
    pub(crate) const fn states(&self) -> &'static [State] {
        use State as S;
        if self.hovering {
            &[
                S::Down,
                S::NoControl,
                S::Idle,
                S::Asked,
                S::Queued,
                S::Insert,
                S::Lease,
                S::LeaseInsert,
                S::Station,
                S::Station,
                S::Station,
                S::Station,
                S::Station,
                S::Station,
            ]
        } else {
            &[
                S::Down,
                S::NoControl,
                S::Idle,
                S::Asked,
                S::Queued,
                S::Insert,
                S::Lease,
                S::LeaseInsert,
            ]
        }
    }
}

/// How the vehicle reads a BPRTC, and what the mission says of it, which is either right or nothing.
struct Layout {
    mission: &'static str,
    world: &'static str,
}

impl Layout {
    fn draw(seed: u64) -> Self {
        let (mission, world) = Dice::new(seed, "trackcircle layout").one(&[
            ("trackcircle_entry_angle = true", "either"),
            ("trackcircle_entry_angle = true", "table"),
            ("trackcircle_entry_angle = false", "header"),
            ("", "either"),
            ("", "table"),
            ("", "header"),
        ]);
        Self { mission, world }
    }
}

/// The operator's orders for the mission: how far a recovery goes, and policies with their conditions.
struct Ahead {
    mission: String,
    world: String,
}

impl Ahead {
    /// Texts of the topside, and of commands in the plan.
    const TEXTS: [&str; 2] = ["home", "clear the way"];

    fn draw(seed: u64) -> Self {
        let mut dice = Dice::new(seed, "orders ahead");
        let (mut mission, mut world) = (String::new(), String::new());
        if dice.chance(0.25) {
            let (cancels, abort_s) = (dice.chance(0.5), dice.figure(10.0, 60.0));
            mission += &format!("\n[recovery]\ncancel_current = {cancels}\nabort_after_s = {abort_s:?}\n");
        }
        if dice.chance(0.15) {
            let stale_s = dice.figure(5.0, 40.0);
            let order = Self::order(&mut dice);
            mission += &format!("\n[[policy]]\nwhen = {{ navigation-stale-for-s = {stale_s:?} }}\norder = {order}\n");
        }
        for (text, when) in Self::TEXTS.into_iter().zip(["topside-message", "mission-command"]) {
            if !dice.chance(0.15) {
                continue;
            }
            let order = Self::order(&mut dice);
            mission += &format!("\n[[policy]]\nwhen = {{ {when} = \"{text}\" }}\norder = {order}\n");
            let at_s = dice.figure(60.0, 700.0);
            world += &if when == "topside-message" {
                format!("\n[[topside.messages]]\nat_s = {at_s:?}\ntransport = \"acoustic-modem\"\ntext = \"{text}\"\n")
            } else {
                format!("\n[[mission.commands]]\nat_s = {at_s:?}\ntext = \"{text}\"\n")
            };
        }
        Self { mission, world }
    }

    /// An order that cancels something or ends the mission. The hunt itself holds and releases, and would not know of a
    /// policy's hold.
    fn order(dice: &mut Dice) -> &'static str {
        dice.one(&[
            "\"cancel-all\"",
            "\"cancel-all\"",
            "\"cancel-current\"",
            "\"cancel-current\"",
            "\"cancel-element\"",
            "{ abort = { text = \"ordered ahead\" } }",
        ])
    }
}

fn mission(dice: &mut Dice, (hovering, ship): (bool, bool), area: &Area, layout: &str, detours: bool) -> String {
    let control = if dice.chance(0.85) { "bfctl" } else { "running" };
    let mut text = format!("[vehicle]\n{layout}\n\n[session]\ncontrol = \"{control}\"\n\n[limits]\n{LIMITS}");
    // What the vehicle can do, and the strongest current of its water.
    let ([slowest, fastest], current_mps) = speeds(hovering);
    text += &format!(
        "speed_min_mps = {slowest:?}\nspeed_max_mps = {fastest:?}\ncurrent_max_mps = {:?}\n",
        current_mps + 0.1
    );
    // Depths are limited either by the chart, which is right in every world here, or only with bottom lock.
    if hovering || dice.chance(0.5) {
        text += "water_depth_min_m = 45.0\nwater_depth_max_m = 75.0\n";
    }
    // A stop of the process that does not make navigation stale must end the lease nevertheless.
    text += &format!("navigation_age_max_s = {:?}\n", dice.one(&[1.0, 1.0, 2.5]));
    text += &format!("modify_term_max_s = {:?}\n", dice.figure(15.0, 60.0));
    if detours {
        text += DETOUR_CAPS;
    } else {
        text += &format!("inserts_open_max = {}\n", dice.one(&[1, 2, 3]));
        text += &format!("inserts_total_max = {}\n", dice.one(&[8, 12, 16]));
        text += &format!("inserts_duration_max_s = {:?}\n", dice.figure(900.0, 1800.0));
    }
    text += &format!("requests_per_s = {}\n", dice.one(&[5, 10, 20]));
    if hovering {
        text += STATION_LIMITS;
    }
    let grants = if ship {
        r#"["message", "topside", "station", "devices", "silent"]"#
    } else if hovering {
        r#"["modify", "insert", "interrupt", "message", "topside", "station", "devices", "silent", "trim", "buoyancy"]"#
    } else {
        r#"["modify", "insert", "interrupt", "message", "surface", "topside", "dvl", "silent", "trim", "buoyancy", "acoustic"]"#
    };
    // Some of the requests lie outside.
    let reach_m = 1.1 * area.reach_m();
    for (name, detour) in ["first", "second"].into_iter().zip(DETOURS) {
        let failure = dice.one(&[
            "yield", "cancel", "yield", "cancel", "yield", "cancel", "yield", "cancel", "yield", "cancel", "abort",
        ]);
        text += &format!("\n[[plugin]]\nname = \"{name}\"\ncomponent = \"prober\"\n");
        text += &format!("grants = {grants}\non_failure = \"{failure}\"\n\n[plugin.config]\n");
        text += &format!("seed = {}\nhovering = {hovering}\n", dice.seed() >> 16);
        text += &format!("east_min_m = {:.1}\neast_max_m = {reach_m:.1}\n", -reach_m);
        text += &format!("north_min_m = {:.1}\nnorth_max_m = {reach_m:.1}\n", -reach_m);
        text += &format!("depth_m = [2.0, {:.1}]\n", area.depth_max_m + 4.0);
        text += &format!(
            "altitude_m = [{:.1}, 40.0]\nspeed_mps = [{slowest:?}, {fastest:?}]\n",
            area.altitude_min_m
        );
        if detours {
            text += detour;
            continue;
        }
        text += &format!("boldness = {:?}\n", dice.figure(0.1, 0.8));
        text += &format!("insert_every_s = {:?}\n", dice.figure(40.0, 150.0));
        text += &format!("modify_share = {:?}\n", dice.figure(0.2, 0.8));
    }
    text
}

fn world(dice: &mut Dice, (hovering, ship): (bool, bool), area: &Area, layout: &str) -> String {
    let class = if hovering {
        "hovering"
    } else {
        dice.one(&["9-inch", "12-inch", "12-inch", "21-inch"])
    };
    let first = area.points[0];
    let (east_m, north_m, depth_m) = if hovering {
        (0.0, -12.0, 3.0)
    } else {
        (first.east_m + 20.0, first.north_m, area.depth_m)
    };
    let (day, hour, minute) = (1 + dice.below(28), dice.below(24), dice.below(60));
    let mut text = format!(
        "[start]\nutc = 2026-06-{day:02}T{hour:02}:{minute:02}:00Z\neast_m = {east_m:.1}\nnorth_m = {north_m:.1}\n\
         depth_m = {depth_m:.1}\n\n"
    );
    text += &format!(
        "[origin]\nlatitude_deg = {:?}\nlongitude_deg = {:?}\n\n",
        area.origin.latitude.as_deg(),
        area.origin.longitude.as_deg()
    );
    text += &format!(
        "[seabed]\ndepth_m = 60\nslope = {:?}\ndownslope_deg = {:?}\nmeanders = 0\n\n",
        dice.figure(0.0, 0.01),
        dice.figure(0.0, 359.0)
    );
    text += &format!(
        "[current]\nspeed_mps = {:?}\ntowards_deg = {:?}\n\n",
        dice.figure(0.0, speeds(hovering).1),
        dice.figure(0.0, 359.0)
    );
    let hz = dice.one(&[4, 4, 4, 5, 10]);
    text += &format!("[vehicle]\nclass = \"{class}\"\naltitude_min_m = 2\ntick_hz = {hz}\n\n");
    text += &format!(
        "[mission]\nstarts_after_s = {:?}\nwrap_up = \"{}\"\ngps_fix_s = 30\ngps_within_s = 240\n\n",
        dice.figure(1.0, 15.0),
        dice.one(&["none", "surface"])
    );
    text += &format!(
        "[spi]\nprofile = \"{}\"\nacknowledge = \"{}\"\npending_s = [0.05, {:?}]\n\n",
        dice.one(&["spec", "field"]),
        dice.one(&["pending", "pending", "immediate"]),
        dice.figure(0.1, 1.5)
    );
    text += match (ship, hovering) {
        (true, _) => SHIP,
        (false, true) => "[hovering]\nrelative_hz = 5\n\n",
        (false, false) => MODEM,
    };
    text += "[interpretation]\n";
    text += &format!("trackcircle_layout = \"{layout}\"\n");
    for key in OPEN {
        text += &format!("{key} = \"seed\"\n");
    }
    // If it is not repeated, a lost connection ends the payload's control during the leg, and most missions would be
    // idle.
    let replay = if dice.chance(0.7) { "true" } else { "\"seed\"" };
    text += &format!("control_replay = {replay}\n");
    text += &if hovering { station() } else { lines(dice, area) };
    text
}

/// The speeds that may be requested, and the strongest current, metres a second.
const fn speeds(hovering: bool) -> ([f64; 2], f64) {
    if hovering { ([0.3, 0.7], 0.1) } else { ([1.0, 2.0], 0.3) }
}

/// A hovering vehicle keeps its station beside the ship.
fn station() -> String {
    let mut text = String::new();
    for (duration_s, dynamic) in [(380, true), (380, true), (380, true), (380, false)] {
        text += &format!(
            "\n[[plan]]\nkind = \"setpoint\"\nheading_deg = 0\nduration_s = {duration_s}\ndepth_m = 3\nspeed_mps = 0\n\
             dynamic = {dynamic}\n"
        );
    }
    text
}

/// Lines during which the backseat may steer, and the way home without it.
fn lines(dice: &mut Dice, area: &Area) -> String {
    let mut text = String::new();
    let flown = format!("depth_m = {:.1}\nspeed_mps = {:?}\n", area.depth_m, area.speed_mps);
    for pair in area.points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        text += &format!(
            "\n[[plan]]\nkind = \"trackline\"\nstart = {{ east_m = {:.1}, north_m = {:.1} }}\n\
             end = {{ east_m = {:.1}, north_m = {:.1} }}\n{flown}dynamic = true\ntimeout_s = 420\n",
            from.east_m, from.north_m, to.east_m, to.north_m
        );
        if dice.chance(0.2) {
            text += "dynamic_from_s = 20\n";
        }
    }
    let home = area.points[0];
    text += &format!(
        "\n[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = {:.1}, north_m = {:.1} }}\n{flown}timeout_s = 300\n",
        home.east_m, home.north_m
    );
    text
}

#[cfg(test)]
mod tests {
    use backseat_mvc::WorldFile;

    use super::*;

    #[test]
    fn every_seed_draws_a_world_and_a_fence_that_can_be() {
        for scenario in (0..300).flat_map(|seed| [Scenario::draw(seed), Scenario::draw_detours(seed)]) {
            let world = WorldFile::from_toml(&scenario.world);
            assert!(world.is_ok(), "{}\n{}", world.unwrap_err(), scenario.world);
        }
    }
}
