use std::time::Duration;

use backseat_mvc::{Directions, Fault as VehicleFault, FaultKind, FaultPlan, LinkFault, LinkFaultKind, Untrue, Whom};
use backseat_spi::Text;
use backseat_units::Timestamp;
use serde::{Deserialize, Serialize};

use crate::dice::Dice;
use crate::phase::CALM_S;

/// The faults of `plugins/faulty`, by their names in its configuration.
pub const PLUGIN_FAULTS: [&str; 26] = [
    "trap",
    "loop",
    "grow",
    "flood",
    "nan",
    "infinite",
    "huge",
    "latitude_91",
    "error",
    "log_flood",
    "huge_string",
    "big_snapshot",
    "stale",
    "contradict",
    "cross_fence",
    "topside_flood",
    "packet_flood",
    "gps_flood",
    "light_flood",
    "nine_frames",
    "long_frame",
    "no_frames",
    "long_topside",
    "reserved_text",
    "camera_1000",
    "uninvited",
];

/// What a plugin can be swapped to: the component that flies, which goes on where that was, or one that cannot read its
/// state.
pub const SWAPS: [&str; 2] = ["prober", "faulty"];
/// The share of the plugins' faults that are swaps.
const SWAP_SHARE: f64 = 0.15;

/// A fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// A fault of the vehicle, its navigation or the link, as in the mock. Its own time is not used.
    Vehicle(VehicleFault),
    /// A plugin misbehaves.
    Plugin {
        /// The plugin's index by priority, from 0.
        slot: usize,
        /// One of [`PLUGIN_FAULTS`].
        fault: String,
        /// The duration.
        lasts: Duration,
    },
    /// The operator puts another version in a plugin's place.
    Swap {
        /// The plugin's index by priority, from 0.
        slot: usize,
        /// The component: one of [`SWAPS`].
        to: String,
        /// For how many steps it is on trial.
        trial_steps: u32,
    },
    /// The runtime is killed.
    Kill {
        /// The time until it is started again.
        away: Duration,
        /// How far the computer's clock has been set when it starts again, seconds.
        clock_s: f64,
    },
    /// The runtime is stopped, and its connection stays open.
    Stop {
        /// The duration.
        lasts: Duration,
    },
    /// The operator holds.
    Hold {
        /// The time until the release.
        lasts: Duration,
    },
    /// All plugins trap in each step.
    AllTrap {
        /// The time until they recover.
        lasts: Duration,
    },
    /// Nothing can be written to the disk.
    DiskFull {
        /// The duration.
        lasts: Duration,
    },
}

/// A delay that lasts at least this long is a property of the link, not a passing fault.
const STANDING: Duration = Duration::from_secs(300);
/// The share of the vehicle's faults that are another dive.
const DIVE_SHARE: f64 = 0.04;

/// Faults of our own computer.
const COMPUTER: [&str; 7] = [
    "kill",
    "kill_clock",
    "stop",
    "stop_short",
    "hold",
    "disk_full",
    "all_trap",
];

impl Fault {
    /// A fault of any kind: half of them the vehicle's, then the plugins', then the computer's.
    pub(crate) fn draw(dice: &mut Dice, lasts_max_s: f64) -> Self {
        let sort = dice.between(0.0, 1.0);
        if sort < 0.5 {
            Self::draw_vehicle(dice)
        } else if sort < 0.8 && dice.chance(SWAP_SHARE) {
            Self::Swap {
                slot: dice.below(2),
                to: if dice.chance(0.8) { SWAPS[0] } else { SWAPS[1] }.to_owned(),
                trial_steps: dice.one(&[0, 3, 30]),
            }
        } else if sort < 0.8 {
            Self::Plugin {
                slot: dice.below(2),
                fault: dice.one(&PLUGIN_FAULTS).to_owned(),
                lasts: dice.millis(2.0, lasts_max_s.min(120.0)),
            }
        } else {
            Self::draw_computer(dice)
        }
    }

    /// A fault that ends the mission or switches off the payload's power.
    pub(crate) fn draw_fatal(dice: &mut Dice) -> Self {
        let (kind, lasts) = if dice.chance(0.5) {
            (FaultKind::MissionAbort, Duration::ZERO)
        } else {
            (FaultKind::Shutdown, Duration::from_secs(60))
        };
        Self::Vehicle(VehicleFault {
            at: Timestamp::ZERO,
            lasts,
            kind,
        })
    }

