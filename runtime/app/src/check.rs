use std::path::PathBuf;

use anyhow::{Result, bail};
use backseat_core::PluginSetup;
use backseat_core::plugin::Topic;
use backseat_fence::{Kind, Window, Zone};
use backseat_lock::LOCK;
use backseat_mission::{Mission, with_suggestion};
use backseat_plugin_host::{COMPILE_TIME, COMPONENT_BYTES, Host, Origin};
use backseat_plugin_loader::load_plugins;
use backseat_units::{EastNorth, LocalFrame, Utc};
use clap::Args;

use crate::arguments::MissionArguments;
use crate::cache::host;
use crate::check::machine::RoomForLogs;
use crate::clock::Clock;
use crate::lock::{BesideLock, Locked, beside_lock, sign, signer};
use crate::one_line;
use crate::output::{kib, say};
use crate::run::host_and_port;
use crate::state::State;
use crate::swap::named_file;

mod front_seat;
pub(crate) mod machine;
mod missing;
#[cfg(feature = "simulation")]
mod scenario;
#[cfg(feature = "simulation")]
use scenario::front_seat;
#[cfg(not(feature = "simulation"))]
mod sea;
#[cfg(not(feature = "simulation"))]
use sea::front_seat;

#[derive(Debug, Args)]
pub(crate) struct Check {
    #[command(flatten)]
    pub(crate) mission: MissionArguments,
    /// Print mission.toml with all settings applied (file, environment, --set) and stop
    #[arg(long)]
    pub(crate) resolved: bool,
    /// Check this plan of the front seat against the fence; its [[plan]] is written as in world.toml [default: the plan
    /// that the mission's [plan] names, else, in builds with the simulation, that of world.toml]
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) plan: Option<PathBuf>,
    /// When the dive begins, such as 2026-06-01T08:00:00Z; decides which zones are valid [default: now, and also the
    /// start time of world.toml in builds with the simulation]
    #[arg(long, value_name = "TIME", value_parser = utc)]
    pub(crate) at: Option<Utc>,
    /// Where the dive will write its logs
    #[arg(long, value_name = "DIR", default_value = "logs")]
    pub(crate) log: PathBuf,
    #[command(flatten)]
    pub(crate) log_room: RoomForLogs,
    /// Sign the mission with this secret key if it is ready: writes mission.lock, for `run --locked`. A pair of keys is made
    /// by `backseat key`
    #[arg(long, value_name = "NAME.key")]
    pub(crate) sign: Option<PathBuf>,
    /// Check also that the mission is as somebody signed it with the secret key of this pair, as `run --locked` does
    #[arg(long, value_name = "NAME.pub", conflicts_with = "sign")]
    pub(crate) locked: Option<PathBuf>,
    /// Who signs, for the lock and the log [default: the user's name]
    #[arg(long, value_name = "WHO", requires = "sign", value_parser = signer)]
    pub(crate) signer: Option<String>,
    /// Sign also that the component in FILE may take the place of the plugin NAME in mid-dive (`backseat swap`)
    #[arg(long, value_name = "NAME=FILE", requires = "sign", value_parser = named_file)]
    pub(crate) may_swap: Vec<(String, PathBuf)>,
    /// Where the dive will keep identifiers and the operator's hold [default: the user's state folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) state: Option<PathBuf>,
}

