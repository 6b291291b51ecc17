use std::time::Duration;

use anyhow::{Result, anyhow};
use backseat_core::plugin::Topic;
use backseat_fence::{Fence, Kind, Rfc3339, Window};
use backseat_mission::{Dive, FrontSeatPlan, Mission, beyond_class};
use backseat_mvc::{VehicleConfig, WorldFile};
use backseat_plugin_host::{COMPILE_TIME, COMPONENT_BYTES, Host};
use backseat_sim::load_plugins;
use backseat_units::{EastNorth, LocalFrame, OutOfRange, Position, Utc};

use crate::cli::Check;
use crate::clock::Clock;
use crate::output::say;
use crate::run::host_and_port;
use crate::state::State;

mod machine;

/// Everything that can be known before a dive. True where the mission can be flown.
pub(crate) fn check(arguments: &Check) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    if arguments.resolved {
        say!("{}", mission.resolved.trim_end());
        return Ok(true);
    }
    say!("{} (hash {})", mission.name, &mission.hash()[..16]);
    print_fence(&mission)?;
    let host = Host::new()?;
    let clock = Clock::start();
    let begun = clock.now();
    let loaded = load_plugins(&host, &mission, arguments.mission.plugins.as_deref())?;
    for ((setup, table), (_, bytes)) in loaded.setups.iter().zip(&mission.file.plugins).zip(&loaded.components) {
        let description = &setup.description;
        let topics: Vec<&str> = description
            .topics
            .iter()
            .map(|topic| match topic {
                Topic::Ctd => "CTD",
                Topic::MissionCommand => "mission commands",
                Topic::Behavior => "behaviours",
                Topic::Logging => "data logging",
                Topic::Topside => "topside messages",
                Topic::Acoustic => "acoustic packets",
                Topic::Plan => "the vehicle's plan",
                Topic::Telemetry => "telemetry",
                Topic::SoundVelocity => "sound velocity",
                Topic::Compass => "compasses",
                Topic::Pressure => "pressure",
                Topic::VehicleSpeed => "vehicle speed",
                Topic::Battery => "batteries",
                Topic::Surfaces => "elevator and rudder",
                Topic::Dvl => "DVL",
                Topic::DvlBeams => "DVL beams",
                Topic::Imu => "IMU",
                Topic::Servo => "pitch servos",
                Topic::Trim => "trim",
                Topic::Buoyancy => "buoyancy",
                Topic::RelativeNavigation => "relative navigation",
            })
            .collect();
        say!(
            "plugin {}: {} {}, {} kB, a step every {} ms, listens to {}; granted {:?}",
            setup.name,
            description.name,
            description.version,
            bytes.len() / 1024,
            description.step_period.as_millis(),
            if topics.is_empty() {
                "nothing more".to_owned()
            } else {
                topics.join(", ")
            },
            table.grants,
        );
    }
    if !loaded.setups.is_empty() {
        say!(
            "compiled in {:.1} s; a component may have {} MiB and take {} s",
            clock.now().since(begun).as_secs_f64(),
            COMPONENT_BYTES >> 20,
            COMPILE_TIME.as_secs()
        );
    }
    let mut good = true;
    for table in mission.file.plugins.iter().filter(|table| table.grants.is_empty()) {
        say!(
            "plugin {}: it is granted nothing, so every request of it will be rejected",
            table.name
        );
        good = false;
    }
    for policy in &mission.file.policies {
        say!("policy: when {:?}: {:?}", policy.when, policy.order);
    }
    for driver in &mission.file.drivers {
        let sends: Vec<&str> = driver.sends.iter().map(|sentence| sentence.letters()).collect();
        say!(
            "driver {}: may send BP{}, heard on {}",
            driver.name,
            sends.join(", BP"),
            driver.listen
        );
    }
    let mut findings = dive(&mission, arguments, clock.utc_at_start())?;
    if let Err(error) = host_and_port(&mission.file.vehicle.address, "mission.toml: vehicle.address") {
        findings.push(error.to_string());
    }
    match State::folder_of(arguments.state.as_deref(), &mission) {
        Ok(state) => {
            let now = clock.utc_at_start();
            findings.extend(machine::findings(&mission, &arguments.log, &state, now));
            findings.extend(machine::kept(&mission, &state)?);
        }
        Err(error) => findings.push(format!("state: {error:#}")),
    }
    for finding in &findings {
        say!("{finding}");
    }
    good &= findings.is_empty();
    say!("{}", if good { "ready" } else { "not ready" });
    Ok(good)
}

