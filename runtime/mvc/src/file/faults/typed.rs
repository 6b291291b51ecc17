use core::time::Duration;

use backseat_spi::{CommandName, Text};
use backseat_units::{EastNorth, Timestamp};

use super::{FaultEntry, FaultName};
use crate::event::ClientId;
use crate::faults::{AckFilter, Directions, Fault, FaultKind, LinkFault, LinkFaultKind, NegativeStatus, Untrue, Whom};
use crate::file::SHUTDOWN_NOTICE;

/// The longest time in a plan, seconds: ten years.
pub(in crate::file) const LONGEST_S: f64 = 315_360_000.0;
/// The least time for which writes are collected, seconds.
const HOLD_MIN_S: f64 = 0.001;
const SECONDS: &str = "0 to 315360000 s";

/// The keys that several kinds share.
mod keys {
    pub(super) const FOR: &str = "for_s";
    pub(super) const LINK: [&str; 3] = ["client", "role", "direction"];
    pub(super) const CONNECTION: [&str; 2] = ["client", "role"];
    pub(super) const ACKS: [&str; 2] = ["command", "stage"];
}

/// Converts an entry into the typed fault.
impl FaultEntry {
    pub(super) fn fault(&self) -> Result<Fault, String> {
        let at_s = self.needed("at_s", self.at_s)?;
        let at = Timestamp::ZERO + seconds("at_s", at_s, 0.0, LONGEST_S, SECONDS)?;
        self.at(at)
    }

    /// Converts the entry of a rule or of the operator into a fault that begins at time zero.
    pub(in crate::file) fn untimed(&self) -> Result<Fault, String> {
        if self.at_s.is_some() {
            return Err("a fault has no `at_s` here: it begins when it is ordered".to_owned());
        }
        self.at(Timestamp::ZERO)
    }

    fn at(&self, at: Timestamp) -> Result<Fault, String> {
        let kind = self.typed()?;
        Ok(Fault {
            at,
            lasts: self.lasts()?,
            kind,
        })
    }

