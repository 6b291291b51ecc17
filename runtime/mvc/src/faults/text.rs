use core::fmt;

use backseat_spi::CommandName;

use super::{
    AckFilter, AckStage, Directions, FaultEdge, FaultEvent, FaultKind, LinkFault, LinkFaultKind, NegativeStatus,
    Untrue, Whom,
};
use crate::faults::Sensor;

impl fmt::Display for FaultEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edge = match self.edge {
            FaultEdge::Begin => "begins",
            FaultEdge::End => "ends",
        };
        write!(f, "fault {} {edge}: {}", self.number, self.kind)
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(fault) => fault.fmt(f),
            Self::AcksLost(acks) => write!(f, "{acks} lost"),
            Self::AcksLate { acks, delay } => write!(f, "{acks} {} s late", delay.as_secs_f64()),
            Self::AcksNegative { command, status, done } => {
                let status = match status {
                    NegativeStatus::Invalid => "invalid",
                    NegativeStatus::Failed => "failed",
                };
                let done = if *done { ", but carried out" } else { "" };
                write!(f, "{} refused as {status}{done}", Commands(*command))
            }
            Self::ControlTaken => f.write_str("control taken back"),
            Self::NavigationFrozen => f.write_str("navigation frozen"),
            Self::NavigationJump(by) => {
                write!(f, "navigation moved by {} m east, {} m north", by.east_m, by.north_m)
            }
            Self::NavigationMissing => f.write_str("navigation missing"),
            Self::Untrue(untrue) => untrue.fmt(f),
            Self::AnotherDive { file, reversed } => {
                let plan = if *reversed {
                    "its plan reversed"
                } else {
                    "the same plan"
                };
                write!(f, "another dive, {}, {plan}", file.as_str())
            }
            Self::MissionAbort => f.write_str("mission aborted"),
            Self::SensorDropout(sensor) => write!(f, "{sensor} dropped out"),
            Self::Shutdown => f.write_str("shutdown"),
            Self::ClockStep(nanos) => write!(f, "vehicle clock moved by {} s", *nanos as f64 / 1e9),
        }
    }
}

impl fmt::Display for Untrue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PositionCreeps { speed_mps, towards_deg } => {
                write!(f, "position creeps by {speed_mps} m/s towards {towards_deg} degrees")
            }
            Self::PositionFrozen => f.write_str("position frozen"),
            Self::PositionBackwards => f.write_str("position goes backwards"),
            Self::VelocityMissing => f.write_str("velocity missing"),
            Self::HeadingFlips { by_deg } => write!(f, "heading flips by {by_deg} degrees"),
            Self::DepthFlips { by_m } => write!(f, "depth flips by {by_m} m"),
        }
    }
}

impl fmt::Display for LinkFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            LinkFaultKind::Cut => return write!(f, "link cut for {}", self.whom),
            LinkFaultKind::Refuse => return write!(f, "connections refused for {}", self.whom),
            LinkFaultKind::Deaf => return write!(f, "vehicle deaf to {}", self.whom),
            LinkFaultKind::Stall => f.write_str("stall"),
            LinkFaultKind::HalfOpen => f.write_str("silent loss"),
            LinkFaultKind::Delay { delay, jitter, growth } => {
                let (delay_s, jitter_s) = (delay.as_secs_f64(), jitter.as_secs_f64());
                write!(f, "delay of {delay_s} s plus up to {jitter_s} s")?;
                if growth > 0.0 {
                    write!(f, ", growing by {growth} s a second,")?;
                }
                Ok(())
            }
            LinkFaultKind::Split { bytes, gap } => {
                write!(f, "pieces of up to {bytes} bytes, {} s apart,", gap.as_secs_f64())
            }
            LinkFaultKind::Join { hold } => write!(f, "writes collected for {} s", hold.as_secs_f64()),
            LinkFaultKind::Duplicate { chance } => write!(f, "sentences duplicated, chance {chance},"),
            LinkFaultKind::Corrupt { chance } => write!(f, "bytes corrupted, chance {chance},"),
            LinkFaultKind::Drop { chance } => write!(f, "sentences lost, chance {chance},"),
        }?;
        write!(f, " on the link {} for {}", self.direction, self.whom)
    }
}

impl fmt::Display for Directions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Both => "in both directions",
            Self::ToVehicle => "to the vehicle",
            Self::FromVehicle => "from the vehicle",
        })
    }
}

impl fmt::Display for Whom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all clients"),
            Self::Client(client) => client.fmt(f),
            Self::Role(role) => write!(f, "role {role}"),
        }
    }
}

impl fmt::Display for AckFilter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let stage = match self.stage {
            AckStage::All => "acknowledgements",
            AckStage::Pending => "pending acknowledgements",
            AckStage::Outcome => "outcomes",
        };
        write!(f, "{stage} of {}", Commands(self.command))
    }
}

struct Commands(Option<CommandName>);

impl fmt::Display for Commands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.as_ref().map_or("every command", CommandName::as_str))
    }
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dvl => "DVL",
            Self::Altimeter => "altimeter",
            Self::Gps => "GPS",
            Self::Compass => "compass",
            Self::Depth => "depth sensor",
            Self::Imu => "IMU",
            Self::Ctd => "CTD",
            Self::SoundVelocity => "sound velocity sensor",
            Self::Tailcone => "tailcone",
            Self::Telemetry => "telemetry",
        })
    }
}
