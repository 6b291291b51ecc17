//! What is told of a run.

use serde_json::Value;

use super::refusal::{ended, refusal};
use super::{Fields, PLUGIN, fault, local, log_line, operator_act, position, version};

pub(crate) fn note() -> Value {
    operator_act(Fields::new())
        .text("text", "All of it in one line.")
        .text(
            "note",
            "The kind of note. The other properties belong to one kind or to several.",
        )
        .number("retry_s", "Time to the next attempt to connect.")
        .text("version", "The vehicle's interface version.")
        .number("offset_s", "Our clock less the vehicle's.")
        .text("vehicle", "The vehicle's time.")
        .text("status", "The vehicle's mission status.")
        .integer("plugin", PLUGIN)
        .variant("reason", "Why a lease ended.", ended())
        .integer("elements", "How many elements the vehicle's plan has.")
        .boolean("began", "The behavior began; if not, it ended.")
        .integer("number", "The behavior's number in the dive file.")
        .integer("identifier", "Our identifier of the behavior.")
        .text("kind", "The behavior's kind.")
        .integer("count", "How many there were on this connection.")
        .object("fault", "How a plugin failed.", fault())
        .text("then", "What core does about it.")
        .object("to", "The version that takes a plugin's place.", version())
        .object("line", "A line that a plugin logged.", log_line())
        .number("seconds", "How late the runtime woke.")
        .text(
            "simulation",
            "What the simulation did to the runtime's process, which core does not know: killed, stopped, continues, \
             started-again, substituted or reinstated.",
        )
        .into_message("An event of the run.", &["text", "note"])
}

pub(crate) fn request() -> Value {
    let why = refusal()
        .text("rule", "The rule of the monitor that rejected it.")
        .text("kind", "The way in which it ended.")
        .text("cause", "The name of the exact cause.");
    Fields::new()
        .text("text", "All of it in one line.")
        .integer("request", "Its number in this run.")
        .text("owner", "Who made the request: plugin, operator or external.")
        .integer("plugin", "Place in priority order, 0 first; only for a plugin.")
        .integer(
            "external",
            "Place in the mission file, 0 first; only for an external source.",
        )
        .integer("tag", "The number by which its owner knows it.")
        .text("kind", "What it asks for: modify, trackline and others.")
        .integer("identifier", "SPI identifier of an insert.")
        .text(
            "state",
            "rejected, sent, pending, accepted, failed, timed-out, unknown, started, ended or cancelled.",
        )
        .text("reason", "Why it was rejected, failed or ended, in one line.")
        .object(
            "why",
            "The same for programs: a refusal also has what was breached.",
            why,
        )
        .into_message(
            "A request of a plugin, the operator or an external source has a new state.",
            &["text", "request", "owner", "tag", "kind", "state"],
        )
}

pub(crate) fn control() -> Value {
    Fields::new()
        .text("text", "")
        .boolean("granted", "Requests can be sent.")
        .text("reason", "Why it was lost.")
        .text("cause", "The name of the reason, such as vehicle-has-control.")
        .into_message(
            "Control of the vehicle was gained or lost.",
            &["text", "granted", "reason"],
        )
}

pub(crate) fn navigation() -> Value {
    Fields::new()
        .number("time_s", "When the solution was computed, since the start of the run.")
        .number("latitude_deg", "")
        .number("longitude_deg", "")
        .number("east_m", "In the fence's frame.")
        .number("north_m", "In the fence's frame.")
        .number("depth_m", "")
        .number("altitude_m", "Absent without bottom lock.")
        .number("heading_deg", "True.")
        .number("roll_deg", "Starboard down positive.")
        .number("pitch_deg", "Nose up positive.")
        .number("east_mps", "Over the ground.")
        .number("north_mps", "Over the ground.")
        .number("down_mps", "")
        .number("yaw_rate_dps", "Clockwise positive.")
        .boolean("gps", "The solution includes GPS.")
        .into_message("Navigation as the safety monitor uses it (SPI 6.1, 6.2).", &[])
}

pub(crate) fn truth() -> Value {
    Fields::new()
        .integer("at", "Time of the run, nanoseconds.")
        .object("local", "In the fence's frame.", local())
        .object("position", "WGS84.", position())
        .number("depth_m", "Below the surface.")
        .number("water_depth_m", "")
        .text("steering", "Who steers the vehicle.")
        .into_message("What only the simulation knows.", &[])
}

pub(crate) fn vehicle() -> Value {
    Fields::new()
        .text("text", "")
        .into_message("A line of the simulated vehicle's own log.", &["text"])
}
