//! Prints the speed tables: `cargo bench -p backseat-bench` prints all of them, `cargo bench -p backseat-bench -- sonar spi`
//! those of these names.

use std::process::ExitCode;

mod campaign;
mod console;
mod fence;
mod mvc;
mod platform;
mod s7k;
mod sixdof;
mod sonar;
mod speed;
mod spi;

/// The tables in the order in which they are printed.
const TABLES: [(&str, fn()); 10] = [
    ("speed", speed::print),
    ("platform", platform::print),
    ("campaign", campaign::print),
    ("console", console::print),
    ("spi", spi::print),
    ("fence", fence::print),
    ("mvc", mvc::print),
    ("sixdof", sixdof::print),
    ("s7k", s7k::print),
    ("sonar", sonar::print),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // `cargo test --benches` and lists of tests run this too, but should not measure.
    if arguments
        .iter()
        .any(|argument| argument == "--test" || argument == "--list")
    {
        return ExitCode::SUCCESS;
    }
    // Cargo adds `--bench`.
    let chosen: Vec<&str> = arguments
        .iter()
        .map(String::as_str)
        .filter(|argument| *argument != "--bench")
        .collect();
    if let Some(unknown) = chosen
        .iter()
        .find(|name| TABLES.iter().all(|(table, _)| table != *name))
    {
        let names: Vec<&str> = TABLES.iter().map(|(table, _)| *table).collect();
        eprintln!("error: no table `{unknown}`: expected {}", names.join(", "));
        return ExitCode::from(2);
    }
    for (name, print) in TABLES {
        if chosen.is_empty() || chosen.contains(&name) {
            println!("\n{name}:\n");
            print();
        }
    }
    ExitCode::SUCCESS
}
