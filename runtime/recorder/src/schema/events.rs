//! The input of a plugin's step, and what it has of the sonars.

use super::core::placed;
use super::refusal::{ended, failure, refusal};
use super::{Fields, RUN_TIME, duration, local, position};

pub(super) fn step() -> Fields {
    let relative = measured(&[
        ("horizontal_m", "Along the target."),
        ("vertical_m", "Across it."),
        ("distance_m", "From it."),
        ("heading_deg", "Zero is towards the target."),
        ("depth_m", ""),
        ("absolute_heading_deg", "In the vehicle's inertial frame."),
        ("roll_deg", ""),
        ("pitch_deg", ""),
    ]);
    let cartesian = measured(&[
        ("x_m", ""),
        ("y_m", ""),
        ("z_m", ""),
        ("heading_deg", "Zero is towards the target."),
    ]);
    Fields::new()
        .integer("now", RUN_TIME)
        .integer("utc", "Nanoseconds since 1970.")
        .object("clocks_apart", "How far the vehicle's UTC is from ours.", duration())
        .object("navigation", "The newest, while it is fresh.", navigation())
        .object("relative", "BFRNV, while it is fresh.", relative)
        .object("cartesian", "BFCNV, while it is fresh.", cartesian)
        .boolean("control", "Requests can be sent.")
        .list("events", "Since the last step, oldest first.", event())
}

fn measured(figures: &[(&str, &str)]) -> Fields {
    let fields = Fields::new().integer("measured", RUN_TIME);
    figures
        .iter()
        .fold(fields, |fields, (name, what)| fields.number(name, what))
}

fn solution() -> Fields {
    Fields::new()
        .integer("solution", RUN_TIME)
        .object("position", "WGS84.", position())
        .object("local", "In the fence's frame.", local())
        .number("depth", "Metres.")
        .number("altitude", "Metres; absent without bottom lock.")
        .number("heading", "True, degrees.")
        .number("roll_deg", "Starboard down positive.")
        .number("pitch_deg", "Nose up positive.")
}

fn navigation() -> Fields {
    solution()
        .number("east_mps", "")
        .number("north_mps", "")
        .number("down_mps", "")
        .number("yaw_rate_dps", "Clockwise positive.")
        .boolean("gps", "The solution includes GPS.")
}

fn event() -> Fields {
    let behavior = || {
        Fields::new()
            .text("kind", "")
            .integer("tag", "Of the plugin's own request.")
    };
    let state = Fields::new()
        .variant("rejected", "", refusal())
        .variant("failed", "", failure())
        .variant("ended", "", ended());
    let window = Fields::new()
        .integer("until", RUN_TIME)
        .integer("address", "")
        .text("device", "");
    let frame = Fields::new().boolean("good", "").list_of("data", "integer", "Bytes.");
    let packet = Fields::new()
        .integer("arrived", RUN_TIME)
        .integer("source", "")
        .integer("destination", "")
        .integer("mode", "")
        .list("frames", "", frame);
    let element = Fields::new()
        .integer("number", "In the dive file.")
        .integer("identifier", "Of an insert.")
        .list("points", "", placed());
    let contents = Fields::new()
        .boolean("control", "Gained or lost.")
        .object(
            "outcome",
            "",
            Fields::new()
                .integer("tag", "")
                .variant("state", "The request's state.", state),
        )
        .object(
            "ctd",
            "",
            measured(&[
                ("conductivity_us_per_cm", ""),
                ("temperature_c", ""),
                ("pressure_kpa", ""),
            ]),
        )
        .text("mission-command", "")
        .object("behavior-began", "", behavior())
        .object("behavior-ended", "", behavior())
        .integer("timer", "")
        .object(
            "restored",
            "",
            Fields::new()
                .integer("lost_steps", "")
                .list_of("open", "integer", "Tags."),
        )
        .text("logging-began", "")
        .text("logging-ended", "")
        .object(
            "topside-message",
            "",
            Fields::new().text("transport", "").text("text", ""),
        )
        .boolean("dvl-trigger", "")
        .object("window", "", window)
        .object("packet", "", packet)
        .list("plan", "", element)
        .variant("sample", "", sample())
        .object("sidescan", "", ping())
        .object("sub-bottom", "", ping())
        .variant("sonar", "", sonar_event());
    Fields::new().variant("is", "What has happened.", contents)
}

