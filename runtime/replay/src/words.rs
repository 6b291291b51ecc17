//! Requests and inputs of plugins in words.

use std::fmt::Write as _;

use backseat_core::plugin::{
    Event, NavigationSample, PositionRequest, Request, Sample, StationTarget, StepInput, VerticalRequest,
};

/// How many events are named one by one.
const EVENTS_MAX: usize = 12;

/// A request in one line, with units.
#[must_use]
pub fn describe_request(request: &Request) -> String {
    match request {
        Request::Modify(asked) => format!(
            "modify {}: heading {:.3}°, {}, {:.3} m/s, for {} s",
            asked.tag,
            asked.heading_deg,
            vertical(asked.vertical),
            asked.speed_mps,
            asked.duration.as_secs_f64()
        ),
        Request::EndModify => "end the modify".to_owned(),
        Request::Trackline(asked) => format!(
            "trackline {}: from {} to {}, {}, {:.3} m/s{}",
            asked.tag,
            place(asked.start),
            place(asked.end),
            vertical(asked.vertical),
            asked.speed_mps,
            interrupts(asked.interrupt)
        ),
        Request::Trackcircle(asked) => {
            let entry = asked
                .entry_angle_deg
                .map_or_else(String::new, |angle| format!(", entered at {angle:.1}°"));
            format!(
                "trackcircle {}: around {}, radius {:.2} m, {} orbits, {}, {:.3} m/s{entry}{}",
                asked.tag,
                place(asked.centre),
                asked.radius_m,
                asked.orbits,
                vertical(asked.vertical),
                asked.speed_mps,
                interrupts(asked.interrupt)
            )
        }
        Request::Cancel(tag) => format!("cancel {tag}"),
        Request::Message(text) => format!("message: {text}"),
        Request::GpsHit(asked) => format!("GPS hit {} at {}", asked.tag, place(asked.position)),
        Request::Topside(asked) => format!("topside message {}: {}", asked.tag, asked.text),
        Request::DvlTrigger(asked) => format!(
            "DVL trigger {}: external {}, triggering {}",
            asked.tag, asked.external, asked.triggering
        ),
        Request::Silent(asked) => format!("silent mode {}: {}", asked.tag, on_or_off(asked.silent)),
        Request::Trim(tag) => format!("trim {tag}"),
        Request::Buoyancy(tag) => format!("buoyancy {tag}"),
        Request::Packet(asked) => format!(
            "packet {}: to {}, mode {}, {} frames",
            asked.tag,
            asked.destination,
            asked.mode,
            asked.frames.len()
        ),
        Request::Station(asked) => {
            let target = match asked.target {
                StationTarget::Here => "here".to_owned(),
                StationTarget::Hull {
                    horizontal_m,
                    vertical_m,
                    distance_m,
                } => format!("hull {horizontal_m:.2} m, {vertical_m:.2} m, {distance_m:.2} m off"),
                StationTarget::Bottom { x_m, y_m, vertical: to } => {
                    format!("bottom {x_m:.2} m, {y_m:.2} m, {}", vertical(to))
                }
            };
            let speed = asked
                .speed_mps
                .map_or_else(String::new, |speed| format!(", {speed:.3} m/s"));
            format!(
                "station {}: {target}{speed}, for {} s",
                asked.tag,
                asked.duration.as_secs_f64()
            )
        }
        Request::EndStation => "end the station keeping".to_owned(),
        Request::SonarAngle(asked) => format!("sonar angle {}: {:.2}°", asked.tag, asked.angle_deg),
        Request::Camera(asked) => format!(
            "camera {}: pan {}, tilt {}, zoom {}",
            asked.tag, asked.pan, asked.tilt, asked.zoom
        ),
        Request::Light(asked) => format!("light {}: {} {}", asked.tag, asked.light, on_or_off(asked.on)),
        Request::SonarSet(asked) => format!("sonar setting {}: {:?}", asked.tag, asked.setting),
        Request::SonarLog(asked) => format!("sonar logging {}: {}", asked.tag, on_or_off(asked.on)),
        Request::Timer { id, after } => format!("timer {id} in {} s", after.as_secs_f64()),
    }
}

