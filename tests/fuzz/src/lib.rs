//! Fuzz targets: one function each, which takes any bytes and panics where an invariant is broken (safety
//! requirement 013: no bytes from any peer can panic or grow memory without bound).
//!
//! The stock test suite runs each file of `corpus/<target>/`, the examples of the message catalogue, and a few thousand
//! deterministic mutations of both through its target, and needs nothing but `cargo test`.
//!
//! To search further, with libFuzzer and a C++ compiler, on stable Rust: its coverage instrumentation is an LLVM pass
//! that `rustc` runs where it is asked to. `--target` keeps it out of build scripts.
//!
//! ```text
//! export RUSTFLAGS="--cfg fuzzing -Ccodegen-units=1 -Cdebug-assertions -Coverflow-checks \
//!     -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
//!     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
//!     -Cllvm-args=-sanitizer-coverage-pc-table \
//!     -Cllvm-args=-sanitizer-coverage-trace-compares"
//! cargo build -p backseat-fuzz --features libfuzzer --release \
//!     --target x86_64-unknown-linux-gnu --target-dir target/fuzz
//! mkdir -p target/fuzz/found
//! target/fuzz/x86_64-unknown-linux-gnu/release/fuzz-from-vehicle \
//!     target/fuzz/found tests/fuzz/corpus/from_vehicle -max_len=4400 -max_total_time=60
//! ```
//!
//! What was run so far on the targets of the 7k format, 100.7 million executions in all, with an input of at most 4096
//! bytes (600 for texts):
//!
//! | target | executions | found |
//! |---|---|---|
//! | `s7k_frame` | 15,000,000 | nothing |
//! | `s7k_record` | 44,500,000 in two runs | nothing |
//! | `s7k_text` | 31,202,519 | after 1,202,519: a number was written as -0.00 (`negative_zero`) |
//! | `s7k_stream` | 8,003,269 | nothing |
//! | `s7k_file` | 2,000,000 | nothing |
//!
//! Inputs that reached new code are kept as `found_…`, a share of what `-set_cover_merge=1` leaves of them.
//! libFuzzer writes a failing input to `crash-…`; put it into the target's corpus under a name that says what it is.

mod fences;
mod messages;
mod sonar;
mod streams;

pub use fences::fence;
pub use messages::{from_vehicle, to_vehicle};
pub use sonar::{s7k_file, s7k_frame, s7k_record, s7k_stream, s7k_text};
pub use streams::{frame, stream};

/// A function that takes any bytes and panics where an invariant is broken.
pub type Target = fn(&[u8]);

/// Every target with the name of its corpus folder.
pub const TARGETS: [(&str, Target); 10] = [
    ("frame", frame),
    ("from_vehicle", from_vehicle),
    ("to_vehicle", to_vehicle),
    ("stream", stream),
    ("fence", fence),
    ("s7k_frame", s7k_frame),
    ("s7k_record", s7k_record),
    ("s7k_text", s7k_text),
    ("s7k_file", s7k_file),
    ("s7k_stream", s7k_stream),
];
