use super::{CircleLayout, EmptyMode, Interpretation, ResumeFrom};
use crate::file::{
    Acknowledged, AdjustmentWhenSilenced, AfterInterrupt, AfterSuspension, AllTopics, BrokenLine, CancelAllScope,
    Choice, CtdPressure, HeadingFrame, HullVertical, InsertPlace, InsertsAfterControl, InterpretationConfig,
    Interruption, ModifyBeyond, ModifyEmptyMode, ModifyFins, TrackcircleLayout, UnackedFrames, UnknownCommand,
};

impl Interpretation {
    /// What the seed drew: each key of `[interpretation]` that says `"seed"`, with the value that it stands for in this
    /// run, as `world.toml` would have it, in the order of the section's documentation.
    #[must_use]
    pub fn drawn(&self, config: &InterpretationConfig) -> Vec<(&'static str, String)> {
        let word = |first: bool, yes: &str, no: &str| format!("\"{}\"", if first { yes } else { no });
        let rows = [
            (
                "inserts_after_control",
                config.inserts_after_control == InsertsAfterControl::Seed,
                word(self.inserts_fly_on, "fly", "drop"),
            ),
            (
                "after_interrupt",
                config.after_interrupt == AfterInterrupt::Seed,
                word(self.resume, "resume", "next"),
            ),
            (
                "lead_in_m",
                config.lead_in_m == Choice::Seed,
                format!("{:.3}", self.lead_in_m),
            ),
            (
                "control_replay",
                config.control_replay == Choice::Seed,
                self.control_replay.to_string(),
            ),
            (
                "cancel_all_scope",
                config.cancel_all_scope == CancelAllScope::Seed,
                word(self.cancel_all, "all", "own"),
            ),
            (
                "modify_heading",
                config.modify_heading == HeadingFrame::Seed,
                word(self.heading_is_grid, "grid", "true"),
            ),
            (
                "insert_place",
                config.insert_place == InsertPlace::Seed,
                word(self.inserts_at_legs, "leg", "current"),
            ),
            (
                "insert_logging",
                config.insert_logging == Choice::Seed,
                self.insert_logging.to_string(),
            ),
            (
                "cancel_scope",
                config.cancel_scope == CancelAllScope::Seed,
                word(self.cancel_any, "all", "own"),
            ),
            (
                "cancel_all_gps",
                config.cancel_all_gps == Choice::Seed,
                self.cancel_all_gps.to_string(),
            ),
            (
                "modify_survives",
                config.modify_survives == Choice::Seed,
                self.modify_survives.to_string(),
            ),
            (
                "modify_beyond",
                config.modify_beyond == ModifyBeyond::Seed,
                word(self.modify_beyond_refused, "refuse", "clip"),
            ),
            (
                "modify_fins",
                config.modify_fins == ModifyFins::Seed,
                word(self.fins_change, "change", "absolute"),
            ),
            (
                "modify_empty_mode",
                config.modify_empty_mode == ModifyEmptyMode::Seed,
                match self.empty_mode {
                    EmptyMode::Behavior => "\"behavior\"".to_owned(),
                    EmptyMode::Zero => "\"zero\"".to_owned(),
                    EmptyMode::Refused => "\"refuse\"".to_owned(),
                },
            ),
            (
                "suspend_needs_control",
                config.suspend_needs_control == Choice::Seed,
                self.suspend_needs_control.to_string(),
            ),
            (
                "after_suspension",
                config.after_suspension == AfterSuspension::Seed,
                match self.resume_from {
                    ResumeFrom::Behavior => "\"behavior\"".to_owned(),
                    ResumeFrom::SuspensionPoint => "\"return\"".to_owned(),
                    ResumeFrom::Here => "\"here\"".to_owned(),
                },
            ),
            (
                "hull_vertical",
                config.hull_vertical == HullVertical::Seed,
                word(self.hull_vertical_up, "up", "down"),
            ),
            (
                "adjustment_when_silenced",
                config.adjustment_when_silenced == AdjustmentWhenSilenced::Seed,
                word(self.silence_cancels_adjustment, "cancel", "refuse"),
            ),
            (
                "adjustment_needs_status",
                config.adjustment_needs_status == Choice::Seed,
                self.adjustment_needs_status.to_string(),
            ),
            (
                "dvl_timeout_announced",
                config.dvl_timeout_announced == Choice::Seed,
                self.dvl_timeout_announced.to_string(),
            ),
            (
                "unacked_frames",
                config.unacked_frames == UnackedFrames::Seed,
                word(self.unacked_is_failed, "failed", "unacknowledged"),
            ),
            (
                "interruption",
                config.interruption == Interruption::Seed,
                word(self.set_interrupts, "set", "behavior"),
            ),
            (
                "acknowledged",
                config.acknowledged == Acknowledged::Seed,
                word(self.acknowledges_sections, "sections", "all"),
            ),
            (
                "echo_decimals",
                config.echo_decimals == Choice::Seed,
                self.echo_decimals.to_string(),
            ),
            (
                "trackcircle_layout",
                config.trackcircle_layout == TrackcircleLayout::Seed,
                match self.trackcircle_layout {
                    CircleLayout::Either => "\"either\"".to_owned(),
                    CircleLayout::Table => "\"table\"".to_owned(),
                    CircleLayout::Header => "\"header\"".to_owned(),
                },
            ),
            (
                "unknown_command",
                config.unknown_command == UnknownCommand::Seed,
                word(self.unknown_is_named, "name", "nak"),
            ),
            (
                "broken_line",
                config.broken_line == BrokenLine::Seed,
                word(self.broken_lines_answered, "nak", "ignore"),
            ),
            (
                "ctd_pressure",
                config.ctd_pressure == CtdPressure::Seed,
                word(self.ctd_pressure_is_gauge, "gauge", "absolute"),
            ),
            (
                "all_topics",
                config.all_topics == AllTopics::Seed,
                word(self.all_is_navigation, "navigation", "all"),
            ),
        ];
        let drawn = rows.into_iter().filter(|(_, drawn, _)| *drawn);
        drawn.map(|(key, _, value)| (key, value)).collect()
    }
}
