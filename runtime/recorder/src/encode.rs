//! Inputs and outputs of core as messages.

use std::borrow::Cow;
use std::fmt::Write as _;

use backseat_core::plugin::{Event, Measure, PluginId, StepInput};
use backseat_core::{Input, Note, Output, ToSonar};
use serde_json::Error;

use crate::channel::Channel;
use crate::header::Rate;
use crate::measures::{MeasureRow, topic};
use crate::message::{ControlRef, InputRef, NoteRef, OutputRef, RequestRef};
use crate::{bytes, plain};

/// Where a message goes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place<'a> {
    Channel(Channel),
    /// The channel of a value that this plugin publishes.
    Measure(PluginId, &'a Measure),
}

/// An input or an output as the log has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoded {
    /// The topic of its channel.
    pub topic: Cow<'static, str>,
    /// The message.
    pub data: Vec<u8>,
}

/// Encodes outputs of core as a recorder does, to compare them with what a log has.
#[derive(Clone, Debug)]
pub struct Encoder {
    rate: Rate,
    plugins: Vec<String>,
    text: String,
}

impl Encoder {
    /// An encoder for a log of this rate. `plugins` are the plugins' names in priority order.
    #[must_use]
    pub const fn new(rate: Rate, plugins: Vec<String>) -> Self {
        Self {
            rate,
            plugins,
            text: String::new(),
        }
    }

    /// The message of an output; `None` for outputs that are not recorded.
    ///
    /// # Errors
    ///
    /// None of the outputs that core has: an error of the encoder.
    pub fn output(&mut self, output: &Output) -> Result<Option<Encoded>, Error> {
        let mut data = Vec::new();
        let place = write_output(&mut data, &mut self.text, self.rate, output)?;
        Ok(place.map(|place| Encoded {
            topic: match place {
                Place::Channel(channel) => Cow::Borrowed(channel.topic()),
                Place::Measure(plugin, measure) => Cow::Owned(topic(&self.plugins, plugin, &measure.name)),
            },
            data,
        }))
    }
}

/// The message of an input.
///
/// # Errors
///
/// None of the inputs that core has: an error of the encoder.
pub fn encode_input(input: &Input<'_>) -> Result<Encoded, Error> {
    let mut data = Vec::new();
    let channel = write_input(&mut data, input)?;
    Ok(Encoded {
        topic: Cow::Borrowed(channel.topic()),
        data,
    })
}

/// Appends an input.
pub(crate) fn write_input(out: &mut Vec<u8>, input: &Input<'_>) -> Result<Channel, Error> {
    let message = match input {
        // The most frequent inputs are written without the encoder.
        Input::Received(bytes) => {
            bytes::write(out, bytes);
            return Ok(Channel::FromVehicle);
        }
        Input::Timeout => {
            out.extend_from_slice(br#"{"input":"timeout"}"#);
            return Ok(Channel::Input);
        }
        Input::External(external, bytes) => {
            bytes::write_external(out, "input", *external, bytes);
            return Ok(Channel::Input);
        }
        Input::LinkUp => InputRef::LinkUp,
        Input::LinkDown => InputRef::LinkDown,
        Input::Returned(plugin, returned) => InputRef::Returned {
            plugin: *plugin,
            returned,
        },
        Input::Restarted(plugin, restarted) => InputRef::Restarted {
            plugin: *plugin,
            restarted,
        },
        Input::Swap(plugin, version) => InputRef::Swap {
            plugin: *plugin,
            version,
        },
        Input::Operator(act) => InputRef::Operator { act },
        Input::Sonar(report) => InputRef::Sonar { report },
        Input::UtcSet(by_nanos) => InputRef::UtcSet { by_nanos: *by_nanos },
        Input::Reserved(reservation) => InputRef::Reserved {
            reservation: *reservation,
        },
    };
    plain::write(out, &message)?;
    Ok(Channel::Input)
}

/// Appends an output; `None` if it is not recorded. `text` is kept to reuse its allocation.
pub(crate) fn write_output<'a>(
    out: &mut Vec<u8>,
    text: &mut String,
    rate: Rate,
    output: &'a Output,
) -> Result<Option<Place<'a>>, Error> {
    let message = match output {
        Output::Send(bytes) => {
            bytes::write(out, bytes);
            return Ok(Some(Place::Channel(Channel::ToVehicle)));
        }
        Output::Note(note) => return write_note(out, text, note).map(Some),
        Output::Connect { after } => OutputRef::Connect {
            after_s: after.as_secs_f64(),
        },
        Output::ResetLink => OutputRef::ResetLink,
        Output::Invoke(plugin, step) => match rate {
            Rate::Simulation => {
                let PluginId(plugin) = plugin;
                out.extend_from_slice(format!(r#"{{"output":"invoke","plugin":{plugin}}}"#).as_bytes());
                return Ok(Some(Place::Channel(Channel::Output)));
            }
            Rate::Deployed => {
                let (plugin, step) = (*plugin, &*without_samples(step));
                plain::write(out, &OutputRef::Invoke { plugin, step })?;
                return Ok(Some(Place::Channel(Channel::Output)));
            }
        },
        // What the client is told of the vehicle is in the vehicle's own sentences.
        Output::Sonar(ToSonar::Navigation(..) | ToSonar::SoundSpeed { .. }) => return Ok(None),
        Output::Sonar(order) => OutputRef::Sonar { order },
        Output::External(external, bytes) => {
            bytes::write_external(out, "output", *external, bytes);
            return Ok(Some(Place::Channel(Channel::Output)));
        }
        Output::Restart(plugin) => OutputRef::Restart { plugin: *plugin },
        Output::Reserve(reservation) => OutputRef::Reserve {
            reservation: *reservation,
        },
        Output::Finish => OutputRef::Finish,
    };
    plain::write(out, &message)?;
    Ok(Some(Place::Channel(Channel::Output)))
}

fn write_note<'a>(out: &mut Vec<u8>, text: &mut String, note: &'a Note) -> Result<Place<'a>, Error> {
    if let Note::PluginMeasure { plugin, measure } = note {
        serde_json::to_writer(out, &MeasureRow::from(measure))?;
        return Ok(Place::Measure(*plugin, measure));
    }
    text.clear();
    write!(text, "{note}").expect("a String takes everything");
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other notes go to one channel")]
    let channel = match note {
        Note::Request(transition) => {
            plain::write(out, &RequestRef::new(text, transition))?;
            Channel::Requests
        }
        Note::Control { granted, reason } => {
            let message = ControlRef {
                text,
                granted: *granted,
                reason: reason.map_or("", |reason| reason.text()),
                cause: reason.map(|reason| reason.name()),
            };
            plain::write(out, &message)?;
            Channel::Control
        }
        other => {
            plain::write(out, &NoteRef::new(text, other))?;
            Channel::Notes
        }
    };
    Ok(Place::Channel(channel))
}

/// A step's input without the samples of its pings, which the inputs of core have already.
fn without_samples(step: &StepInput) -> Cow<'_, StepInput> {
    let is_ping = |event: &Event| matches!(event, Event::Sidescan(_) | Event::SubBottom(_));
    if !step.events.iter().any(is_ping) {
        return Cow::Borrowed(step);
    }
    let mut step = step.clone();
    for event in &mut step.events {
        if let Event::Sidescan(ping) | Event::SubBottom(ping) = event {
            for channel in &mut ping.channels {
                channel.samples = Vec::new();
            }
        }
    }
    Cow::Owned(step)
}
