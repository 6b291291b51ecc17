/// The lines of one message.
pub(crate) fn of(lines: &[String], name: &str) -> Vec<String> {
    let start = format!("${name},");
    lines.iter().filter(|line| line.starts_with(&start)).cloned().collect()
}

/// A field of a line. Field 0 is the message's name.
pub(crate) fn field(line: &str, index: usize) -> &str {
    line.split(',').nth(index).expect("the line has that many fields")
}

/// A field as a number.
pub(crate) fn number(line: &str, index: usize) -> f64 {
    field(line, index).parse().expect("the field is a number")
}

/// The time of a line, in seconds since eight o'clock, when the tests' missions start.
pub(crate) fn seconds(line: &str) -> f64 {
    let time = field(line, 1);
    let part = |from, to| time[from..to].parse::<f64>().expect("a timestamp has digits");
    (part(0, 2) - 8.0) * 3600.0 + part(2, 4) * 60.0 + part(4, time.len())
}
