use backseat_s7k::record::Samples;
use serde::{Deserialize, Serialize};

/// How several samples become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decimation {
    /// The greatest amplitude: a small target stays visible.
    #[default]
    Maximum,
    /// The mean amplitude: backscatter stays comparable.
    Mean,
}

/// Appends at most `bins` amplitudes. Bin `k` of `b` covers the samples from `k n / b` to `(k + 1) n / b` (rounded down)
/// of `n`, so each sample is in exactly one bin. There are as many bins as samples if there are fewer samples.
///
/// The samples are read where they lie in the record; only the bins are written.
pub(crate) fn decimate(samples: &Samples<'_>, bins: usize, how: Decimation, out: &mut Vec<f32>) {
    let count = samples.len();
    let bins = bins.min(count);
    if bins == 0 {
        return;
    }
    out.reserve_exact(bins);
    let end_of = |bin: usize| (bin + 1) * count / bins;
    let (mut bin, mut index, mut start, mut end) = (0, 0, 0, end_of(0));
    let (mut greatest, mut sum) = (0.0_f32, 0.0_f64);
    samples.for_each_amplitude(|amplitude| {
        greatest = greatest.max(amplitude);
        sum += f64::from(amplitude);
        index += 1;
        if index == end {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_precision_loss,
                reason = "a mean of f32 values"
            )]
            out.push(match how {
                Decimation::Maximum => greatest,
                Decimation::Mean => (sum / (end - start) as f64) as f32,
            });
            bin += 1;
            (start, end) = (end, end_of(bin));
            (greatest, sum) = (0.0, 0.0);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(amplitudes: &[i16], bins: usize, how: Decimation) -> Vec<f32> {
        let bytes: Vec<[u8; 2]> = amplitudes.iter().map(|value| value.to_le_bytes()).collect();
        let mut out = Vec::new();
        decimate(&Samples::I16(&bytes), bins, how, &mut out);
        out
    }

    #[test]
    fn each_bin_has_the_maximum_or_the_mean_of_its_samples() {
        let samples = [1, -9, 2, 3, 4, 5, -20];
        // Bins of 2, 2 and 3 samples.
        assert_eq!(of(&samples, 3, Decimation::Maximum), [9.0, 3.0, 20.0]);
        assert_eq!(of(&samples, 3, Decimation::Mean), [5.0, 2.5, 29.0 / 3.0]);
    }

    #[test]
    fn every_sample_is_in_one_bin() {
        for count in 1..40_i16 {
            for bins in 1..50 {
                let ones = vec![1; count as usize];
                assert_eq!(of(&ones, bins, Decimation::Mean), vec![1.0; bins.min(count as usize)]);
                let last: Vec<i16> = (1..=count).collect();
                let greatest = of(&last, bins, Decimation::Maximum);
                assert_eq!(greatest.last(), Some(&f32::from(count)));
            }
        }
    }

    #[test]
    fn no_samples_or_no_bins_give_nothing() {
        assert!(of(&[], 4, Decimation::Mean).is_empty());
        assert!(of(&[1, 2], 0, Decimation::Mean).is_empty());
        let raw = Samples::Raw {
            bytes_per_sample: 3,
            bytes: &[0; 9],
        };
        let mut out = Vec::new();
        decimate(&raw, 4, Decimation::Maximum, &mut out);
        assert!(out.is_empty());
    }
}