    fn typed(&self) -> Result<FaultKind, String> {
        use FaultName as Name;
        use LinkFaultKind as Link;
        let chance = || ranged("chance", self.needed("chance", self.chance)?, 0.0, 1.0, "0 to 1");
        Ok(match self.kind {
            Name::LinkCut => self.connection(Link::Cut)?,
            Name::Refuse => self.connection(Link::Refuse)?,
            Name::Stall => self.link(Link::Stall, &[])?,
            Name::Deaf => {
                self.only(&[&keys::CONNECTION, &[keys::FOR]])?;
                FaultKind::Link(LinkFault {
                    whom: self.whom()?,
                    direction: Directions::ToVehicle,
                    kind: Link::Deaf,
                })
            }
            Name::HalfOpen => self.link(Link::HalfOpen, &[])?,
            Name::Delay => {
                let delay = seconds("delay_s", self.needed("delay_s", self.delay_s)?, 0.0, 60.0, "0 to 60 s")?;
                let jitter = seconds("jitter_s", self.jitter_s.unwrap_or(0.0), 0.0, 60.0, "0 to 60 s")?;
                let growth = ranged("growth", self.growth.unwrap_or(0.0), 0.0, 1.0, "0 to 1")?;
                self.link(
                    Link::Delay { delay, jitter, growth },
                    &["delay_s", "jitter_s", "growth"],
                )?
            }
            Name::Split => {
                let bytes = self.needed("bytes", self.bytes)?;
                if !(1..=4096).contains(&bytes) {
                    return Err(format!("bytes is {bytes}, expected 1 to 4096"));
                }
                let gap = seconds("gap_s", self.gap_s.unwrap_or(0.0), 0.0, 1.0, "0 to 1 s")?;
                self.link(Link::Split { bytes, gap }, &["bytes", "gap_s"])?
            }
            Name::Join => {
                let hold_s = self.needed("hold_s", self.hold_s)?;
                let hold = seconds("hold_s", hold_s, HOLD_MIN_S, 10.0, "0.001 to 10 s")?;
                self.link(Link::Join { hold }, &["hold_s"])?
            }
            Name::Duplicate => self.link(Link::Duplicate { chance: chance()? }, &["chance"])?,
            Name::Corrupt => self.link(Link::Corrupt { chance: chance()? }, &["chance"])?,
            Name::Drop => self.link(Link::Drop { chance: chance()? }, &["chance"])?,
            Name::AcksLost => {
                self.only(&[&keys::ACKS, &[keys::FOR]])?;
                FaultKind::AcksLost(self.acks()?)
            }
            Name::AcksLate => {
                self.only(&[&keys::ACKS, &[keys::FOR, "delay_s"]])?;
                let delay_s = self.needed("delay_s", self.delay_s)?;
                let delay = seconds("delay_s", delay_s, 0.0, 60.0, "0 to 60 s")?;
                FaultKind::AcksLate {
                    acks: self.acks()?,
                    delay,
                }
            }
            Name::AcksNegative => {
                self.only(&[&["command", "status", "done", keys::FOR]])?;
                FaultKind::AcksNegative {
                    command: self.command()?,
                    status: match self.status {
                        Some(0) => NegativeStatus::Invalid,
                        Some(1) | None => NegativeStatus::Failed,
                        Some(other) => return Err(format!("status is {other}, expected 0 or 1")),
                    },
                    done: self.done.unwrap_or(false),
                }
            }
            Name::ControlTaken => self.plain(FaultKind::ControlTaken)?,
            Name::NavigationFrozen => self.plain(FaultKind::NavigationFrozen)?,
            Name::NavigationMissing => self.plain(FaultKind::NavigationMissing)?,
            Name::PositionCreep
            | Name::PositionFrozen
            | Name::PositionBackwards
            | Name::VelocityMissing
            | Name::HeadingFlip
            | Name::DepthFlip => FaultKind::Untrue(self.untrue()?),
            Name::AnotherDive => {
                self.only(&[&["dive_file", "reversed"]])?;
                let file = self.dive_file.as_deref().unwrap_or_default();
                if file.trim().is_empty() || Text::cleaned(file).as_str() != file {
                    return Err(format!(
                        "dive_file is {file:?}, expected a name in printable ascii without comma, asterisk and dollar"
                    ));
                }
                FaultKind::AnotherDive {
                    file: Text::cleaned(file),
                    reversed: self.reversed.unwrap_or(false),
                }
            }
            Name::MissionAbort => self.plain(FaultKind::MissionAbort)?,
            Name::Shutdown => self.plain(FaultKind::Shutdown)?,
            Name::NavigationJump => {
                self.only(&[&["east_m", "north_m", keys::FOR]])?;
                let metres = |key, value: Option<f64>| {
                    ranged(key, self.needed(key, value)?, -10_000.0, 10_000.0, "-10000 to 10000 m")
                };
                FaultKind::NavigationJump(EastNorth::new(
                    metres("east_m", self.east_m)?,
                    metres("north_m", self.north_m)?,
                ))
            }
            Name::SensorDropout => {
                self.only(&[&["sensor", keys::FOR]])?;
                FaultKind::SensorDropout(self.needed("sensor", self.sensor)?.into())
            }
            Name::ClockStep => {
                self.only(&[&["by_s", keys::FOR]])?;
                let by_s = self.needed("by_s", self.by_s)?;
                let by_s = ranged("by_s", by_s, -86_400.0, 86_400.0, "-86400 to 86400 s")?;
                FaultKind::ClockStep((by_s * 1e9).round() as i64)
            }
        })
    }