    /// A link that loses sentences of the vehicle.
    pub(crate) fn dropping(dice: &mut Dice) -> Self {
        loop {
            let mut drawn = Self::draw_vehicle(dice);
            if let Self::Vehicle(fault) = &mut drawn
                && let FaultKind::Link(link) = &mut fault.kind
                && let LinkFaultKind::Drop { chance } = &mut link.kind
            {
                *chance = 0.5;
                return drawn;
            }
        }
    }

    /// Whether the fault ends the vehicle's mission.
    pub(crate) fn ends_mission(&self) -> bool {
        matches!(self, Self::Vehicle(fault) if matches!(fault.kind, FaultKind::MissionAbort))
    }

    /// A link that is slow, constantly or increasingly, during all of the safety phase and over all connections.
    pub(crate) fn draw_slow_link(dice: &mut Dice) -> Self {
        let grows = dice.chance(0.5);
        let delay = if grows { Duration::ZERO } else { dice.millis(0.02, 2.5) };
        Self::Vehicle(VehicleFault {
            at: Timestamp::ZERO,
            lasts: Duration::from_secs_f64(CALM_S),
            kind: FaultKind::Link(LinkFault {
                whom: Whom::All,
                direction: dice.one(&[Directions::Both, Directions::ToVehicle, Directions::FromVehicle]),
                kind: LinkFaultKind::Delay {
                    delay,
                    jitter: if dice.chance(0.5) {
                        dice.millis(0.0, 0.3)
                    } else {
                        Duration::ZERO
                    },
                    growth: if grows { dice.figure(0.001, 0.02) } else { 0.0 },
                },
            }),
        })
    }

    fn draw_dive(dice: &mut Dice) -> Self {
        let file = format!("dive-{}.dive", dice.below(1000));
        Self::Vehicle(VehicleFault {
            at: Timestamp::ZERO,
            lasts: Duration::ZERO,
            kind: FaultKind::AnotherDive {
                file: Text::cleaned(&file),
                reversed: dice.chance(0.6),
            },
        })
    }

    fn draw_vehicle(dice: &mut Dice) -> Self {
        if dice.chance(DIVE_SHARE) {
            return Self::draw_dive(dice);
        }
        loop {
            // The mock's own draw knows the range of each kind.
            let mut plan = FaultPlan::draw(dice.seed(), Duration::from_secs(60), 0.25);
            if let Some(fault) = plan.faults.pop()
                && !is_fatal(&fault)
            {
                return Self::Vehicle(VehicleFault {
                    at: Timestamp::ZERO,
                    ..fault
                });
            }
        }
    }

    fn draw_computer(dice: &mut Dice) -> Self {
        match dice.one(&COMPUTER) {
            "kill" => Self::Kill {
                away: dice.millis(0.1, 20.0),
                clock_s: 0.0,
            },
            "kill_clock" => Self::Kill {
                away: dice.millis(0.1, 20.0),
                clock_s: dice.one(&[-86_400.0, -3600.0, -70.0, -2.5, 0.2, 30.0, 61.0, 4000.0]),
            },
            "stop" => Self::Stop {
                // After the shorter ones most things look as they did before.
                lasts: if dice.chance(0.5) {
                    dice.millis(1.0, 4.0)
                } else {
                    dice.millis(1.0, 30.0)
                },
            },
            "stop_short" => Self::Stop {
                lasts: dice.millis(0.05, 1.0),
            },
            "hold" => Self::Hold {
                lasts: dice.millis(1.0, 60.0),
            },
            "all_trap" => Self::AllTrap {
                lasts: dice.millis(5.0, 60.0),
            },
            _ => Self::DiskFull {
                lasts: dice.millis(5.0, 120.0),
            },
        }
    }

    /// The name of its kind, for coverage.
    #[must_use]
    pub fn kind(&self) -> String {
        match self {
            Self::Vehicle(fault) => vehicle_kind(fault).to_owned(),
            Self::Plugin { fault, .. } => format!("plugin {fault}"),
            Self::Swap { to, trial_steps, .. } => swap_kind(to, *trial_steps),
            Self::Kill { clock_s, .. } if *clock_s != 0.0 => "runtime killed, clock set".to_owned(),
            Self::Kill { .. } => "runtime killed".to_owned(),
            Self::Stop { lasts } if *lasts < Duration::from_secs(1) => "runtime stopped under 1 s".to_owned(),
            Self::Stop { .. } => "runtime stopped".to_owned(),
            Self::Hold { .. } => "operator's hold".to_owned(),
            Self::AllTrap { .. } => "all plugins trap".to_owned(),
            Self::DiskFull { .. } => "disk full".to_owned(),
        }
    }

