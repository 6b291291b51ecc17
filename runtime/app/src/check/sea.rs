//! A check in the program without the simulation: it does not read `world.toml`.

use std::path::Path;

use anyhow::{Result, bail};
use backseat_mission::Mission;

use super::front_seat::FrontSeat;

/// The front seat, as far as the mission itself describes it.
pub(super) fn front_seat(mission: &Mission, plan: Option<&Path>, sets: &[String]) -> Result<FrontSeat> {
    if let Some(set) = sets.first() {
        bail!("--set {set}: this program was built for sea, and does not read world.toml: leave it out");
    }
    Ok(FrontSeat {
        remark: Some(
            "this program was built for sea, without the simulation: of world.toml it reads the plan, if [plan] names it, and nothing else",
        ),
        ..FrontSeat::of_mission(mission, plan)?
    })
}