fn sample() -> Fields {
    let telemetry = measured(&[
        ("acoustic_up_available_kb", ""),
        ("acoustic_up_last_kb", ""),
        ("acoustic_down_available_kb", ""),
        ("acoustic_down_last_kb", ""),
    ]);
    let battery = measured(&[
        ("voltage_v", ""),
        ("cell_min_v", ""),
        ("cell_max_v", ""),
        ("temperature_c", ""),
        ("capacity_kwh", ""),
        ("charge_percent", ""),
    ]);
    let surfaces = measured(&[
        ("elevator_deg", ""),
        ("rudder_deg", ""),
        ("elevator_target_deg", ""),
        ("rudder_target_deg", ""),
    ]);
    let beams = |velocities| {
        measured(&[("temperature_c", "")])
            .numbered("velocity_mps", "number", velocities, "")
            .numbered("ranges_m", "number", 4, "")
    };
    let attitude = measured(&[("heading_deg", ""), ("pitch_deg", ""), ("roll_deg", "")]);
    Fields::new()
        .object(
            "telemetry",
            "",
            telemetry.boolean("rf_connected", "").boolean("ethernet_available", ""),
        )
        .object("sound-velocity", "", measured(&[("sound_velocity_mps", "")]))
        .object("compass", "", attitude.integer("number", ""))
        .object("pressure", "", measured(&[("pressure_kpa", "")]))
        .object(
            "vehicle-speed",
            "",
            measured(&[("thruster_rpm", ""), ("water_speed_mps", "")]),
        )
        .object("battery", "", battery.integer("number", ""))
        .object("surfaces", "", surfaces)
        .object("dvl", "", beams(3))
        .object("dvl-beams", "", beams(4))
        .object(
            "imu",
            "",
            measured(&[])
                .numbered("rate_dps", "number", 3, "")
                .numbered("acceleration_mps2", "number", 3, ""),
        )
        .object("servo", "", measured(&[("dvl_deg", ""), ("sonar_deg", "")]))
        .object(
            "trim",
            "",
            measured(&[("pitch_deg", ""), ("roll_deg", "")]).boolean("adjusting", ""),
        )
        .object("buoyancy", "", measured(&[("buoyancy_n", "")]).boolean("adjusting", ""))
}

pub(super) fn ping() -> Fields {
    let channel = Fields::new()
        .text("side", "port, starboard or other.")
        .boolean("ground_range", "The samples are spaced along the ground.")
        .figure("range_m", "Of the end of the last sample.")
        .integer("start_nanos", "From the ping to the first sample.")
        .figure("sample_nanos", "From one sample to the next.")
        .integer("recorded", "How many samples the record has.")
        .figure("volts_per_step", "")
        .list_of("samples", "number", "Amplitudes.");
    Fields::new()
        .boolean("sub_bottom", "A sub-bottom profile and no sidescan.")
        .integer("sensor", "Index in the payload controller.")
        .integer("number", "By the sonar.")
        .integer("time", RUN_TIME)
        .text("time_source", "measured, controller or arrival.")
        .text("decimation", "How several samples became one.")
        .list("channels", "", channel)
        .object(
            "navigation",
            "The vehicle's last solution that was not later than the ping.",
            solution().numbered("velocity_mps", "number", 2, "East and north."),
        )
}

pub(super) fn sonar_event() -> Fields {
    let alarm = || {
        Fields::new()
            .integer("id", "")
            .boolean("active", "Absent for one that only happens.")
            .integer("sensor", "")
            .text("text", "")
    };
    let logging = Fields::new()
        .boolean("on", "")
        .text("file", "")
        .figure("size_mb", "")
        .boolean("missing", "It is off although it was ordered on.");
    let swath = Fields::new()
        .integer("sensor", "")
        .integer("number", "")
        .figure("port_m", "")
        .figure("starboard_m", "")
        .figure("altitude_m", "")
        .text("source", "Where the altitude comes from.");
    Fields::new()
        .boolean("ready", "")
        .object("logging", "", logging)
        .list(
            "health",
            "",
            Fields::new().integer("1", "Sensor.").boolean("2", "Healthy."),
        )
        .object("alarm", "", alarm())
        .list("active-alarms", "", alarm())
        .object("swath", "", swath)
}
