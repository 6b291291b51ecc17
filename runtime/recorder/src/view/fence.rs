use super::geometry::write_geojson;
use super::{Batch, Topic};

/// `/map/fence`: the mission's fence, once at the start.
pub(super) struct FenceMap {
    /// The fence, until it is written.
    text: Option<String>,
}

impl FenceMap {
    pub(super) fn new(text: &str) -> Self {
        Self {
            text: Some(text.to_owned()),
        }
    }

    pub(super) fn started(&mut self, batch: &mut Batch) {
        if let Some(text) = self.text.take() {
            write_geojson(Topic::Fence, &text, batch);
        }
    }
}