/// What a plugin knew at a step, in one line.
#[must_use]
pub fn describe_input(input: &StepInput) -> String {
    let mut text = match &input.navigation {
        Some(navigation) => describe_navigation(navigation),
        None => "no fresh navigation".to_owned(),
    };
    text.push_str(if input.control { "; control" } else { "; no control" });
    if let Some(relative) = &input.relative {
        let _infallible = write!(text, "; {:.2} m from the target", relative.distance_m);
    }
    if !input.events.is_empty() {
        let named: Vec<String> = input.events.iter().take(EVENTS_MAX).map(describe_event).collect();
        let _infallible = write!(text, "; events: {}", named.join(", "));
        if input.events.len() > EVENTS_MAX {
            let _infallible = write!(text, " and {} more", input.events.len() - EVENTS_MAX);
        }
    }
    text
}

fn describe_navigation(navigation: &NavigationSample) -> String {
    let altitude = navigation.altitude.map_or_else(
        || "no bottom lock".to_owned(),
        |altitude| format!("altitude {:.2} m", altitude.as_m()),
    );
    format!(
        "{:.1} m east, {:.1} m north, depth {:.2} m, {altitude}, heading {:.1}°, {:.2} m/s",
        navigation.local.east_m,
        navigation.local.north_m,
        navigation.depth.as_m(),
        navigation.heading.as_deg(),
        (navigation.east_mps * navigation.east_mps + navigation.north_mps * navigation.north_mps).sqrt()
    )
}

fn describe_event(event: &Event) -> String {
    match event {
        Event::Control(true) => "control gained".to_owned(),
        Event::Control(false) => "control lost".to_owned(),
        Event::Outcome { tag, state } => {
            let state = backseat_recorder::describe_state(state);
            match state.1 {
                Some(reason) => format!("request {tag} {} ({reason})", state.0),
                None => format!("request {tag} {}", state.0),
            }
        }
        Event::Ctd(_) => "a CTD sample".to_owned(),
        Event::MissionCommand(text) => format!("mission command {text:?}"),
        Event::BehaviorBegan(behavior) => format!("{} began", behavior.kind),
        Event::BehaviorEnded(behavior) => format!("{} ended", behavior.kind),
        Event::Timer(id) => format!("timer {id}"),
        Event::Restored { lost_steps, .. } => format!("restored, {lost_steps} steps lost"),
        Event::Shutdown => "shutdown in a minute".to_owned(),
        Event::LoggingBegan(text) => format!("logging begins: {text}"),
        Event::LoggingEnded(text) => format!("logging ends: {text}"),
        Event::TopsideMessage { text, .. } => format!("topside message {text:?}"),
        Event::DvlTrigger(allowed) => format!("DVL trigger {}", if *allowed { "allowed" } else { "withdrawn" }),
        Event::Window(_) => "an acoustic window".to_owned(),
        Event::Packet(packet) => format!("a packet from {}", packet.source),
        Event::Plan(elements) => format!("the plan, {} elements", elements.len()),
        Event::Sample(sample) => describe_sample(sample).to_owned(),
        Event::Sidescan(ping) => format!("sidescan ping {}", ping.number),
        Event::SubBottom(ping) => format!("sub-bottom ping {}", ping.number),
        Event::Sonar(_) => "a report of the sonars".to_owned(),
    }
}

const fn describe_sample(sample: &Sample) -> &'static str {
    match sample {
        Sample::Telemetry(_) => "BFTEL",
        Sample::SoundVelocity(_) => "BFSVS",
        Sample::Compass(_) => "BFRCM",
        Sample::Pressure(_) => "BFRDP",
        Sample::VehicleSpeed(_) => "BFRVL",
        Sample::Battery(_) => "BFRBS",
        Sample::Surfaces(_) => "BFERC",
        Sample::Dvl(_) => "BFDVL",
        Sample::DvlBeams(_) => "BFDV2",
        Sample::Imu(_) => "BFIMU",
        Sample::Servo(_) => "BFPIT",
        Sample::Trim(_) => "BFTRM",
        Sample::Buoyancy(_) => "BFBOY",
    }
}

fn vertical(vertical: VerticalRequest) -> String {
    match vertical {
        VerticalRequest::DepthM(depth_m) => format!("depth {depth_m:.3} m"),
        VerticalRequest::AltitudeM(altitude_m) => format!("altitude {altitude_m:.3} m"),
    }
}

fn place(place: PositionRequest) -> String {
    format!("{:.7} {:.7}", place.latitude_deg, place.longitude_deg)
}

const fn interrupts(interrupt: bool) -> &'static str {
    if interrupt { ", interrupts" } else { "" }
}

const fn on_or_off(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}
