use backseat_spi::{HorizontalMode, ModifyBehavior, ModifySpeedMode, ModifyVerticalMode};
use backseat_units::Timestamp;
use backseat_units::math::wrap_360;

use crate::event::{ClientId, ModifyValues, ModifyVertical};
use crate::hull::Hull;

/// The modify that is in force (SPI 7.12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Modify {
    pub(crate) client: ClientId,
    pub(crate) values: ModifyValues,
    /// When it lapses unless it is refreshed.
    pub(crate) until: Timestamp,
}

/// Why a BPRMB is not taken.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ModifyFault {
    /// A field has no meaning: status 0.
    Invalid(String),
    /// This mock does not fly it: status 1.
    Unsupported(&'static str),
}

/// Reads BPRMB. `grid_convergence_deg` is what to add to its heading to count from true north.
///
/// An empty horizontal mode is a heading, and an empty vertical mode a depth, as the numbers that the fields had
/// before the modes were added; an empty speed mode is refused, since 0 means rpm here and metres a second in BPRTK.
pub(crate) fn read(
    request: &ModifyBehavior,
    hull: &Hull,
    grid_convergence_deg: f64,
) -> Result<ModifyValues, ModifyFault> {
    let heading_deg = match (request.horizontal, request.horizontal_mode) {
        (None, _) => None,
        (Some(deg), None | Some(HorizontalMode::Heading)) if deg.abs() <= 720.0 => {
            Some(wrap_360(deg + grid_convergence_deg))
        }
        (Some(deg), None | Some(HorizontalMode::Heading)) => {
            return Err(ModifyFault::Invalid(format!(
                "horizontal {deg}: expected a heading in degrees"
            )));
        }
        (Some(_), Some(HorizontalMode::Rudder)) => {
            return Err(ModifyFault::Unsupported(
                "rudder adjustment is not supported by this mock",
            ));
        }
        (Some(_), Some(HorizontalMode::Other(code))) => {
            return Err(ModifyFault::Invalid(format!("horizontal_mode {code}: expected 0 or 1")));
        }
    };
    let vertical = match (request.vertical_m, request.vertical_mode) {
        (None, _) => None,
        (Some(depth), None | Some(ModifyVerticalMode::Depth)) => Some(ModifyVertical::Depth(depth)),
        (Some(altitude), Some(ModifyVerticalMode::Altitude)) => Some(ModifyVertical::Altitude(altitude)),
        (Some(pitch), Some(ModifyVerticalMode::Pitch)) => Some(ModifyVertical::Pitch(pitch)),
        (Some(_), Some(ModifyVerticalMode::Elevator)) => {
            return Err(ModifyFault::Unsupported(
                "elevator adjustment is not supported by this mock",
            ));
        }
        (Some(_), Some(ModifyVerticalMode::Other(code))) => {
            return Err(ModifyFault::Invalid(format!("vertical_mode {code}: expected 0 to 3")));
        }
    };
    let speed_mps = match (request.speed, request.speed_mode) {
        (None, _) => None,
        (Some(rpm), Some(ModifySpeedMode::Rpm)) => Some(rpm / hull.rpm_per_mps),
        (Some(mps), Some(ModifySpeedMode::MetresPerSecond)) => Some(mps),
        (Some(_), None) => return Err(ModifyFault::Invalid("speed_mode: empty beside a speed".to_owned())),
        (Some(_), Some(ModifySpeedMode::Other(code))) => {
            return Err(ModifyFault::Invalid(format!("speed_mode {code}: expected 0 or 1")));
        }
    };
    Ok(ModifyValues {
        heading_deg,
        vertical,
        speed_mps,
    })
}
