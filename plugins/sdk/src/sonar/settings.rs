use serde::{Deserialize, Serialize};

/// Settings of a [`Detector`](super::Detector). All keys have defaults, which suit pings of 1000 to 2000 samples from a
/// sidescan of about 400 kHz at an altitude of 5 to 20 m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DetectorSettings {
    /// Width of a cell over the ground across the track, metres, 0.05 to 2.
    pub cell_m: f64,
    /// Ground range that is searched at most, metres, 5 to 500. What the sonar's range does not reach is not searched.
    pub range_m: f64,
    /// Where the search begins, in altitudes of ground range, 0.2 to 5: nearer, shadows are short and cells have few
    /// samples.
    pub nadir: f64,
    /// How many pings are averaged along the track, 1 to 50.
    pub pings: u8,
    /// How long a highlight is at least, metres over the ground, 0.1 to 10.
    pub highlight_m: f64,
    /// How long a highlight is at most, metres over the ground, 1 to 50.
    pub highlight_max_m: f64,
    /// How long a shadow is at least, metres over the ground, 0.1 to 50.
    pub shadow_m: f64,
    /// How long a shadow is at most, metres over the ground, 1 to 100.
    pub shadow_max_m: f64,
    /// The strip of seabed on the near side with which both are compared, metres, 1 to 50.
    pub reference_m: f64,
    /// How probable it is that a place of an even seabed passes as highlight and shadow by chance, 1e-12 to 0.01.
    pub false_alarm: f64,
    /// A highlight is at least so much brighter than the seabed beside it, decibels, 0 to 40. An uneven seabed does not
    /// follow the statistics of speckle: gravel is some 7 dB brighter than sand.
    pub highlight_db: f64,
    /// A shadow is at least so much darker than the seabed beside it, decibels, 0 to 30. A small object hides only a part
    /// of a wide beam.
    pub shadow_db: f64,
    /// How many pings must show it, 1 to 100.
    pub hits: u16,
    /// How far across the track hits of successive pings may be apart, metres, 0.2 to 20.
    pub join_m: f64,
    /// How many pings in a row may miss it, 0 to 50.
    pub gap_pings: u8,
    /// A contact is cut at this length along the track, metres, 2 to 500.
    pub length_max_m: f64,
    /// How many pings the normalisation covers, 20 to 10000.
    pub memory_pings: u16,
    /// While the track turns faster than this, nothing is learnt and no contact is made, degrees a metre, 0.05 to 20.
    pub turn_deg_per_m: f64,
}

impl Default for DetectorSettings {
    fn default() -> Self {
        Self {
            cell_m: 0.25,
            range_m: 100.0,
            nadir: 0.7,
            pings: 5,
            highlight_m: 0.5,
            highlight_max_m: 12.0,
            shadow_m: 0.75,
            shadow_max_m: 30.0,
            reference_m: 8.0,
            false_alarm: 1e-7,
            highlight_db: 10.0,
            shadow_db: 3.0,
            hits: 4,
            join_m: 1.5,
            gap_pings: 4,
            length_max_m: 80.0,
            memory_pings: 300,
            turn_deg_per_m: 0.5,
        }
    }
}

/// A setting that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{key} is {value}: expected {least} to {most}")]
pub struct SettingsError {
    /// The key.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// The least value.
    pub least: f64,
    /// The greatest value.
    pub most: f64,
}

/// Whether a value is within a range.
pub(crate) fn within(key: &'static str, value: f64, least: f64, most: f64) -> Result<(), SettingsError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(SettingsError {
            key,
            value,
            least,
            most,
        })
    }
}

impl DetectorSettings {
    /// Checks the ranges of all settings.
    ///
    /// # Errors
    /// [`SettingsError`] with the first setting that is out of its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        within("cell_m", self.cell_m, 0.05, 2.0)?;
        within("range_m", self.range_m, 5.0, 500.0)?;
        within("nadir", self.nadir, 0.2, 5.0)?;
        within("pings", f64::from(self.pings), 1.0, 50.0)?;
        within("highlight_m", self.highlight_m, 0.1, 10.0)?;
        within("highlight_max_m", self.highlight_max_m, 1.0, 50.0)?;
        within("shadow_m", self.shadow_m, 0.1, 50.0)?;
        within("shadow_max_m", self.shadow_max_m, 1.0, 100.0)?;
        within("reference_m", self.reference_m, 1.0, 50.0)?;
        within("false_alarm", self.false_alarm, 1e-12, 0.01)?;
        within("highlight_db", self.highlight_db, 0.0, 40.0)?;
        within("shadow_db", self.shadow_db, 0.0, 30.0)?;
        within("hits", f64::from(self.hits), 1.0, 100.0)?;
        within("join_m", self.join_m, 0.2, 20.0)?;
        within("gap_pings", f64::from(self.gap_pings), 0.0, 50.0)?;
        within("length_max_m", self.length_max_m, 2.0, 500.0)?;
        within("memory_pings", f64::from(self.memory_pings), 20.0, 10_000.0)?;
        within("turn_deg_per_m", self.turn_deg_per_m, 0.05, 20.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_out_of_its_range_is_named() {
        assert_eq!(DetectorSettings::default().validate(), Ok(()));
        let odd = DetectorSettings {
            cell_m: f64::NAN,
            ..DetectorSettings::default()
        };
        assert_eq!(odd.validate().unwrap_err().key, "cell_m");
        let odd = DetectorSettings {
            hits: 0,
            ..DetectorSettings::default()
        };
        assert_eq!(odd.validate().unwrap_err().to_string(), "hits is 0: expected 1 to 100");
    }
}