    /// How navigation messages are wrong, if the kind is one of those.
    fn untrue(&self) -> Result<Untrue, String> {
        let number =
            |key, value: Option<f64>, most: f64, expected| ranged(key, self.needed(key, value)?, -most, most, expected);
        #[expect(
            clippy::wildcard_enum_match_arm,
            reason = "callers use it only for wrong navigation messages"
        )]
        let (own, untrue): (&[&str], _) = match self.kind {
            FaultName::PositionCreep => {
                let speed_mps = self.needed("speed_mps", self.speed_mps)?;
                let untrue = Untrue::PositionCreeps {
                    speed_mps: ranged("speed_mps", speed_mps, 0.0, 100.0, "0 to 100 m/s")?,
                    towards_deg: number("towards_deg", self.towards_deg, 360.0, "-360 to 360 degrees")?,
                };
                (&["speed_mps", "towards_deg"], untrue)
            }
            FaultName::PositionBackwards => (&[], Untrue::PositionBackwards),
            FaultName::VelocityMissing => (&[], Untrue::VelocityMissing),
            FaultName::HeadingFlip => {
                let by_deg = number("by_deg", self.by_deg, 180.0, "-180 to 180 degrees")?;
                (&["by_deg"], Untrue::HeadingFlips { by_deg })
            }
            FaultName::DepthFlip => {
                let by_m = number("by_m", self.by_m, 1000.0, "-1000 to 1000 m")?;
                (&["by_m"], Untrue::DepthFlips { by_m })
            }
            _ => (&[], Untrue::PositionFrozen),
        };
        self.only(&[own, &[keys::FOR]])?;
        Ok(untrue)
    }

    fn lasts(&self) -> Result<Duration, String> {
        use FaultName as Name;
        match (self.kind, self.for_s) {
            (Name::MissionAbort | Name::AnotherDive, None) => Ok(Duration::ZERO),
            (Name::Shutdown, None) => Ok(SHUTDOWN_NOTICE),
            (Name::MissionAbort | Name::AnotherDive | Name::Shutdown, Some(_)) => {
                Err(format!("{} has no `for_s`", self.name()))
            }
            (Name::LinkCut | Name::NavigationJump | Name::ClockStep, None) => Ok(Duration::ZERO),
            (_, for_s) => seconds("for_s", self.needed("for_s", for_s)?, 0.0, LONGEST_S, SECONDS),
        }
    }

    fn plain(&self, kind: FaultKind) -> Result<FaultKind, String> {
        self.only(&[&[keys::FOR]])?;
        Ok(kind)
    }

    fn connection(&self, kind: LinkFaultKind) -> Result<FaultKind, String> {
        self.only(&[&keys::CONNECTION, &[keys::FOR]])?;
        Ok(FaultKind::Link(LinkFault {
            whom: self.whom()?,
            direction: Directions::Both,
            kind,
        }))
    }

    fn link(&self, kind: LinkFaultKind, own: &[&str]) -> Result<FaultKind, String> {
        self.only(&[&keys::LINK, &[keys::FOR], own])?;
        Ok(FaultKind::Link(LinkFault {
            whom: self.whom()?,
            direction: self.direction.map(Into::into).unwrap_or_default(),
            kind,
        }))
    }

    fn whom(&self) -> Result<Whom, String> {
        match (self.client, &self.role) {
            (None, None) => Ok(Whom::All),
            (Some(number), None) => Ok(Whom::Client(ClientId(number))),
            (None, Some(role)) => Ok(Whom::Role(role.clone())),
            (Some(_), Some(_)) => Err("it has `client` and `role`, expected one of them".to_owned()),
        }
    }

    fn acks(&self) -> Result<AckFilter, String> {
        Ok(AckFilter {
            command: self.command()?,
            stage: self.stage.map(Into::into).unwrap_or_default(),
        })
    }

    fn command(&self) -> Result<Option<CommandName>, String> {
        let Some(name) = &self.command else { return Ok(None) };
        match CommandName::new(name) {
            Ok(name) if is_command(name) => Ok(Some(name)),
            Ok(_) | Err(_) => Err(format!(
                "command is {name:?}, expected a command of the interface, RMB or BPRMB"
            )),
        }
    }

    fn needed<T>(&self, key: &str, value: Option<T>) -> Result<T, String> {
        value.ok_or_else(|| format!("{} needs `{key}`", self.name()))
    }

    /// Refuses keys that are set but have no meaning for this kind.
    fn only(&self, allowed: &[&[&str]]) -> Result<(), String> {
        let there = [
            ("for_s", self.for_s.is_some()),
            ("client", self.client.is_some()),
            ("role", self.role.is_some()),
            ("direction", self.direction.is_some()),
            ("delay_s", self.delay_s.is_some()),
            ("jitter_s", self.jitter_s.is_some()),
            ("bytes", self.bytes.is_some()),
            ("gap_s", self.gap_s.is_some()),
            ("hold_s", self.hold_s.is_some()),
            ("chance", self.chance.is_some()),
            ("command", self.command.is_some()),
            ("stage", self.stage.is_some()),
            ("status", self.status.is_some()),
            ("done", self.done.is_some()),
            ("east_m", self.east_m.is_some()),
            ("north_m", self.north_m.is_some()),
            ("sensor", self.sensor.is_some()),
            ("by_s", self.by_s.is_some()),
            ("growth", self.growth.is_some()),
            ("speed_mps", self.speed_mps.is_some()),
            ("towards_deg", self.towards_deg.is_some()),
            ("by_deg", self.by_deg.is_some()),
            ("by_m", self.by_m.is_some()),
            ("dive_file", self.dive_file.is_some()),
            ("reversed", self.reversed.is_some()),
        ];
        let alien = there
            .iter()
            .find(|(key, is)| *is && !allowed.iter().any(|keys| keys.contains(key)));
        match alien {
            Some((key, _)) => Err(format!("{} has no `{key}`", self.name())),
            None => Ok(()),
        }
    }

    fn name(&self) -> String {
        format!("a fault of kind {}", self.kind)
    }
}

fn ranged(key: &str, value: f64, least: f64, most: f64, expected: &str) -> Result<f64, String> {
    if value >= least && value <= most {
        Ok(value)
    } else {
        Err(format!("{key} is {value}, expected {expected}"))
    }
}

fn seconds(key: &str, value: f64, least: f64, most: f64, expected: &str) -> Result<Duration, String> {
    ranged(key, value, least, most, expected).map(Duration::from_secs_f64)
}

pub(in crate::file) fn is_command(name: CommandName) -> bool {
    backseat_spi::catalogue()
        .iter()
        .any(|entry| entry.name.strip_prefix("BP") == Some(name.as_str()))
}
