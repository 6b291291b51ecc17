use crate::file::{Acknowledged, AllTopics, BrokenLine, Choice, LineEnd, Profile, UnknownCommand, WorldFile};

/// How far the Sandshark's clock is set to differ from the payload's, seconds. In the recordings they differ by hours.
const CLOCK_AHEAD_S: f64 = -4.0 * 3600.0;

impl WorldFile {
    /// Sets what recordings of a Sandshark show of its side of the interface, whatever the file says of it. Everything
    /// else stays as it is: the plan, the world, and how the vehicle moves.
    ///
    /// `runtime/docs/mock.md` says what each setting is based on.
    pub fn like_sandshark(&mut self) {
        let spi = &mut self.spi;
        "1.11".clone_into(&mut spi.version);
        spi.profile = Profile::Field;
        spi.line_end = LineEnd::CrlfLf;
        // The words of SPI 6.21: the recordings have a text here, and clients may not depend on which.
        "request successfully processed".clone_into(&mut spi.acknowledge_text);
        let interpretation = &mut self.interpretation;
        interpretation.control_replay = Choice::Fixed(false);
        interpretation.acknowledged = Acknowledged::All;
        interpretation.echo_decimals = Choice::Fixed(3.0);
        interpretation.unknown_command = UnknownCommand::Nak;
        interpretation.broken_line = BrokenLine::Nak;
        interpretation.all_topics = AllTopics::Navigation;
        self.start.clock_ahead_s = CLOCK_AHEAD_S;
    }
}
