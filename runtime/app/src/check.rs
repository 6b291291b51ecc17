use anyhow::Result;
use backseat_core::plugin::Topic;
use backseat_fence::{Breach, Fence, Kind, Shape, Sweep, VerticalExtent};
use backseat_mission::Mission;
use backseat_plugin_host::Host;
use backseat_sim::load_plugins;
use backseat_units::EastNorth;

use crate::cli::Check;
use crate::output::say;

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
    match &mission.world {
        None => say!("no world.toml: this mission cannot be simulated"),
        Some(world) => {
            let vehicle = mission.vehicle(world, 1)?;
            let frame = mission.envelope.fence().frame();
            let mut outside = 0;
            let legs = vehicle.plan_points();
            let mut from = frame.to_local(vehicle.truth().position);
            if let Err(breach) = mission.envelope.fence().contains(from) {
                say!("start: {breach}");
                outside += 1;
            }
            for (number, position) in &legs {
                let to = frame.to_local(*position);
                let entry = number.and_then(|number| world.plan.get(number as usize - 1));
                if let Err(breach) = check_leg(
                    mission.envelope.fence(),
                    from,
                    to,
                    entry.and_then(|entry| entry.depth_m),
                ) {
                    say!("plan element {}: {breach}", number.unwrap_or(0));
                    outside += 1;
                }
                from = to;
            }
            if outside == 0 {
                say!(
                    "plan: start, all {} points and the ways between them lie inside the fence",
                    legs.len()
                );
            } else {
                good = false;
            }
        }
    }
    say!("{}", if good { "ready" } else { "not ready" });
    Ok(good)
}

/// A leg of the front seat's plan, with the zone's margin; its depth where the plan gives one. What its altitude is, no
/// file tells.
fn check_leg(fence: &Fence, from: EastNorth, to: EastNorth, depth_m: Option<f64>) -> Result<(), Breach> {
    let Some(depth_m) = depth_m else {
        return fence.contains(to).map(|_| ());
    };
    let extent = VerticalExtent {
        depth_min_m: depth_m,
        depth_max_m: depth_m,
        altitude_min_m: 1e6,
    };
    fence
        .check(
            &Sweep {
                shape: Shape::leg(from, to),
                radius_m: 0.0,
            },
            &extent,
        )
        .map(|_| ())
}

fn print_fence(mission: &Mission) -> Result<()> {
    let origin = mission.envelope.fence().frame().origin();
    say!(
        "fence around latitude {:.5} longitude {:.5}:",
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
            "  {}: {what}, margin {} m, {vertices} vertices",
            zone.name(),
            zone.margin_m()
        );
    }
    Ok(())
}
