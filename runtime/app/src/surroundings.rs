//! Whether the simulated world lies within the limits of the mission. Beyond them the runtime assumes too little, and
//! the vehicle may leave the fence.

use backseat_fence::Fence;
use backseat_mission::{Mission, beyond_class, expected_plan, first_difference};
use backseat_mvc::{ControlWindow, WorldFile};
use backseat_plan::planned_behaviors;
use backseat_scenario::Scenario;
use backseat_units::math::{hypot, wrap_180};
use backseat_units::{EastNorth, LocalFrame};
use backseat_world::World;

/// A fence that is farther than this from the simulation's origin, degrees, is another place's.
const FAR_DEG: f64 = 1.0;
/// Two origins that are nearer than this count as the same, metres.
const SAME_PLACE_M: f64 = 1.0;
/// How many places are looked at in each direction across the fence.
const PLACES: u32 = 60;
/// A limit that is exceeded by less is met: limits are written with few digits.
const TOLERANCE: f64 = 1e-3;

/// What is beyond the limits in the world of this seed, one line each.
pub(crate) fn beyond_limits(mission: &Mission, scenario: &Scenario, world: &World) -> Vec<String> {
    let (limits, file) = (&mission.file.limits, &scenario.world);
    let mut lines: Vec<String> = never_in_control(file)
        .into_iter()
        .chain(far_from_fence(mission, file))
        .chain(other_origin(mission, scenario))
        .chain(other_plan(mission, scenario))
        .collect();
    let mut over = |what: &str, value: f64, key: &str, limit: f64| {
        if value > limit + TOLERANCE {
            lines.push(format!("world: {what}, limits.{key} is {limit}"));
        }
    };
    let current = current_max_mps(file);
    over(
        &format!("current up to {current:.2} m/s"),
        current,
        "current_max_mps",
        limits.current_max_mps,
    );
    // Three standard deviations of one reading, and one of the drift in an hour.
    let noise = 3.0 * file.sensors.position_noise_m;
    let drift = file.sensors.position_drift_m_per_sqrt_h;
    over(
        &format!("a position is wrong by up to {noise:.1} m (three times position_noise_m)"),
        noise,
        "navigation_error_m",
        limits.navigation_error_m,
    );
    over(
        &format!("positions drift by {drift:.1} m in an hour (position_drift_m_per_sqrt_h)"),
        drift,
        "navigation_error_m",
        limits.navigation_error_m,
    );
    if let Some(seabed) = file
        .world_config()
        .frame()
        .ok()
        .and_then(|frame| Seabed::within(mission.envelope.fence(), world, &frame))
    {
        let Seabed { least_m, most_m, slope } = seabed;
        over(
            &format!("the seabed inside the fence slopes by up to {slope:.3}"),
            slope,
            "seabed_slope_max",
            limits.seabed_slope_max,
        );
        if let Some(max) = limits.water_depth_max_m {
            let what = format!("the water inside the fence is up to {most_m:.1} m deep");
            over(&what, most_m, "water_depth_max_m", max);
        }
        if let Some(min) = limits.water_depth_min_m.filter(|min| least_m < min - TOLERANCE) {
            lines.push(format!(
                "world: the water inside the fence is only {least_m:.1} m deep in places, limits.water_depth_min_m \
                 is {min}"
            ));
        }
    }
    lines
}

/// Whether the vehicle never gives control, so that plugins can do nothing.
fn never_in_control(file: &WorldFile) -> Option<String> {
    let never = file.mission.control == ControlWindow::Plan && !file.plan.iter().any(|element| element.dynamic);
    never.then(|| {
        "world: no [[plan]] has dynamic = true, so the vehicle never gives control, and plugins can steer nothing"
            .to_owned()
    })
}

/// Whether the metres of `world.toml` are not those of plugins, log and map.
fn other_origin(mission: &Mission, scenario: &Scenario) -> Option<String> {
    let origin = scenario.world.world_config().frame().ok()?.origin();
    let apart = mission.envelope.fence().frame().to_local(origin);
    let apart_m = hypot(apart.east_m, apart.north_m);
    (SAME_PLACE_M..50_000.0).contains(&apart_m).then(|| {
        format!(
            "world: the [origin] of world.toml is {apart_m:.0} m from that of mission.toml, from which plugins, log and map \
             count metres: give both the same [origin]"
        )
    })
}

