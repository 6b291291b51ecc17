//! Samples of imagery as typed views on the record's bytes.

use super::imagery::{ChannelHeader, Polarity, SampleFormat};

/// The samples of a channel. The arrays hold each sample's bytes, little-endian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Samples<'a> {
    /// Envelope of one byte without sign.
    U8(&'a [u8]),
    /// Envelope of one byte with sign.
    I8(&'a [u8]),
    /// Envelope of two bytes without sign.
    U16(&'a [[u8; 2]]),
    /// Envelope of two bytes with sign.
    I16(&'a [[u8; 2]]),
    /// Envelope of four bytes without sign.
    U32(&'a [[u8; 4]]),
    /// Envelope of four bytes with sign.
    I32(&'a [[u8; 4]]),
    /// In-phase and quadrature, two bytes each, with sign.
    Complex16(&'a [[u8; 4]]),
    /// Another form.
    Raw {
        /// Bytes of each sample.
        bytes_per_sample: u8,
        /// All samples.
        bytes: &'a [u8],
    },
}

impl<'a> Samples<'a> {
    pub(super) fn of(format: SampleFormat, header: &ChannelHeader, bytes: &'a [u8]) -> Self {
        let (pairs, _) = bytes.as_chunks();
        let (fours, _) = bytes.as_chunks();
        match (format, header.bytes_per_sample, header.polarity) {
            (SampleFormat::Envelope, 1, Polarity::Unipolar) => Self::U8(bytes),
            (SampleFormat::Envelope, 1, Polarity::Bipolar) => Self::I8(bytes),
            (SampleFormat::Envelope, 2, Polarity::Unipolar) => Self::U16(pairs),
            (SampleFormat::Envelope, 2, Polarity::Bipolar) => Self::I16(pairs),
            (SampleFormat::Envelope, 4, Polarity::Unipolar) => Self::U32(fours),
            (SampleFormat::Envelope, 4, Polarity::Bipolar) => Self::I32(fours),
            (SampleFormat::Complex, 4, _) => Self::Complex16(fours),
            (SampleFormat::Envelope | SampleFormat::Complex | SampleFormat::Other(_), bytes_per_sample, _) => {
                Self::Raw {
                    bytes_per_sample,
                    bytes,
                }
            }
        }
    }

    /// How many samples there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        match self {
            Self::U8(samples) | Self::I8(samples) => samples.len(),
            Self::U16(samples) | Self::I16(samples) => samples.len(),
            Self::U32(samples) | Self::I32(samples) | Self::Complex16(samples) => samples.len(),
            Self::Raw {
                bytes_per_sample: 0, ..
            } => 0,
            Self::Raw {
                bytes_per_sample,
                bytes,
            } => bytes.len() / *bytes_per_sample as usize,
        }
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Appends the amplitude of each sample, as [`Self::for_each_amplitude`] gives it.
    pub fn amplitudes(&self, out: &mut Vec<f32>) {
        out.reserve(match self {
            Self::Raw { .. } => 0,
            Self::U8(_) | Self::I8(_) | Self::U16(_) | Self::I16(_) => self.len(),
            Self::U32(_) | Self::I32(_) | Self::Complex16(_) => self.len(),
        });
        self.for_each_amplitude(|amplitude| out.push(amplitude));
    }

    /// Calls `take` with the amplitude of each sample in order, in steps of the converter: the absolute value of an
    /// envelope, the modulus of a complex sample. Calls it never for samples in another form.
    pub fn for_each_amplitude(&self, take: impl FnMut(f32)) {
        #[expect(
            clippy::cast_precision_loss,
            reason = "24 bits of amplitude are more than a sonar resolves"
        )]
        match self {
            Self::U8(samples) => samples.iter().map(|byte| f32::from(*byte)).for_each(take),
            Self::I8(samples) => samples
                .iter()
                .map(|byte| f32::from(byte.cast_signed()).abs())
                .for_each(take),
            Self::U16(samples) => samples
                .iter()
                .map(|pair| f32::from(u16::from_le_bytes(*pair)))
                .for_each(take),
            Self::I16(samples) => samples
                .iter()
                .map(|pair| f32::from(i16::from_le_bytes(*pair)).abs())
                .for_each(take),
            Self::U32(samples) => samples
                .iter()
                .map(|four| u32::from_le_bytes(*four) as f32)
                .for_each(take),
            Self::I32(samples) => samples
                .iter()
                .map(|four| (i32::from_le_bytes(*four) as f32).abs())
                .for_each(take),
            Self::Complex16(samples) => samples
                .iter()
                .map(|four| {
                    let [i, q] = complex(*four);
                    let (i, q) = (f32::from(i), f32::from(q));
                    (i * i + q * q).sqrt()
                })
                .for_each(take),
            Self::Raw { .. } => {}
        }
    }

    /// The in-phase and quadrature parts; nothing if the samples are not complex.
    pub fn complex(&self) -> impl Iterator<Item = [i16; 2]> + use<'a> {
        let samples = match *self {
            Self::Complex16(samples) => samples,
            Self::U8(_) | Self::I8(_) | Self::U16(_) | Self::I16(_) | Self::U32(_) | Self::I32(_) => &[],
            Self::Raw { .. } => &[],
        };
        samples.iter().map(|four| complex(*four))
    }
}

const fn complex([a, b, c, d]: [u8; 4]) -> [i16; 2] {
    [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])]
}
