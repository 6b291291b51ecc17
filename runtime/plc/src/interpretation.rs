//! How the controller reads what the specification leaves open.

use backseat_world::Stream;
use serde::Deserialize;

/// Emits for each key its readings and the choice of a seed, and the table of all keys.
macro_rules! readings {
    ($(
        $(#[$doc:meta])*
        $key:ident: $Reading:ident { $( $(#[$variant_doc:meta])* $Variant:ident, )* }
    )*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
            #[serde(rename_all = "snake_case")]
            pub enum $Reading {
                $( $(#[$variant_doc])* $Variant, )*
                /// The seed draws one of the others.
                Seed,
            }

            impl Default for $Reading {
                /// The first reading.
                fn default() -> Self {
                    Self::READINGS[0]
                }
            }

            impl $Reading {
                const READINGS: &'static [Self] = &[$( Self::$Variant ),*];

                /// Draws from the stream in any case, so that one key does not change what another one draws.
                fn resolve(self, stream: &mut Stream) -> Self {
                    let count = Self::READINGS.len();
                    let drawn = ((stream.uniform() * count as f64) as usize).min(count - 1);
                    if self == Self::Seed { Self::READINGS[drawn] } else { self }
                }
            }
        )*

        /// The table `[plc.interpretation]`. Each key is one reading of what the specification leaves open, or `"seed"`:
        /// then each seed draws a reading, so that no client comes to depend on one.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct InterpretationConfig {
            $( $(#[$doc])* pub $key: $Reading, )*
        }

        impl InterpretationConfig {
            /// One reading for each key.
            pub(crate) fn resolve(&self, seed: u64) -> Self {
                let mut stream = Stream::new(seed, "plc interpretation");
                Self { $( $key: self.$key.resolve(&mut stream), )* }
            }
        }
    };
}

readings! {
    /// Whether an acknowledgement comes before or after the message that its command solicits (2.6: no guarantee).
    acknowledge: AcknowledgeOrder {
        /// Before it.
        First,
        /// After it.
        Last,
    }

    /// Who gets the alarms about one client's command or message: 10, 11 and 14 (Table 18 does not say).
    client_alarms: ClientAlarms {
        /// That client.
        Own,
        /// Every client.
        All,
    }

    /// The mode of an alarm without duration, such as a dropped ping (Table 10 does not say).
    event_alarm_mode: EventAlarmMode {
        /// -1, unspecified.
        Unspecified,
        /// 1, active.
        Active,
    }

    /// Which message the command "status" solicits for a sensor (Table 16 does not say).
    sensor_status: SensorStatus {
        /// Status 6 with this sensor alone.
        Health,
        /// Status 4, its pulses.
        Pulses,
    }

    /// What the command "reset" does (Table 16: "reserved for future use").
    reset: ResetReading {
        /// Resets the sensor.
        DefaultState,
        /// Nothing: it is not known.
        Unknown,
    }

    /// Whether a client gets alarms before it sends the command "alarm" (Table 16 does not say).
    alarms_at_connect: AlarmsAtConnect {
        /// All of them.
        On,
        /// None.
        Off,
    }

    /// Whether a client gets acknowledgements before it sends the command "verbose" (2.6 does not say).
    verbose_at_connect: VerboseAtConnect {
        /// None.
        Quiet,
        /// All of them.
        Verbose,
    }

    /// From where the indices of a loaded run list count (2.5: "unique sequential").
    loaded_index: LoadedIndex {
        /// From 0, as at the start.
        Restart,
        /// On from the greatest one so far.
        Continue,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seed_draws_only_what_is_left_to_it() {
        let all = InterpretationConfig {
            acknowledge: AcknowledgeOrder::Seed,
            ..InterpretationConfig::default()
        };
        let drawn: Vec<AcknowledgeOrder> = (0..20).map(|seed| all.resolve(seed).acknowledge).collect();
        assert!(drawn.contains(&AcknowledgeOrder::First) && drawn.contains(&AcknowledgeOrder::Last));
        assert!((0..20).all(|seed| all.resolve(seed).reset == ResetReading::DefaultState));
    }
}
