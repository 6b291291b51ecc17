/// How a command ends.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// The process's exit code.
    pub code: u8,
    /// When it is used.
    pub meaning: &'static str,
}

/// All is well.
pub const MET: u8 = 0;
/// The command did its work, and the answer is no.
pub const UNMET: u8 = 1;
/// The command could not do its work.
pub const UNUSABLE: u8 = 2;
/// A fault of the program itself: the code that Rust gives a panic.
pub const PANICKED: u8 = 101;

/// The exit codes of every command, in ascending order.
pub const EXITS: [Exit; 4] = [
    Exit {
        code: MET,
        meaning: "Done. `sim`: every expectation held. `check`: ready. `fly`, `log judge`: no rule broke. `replay`: all \
                  is identical. `s7k verify`: no fault. `plugin test`: tests and flights passed. `plugin check`: no \
                  objection. `run`: ended in order, also by a signal.",
    },
    Exit {
        code: UNMET,
        meaning: "Done, and the answer is no. `sim`: an expectation did not hold. `check`: not ready. `fly`, `log judge`: \
                  a rule broke. `replay`: something differs. `s7k verify`: a fault in the recording. `plugin test`: a \
                  test or a flight failed. `plugin inspect`: not a plugin. `plugin check`: an objection.",
    },
    Exit {
        code: UNUSABLE,
        meaning: "Not done: a wrong option, a file that cannot be read, a device that fails. One line on standard error \
                  says what, where and what to do.",
    },
    Exit {
        code: PANICKED,
        meaning: "A fault of `backseat` itself. Please report it, with what standard error says.",
    },
];