/// Whether the simulated vehicle flies another plan than the one that the mission names, so that core never steers.
fn other_plan(mission: &Mission, scenario: &Scenario) -> Option<String> {
    let (plan, table) = (mission.plan.as_ref()?, mission.file.plan.as_ref()?);
    let origin = scenario.world.world_config().frame().ok()?.origin();
    let limits = scenario.vehicle_of(mission).limits();
    let simulated = planned_behaviors(&scenario.world.plan, origin, &limits).ok()?;
    let simulated = expected_plan(&simulated, plan.tolerance_m);
    let difference = first_difference(&plan.expected(), &simulated, mission.envelope.fence().frame())?;
    Some(format!(
        "world: the [[plan]] of world.toml differs from {} (mission.toml, [plan]): {difference}. A vehicle whose plan differs \
         is not steered",
        table.file
    ))
}

/// Whether the simulated vehicle is nowhere near the fence.
fn far_from_fence(mission: &Mission, file: &WorldFile) -> Option<String> {
    let degrees = |frame: &LocalFrame| {
        let origin = frame.origin();
        (origin.latitude.as_deg(), origin.longitude.as_deg())
    };
    let fence = degrees(mission.envelope.fence().frame());
    let world = degrees(&file.world_config().frame().ok()?);
    let near = |latitude_deg: f64, longitude_deg: f64| {
        (latitude_deg - world.0).abs() < FAR_DEG && wrap_180(longitude_deg - world.1).abs() < FAR_DEG
    };
    if near(fence.0, fence.1) {
        return None;
    }
    let why = if near(fence.1, fence.0) {
        "latitude and longitude are swapped in one of them (GeoJSON has longitude first)"
    } else {
        "the vehicle is nowhere near its fence"
    };
    Some(format!(
        "world: [origin] is at latitude {:.3} longitude {:.3}, and the fence around latitude {:.3} longitude {:.3}: {why}",
        world.0, world.1, fence.0, fence.1
    ))
}

/// What the simulated vehicle cannot do although the limits expect it, one line each.
pub(crate) fn beyond_vehicle(mission: &Mission, scenario: &Scenario) -> Vec<String> {
    let vehicle = scenario.vehicle_of(mission);
    let findings = beyond_class(
        &mission.file.limits,
        mission.envelope.fence(),
        vehicle.class,
        &vehicle.limits(),
    );
    findings
        .into_iter()
        .map(|finding| format!("world: {finding}"))
        .collect()
}

/// The fastest current that any seed can draw.
fn current_max_mps(file: &WorldFile) -> f64 {
    let current = &file.current;
    let tides: f64 = current.tides.iter().map(|tide| tide.speed_mps.most()).sum();
    let factors = current.layers.iter().map(|layer| layer.factor);
    // Without layers the current is the same at all depths, or it falls.
    let factor = factors.reduce(f64::max).unwrap_or(1.0);
    (current.speed_mps.most() + tides) * factor
}

/// The seabed below the places where the fence lets the vehicle be.
struct Seabed {
    least_m: f64,
    most_m: f64,
    slope: f64,
}

impl Seabed {
    fn within(fence: &Fence, world: &World, frame: &LocalFrame) -> Option<Self> {
        let corners = || fence.zones().flat_map(|zone| zone.rings()).flat_map(|ring| ring.points);
        let range = |of: fn(&EastNorth) -> f64| {
            let least = corners().map(of).reduce(f64::min)?;
            let most = corners().map(of).reduce(f64::max)?;
            Some((least, (most - least) / f64::from(PLACES)))
        };
        let (east, step_east) = range(|corner| corner.east_m)?;
        let (north, step_north) = range(|corner| corner.north_m)?;
        let mut found: Option<Self> = None;
        for (column, row) in (0..=PLACES).flat_map(|column| (0..=PLACES).map(move |row| (column, row))) {
            let place = EastNorth::new(
                east + step_east * f64::from(column),
                north + step_north * f64::from(row),
            );
            if fence.contains(place).is_err() {
                continue;
            }
            let place = frame.to_local(fence.frame().to_position(place));
            let depth_m = world.water_depth_m(place);
            let gradient = world.gradient(place);
            let slope = hypot(gradient.east_m, gradient.north_m);
            let before = found.unwrap_or(Self {
                least_m: depth_m,
                most_m: depth_m,
                slope,
            });
            found = Some(Self {
                least_m: before.least_m.min(depth_m),
                most_m: before.most_m.max(depth_m),
                slope: before.slope.max(slope),
            });
        }
        found
    }
}