    /// Its duration.
    #[must_use]
    pub fn lasts(&self) -> Duration {
        match self {
            Self::Vehicle(fault) => fault.lasts,
            Self::Swap { .. } => Duration::ZERO,
            Self::Plugin { lasts, .. }
            | Self::Stop { lasts }
            | Self::Hold { lasts }
            | Self::AllTrap { lasts }
            | Self::DiskFull { lasts }
            | Self::Kill { away: lasts, .. } => *lasts,
        }
    }

    /// The same fault, lasting `most` at the longest.
    #[must_use]
    pub fn at_most(mut self, most: Duration) -> Self {
        match &mut self {
            Self::Vehicle(fault) if !is_fatal(fault) => fault.lasts = fault.lasts.min(most),
            Self::Vehicle(_) | Self::Swap { .. } => {}
            Self::Plugin { lasts, .. }
            | Self::Stop { lasts }
            | Self::Hold { lasts }
            | Self::AllTrap { lasts }
            | Self::DiskFull { lasts }
            | Self::Kill { away: lasts, .. } => *lasts = (*lasts).min(most),
        }
        self
    }

    /// Whether it ends the mission or the payload's connection for good, or is intended to.
    #[must_use]
    pub fn is_fatal(&self) -> bool {
        matches!(self, Self::Vehicle(fault) if is_fatal(fault))
    }

    /// Every kind, in the order of the table.
    #[must_use]
    pub fn kinds() -> Vec<String> {
        let vehicle = [
            "link cut",
            "link refused",
            "link stalled",
            "link half-open",
            "link delayed",
            "link delayed more and more",
            "link delayed throughout",
            "link split",
            "link joined",
            "link duplicated",
            "link corrupted",
            "link dropping",
            "vehicle deaf",
            "acknowledgements lost",
            "acknowledgements late",
            "acknowledgements negative",
            "control taken",
            "navigation frozen",
            "navigation jumps",
            "navigation missing",
            "position creeps",
            "position frozen",
            "position goes backwards",
            "velocity missing",
            "heading flips",
            "depth flips",
            "another dive",
            "sensor drops out",
            "vehicle's clock set",
            "mission aborted",
            "shutdown",
        ];
        let computer = [
            "runtime killed",
            "runtime killed, clock set",
            "runtime stopped",
            "runtime stopped under 1 s",
            "operator's hold",
            "all plugins trap",
            "disk full",
        ];
        vehicle
            .into_iter()
            .chain(computer)
            .map(str::to_owned)
            .chain([swap_kind(SWAPS[0], 0), swap_kind(SWAPS[0], 1), swap_kind(SWAPS[1], 1)])
            .chain(PLUGIN_FAULTS.iter().map(|fault| format!("plugin {fault}")))
            .collect()
    }
}

fn swap_kind(to: &str, trial_steps: u32) -> String {
    let kind = match (to == SWAPS[0], trial_steps > 0) {
        (true, true) => "plugin swapped on trial",
        (true, false) => "plugin swapped",
        (false, _) => "plugin not swapped",
    };
    kind.to_owned()
}

fn is_fatal(fault: &VehicleFault) -> bool {
    matches!(fault.kind, FaultKind::MissionAbort | FaultKind::Shutdown)
}

fn vehicle_kind(fault: &VehicleFault) -> &'static str {
    match &fault.kind {
        FaultKind::Link(link) => match link.kind {
            LinkFaultKind::Cut => "link cut",
            LinkFaultKind::Refuse => "link refused",
            LinkFaultKind::Stall => "link stalled",
            LinkFaultKind::HalfOpen => "link half-open",
            LinkFaultKind::Deaf => "vehicle deaf",
            LinkFaultKind::Delay { growth, .. } if growth > 0.0 => "link delayed more and more",
            LinkFaultKind::Delay { .. } if fault.lasts >= STANDING => "link delayed throughout",
            LinkFaultKind::Delay { .. } => "link delayed",
            LinkFaultKind::Split { .. } => "link split",
            LinkFaultKind::Join { .. } => "link joined",
            LinkFaultKind::Duplicate { .. } => "link duplicated",
            LinkFaultKind::Corrupt { .. } => "link corrupted",
            LinkFaultKind::Drop { .. } => "link dropping",
        },
        FaultKind::AcksLost(_) => "acknowledgements lost",
        FaultKind::AcksLate { .. } => "acknowledgements late",
        FaultKind::AcksNegative { .. } => "acknowledgements negative",
        FaultKind::ControlTaken => "control taken",
        FaultKind::NavigationFrozen => "navigation frozen",
        FaultKind::NavigationJump(_) => "navigation jumps",
        FaultKind::NavigationMissing => "navigation missing",
        FaultKind::Untrue(Untrue::PositionCreeps { .. }) => "position creeps",
        FaultKind::Untrue(Untrue::PositionFrozen) => "position frozen",
        FaultKind::Untrue(Untrue::PositionBackwards) => "position goes backwards",
        FaultKind::Untrue(Untrue::VelocityMissing) => "velocity missing",
        FaultKind::Untrue(Untrue::HeadingFlips { .. }) => "heading flips",
        FaultKind::Untrue(Untrue::DepthFlips { .. }) => "depth flips",
        FaultKind::AnotherDive { .. } => "another dive",
        FaultKind::SensorDropout(_) => "sensor drops out",
        FaultKind::ClockStep(_) => "vehicle's clock set",
        FaultKind::MissionAbort => "mission aborted",
        FaultKind::Shutdown => "shutdown",
    }
}

