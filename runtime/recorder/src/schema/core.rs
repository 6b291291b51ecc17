//! What core is given and gives.

use serde_json::Value;

use super::events::{ping, sonar_event, step};
use super::{Fields, PLUGIN, duration, fault, log_line, measure, operator_act, position, sonar_setting, version};

pub(crate) fn bytes() -> Value {
    Fields::new().bytes().into_message(
        "The bytes of one read or write of the link, cut anywhere: `text` or `base64`.",
        &[],
    )
}

pub(crate) fn input() -> Value {
    let identifiers = Fields::new()
        .integer("next", "The first identifier that is not used.")
        .integer("reserved", "All below this are reserved on disk.")
        .integer("first", "The first identifier of the vehicle's mission.")
        .integer("inserts", "How many inserts previous runs can have sent at most.")
        .integer("gps_hits", "How many GPS hits previous runs can have sent at most.");
    let start = Fields::new()
        .integer("utc", "UTC at time zero, nanoseconds since 1970.")
        .object("identifiers", "Absent if the state on disk is missing.", identifiers)
        .boolean("armed", "Requests that steer may be sent.")
        .boolean("held", "The operator's hold is set.")
        .integer("jitter", "Seed of the back-off.");
    let returned = Fields::new()
        .integer("fuel", "Fuel used.")
        .list("log", "Lines that the plugin logged.", log_line())
        .list(
            "measures",
            "Values that it published; absent if there are none.",
            measure(),
        )
        .variant(
            "result",
            "ok or err.",
            Fields::new().list("ok", "What the plugin asks for.", request()).object(
                "err",
                "How the step failed.",
                fault(),
            ),
        );
    let restarted = Fields::new()
        .integer("fuel", "Fuel used.")
        .integer("lost_steps", "Steps since the last snapshot.")
        .variant(
            "result",
            "ok or err.",
            Fields::new().object("err", "Why it failed.", fault()),
        );
    operator_act(Fields::new())
        .text(
            "input",
            "start, link-up, link-down, returned, restarted, swap, operator, external, sonar, reserved, utc-set, timeout \
             or gap. The other properties belong to one of these or to several.",
        )
        .object("start", "What core was started with.", start)
        .integer("plugin", "Place in priority order, 0 first (returned, restarted, swap).")
        .object(
            "returned",
            "Fuel, log lines, and requests or fault of a step.",
            returned,
        )
        .object(
            "restarted",
            "Fuel, lost steps, and fault, if any, of a restart.",
            restarted,
        )
        .object("version", "The version that takes the plugin's place (swap).", version())
        .integer("external", "Place in the mission file, 0 first (external).")
        .bytes()
        .variant("report", "What the client of the sonars reports (sonar).", from_sonar())
        .and(reservation())
        .integer(
            "by_nanos",
            "How far the computer's clock has been set since the start in all (utc-set).",
        )
        .number("since_s", "Since when records are missing, seconds of the run (gap).")
        .integer("records", "How many records are missing (gap).")
        .into_message("An input of core that is not bytes of the link.", &["input"])
}

pub(crate) fn shadow() -> Value {
    let judged = Fields::new()
        .boolean("allowed", "Its geometry and its figures could be sent.")
        .number("clearance_m", "Absent if it is refused or has no geometry.")
        .text("refusal", "Why it is refused.");
    Fields::new()
        .text("plugin", "The plugin in whose shadow it is.")
        .text("sha256", "Its component's, hexadecimal.")
        .number(
            "step_s",
            "When core asked the plugin for this step, seconds of the run.",
        )
        .integer("fuel", "Fuel used.")
        .list("log", "Lines that it logged.", log_line())
        .list("requests", "What it asks for.", request())
        .list(
            "judged",
            "What the safety monitor says of each, in the same order.",
            judged,
        )
        .object("fault", "How it failed; absent if it did not.", fault())
        .integer("missed", "Steps before this one that it missed.")
        .into_message(
            "A step of a plugin in the shadow of another one.",
            &["plugin", "step_s"],
        )
}

fn reservation() -> Fields {
    Fields::new()
        .integer("below", "All SPI identifiers below this are reserved.")
        .integer("inserts", "How many inserts of the vehicle's mission, in all.")
        .integer("gps_hits", "How many GPS hits of the vehicle's mission, in all.")
}

fn from_sonar() -> Fields {
    let outcome = Fields::new().integer("request", "Its number in the ledger.").variant(
        "outcome",
        "How it ended.",
        Fields::new().text("failed", "In words."),
    );
    let status =
        Fields::new()
            .text("text", "In words.")
            .list("conditions", "What is wrong.", Fields::new().text("is", ""));
    Fields::new()
        .object(
            "ping",
            "",
            Fields::new().integer("1", PLUGIN).object("2", "The ping.", ping()),
        )
        .variant("event", "For the plugins that asked for it.", sonar_event())
        .object("outcome", "A request has ended.", outcome)
        .object("status", "The state of the sonars.", status)
        .text("line", "A line for the log.")
}

