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
        .integer("polygon", "")
        .integer("hole", "")
        .integer("number", "")
        .number("latitude_deg", "")
        .number("longitude_deg", "");
    let span = || {
        Fields::new()
            .integer("from", "UTC, nanoseconds since 1970.")
            .integer("until", "UTC, nanoseconds since 1970.")
    };
    let zone = Fields::new()
        .text("rule", "The rule of the fence.")
        .text("zone", "")
        .figure("missing_m", "")
        .figure("bound_m", "The zone's limit of depth or altitude.")
        .figure("margin_m", "")
        .object("edge", "The nearest edge, and the place on it.", edge)
        .object("valid", "When the zone is valid.", span())
        .object("asked", "The time of the question.", span())
        .text("number", "Which number is unusable.");
    let kept = Fields::new()
        .text("axis", "")
        .text("key", "")
        .number("reached_m", "")
        .number("bound_m", "");
    let entered = Fields::new().text("list", "").text("key", "");
    let boxed = Fields::new()
        .text("name", "")
        .text("stretch", "")
        .number("missing_m", "")
        .variant(
            "edge",
            "The bound.",
            Fields::new().object("kept", "", kept).object("entered", "", entered),
        );
    let figure = Fields::new()
        .text("figure", "")
        .number("value", "")
        .text(
            "not_finite",
            "What the value is if it is no finite number: nan, infinity or minus-infinity.",
        )
        .number("least", "")
        .number("most", "");
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
                .text("reason", "")
                .number("left_s", "For how much longer."),
        )
        .object(
            "command-in-text",
            "",
            Fields::new().text("letters", "").integer("at", "Bytes."),
        )
        .text("unwritable", "")
        .object("delays", "", Fields::new().integer("request", ""))
}

/// The contents of a failure's variants.
pub(super) fn failure() -> Fields {
    Fields::new()
        .text("vehicle", "The vehicle's words.")
        .text("sonar", "The payload controller's words.")
}

/// The contents of an end's variants.
pub(super) fn ended() -> Fields {
    let frame = Fields::new().variant("is", "", Fields::new().integer("other", ""));
    Fields::new()
        .text("by", "The cause.")
        .object(
            "said",
            "",
            Fields::new().text("1", "The cause.").text("2", "Words or a figure."),
        )
        .variant("refusal", "", refusal())
        .text("uncontrolled", "")
        .list("frames", "", frame)
}
