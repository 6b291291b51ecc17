/// A device that turns to an ordered angle at a constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Servo {
    at_deg: f64,
    to_deg: f64,
}

impl Servo {
    pub(crate) const fn new(at_deg: f64) -> Self {
        Self { at_deg, to_deg: at_deg }
    }

    pub(crate) const fn at_deg(&self) -> f64 {
        self.at_deg
    }

    pub(crate) const fn turn_to(&mut self, deg: f64) {
        self.to_deg = deg;
    }

    /// One step, in which it turns by at most `most_deg`.
    pub(crate) fn step(&mut self, most_deg: f64) {
        self.at_deg += (self.to_deg - self.at_deg).clamp(-most_deg, most_deg);
    }
}
