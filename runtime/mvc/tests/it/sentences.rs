use backseat_units::EastNorth;

use crate::payload::Payload;

/// A field of a sentence as a number. Field 0 is the name.
pub(crate) fn field(line: &str, index: usize) -> f64 {
    line.split(',')
        .nth(index)
        .and_then(|field| field.parse().ok())
        .unwrap_or_else(|| panic!("{line}: field {index} is no number"))
}

/// The time of a sentence, in seconds of its day.
pub(crate) fn seconds(line: &str) -> f64 {
    let stamp = field(line, 1);
    (stamp / 10_000.0).floor() * 3600.0 + (stamp / 100.0).floor() % 100.0 * 60.0 + stamp % 100.0
}

/// The vehicle's place in a BFNVG, in the world's frame.
pub(crate) fn place(payload: &Payload, line: &str) -> EastNorth {
    let degrees = |index: usize| {
        let value = field(line, index);
        (value / 100.0).trunc() + value % 100.0 / 60.0
    };
    let position = backseat_units::Position::from_deg(degrees(2), -degrees(4)).expect("a position");
    payload.mvc.frame().to_local(position)
}

/// The error of a BFNVG that was sent just now.
pub(crate) fn off(payload: &Payload, line: &str) -> EastNorth {
    place(payload, line) - payload.mvc.truth().local
}

/// The file with one key set, in a section that is added if the file does not have it.
pub(crate) fn with(text: &str, section: &str, key: &str) -> String {
    let name = key.split(' ').next().expect("a key");
    let header = format!("[{section}]\n");
    let Some((before, after)) = text.split_once(&header) else {
        return text.replacen("[mission]", &format!("{header}{key}\n[mission]"), 1);
    };
    let end = after.find("\n[").map_or(after.len(), |at| at + 1);
    let kept: String = after[..end]
        .lines()
        .filter(|line| line.split(' ').next() != Some(name))
        .map(|line| format!("{line}\n"))
        .collect();
    format!("{before}{header}{key}\n{kept}{}", &after[end..])
}

/// What a client that has one message on receives between two times.
pub(crate) fn heard(text: &str, seed: u64, message: &str, from_s: f64, to_s: f64) -> (Payload, Vec<String>) {
    let mut payload = Payload::connected(text, seed, &[message]);
    payload.until(from_s);
    payload.heard();
    payload.until(to_s);
    let heard = payload.heard();
    (payload, heard)
}
