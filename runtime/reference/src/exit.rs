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
/// The same command may do it later: EX_TEMPFAIL of `sysexits.h`.
pub const STOPPED: u8 = 75;
/// A fault of the program itself: the code that Rust gives a panic.
pub const PANICKED: u8 = 101;

/// The exit codes of every command, in ascending order.
pub const EXITS: [Exit; 5] = [
    Exit {
        code: MET,
        meaning: "Done. `sim`: every expectation held, and no plugin was quarantined. `check`: ready. `fly`, `log \
                  judge`: no rule broke. `replay`: all is identical. `s7k verify`: no fault. `plugin test`: tests \
                  and flights passed. `plugin check`: no objection. `run`: ended in order, also by a signal. \
                  `campaign`: every run met its expectations; with `--shard`, every run of the shard was flown.",
    },
    Exit {
        code: UNMET,
        meaning: "Done, and the answer is no. `sim`: an expectation did not hold, a plugin was quarantined, or a \
                  file of the sonar's recording could not be written. `check`: not ready. `doctor`: something is \
                  bad. `swap`: the new version was not taken or did not stay. `spi connect`: the vehicle said \
                  nothing. `fly`, `log judge`: a rule broke. `replay`: something differs. `s7k verify`: a fault in \
                  the recording. `plugin test`: a test or a flight failed. `plugin inspect`: not a plugin. `plugin \
                  check`: an objection. `campaign`: a run missed an expectation, broke a rule or could not be \
                  flown.",
    },
    Exit {
        code: UNUSABLE,
        meaning: "Not done: a wrong option, a file that cannot be read, a device that fails. One line on standard \
                  error says what, where and what to do.",
    },
    Exit {
        code: STOPPED,
        meaning: "`campaign`: stopped before its end by Ctrl-C, SIGTERM or `--stop-after`. What was flown is kept; \
                  the same command goes on. `run`: could not begin because of what is around it, which may pass: a \
                  disk of logs or state that is read-only, a full disk of the state folder, a port that another \
                  program has, an address that this computer does not have. A service tries again.",
    },
    Exit {
        code: PANICKED,
        meaning: "A fault of `backseat` itself. Please report it, with what standard error says.",
    },
];
