//! Functions for the code that [`crate::export!`] generates. Plugins do not call them directly.

use std::cell::RefCell;

use crate::{Briefing, Description, Plugin, Request, StepInput, log};

/// Holds the single instance of a component.
pub type Slot<P> = RefCell<Option<P>>;

const NOT_INITIALISED: &str = "called before init";

/// Exports a type that implements [`Plugin`] as the component's plugin. Use it exactly once in a crate.
///
/// On the host, where unit tests run, it only checks that the type implements [`Plugin`].
#[macro_export]
macro_rules! export {
    ($plugin:ty) => {
        const _: () = {
            #[cfg(not(target_arch = "wasm32"))]
            const fn is_a_plugin<P: $crate::Plugin>() {}
            #[cfg(not(target_arch = "wasm32"))]
            const _: () = is_a_plugin::<$plugin>();

            #[cfg(target_arch = "wasm32")]
            ::std::thread_local! {
                static SLOT: $crate::exports::Slot<$plugin> = const { ::std::cell::RefCell::new(None) };
            }

            #[cfg(target_arch = "wasm32")]
            struct Component;

            #[cfg(target_arch = "wasm32")]
            impl $crate::bindings::Guest for Component {
                fn describe() -> $crate::Description {
                    $crate::exports::describe::<$plugin>()
                }
                fn init(briefing: $crate::Briefing) -> ::std::result::Result<(), ::std::string::String> {
                    SLOT.with(|slot| $crate::exports::init(slot, &briefing))
                }
                fn step(
                    input: $crate::StepInput,
                ) -> ::std::result::Result<::std::vec::Vec<$crate::Request>, ::std::string::String> {
                    SLOT.with(|slot| $crate::exports::step(slot, &input))
                }
                fn snapshot() -> ::std::vec::Vec<u8> {
                    SLOT.with(|slot| $crate::exports::snapshot(slot))
                }
                fn restore(state: ::std::vec::Vec<u8>) -> ::std::result::Result<(), ::std::string::String> {
                    SLOT.with(|slot| $crate::exports::restore(slot, &state))
                }
            }

            #[cfg(target_arch = "wasm32")]
    $crate::bindings::export_component!(Component with_types_in $crate::bindings);
        };
    };
}

/// Describes the plugin.
#[must_use]
pub fn describe<P: Plugin>() -> Description {
    log_panics();
    P::describe()
}

/// Creates the instance from its configuration, and tells it about the mission.
pub fn init<P: Plugin>(slot: &Slot<P>, briefing: &Briefing) -> Result<(), String> {
    log_panics();
    let mut plugin = P::new(parse(&briefing.config)?)?;
    plugin.brief(briefing)?;
    *slot.borrow_mut() = Some(plugin);
    Ok(())
}

/// Runs one step of the instance.
pub fn step<P: Plugin>(slot: &Slot<P>, input: &StepInput) -> Result<Vec<Request>, String> {
    slot.borrow_mut().as_mut().ok_or(NOT_INITIALISED)?.step(input)
}

/// The instance's state; empty if there is no instance.
pub fn snapshot<P: Plugin>(slot: &Slot<P>) -> Vec<u8> {
    slot.borrow().as_ref().map(P::snapshot).unwrap_or_default()
}

/// Restores the state of an earlier instance.
pub fn restore<P: Plugin>(slot: &Slot<P>, state: &[u8]) -> Result<(), String> {
    slot.borrow_mut().as_mut().ok_or(NOT_INITIALISED)?.restore(state)
}

/// A panic ends in a trap, which carries no text, so from now on the message is logged first.
fn log_panics() {
    std::panic::set_hook(Box::new(|panic| log::write(log::Level::Error, &panic.to_string())));
}

/// Parses the configuration. An error names the key.
pub(crate) fn parse<C: serde::de::DeserializeOwned>(json: &str) -> Result<C, String> {
    let mut deserializer = serde_json::Deserializer::from_str(json);
    serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let key = error.path().to_string();
        let fault = error.into_inner().to_string();
        // The position in the JSON means nothing to the user, who wrote TOML.
        let fault = fault.split(" at line ").next().unwrap_or_default();
        if key == "." {
            format!("config: {fault}")
        } else {
            format!("config: {key}: {fault}")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Config {
        count: u8,
    }

    struct Counter(u8);

    fn briefing(config: &str) -> Briefing {
        Briefing {
            config: config.to_owned(),
            ..Briefing::default()
        }
    }

    impl Plugin for Counter {
        type Config = Config;
        fn describe() -> Description {
            Description {
                name: "counter".into(),
                version: "1".into(),
                step_period_ns: 1,
                topics: vec![],
                grants: vec![],
            }
        }
        fn new(config: Config) -> Result<Self, String> {
            Ok(Self(config.count))
        }
        fn brief(&mut self, briefing: &Briefing) -> Result<(), String> {
            if briefing.limits.speed_max < 1.0 {
                return Err("too slow".to_owned());
            }
            Ok(())
        }
        fn step(&mut self, _: &StepInput) -> Result<Vec<Request>, String> {
            self.0 += 1;
            Ok(vec![])
        }
        fn snapshot(&self) -> Vec<u8> {
            vec![self.0]
        }
        fn restore(&mut self, state: &[u8]) -> Result<(), String> {
            self.0 = *state.first().ok_or("empty state")?;
            Ok(())
        }
    }

    crate::export!(Counter);

    #[test]
    fn an_instance_is_initialised_stepped_and_restored() {
        let slot = Slot::<Counter>::default();
        assert_eq!(step(&slot, &StepInput::default()).unwrap_err(), NOT_INITIALISED);
        init(&slot, &briefing(r#"{"count": 3}"#)).unwrap();
        step(&slot, &StepInput::default()).unwrap();
        assert_eq!(snapshot(&slot), [4]);
        restore(&slot, &[9]).unwrap();
        assert_eq!(snapshot(&slot), [9]);
        assert_eq!(restore(&slot, &[]).unwrap_err(), "empty state");
    }

    #[test]
    fn a_plugin_may_refuse_the_mission() {
        let mut slow = briefing(r#"{"count": 3}"#);
        slow.limits.speed_max = 0.5;
        let slot = Slot::<Counter>::default();
        assert_eq!(init(&slot, &slow).unwrap_err(), "too slow");
        assert!(slot.borrow().is_none());
    }

    #[test]
    fn the_refusal_of_a_configuration_names_the_key() {
        let refusal = |json| parse::<Config>(json).unwrap_err();
        assert_eq!(
            refusal(r#"{"cuont": 3}"#),
            "config: cuont: unknown field `cuont`, expected `count`"
        );
        assert_eq!(refusal("{}"), "config: missing field `count`");
        assert_eq!(
            refusal(r#"{"count": "x"}"#),
            "config: count: invalid type: string \"x\", expected u8"
        );
    }
}
