use backseat_world::Span;
use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::file::MissionCommandConfig;

/// The `[mission]` section: how the mission starts and ends, and what it lets a payload do.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MissionConfig {
    /// When the vehicle's computer begins to take missions, counted from the start of the run, seconds, 0 to 86400. BFMIS
    /// reports `Offline` until then.
    pub online_after_s: f64,
    /// When the mission starts, counted from the start of the run, seconds, 0 to 86400. With `[[dive]]` each dive says
    /// when it starts.
    pub starts_after_s: f64,
    /// The name of the dive file, as BFMIS, BFMBS and BFMBE give it.
    pub dive_file: String,
    /// The folder that BFMIS names after `Running` (SPI 6.11); may be empty. The mock writes nothing there.
    pub log_dir: String,
    /// What the vehicle does after the last element of its plan, or when its mission is aborted.
    pub wrap_up: WrapUp,
    /// The longest time that the mission may take before the vehicle aborts it, seconds; `None` for no limit.
    pub time_limit_s: Option<f64>,
    /// How many inserts of payloads may wait in the plan, 1 to 1000. More are refused.
    pub inserts_max: u32,
    /// How long one behavior may be modified in all, seconds; `None` for no limit (SPI 7.12).
    pub modify_total_s: Option<f64>,
    /// How far a modify may take the vehicle from the line of the behavior, metres; `None` for no limit (SPI 7.12). A
    /// setpoint has no line.
    pub modify_deviation_m: Option<f64>,
    /// What ends when a modify exceeds one of these two limits.
    pub modify_limit: ModifyLimit,
    /// When the payload has control (BFCTL 1, SPI 6.24).
    pub control: ControlWindow,
    /// How long the antenna must be out of the water before a GPS hit has its fix, seconds, drawn once for the run, 0
    /// to 600.
    pub gps_fix_s: Span,
    /// How long after it came to its place a GPS hit gives up without a fix, seconds, 1 to 1e5 (SPI 7.7: "currently
    /// uses vehicle default").
    pub gps_within_s: f64,
    /// Whether a payload may start an empty mission (SPI 7.20: "must be specially configured").
    pub empty_allowed: bool,
    /// When the payload's power goes off, counted from the start of the run, seconds, 60 or more. The vehicle sends
    /// BFSHT 60 s before (SPI 5.2), and cuts off every client when the power goes off. With `None` it stays on.
    pub shutdown_after_s: Option<f64>,
    /// The mission commands that the vehicle sends at given times (SPI 5.1), at most 1000.
    pub commands: Vec<MissionCommandConfig>,
}

/// What the vehicle does after the last element of its plan, or when its mission is aborted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WrapUp {
    /// The mission is over at once.
    #[default]
    None,
    /// The vehicle climbs to the surface first. BFMIS reports `WrappingUp`, or `Aborting` after an abort, meanwhile.
    Surface,
}

/// When the payload has control (BFCTL 1). SPI 6.24 allows both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ControlWindow {
    /// While the current element of the plan allows dynamic requests.
    #[default]
    Plan,
    /// From the start of the mission to its end.
    Mission,
}

/// What ends when a modify exceeds a limit of the mission. SPI 7.12 allows the vehicle to end the behavior.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ModifyLimit {
    /// The behavior: the next one begins. The modify is over.
    #[default]
    Behavior,
    /// The modify alone. No other is accepted under the same behavior.
    Modify,
}

impl Default for MissionConfig {
    fn default() -> Self {
        Self {
            online_after_s: 0.0,
            starts_after_s: 10.0,
            dive_file: "survey.dive".to_owned(),
            log_dir: "/logs/survey".to_owned(),
            wrap_up: WrapUp::None,
            time_limit_s: None,
            inserts_max: 32,
            modify_total_s: None,
            modify_deviation_m: None,
            modify_limit: ModifyLimit::Behavior,
            control: ControlWindow::Plan,
            gps_fix_s: Span::fixed(30.0),
            gps_within_s: 600.0,
            empty_allowed: false,
            shutdown_after_s: None,
            commands: Vec::new(),
        }
    }
}

impl MissionConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        let online = self.online_after_s;
        check(
            (0.0..=86_400.0).contains(&online),
            "mission.online_after_s",
            online,
            "0 to 86400 s",
        )?;
        let starts = self.starts_after_s;
        check(
            (0.0..=86_400.0).contains(&starts),
            "mission.starts_after_s",
            starts,
            "0 to 86400 s",
        )?;
        let inserts = self.inserts_max;
        check(
            (1..=1000).contains(&inserts),
            "mission.inserts_max",
            f64::from(inserts),
            "1 to 1000",
        )?;
        let (least, most) = (self.gps_fix_s.least(), self.gps_fix_s.most());
        let ok = least >= 0.0 && least <= most && most <= 600.0;
        check(ok, "mission.gps_fix_s", most, "0 to 600 s")?;
        let within = self.gps_within_s;
        check(
            (1.0..=1e5).contains(&within),
            "mission.gps_within_s",
            within,
            "1 to 1e5 s",
        )?;
        for (key, least, value) in [
            ("mission.time_limit_s", 1.0, self.time_limit_s),
            ("mission.modify_total_s", 1.0, self.modify_total_s),
            ("mission.modify_deviation_m", 1.0, self.modify_deviation_m),
            ("mission.shutdown_after_s", 60.0, self.shutdown_after_s),
        ] {
            if let Some(value) = value {
                let expected = if least > 1.0 { "60 to 1e7" } else { "1 to 1e7" };
                check(value >= least && value <= 1e7, key, value, expected)?;
            }
        }
        let commands = self.commands.len();
        check(
            commands <= 1000,
            "mission.commands",
            commands as f64,
            "at most 1000 entries",
        )?;
        for command in &self.commands {
            command.validate()?;
        }
        for (key, value) in [
            ("mission.dive_file", &self.dive_file),
            ("mission.log_dir", &self.log_dir),
        ] {
            if backseat_spi::Text::new(value).is_err() || value.len() > 200 {
                let expected = "at most 200 printable ascii characters without comma, asterisk and dollar";
                return Err(MvcError::Value {
                    key,
                    value: format!("{value:?}"),
                    expected,
                });
            }
        }
        Ok(())
    }
}
