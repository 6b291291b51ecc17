use backseat_mvc::{InterpretationConfig, Mvc};
use tracing::info;

/// Shows which readings of the interface the seed drew; nothing where `world.toml` fixes all of them.
pub(crate) fn tell(vehicle: &Mvc, config: &InterpretationConfig, seed: u64) {
    let drawn = vehicle.interpretation().drawn(config);
    if drawn.is_empty() {
        return;
    }
    info!("seed {seed} draws, in [interpretation]:");
    for (key, value) in drawn {
        info!("  {key} = {value}");
    }
}
