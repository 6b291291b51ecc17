//! Sentences as they are on the wire, taken apart by nobody else's code: what the judge and the model vehicle read.

/// A sentence's name and fields.
#[derive(Clone, Debug)]
pub(crate) struct Line<'a> {
    /// Five letters, `BPRMB`.
    pub(crate) name: &'a str,
    fields: Vec<&'a str>,
}

impl<'a> Line<'a> {
    /// A whole line with its checksum and CRLF; `None` where it is none.
    pub(crate) fn parse(text: &'a str) -> Option<Self> {
        let (body, sum) = text.strip_prefix('$')?.strip_suffix("\r\n")?.split_once('*')?;
        let expected = body.bytes().fold(0, |sum, byte| sum ^ byte);
        if u8::from_str_radix(sum, 16) != Ok(expected) {
            return None;
        }
        let mut fields = body.split(',');
        let name = fields.next().filter(|name| name.len() == 5)?;
        Some(Self {
            name,
            fields: fields.collect(),
        })
    }

    pub(crate) fn field(&self, index: usize) -> &'a str {
        self.fields.get(index).copied().unwrap_or_default()
    }

    pub(crate) fn number<T: std::str::FromStr>(&self, index: usize) -> Option<T> {
        self.field(index).parse().ok()
    }

    /// Latitude and longitude in degrees, from four fields.
    pub(crate) fn place(&self, index: usize) -> Option<[f64; 2]> {
        let axis = |value: &str, side: &str, whole: usize| {
            let degrees: f64 = value.get(..whole)?.parse().ok()?;
            let minutes: f64 = value.get(whole..)?.parse().ok()?;
            let sign = if matches!(side, "S" | "W") { -1.0 } else { 1.0 };
            Some(sign * (degrees + minutes / 60.0))
        };
        Some([
            axis(self.field(index), self.field(index + 1), 2)?,
            axis(self.field(index + 2), self.field(index + 3), 3)?,
        ])
    }
}
