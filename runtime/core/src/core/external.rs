//! The way of an external source's sentence: core reads it, admits it, compares it with its bounds, gives it a new
//! stamp, and sends it through the gate; or refuses it.

use backseat_spi::{AckStatus, CommandName, DecodeError, Sentence, ToVehicle};
use backseat_units::TimeOfDay;

use crate::capability::Capabilities;
use crate::context::Context;
use crate::ended::EndCause;
use crate::external::acknowledge;
use crate::io::Note;
use crate::mutations::{Check, is_on};
use crate::owner::ExternalId;
use crate::plugin::Refusal;
use crate::refusal::{Figure, Reason, Uncontrolled};
use crate::session::commands::Purpose;
use crate::session::dispatch::Dispatch;
use crate::session::is_told;
use crate::session::subscriptions::ACKNOWLEDGEMENTS;
use crate::settings::external::{ExternalSentence, bounds};

/// How many lines of one read are answered. Core drops and counts any more that an external source sends at once.
const LINES_MAX: usize = 32;

/// What an external source's line says.
enum Said {
    Message(ToVehicle),
    Unreadable(DecodeError),
}

fn read(sentence: &Sentence<'_>) -> Said {
    match ToVehicle::decode(sentence) {
        Ok(message) => Said::Message(message),
        Err(error) => Said::Unreadable(error),
    }
}

/// Bytes from an external source.
pub(super) fn received(cx: &mut Context, capabilities: &mut Capabilities, source: ExternalId, bytes: &[u8]) {
    let Some(port) = cx.externals.ports.get_mut(source.0) else {
        return;
    };
    port.framer.push(bytes);
    let mut lines = 0;
    while let Some(port) = cx.externals.ports.get_mut(source.0) {
        let said = port.framer.next_sentence().map(|sentence| read(&sentence));
        for _ in 0..port.dropped() {
            lines += 1;
            refuse_line(
                cx,
                source,
                lines,
                CommandName::NAK,
                TimeOfDay::MIDNIGHT,
                "not a sentence",
            );
        }
        let Some(said) = said else { break };
        lines += 1;
        match said {
            Said::Message(message) => external_said(cx, capabilities, source, lines, message),
            Said::Unreadable(error) => {
                let name = name_of(error.message);
                refuse_line(cx, source, lines, name, TimeOfDay::MIDNIGHT, &error.to_string());
            }
        }
    }
}

fn external_said(
    cx: &mut Context,
    capabilities: &mut Capabilities,
    source: ExternalId,
    lines: usize,
    message: ToVehicle,
) {
    let echoed = message.created().unwrap_or(TimeOfDay::MIDNIGHT);
    let name = name_of(message.name());
    let sends = &cx.externals.ports[source.0].setup.sends;
    let sentence =
        ExternalSentence::of(&message).filter(|sentence| sends.contains(sentence) || !is_on(Check::ExternalSends));
    if let Some(sentence) = sentence {
        if lines > LINES_MAX {
            count_refused(cx, source);
        } else {
            ask_for_external(cx, capabilities, source, sentence, name, echoed, message);
        }
        return;
    }
    if is_courtesy(&message) && lines <= LINES_MAX {
        // Programs that talk to a vehicle begin with these sentences. Acknowledgements are always on here.
        return acknowledge(
            &mut cx.outbox,
            cx.stamper.utc(cx.now),
            source,
            (name, echoed),
            (AckStatus::Succeeded, ""),
        );
    }
    let text = "the mission does not let this external source send it";
    refuse_line(cx, source, lines, name, echoed, text);
}

/// A sentence that the external source may send becomes a request.
fn ask_for_external(
    cx: &mut Context,
    capabilities: &mut Capabilities,
    source: ExternalId,
    sentence: ExternalSentence,
    name: CommandName,
    echoed: TimeOfDay,
    message: ToVehicle,
) {
    let port = &mut cx.externals.ports[source.0];
    port.tag += 1;
    let request = cx.ledger.propose(source, port.tag, sentence.kind());
    port.open.insert(request, (name, echoed));
    match admit_external(cx, source, sentence, message) {
        Ok(message) => {
            let moves = bounds::moves_frame(&message) && is_on(Check::FrameReset);
            if moves {
                // The position on which every lease relies is about to change (safety requirement 021).
                capabilities.end_leases(cx, EndCause::NavigationReset);
            }
            let resets = bounds::resets_relative(&message) && is_on(Check::FrameReset);
            let dispatch = Dispatch::new(sentence.letters(), message, Purpose::Request(request));
            let sent = cx.send_request(request, &dispatch);
            if sent && resets {
                cx.vehicle.relative.unsettle(cx.now);
                cx.vehicle.cartesian.unsettle(cx.now);
            }
            if moves {
                cx.vehicle.navigation.frame_reset(cx.now);
            }
        }
        Err(refusal) => cx.reject(request, refusal),
    }
}

