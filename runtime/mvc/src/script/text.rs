use core::fmt;

use super::{ControlOrder, Order, Orderer};

impl fmt::Display for Orderer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rule(number) => write!(f, "rule {number}"),
            Self::Operator => f.write_str("operator"),
        }
    }
}

/// What shall be the case.
impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) if fault.lasts.is_zero() => write!(f, "fault: {}", fault.kind),
            Self::Fault(fault) => write!(f, "fault for {} s: {}", fault.lasts.as_secs_f64(), fault.kind),
            Self::Control(ControlOrder::Plan) => f.write_str("control as the plan says"),
            Self::Control(ControlOrder::Take) => f.write_str("control taken from the payload"),
            Self::Control(ControlOrder::Give) => f.write_str("control given to the payload"),
            Self::Topside { text, role: None, .. } => write!(f, "message from the topside: {text}"),
            Self::Topside {
                text, role: Some(role), ..
            } => write!(f, "message from the topside to {role}: {text}"),
            Self::Load(dive) => write!(f, "dive {dive} loaded"),
            Self::Start => f.write_str("dive started"),
            Self::End => f.write_str("dive ended"),
            Self::Abort => f.write_str("dive aborted"),
            Self::Shutdown => f.write_str("payload shut down"),
        }
    }
}
