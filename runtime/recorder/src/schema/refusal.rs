//! Why a request is refused, has failed or has ended.

use super::Fields;

/// The contents of a refusal's variants.
pub(super) fn refusal() -> Fields {
    let way = |fields: Fields, name: &str, what: &str| fields.variant(name, what, refusal_but_of_a_way());
    let fields = way(
        refusal_but_of_a_way(),
        "way-back",
        "Why the way back from a waiting insert is refused.",
    );
    let fields = way(fields, "way-to", "Why the way to it is refused.");
    way(fields, "way-on", "Why the way from it back to the plan is refused.")
}

fn refusal_but_of_a_way() -> Fields {
    let edge = Fields::new()
        .integer("polygon", "Which polygon of the zone, from 1.")
        .integer("hole", "Which hole of the polygon, from 1; absent for its outer ring.")
        .integer("number", "The edge begins at the ring's vertex of this number, from 1.")
        .number("latitude_deg", "The place on the edge, degrees north.")
        .number("longitude_deg", "The place on the edge, degrees east.");
    let span = || {
        Fields::new()
            .integer("from", "UTC, nanoseconds since 1970.")
            .integer("until", "UTC, nanoseconds since 1970.")
    };
    let zone = Fields::new()
        .text("rule", "The rule of the fence.")
        .text("zone", "The zone's name; absent if no zone allows it.")
        .figure("missing_m", "How many metres are missing; absent if the rule has none.")
        .figure("bound_m", "The zone's limit of depth or altitude, metres.")
        .figure("margin_m", "The zone's margin, metres.")
        .object("edge", "The nearest edge, and the place on it.", edge)
        .object("valid", "When the zone is valid.", span())
        .object("asked", "The time of the question.", span())
        .text("number", "Which number is unusable.");
    let kept = Fields::new()
        .text("axis", "The name of the axis.")
        .text("key", "The key of the bound, such as depth_max_m.")
        .number("reached_m", "How far the vehicle may come on the axis, metres.")
        .number("bound_m", "The bound, metres.");
    let entered = Fields::new()
        .text("list", "The list of the forbidden box, such as keep_out_hull.")
        .text("key", "The key of the nearest bound, such as depth_max_m.");
    let boxed = Fields::new()
        .text(
            "name",
            "The key of an allowed box, the name of a forbidden one, or limits.station for its least altitude.",
        )
        .text("stretch", "here: where it is, until it has stopped; way: on its way.")
        .number("missing_m", "How many metres are missing.")
        .variant(
            "edge",
            "The bound: kept, of an allowed box; entered, of a forbidden one.",
            Fields::new().object("kept", "", kept).object("entered", "", entered),
        );
    let figure = Fields::new()
        .text("figure", "The figure's name, such as speed.")
        .number("value", "In the figure's unit.")
        .text(
            "not_finite",
            "What the value is if it is no finite number: nan, infinity or minus-infinity.",
        )
        .number("least", "The least that is allowed, in the figure's unit.")
        .number("most", "The most that is allowed, in the figure's unit.");
    Fields::new()
        .object("zone", "The zone of the fence that is breached.", zone)
        .object("box", "The box that is breached.", boxed)
        .object("figure", "The figure that is out of its range.", figure)
        .text("uncontrolled", "Why there is no control.")
        .text("not-granted", "The grant that is missing.")
        .text("state", "The state that does not allow it.")
        .object(
            "until",
            "",
            Fields::new()
                .text("reason", "The state that does not allow it yet.")
                .number("left_s", "For how much longer, seconds."),
        )
        .object(
            "command-in-text",
            "",
            Fields::new()
                .text("letters", "The command's letters.")
                .integer("at", "Their place in the text, bytes."),
        )
        .text("unwritable", "Why no sentence can express it.")
        .object(
            "delays",
            "",
            Fields::new().integer("request", "The number in the ledger of the insert that it would delay."),
        )
}

/// The contents of a failure's variants.
pub(super) fn failure() -> Fields {
    Fields::new()
        .text("vehicle", "The vehicle's words.")
        .text("sonar", "The payload controller's words.")
}

/// The contents of an end's variants.
pub(super) fn ended() -> Fields {
    let frame = Fields::new().variant(
        "is",
        "What became of the frame.",
        Fields::new().integer("other", "The vehicle's code."),
    );
    Fields::new()
        .text("by", "The cause.")
        .object(
            "said",
            "",
            Fields::new().text("1", "The cause.").text("2", "Words or a figure."),
        )
        .variant("refusal", "Why it was refused after it had been sent.", refusal())
        .text("uncontrolled", "Why control was lost.")
        .list("frames", "The packet's frames.", frame)
}
