use super::{FaultEntry, FaultName};
use crate::faults::{AckFilter, Fault, FaultKind, LinkFault, LinkFaultKind, NegativeStatus, Untrue, Whom};

/// Converts a typed fault into an entry, with every key that its kind has.
impl FaultEntry {
    fn bare(kind: FaultName, fault: &Fault) -> Self {
        let at_s = Some(fault.at.as_secs_f64());
        Self {
            at_s,
            kind,
            for_s: Some(fault.lasts.as_secs_f64()),
            client: None,
            role: None,
            direction: None,
            delay_s: None,
            jitter_s: None,
            bytes: None,
            gap_s: None,
            hold_s: None,
            chance: None,
            command: None,
            stage: None,
            status: None,
            done: None,
            east_m: None,
            north_m: None,
            sensor: None,
            by_s: None,
            growth: None,
            speed_mps: None,
            towards_deg: None,
            by_deg: None,
            by_m: None,
            dive_file: None,
            reversed: None,
        }
    }

    pub(super) fn of(fault: &Fault) -> Self {
        let bare = |kind| Self::bare(kind, fault);
        let of_acks = |kind, acks: &AckFilter| Self {
            command: acks.command.map(|name| name.as_str().to_owned()),
            stage: Some(acks.stage.into()),
            ..bare(kind)
        };
        match &fault.kind {
            FaultKind::Link(link) => Self::of_link(fault, link),
            FaultKind::AcksLost(acks) => of_acks(FaultName::AcksLost, acks),
            FaultKind::AcksLate { acks, delay } => Self {
                delay_s: Some(delay.as_secs_f64()),
                ..of_acks(FaultName::AcksLate, acks)
            },
            FaultKind::AcksNegative { command, status, done } => Self {
                command: command.map(|name| name.as_str().to_owned()),
                status: Some(match status {
                    NegativeStatus::Invalid => 0,
                    NegativeStatus::Failed => 1,
                }),
                done: Some(*done),
                ..bare(FaultName::AcksNegative)
            },
            FaultKind::ControlTaken => bare(FaultName::ControlTaken),
            FaultKind::NavigationFrozen => bare(FaultName::NavigationFrozen),
            FaultKind::NavigationJump(by) => Self {
                east_m: Some(by.east_m),
                north_m: Some(by.north_m),
                ..bare(FaultName::NavigationJump)
            },
            FaultKind::NavigationMissing => bare(FaultName::NavigationMissing),
            FaultKind::Untrue(untrue) => Self::of_untrue(fault, untrue),
            FaultKind::AnotherDive { file, reversed } => Self {
                for_s: None,
                dive_file: Some(file.as_str().to_owned()),
                reversed: Some(*reversed),
                ..bare(FaultName::AnotherDive)
            },
            FaultKind::MissionAbort => Self {
                for_s: None,
                ..bare(FaultName::MissionAbort)
            },
            FaultKind::SensorDropout(sensor) => Self {
                sensor: Some((*sensor).into()),
                ..bare(FaultName::SensorDropout)
            },
            FaultKind::Shutdown => Self {
                for_s: None,
                ..bare(FaultName::Shutdown)
            },
            FaultKind::ClockStep(nanos) => Self {
                by_s: Some(*nanos as f64 / 1e9),
                ..bare(FaultName::ClockStep)
            },
        }
    }

    fn of_untrue(fault: &Fault, untrue: &Untrue) -> Self {
        let bare = |kind| Self::bare(kind, fault);
        match *untrue {
            Untrue::PositionCreeps { speed_mps, towards_deg } => Self {
                speed_mps: Some(speed_mps),
                towards_deg: Some(towards_deg),
                ..bare(FaultName::PositionCreep)
            },
            Untrue::PositionFrozen => bare(FaultName::PositionFrozen),
            Untrue::PositionBackwards => bare(FaultName::PositionBackwards),
            Untrue::VelocityMissing => bare(FaultName::VelocityMissing),
            Untrue::HeadingFlips { by_deg } => Self {
                by_deg: Some(by_deg),
                ..bare(FaultName::HeadingFlip)
            },
            Untrue::DepthFlips { by_m } => Self {
                by_m: Some(by_m),
                ..bare(FaultName::DepthFlip)
            },
        }
    }

    fn of_link(fault: &Fault, link: &LinkFault) -> Self {
        let (client, role) = match &link.whom {
            Whom::All => (None, None),
            Whom::Client(client) => (Some(client.0), None),
            Whom::Role(role) => (None, Some(role.clone())),
        };
        let bare = |kind| Self {
            client,
            role: role.clone(),
            ..Self::bare(kind, fault)
        };
        let way = |kind| Self {
            direction: Some(link.direction.into()),
            ..bare(kind)
        };
        match link.kind {
            LinkFaultKind::Cut => bare(FaultName::LinkCut),
            LinkFaultKind::Refuse => bare(FaultName::Refuse),
            LinkFaultKind::Stall => way(FaultName::Stall),
            LinkFaultKind::Deaf => bare(FaultName::Deaf),
            LinkFaultKind::HalfOpen => way(FaultName::HalfOpen),
            LinkFaultKind::Delay { delay, jitter, growth } => Self {
                delay_s: Some(delay.as_secs_f64()),
                jitter_s: Some(jitter.as_secs_f64()),
                growth: (growth > 0.0).then_some(growth),
                ..way(FaultName::Delay)
            },
            LinkFaultKind::Split { bytes, gap } => Self {
                bytes: Some(bytes),
                gap_s: Some(gap.as_secs_f64()),
                ..way(FaultName::Split)
            },
            LinkFaultKind::Join { hold } => Self {
                hold_s: Some(hold.as_secs_f64()),
                ..way(FaultName::Join)
            },
            LinkFaultKind::Duplicate { chance } => Self {
                chance: Some(chance),
                ..way(FaultName::Duplicate)
            },
            LinkFaultKind::Corrupt { chance } => Self {
                chance: Some(chance),
                ..way(FaultName::Corrupt)
            },
            LinkFaultKind::Drop { chance } => Self {
                chance: Some(chance),
                ..way(FaultName::Drop)
            },
        }
    }
}