/// The sentence as it will be sent, with our own stamp.
fn admit_external(
    cx: &mut Context,
    source: ExternalId,
    sentence: ExternalSentence,
    message: ToVehicle,
) -> Result<ToVehicle, Refusal> {
    let port = &mut cx.externals.ports[source.0];
    if !port.take(cx.now) {
        let most_hz = port.setup.bounds.rate_max_hz;
        return Err(Figure::Sentences.over(most_hz + 1.0, most_hz));
    }
    // A relayed message is the topside's and not a request of ours, so it passes without control (014).
    if sentence != ExternalSentence::Relay
        && let Some(reason) = cx.lost_because()
    {
        return Err(reason.into());
    }
    if !cx.link.is_up() {
        return Err(Uncontrolled::LinkDown.into());
    }
    if !cx.control.armed {
        return Err(Uncontrolled::NotArmed.into());
    }
    let message = bounded(cx, source, message)?;
    let created = cx.stamper.stamp(cx.now, sentence.letters());
    Ok(bounds::stamped(message, created))
}

/// The message, if every figure is within the external source's bounds.
fn bounded(cx: &Context, source: ExternalId, message: ToVehicle) -> Result<ToVehicle, Refusal> {
    let bounds = &cx.externals.ports[source.0].setup.bounds;
    let utc = cx.utc().time_of_day();
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "an external source can send no other message"
    )]
    match message {
        ToVehicle::TopsideRelay(relay) if relay.text.holds_command() => Err(Reason::TextHoldsSentence.into()),
        ToVehicle::TopsideRelay(relay) => Ok(relay.into()),
        ToVehicle::PayloadCtd(ctd) => bounds.ctd(ctd, utc).map(ToVehicle::from),
        ToVehicle::PositionFix(fix) => {
            let Some(navigation) = cx.vehicle.navigation.fresh(cx.now) else {
                return Err(Reason::NavigationIsStale.into());
            };
            let frame = cx.monitor.envelope.fence().frame();
            bounds.fix(&fix, utc, frame, navigation)?;
            Ok(fix.into())
        }
        ToVehicle::RelativeReset(reset) => {
            bounds.reset(&reset)?;
            Ok(reset.into())
        }
        ToVehicle::BearingOffset(offset) => {
            bounds.bearing(&offset)?;
            Ok(offset.into())
        }
        _ => Err(Reason::NotExternal.into()),
    }
}

/// Refuses a line: counts it, and answers it unless there are too many in one read.
fn refuse_line(cx: &mut Context, source: ExternalId, lines: usize, name: CommandName, echoed: TimeOfDay, text: &str) {
    if lines <= LINES_MAX {
        acknowledge(
            &mut cx.outbox,
            cx.stamper.utc(cx.now),
            source,
            (name, echoed),
            (AckStatus::Invalid, text),
        );
    }
    count_refused(cx, source);
}

fn count_refused(cx: &mut Context, source: ExternalId) {
    let port = &mut cx.externals.ports[source.0];
    port.refused += 1;
    if is_told(port.refused) {
        let text = format!(
            "external source {}: {} lines were refused",
            port.setup.name, port.refused
        );
        cx.note(Note::Text { text });
    }
}

/// Whether a message is one with which every payload introduces itself (SPI 7.25, 7.1). Core does not pass it on.
fn is_courtesy(message: &ToVehicle) -> bool {
    #[expect(clippy::wildcard_enum_match_arm, reason = "no other message introduces a payload")]
    match message {
        ToVehicle::PayloadVersion(_) => true,
        ToVehicle::LoggingControl(logging) => logging.message.as_str() == ACKNOWLEDGEMENTS,
        _ => false,
    }
}

/// The name of a sentence in acknowledgements; `NAK` if it is not the name of a command.
fn name_of(sentence: &str) -> CommandName {
    let known = backseat_spi::catalogue()
        .iter()
        .any(|entry| entry.name == sentence && sentence.starts_with("BP"));
    let name = known.then(|| CommandName::new(sentence).ok()).flatten();
    name.unwrap_or(CommandName::NAK)
}