/// A fault in a plan's file, other than the mock's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Written {
    Plugin { slot: usize, fault: String, for_s: f64 },
    Swap { slot: usize, to: String, trial_steps: u32 },
    Kill { for_s: f64, clock_s: f64 },
    Stop { for_s: f64 },
    Hold { for_s: f64 },
    AllTrap { for_s: f64 },
    DiskFull { for_s: f64 },
}

impl Written {
    /// `None` for the mock's own faults.
    pub(crate) fn of(fault: &Fault) -> Option<Self> {
        let for_s = fault.lasts().as_secs_f64();
        Some(match fault {
            Fault::Vehicle(_) => return None,
            Fault::Plugin { slot, fault, .. } => Self::Plugin {
                slot: *slot,
                fault: fault.clone(),
                for_s,
            },
            Fault::Swap { slot, to, trial_steps } => Self::Swap {
                slot: *slot,
                to: to.clone(),
                trial_steps: *trial_steps,
            },
            Fault::Kill { clock_s, .. } => Self::Kill {
                for_s,
                clock_s: *clock_s,
            },
            Fault::Stop { .. } => Self::Stop { for_s },
            Fault::Hold { .. } => Self::Hold { for_s },
            Fault::AllTrap { .. } => Self::AllTrap { for_s },
            Fault::DiskFull { .. } => Self::DiskFull { for_s },
        })
    }

    /// Converts it to a fault.
    ///
    /// # Errors
    ///
    /// What is invalid, in words.
    pub(crate) fn fault(self) -> Result<Fault, String> {
        let span = |for_s: f64| {
            Duration::try_from_secs_f64(for_s)
                .ok()
                .filter(|span| *span <= Duration::from_secs(86_400))
                .ok_or_else(|| format!("for_s is {for_s}: expected 0 to 86400"))
        };
        Ok(match self {
            Self::Plugin { slot, fault, for_s } => {
                if slot > 1 {
                    return Err(format!("slot is {slot}: expected 0 or 1"));
                }
                if !PLUGIN_FAULTS.contains(&fault.as_str()) {
                    return Err(format!(
                        "fault is {fault:?}: expected one of {}",
                        PLUGIN_FAULTS.join(", ")
                    ));
                }
                Fault::Plugin {
                    slot,
                    fault,
                    lasts: span(for_s)?,
                }
            }
            Self::Swap { slot, to, trial_steps } => {
                if slot > 1 || !SWAPS.contains(&to.as_str()) {
                    return Err(format!(
                        "slot is {slot} and to is {to:?}: expected 0 or 1, and one of {}",
                        SWAPS.join(", ")
                    ));
                }
                Fault::Swap { slot, to, trial_steps }
            }
            Self::Kill { for_s, clock_s } => {
                if !(-1e8..=1e8).contains(&clock_s) {
                    return Err(format!("clock_s is {clock_s}: expected -1e8 to 1e8"));
                }
                Fault::Kill {
                    away: span(for_s)?,
                    clock_s,
                }
            }
            Self::Stop { for_s } => Fault::Stop { lasts: span(for_s)? },
            Self::Hold { for_s } => Fault::Hold { lasts: span(for_s)? },
            Self::AllTrap { for_s } => Fault::AllTrap { lasts: span(for_s)? },
            Self::DiskFull { for_s } => Fault::DiskFull { lasts: span(for_s)? },
        })
    }
}