/// Holds the front seat's plan against the fence, and limits and fence against the vehicle's class.
fn dive(mission: &Mission, arguments: &Check, now: Utc) -> Result<Vec<String>> {
    let (world, fence, limits) = (mission.world.as_ref(), mission.envelope.fence(), &mission.file.limits);
    let class = mission.file.vehicle.class;
    let mut findings = Vec::new();
    match (class, world) {
        (None, None) => say!("no [vehicle] class: what its hull can do is held against nothing"),
        (Some(_), _) | (None, Some(_)) => {
            let vehicle = world.map(|world| world.vehicle).unwrap_or_default();
            let vehicle = VehicleConfig {
                class: class.unwrap_or(vehicle.class),
                ..vehicle
            };
            findings.extend(beyond_class(limits, fence, vehicle.class, &vehicle.limits()));
        }
    }
    let plan = match (&arguments.plan, &mission.plan) {
        (Some(file), _) => Some(FrontSeatPlan::read(file, class, world)?),
        (None, Some(plan)) => Some(plan.clone()),
        (None, None) if world.is_some() => Some(FrontSeatPlan::read(&mission.folder.join("world.toml"), class, world)?),
        (None, None) => None,
    };
    match world {
        None => say!("no world.toml: this mission cannot be simulated"),
        // What only a seed shows: a vehicle or a seabed that cannot be.
        Some(world) => drop(mission.vehicle(world, 1)?),
    }
    let Some(plan) = plan else {
        say!("no plan of the front seat: it is held against nothing; name one by --plan or [plan]");
        return Ok(findings);
    };
    let start = world.map(|world| {
        let origin = Position::from_deg(world.origin.latitude_deg, world.origin.longitude_deg)?;
        Ok(LocalFrame::new(origin).to_position(EastNorth::new(world.start.east_m, world.start.north_m)))
    });
    let start: Option<Position> = start
        .transpose()
        .map_err(|error: OutOfRange| anyhow!("world.toml: origin: {error}"))?;
    let whence = if start.is_some() {
        "its start"
    } else {
        "its first place"
    };
    let after_s = world.map_or(0.0, |world| world.mission.starts_after_s);
    let begun_at = |utc: Utc| Dive {
        fence,
        limits,
        plan: &plan.behaviors,
        start,
        start_depth_m: world.map_or(0.0, |world| world.start.depth_m),
        utc: utc + Duration::try_from_secs_f64(after_s).unwrap_or_default(),
    };
    if begun_at(now).bottom_is_unknown() {
        say!("plan: how far from the bottom it keeps is not judged: [limits] has no water_depth_min_m");
    }
    let mut outside = Vec::new();
    let begins = begins(arguments, world, fence, now);
    if fence.changes() {
        let times: Vec<String> = begins
            .iter()
            .map(|(utc, why)| format!("{} ({why})", Rfc3339(*utc)))
            .collect();
        say!(
            "plan: judged as begun at {}; --at names another time",
            times.join(" and at ")
        );
    }
    for (utc, why) in begins {
        for finding in begun_at(utc).findings() {
            if !outside.iter().any(|(told, _)| *told == finding) {
                outside.push((finding, why));
            }
        }
    }
    if outside.is_empty() {
        say!(
            "plan: {whence} and all {} behaviours, with the ways between them, lie inside the fence",
            plan.behaviors.len()
        );
    }
    findings.extend(outside.into_iter().map(|(finding, why)| match fence.changes() {
        true => format!("{finding} (begun {why})"),
        false => finding,
    }));
    Ok(findings)
}

/// When the dive is taken to begin, and why then. Zones that come and go count on the day of the dive, which is not that of
/// the simulation.
fn begins(arguments: &Check, world: Option<&WorldFile>, fence: &Fence, now: Utc) -> Vec<(Utc, &'static str)> {
    let today = (
        Utc::from_unix_nanos(now.as_unix_nanos() / 1_000_000_000 * 1_000_000_000),
        "now",
    );
    match (arguments.at, world) {
        (Some(at), _) => vec![(at, "as --at says")],
        (None, Some(world)) => {
            let mut begins = vec![(world.start.utc, "as world.toml says")];
            begins.extend(fence.changes().then_some(today));
            begins
        }
        (None, None) => vec![today],
    }
}

fn print_fence(mission: &Mission) -> Result<()> {
    let origin = mission.envelope.fence().frame().origin();
    say!(
        "{} around latitude {:.5} longitude {:.5}:",
        mission.fence_file,
        origin.latitude.as_deg(),
        origin.longitude.as_deg()
    );
    for zone in mission.envelope.fence().zones() {
        let vertices: usize = zone.rings().map(|ring| ring.points.len()).sum();
        let what = match zone.kind() {
            Kind::Inclusion {
                depth,
                altitude_min_m,
                surfacing,
            } => {
                format!(
                    "inclusion, depth {} to {} m, altitude at least {altitude_min_m} m, {}",
                    depth.min_m,
                    depth.max_m,
                    if surfacing { "surfacing allowed" } else { "no surfacing" }
                )
            }
            Kind::Exclusion { depth: None } => "exclusion at all depths".to_owned(),
            Kind::Exclusion { depth: Some(band) } => format!("exclusion from {} to {} m", band.min_m, band.max_m),
        };
        say!(
            "  {}: {what}, margin {} m, {vertices} vertices{}",
            zone.name(),
            zone.margin_m(),
            if zone.window() == Window::default() {
                String::new()
            } else {
                format!(", valid {}", zone.window())
            }
        );
    }
    Ok(())
}
