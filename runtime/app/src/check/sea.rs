//! A check without the simulation: `world.toml` is not looked at.

use std::path::Path;

use anyhow::Result;
use backseat_mission::Mission;

use super::front_seat::FrontSeat;

/// The front seat, as far as the mission itself says.
pub(super) fn front_seat(mission: &Mission, plan: Option<&Path>) -> Result<FrontSeat> {
    Ok(FrontSeat {
        remark: Some("world.toml was not looked at: this program was built for sea, without the simulation"),
        ..FrontSeat::of_mission(mission, plan)?
    })
}