/// A request of a plugin, as an element of a list.
pub(super) fn request() -> Fields {
    let place = || Fields::new().figure("latitude_deg", "").figure("longitude_deg", "");
    let tagged = || Fields::new().integer("tag", "The plugin's name for it.");
    let vertical = |fields: Fields| {
        let contents = Fields::new().figure("depth-m", "").figure("altitude-m", "");
        fields.variant("vertical", "depth-m or altitude-m.", contents)
    };
    let speed = |fields: Fields| fields.figure("speed_mps", "Through the water.");
    let lasting = |fields: Fields| fields.object("duration", "How long it lasts unless it is replaced.", duration());
    let modify = lasting(speed(vertical(tagged().figure("heading_deg", "True."))));
    let trackline = tagged().object("start", "", place()).object("end", "", place());
    let trackline = speed(vertical(trackline)).boolean("interrupt", "Rather than follow the current behavior.");
    let circle = tagged()
        .object("centre", "", place())
        .figure("radius_m", "")
        .figure("orbits", "Clockwise positive.")
        .figure("entry_angle_deg", "From north.");
    let circle = speed(vertical(circle)).boolean("interrupt", "Rather than follow the current behavior.");
    let hull = Fields::new()
        .figure("horizontal_m", "")
        .figure("vertical_m", "")
        .figure("distance_m", "");
    let bottom = vertical(Fields::new().figure("x_m", "").figure("y_m", ""));
    let target = Fields::new().object("hull", "", hull).object("bottom", "", bottom);
    let station = lasting(speed(tagged().variant("target", "here, hull or bottom.", target)));
    let packet = tagged()
        .integer("destination", "The modem that it is for.")
        .integer("mode", "Telemetry mode.")
        .boolean("acknowledge", "")
        .list("frames", "", Fields::new().list_of("items", "integer", "Bytes."));
    let camera = tagged().integer("pan", "").integer("tilt", "").integer("zoom", "");
    let contents = Fields::new()
        .object("modify", "", modify)
        .object("trackline", "", trackline)
        .object("trackcircle", "", circle)
        .integer("cancel", "The tag of the insert.")
        .text("message", "A line for the vehicle's log.")
        .object("gps-hit", "", tagged().object("position", "", place()))
        .object("topside", "", tagged().text("slowest", "Transport.").text("text", ""))
        .object(
            "dvl-trigger",
            "",
            tagged().boolean("external", "").boolean("triggering", ""),
        )
        .object("silent", "", tagged().boolean("silent", ""))
        .integer("trim", "Its tag.")
        .integer("buoyancy", "Its tag.")
        .object("packet", "", packet)
        .object("station", "", station)
        .object("sonar-angle", "", tagged().figure("angle_deg", ""))
        .object("camera", "", camera)
        .object("light", "", tagged().integer("light", "").boolean("on", ""))
        .object("sonar-set", "", sonar_setting(tagged().integer("sensor", "")))
        .object("sonar-log", "", tagged().boolean("on", "").text("file", ""))
        .object(
            "timer",
            "",
            Fields::new().integer("id", "").object("after", "From now.", duration()),
        );
    Fields::new().variant("is", "What kind of request it is.", contents)
}

pub(crate) fn output() -> Value {
    let set = sonar_setting(Fields::new().integer("sensor", ""));
    let log = Fields::new().boolean("on", "").text("file", "");
    let order = Fields::new().integer("request", "Its number in the ledger.").variant(
        "order",
        "What to do.",
        Fields::new().object("set", "", set).object("log", "", log),
    );
    let to_sonar = Fields::new()
        .object("order", "A request.", order)
        .boolean("vehicle-logs", "The vehicle wants data logged.");
    Fields::new()
        .text(
            "output",
            "connect, reset-link, invoke, external, sonar, restart, reserve or finish. The other properties belong to \
             one of these or to several.",
        )
        .number("after_s", "Back-off (connect).")
        .integer("plugin", "Place in priority order, 0 first (invoke, restart).")
        .object("step", "The step's whole input (invoke in a deployed log).", step())
        .integer("external", "Place in the mission file, 0 first (external).")
        .bytes()
        .variant(
            "order",
            "What the client of the sonars is asked to do (sonar).",
            to_sonar,
        )
        .and(reservation())
        .into_message(
            "An output of core that is neither bytes of the link nor a note.",
            &["output"],
        )
}

/// A place with its place in the fence's frame.
pub(super) fn placed() -> Fields {
    Fields::new()
        .object("1", "WGS84.", position())
        .object("2", "In the fence's frame.", super::local())
}