/// Checks everything that can be known before a dive. Returns whether the mission can be flown.
pub(crate) fn check(arguments: &Check) -> Result<bool> {
    let mission = Mission::load(&arguments.mission.mission, &arguments.mission.layers())?;
    if arguments.resolved {
        say!("{}", mission.resolved.trim_end());
        return Ok(true);
    }
    let front_seat = front_seat(&mission, arguments.plan.as_deref(), &arguments.mission.world_sets())?;
    say!(
        "{} (hash of its files, without world.toml: {})",
        mission.name,
        &mission.hash()[..16]
    );
    print_fence(&mission)?;
    let host = host(&arguments.mission)?;
    let clock = Clock::start();
    let begun = clock.now();
    let mut findings = Vec::new();
    // Without its plugins a mission cannot be flown, but its plan and its fence can be checked.
    let loaded = load_plugins(&host, &mission, arguments.mission.plugins.as_deref())
        .map_err(|error| findings.push(error.to_string()))
        .ok();
    let components = loaded
        .iter()
        .flat_map(|loaded| loaded.setups.iter().zip(&loaded.components).zip(&loaded.origins));
    for (((setup, (_, bytes)), origin), table) in components.zip(&mission.file.plugins) {
        let grants: Vec<&str> = table.grants.iter().map(|grant| grant.name()).collect();
        let description = &setup.description;
        let topics: Vec<&str> = description
            .topics
            .iter()
            .map(|topic| match topic {
                Topic::Ctd => "CTD",
                Topic::MissionCommand => "mission commands",
                Topic::Behavior => "behaviors",
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
                Topic::Sidescan => "sidescan",
                Topic::SubBottom => "sub-bottom profiler",
                Topic::Sonar => "sonar events",
            })
            .collect();
        say!(
            "plugin {}: {} {}, {} KiB, {}, a step every {} ms, listens to {}; grants: {}",
            setup.name,
            description.name,
            description.version,
            kib(bytes.len()),
            match origin {
                Origin::Cache => "from the cache",
                Origin::Compiled => "compiled now",
            },
            description.step_period.as_millis(),
            if topics.is_empty() {
                "navigation only".to_owned()
            } else {
                topics.join(", ")
            },
            if grants.is_empty() {
                "none".to_owned()
            } else {
                grants.join(", ")
            },
        );
    }
    let warnings = loaded.iter().flat_map(|loaded| without_pings(&mission, &loaded.setups));
    for line in warnings.chain(missing::depths(&mission)) {
        say!("warning: {line}");
    }
    if loaded.as_ref().is_some_and(|loaded| !loaded.setups.is_empty()) {
        say!(
            "plugins loaded in {:.3} s ({}); limits for one component: {} MiB, {} s to compile",
            clock.now().since(begun).as_secs_f64(),
            cache_of(&host),
            COMPONENT_BYTES >> 20,
            COMPILE_TIME.as_secs()
        );
    }
    let mut good = true;
    for table in mission.file.plugins.iter().filter(|table| table.grants.is_empty()) {
        say!(
            "plugin {}: has no grants, so the runtime will reject all of its requests",
            table.name
        );
        good = false;
    }
    for policy in &mission.file.policies {
        say!("policy: when {}: {}", policy.when, policy.order);
    }
    for source in &mission.file.externals {
        let sends: Vec<&str> = source.sends.iter().map(|sentence| sentence.letters()).collect();
        say!(
            "external source {}: may send BP{}, listening on {}",
            source.name,
            sends.join(", BP"),
            source.listen
        );
    }
    findings.extend(front_seat.findings(&mission, arguments.at, clock.utc_at_start())?);
    if let Err(error) = host_and_port(&mission.file.vehicle.address, "mission.toml: vehicle.address") {
        findings.push(error.to_string());
    }
    match State::folder_of(arguments.state.as_deref(), &mission) {
        Ok(state) => {
            let now = clock.utc_at_start();
            findings.extend(machine::findings(
                &mission,
                (&arguments.log, arguments.log_room),
                &state,
                now,
            )?);
            findings.extend(machine::kept(&mission, &state)?);
        }
        Err(error) => findings.push(format!("state: {error:#}")),
    }
    let mut refused_if_locked = false;
    if let Some(key) = &arguments.locked {
        let compared = Locked::read(&mission, key).and_then(|locked| match &loaded {
            Some(loaded) => locked.compare(&mission, &loaded.components, arguments.mission.plugins.as_deref()),
            None => bail!("{LOCK}: not compared, because the plugins cannot be loaded"),
        });
        match compared {
            Ok(signed) => say!("{LOCK}: {signed}, and nothing differs"),
            Err(error) => findings.push(one_line(&error)),
        }
    } else if let (Some(loaded), None) = (&loaded, &arguments.sign) {
        match beside_lock(&mission, &loaded.components, arguments.mission.plugins.as_deref())? {
            BesideLock::None => {}
            BesideLock::Same(line) => say!("{line}"),
            BesideLock::Refused(line) => {
                say!("warning: {line}");
                refused_if_locked = true;
            }
        }
    }
    for finding in &findings {
        say!("{}", with_suggestion(finding));
    }
    good &= findings.is_empty();
    say!(
        "{}",
        match (good, refused_if_locked) {
            (true, false) => "ready",
            (true, true) => "ready, but not for `run --locked`",
            (false, _) => "not ready",
        }
    );
    if let Some(key) = &arguments.sign {
        match &loaded {
            Some(loaded) if good => {
                if mission.plan.is_none() {
                    say!(
                        "warning: mission.toml has no [plan], so the signature says nothing of the vehicle's own plan, and the \
                         runtime steers beside any"
                    );
                }
                let user = || std::env::var("USER").unwrap_or_else(|_| "somebody".to_owned());
                let by = arguments.signer.clone().unwrap_or_else(user);
                sign(
                    &mission,
                    &loaded.components,
                    &arguments.may_swap,
                    key,
                    &by,
                    clock.utc_at_start(),
                )?;
            }
            Some(_) | None => say!("not signed"),
        }
    }
    Ok(good)
}

