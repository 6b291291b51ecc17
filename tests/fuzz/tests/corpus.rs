//! Runs each corpus through its target, with deterministic mutations.

use std::fs;
use std::path::Path;

use backseat_fuzz::Target;
use backseat_spi::{Direction, catalogue};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// The number of mutations of each seed, so that a target receives a few thousand inputs.
const MUTATIONS: usize = 600;

/// Safety requirement 013.
#[test]
fn no_input_breaks_a_target() {
    for (name, target) in backseat_fuzz::TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
        let mut files: Vec<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        files.sort();
        assert!(!files.is_empty(), "{} is empty", folder.display());
        let files = files
            .into_iter()
            .map(|path| (path.display().to_string(), fs::read(&path).unwrap()));
        let examples = catalogue()
            .iter()
            .map(|entry| (entry.example.to_owned(), entry.example.as_bytes().to_vec()));
        let seeds: Vec<_> = files.chain(examples).collect();
        for (at, (seed, data)) in seeds.iter().enumerate() {
            run(name, seed, target, data);
            let mut random = ChaCha8Rng::seed_from_u64(at as u64);
            let mut mutant = data.clone();
            for round in 0..MUTATIONS {
                // Walks of a few steps away from the seed, and then back to it.
                if round % 5 == 0 {
                    mutant.clone_from(data);
                }
                let other = &seeds[below(&mut random, seeds.len())].1;
                mutate(&mut mutant, other, &mut random);
                run(name, seed, target, &mutant);
            }
        }
    }
}

/// Each row of the tables has a seed for libFuzzer, which does not know the catalogue.
#[test]
fn each_message_has_a_seed() {
    for entry in catalogue() {
        let target = match entry.direction {
            Direction::FromVehicle => "from_vehicle",
            Direction::ToVehicle => "to_vehicle",
        };
        let file = format!("corpus/{target}/row_{}", entry.name.to_ascii_lowercase());
        let seed = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(&file)).expect(&file);
        assert_eq!(seed, entry.example.as_bytes(), "{file}");
    }
}

/// Prints the input of a failure, so that it can be added to the corpus.
fn run(name: &str, seed: &str, target: Target, data: &[u8]) {
    if let Err(cause) = std::panic::catch_unwind(|| target(data)) {
        println!("target {name}, from {seed}: \"{}\"", data.escape_ascii());
        std::panic::resume_unwind(cause);
    }
}

fn below(random: &mut ChaCha8Rng, bound: usize) -> usize {
    if bound == 0 {
        0
    } else {
        random.next_u64() as usize % bound
    }
}

/// One change: a byte, a run of bytes, a field, or a join with another seed.
fn mutate(data: &mut Vec<u8>, other: &[u8], random: &mut ChaCha8Rng) {
    const PIECES: [&[u8]; 24] = [
        b",",
        b"*",
        b"$",
        b"\r\n",
        b"\n",
        b"",
        b" ",
        b"-",
        b".",
        b"-0",
        b"0",
        b"1e9",
        b"nan",
        b"inf",
        b"999999999999999999999",
        b"59.9999999",
        b"235960",
        b"240000",
        b"N",
        b"\xc3\xa9",
        b"\xff",
        b"\0",
        b"BP",
        b"$BFCTL,081025.987,1*78\r\n",
    ];
    let at = below(random, data.len() + 1);
    match below(random, 7) {
        0 if at < data.len() => data[at] = random.next_u64() as u8,
        1 if at < data.len() => data[at] ^= 1 << below(random, 8),
        2 => {
            let end = (at + below(random, 12)).min(data.len());
            data.drain(at..end);
        }
        3 => {
            let end = (at + below(random, 40)).min(data.len());
            let run = data[at..end].to_vec();
            data.splice(at..at, run);
        }
        4 => {
            let from = below(random, other.len());
            let end = (from + below(random, 60)).min(other.len());
            data.splice(at..at, other[from..end].iter().copied());
        }
        5 => {
            // Replaces one whole field.
            let start = data[..at]
                .iter()
                .rposition(|byte| *byte == b',')
                .map_or(0, |comma| comma + 1);
            let end = data[at..]
                .iter()
                .position(|byte| matches!(byte, b',' | b'*'))
                .map_or(data.len(), |comma| at + comma);
            let piece = PIECES[below(random, PIECES.len())];
            data.splice(start..end, piece.iter().copied());
        }
        _ => {
            let piece = PIECES[below(random, PIECES.len())];
            data.splice(at..at, piece.iter().copied());
        }
    }
    data.truncate(8192);
}