fn cache_of(host: &Host) -> String {
    match host.cache().filter(|cache| cache.is_in_use()) {
        Some(cache) => format!("cache: {}", cache.folder().display()),
        None => "no cache".to_owned(),
    }
}

/// Plugins that listen to a sonar, and get no pings of it.
fn without_pings(mission: &Mission, setups: &[PluginSetup]) -> Vec<String> {
    let mut lines = Vec::new();
    let sensors = mission.file.sonar.as_ref().map_or(&[][..], |sonar| &sonar.sensor);
    for (setup, table) in setups.iter().zip(&mission.file.plugins) {
        for (topic, record, what) in [
            (Topic::Sidescan, 3000, "the sidescan"),
            (Topic::SubBottom, 3001, "the sub-bottom profiler"),
        ] {
            if !setup.description.topics.contains(&topic) {
                continue;
            }
            let sends = |index: i32| {
                let mut of = sensors.iter().filter(|sensor| sensor.index == index);
                of.any(|sensor| sensor.records.contains(&record))
            };
            if !table.pings.iter().any(|ping| sends(ping.sensor)) {
                lines.push(format!(
                    "plugin {}: listens to {what}, and gets no ping: it has no [[plugin.ping]] for a [[sonar.sensor]] \
                     with records = [{record}]",
                    setup.name
                ));
            }
        }
    }
    lines
}

fn print_fence(mission: &Mission) -> Result<()> {
    let frame = mission.envelope.fence().frame();
    say!("{}:", mission.fence_file);
    for zone in mission.envelope.fence().zones() {
        let what = match zone.kind() {
            Kind::KeepIn {
                depth,
                altitude_min_m,
                surfacing,
            } => {
                format!(
                    "keep-in, depth {} to {} m, altitude at least {altitude_min_m} m, {}",
                    depth.min_m,
                    depth.max_m,
                    if surfacing { "surfacing allowed" } else { "no surfacing" }
                )
            }
            Kind::KeepOut { depth: None } => "keep-out at all depths".to_owned(),
            Kind::KeepOut { depth: Some(band) } => format!("keep-out from {} to {} m", band.min_m, band.max_m),
        };
        say!(
            "  {}: {what}, margin {} m, {}{}",
            zone.name(),
            zone.margin_m(),
            extent(zone, frame),
            if zone.window() == Window::default() {
                String::new()
            } else {
                format!(", valid {}", zone.window())
            }
        );
    }
    Ok(())
}

/// How large a zone is and where: the smallest rectangle to the north that contains it.
fn extent(zone: &Zone, frame: &LocalFrame) -> String {
    let points = || zone.rings().flat_map(|ring| ring.points);
    let span = |of: fn(&EastNorth) -> f64| {
        let from = points().map(of).fold(f64::INFINITY, f64::min);
        let to = points().map(of).fold(f64::NEG_INFINITY, f64::max);
        (to - from, 0.5 * (from + to))
    };
    let ((width_m, east_m), (height_m, north_m)) = (span(|point| point.east_m), span(|point| point.north_m));
    let middle = frame.to_position(EastNorth::new(east_m, north_m));
    format!(
        "{width_m:.0} m wide and {height_m:.0} m high around latitude {:.5} longitude {:.5}",
        middle.latitude.as_deg(),
        middle.longitude.as_deg()
    )
}

fn utc(text: &str) -> Result<Utc, String> {
    backseat_fence::utc(text)
        .ok_or_else(|| "expected a date and time with its offset, such as 2026-06-01T08:00:00Z".to_owned())
}
