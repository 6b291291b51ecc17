use backseat_sdk::units::EastNorth;

use crate::area::Area;
use crate::gaussian::Gaussian;
use crate::least_squares::LeastSquares;
use crate::samples::Bin;

/// A peak lower than this many standard deviations of a single sample is ignored.
const AMPLITUDE_SIGMAS: f64 = 4.0;
/// Values this many standard deviations above the background do not belong to it.
const BACKGROUND_SIGMAS: f64 = 1.0;
const BACKGROUND_ROUNDS: u32 = 8;
/// Fewer bins than this are not evaluated.
const BINS_MIN: usize = 20;
/// A fit whose error exceeds this fraction of its height is not a Gaussian.
const MISFIT: f64 = 0.12;
/// Above this number, bins are merged: the time of the smoothing grows with their square, and a step's fuel is limited.
const BINS_MAX: usize = 300;
/// Bins farther apart than this do not belong to the same line, metres.
const JOIN_MAX_M: f64 = 40.0;

/// How the maximum was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By a Gaussian that fits.
    Fit,
    /// By the centroid of high values, because no Gaussian fits or its centre is outside the area.
    Centroid,
}

/// A maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// In metres from the area's centre, inside the area.
    pub centre: EastNorth,
    /// Height over the background.
    pub amplitude: f64,
    /// Standard deviation of a single sample.
    pub noise: f64,
    /// The smaller and the larger standard deviation of the peak, metres; `None` for a centroid.
    pub sigmas_m: Option<(f64, f64)>,
    /// How it was found.
    pub method: Method,
}

/// The maximum of the values measured over an area with lines `spacing_m` apart. `None` if there is no clear maximum.
///
/// The background is a plane, fitted robustly. The highest value of a kernel smoothing (with Epanechnikov's kernel)
/// over it is the first guess for [`Gaussian::fit`]. If the fit is not plausible, the centroid of high values around
/// the guess is used.
#[must_use]
pub fn locate(bins: &[Bin], area: &Area, spacing_m: f64) -> Option<Located> {
    if bins.len() < BINS_MIN {
        return None;
    }
    let noise = noise(bins);
    let joined = joined(bins);
    let bins = &joined[..];
    let background = background(bins)?;
    let over = |bin: &Bin| bin.value - (background[0] + background[1] * bin.at.east_m + background[2] * bin.at.north_m);
    let inside: Vec<(EastNorth, f64, f64)> = bins
        .iter()
        .filter(|bin| area.rectangle().contains(bin.at, spacing_m))
        .map(|bin| (bin.at, over(bin), f64::from(bin.count)))
        .collect();
    let (guess, smooth) = highest(&inside, 0.75 * spacing_m)?;
    let believed = |fit: &Gaussian| {
        area.rectangle().contains(fit.centre, 0.0)
            && fit.amplitude > AMPLITUDE_SIGMAS * noise
            && fit.centre.distance_m(guess) < 3.0 * fit.sigmas_m().1
            && fit.amplitude < 5.0 * smooth.max(noise)
            && misfit(fit, bins) < MISFIT * fit.amplitude + noise
    };
    // The second start is for a plume much wider than the distance of the lines; it has few rounds, to limit a step's
    // fuel.
    let fit = [(1.0, 20), (2.0, 10)].into_iter().find_map(|(wide, rounds)| {
        let start = Gaussian::round(guess, wide * spacing_m.max(30.0));
        Gaussian::fit(bins, start, noise, rounds).filter(believed)
    });
    if let Some(fit) = fit {
        return Some(Located {
            centre: fit.centre,
            amplitude: fit.amplitude,
            noise,
            sigmas_m: Some(fit.sigmas_m()),
            method: Method::Fit,
        });
    }
    if smooth < AMPLITUDE_SIGMAS * noise {
        return None;
    }
    Some(Located {
        centre: area
            .rectangle()
            .nearest(centroid(&inside, guess, 1.5 * spacing_m, smooth)),
        amplitude: smooth,
        noise,
        sigmas_m: None,
        method: Method::Centroid,
    })
}

/// The root mean square error of a fit, at the bins where its shape is above a tenth of its peak.
fn misfit(fit: &Gaussian, bins: &[Bin]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for bin in bins {
        let shape = fit.shape_at(bin.at);
        if shape > 0.1 {
            let off = bin.value - fit.background_at(bin.at) - fit.amplitude * shape;
            sum += off * off;
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// The noise of a single sample, from the second differences of successive bins: variation that is smooth over three
/// bins is not noise.
fn noise(bins: &[Bin]) -> f64 {
    let mut differences: Vec<f64> = bins
        .windows(3)
        .map(|three| {
            let difference = three[0].value - 2.0 * three[1].value + three[2].value;
            let variance =
                1.0 / f64::from(three[0].count) + 4.0 / f64::from(three[1].count) + 1.0 / f64::from(three[2].count);
            difference.abs() / variance.sqrt()
        })
        .collect();
    // The median absolute value of a normal distribution is 0.6745 of its standard deviation.
    median(&mut differences).unwrap_or(0.0) / 0.6745
}

/// Merges successive bins until few enough remain.
fn joined(bins: &[Bin]) -> Vec<Bin> {
    let most = bins.len().div_ceil(BINS_MAX);
    let mut out: Vec<Bin> = Vec::with_capacity(BINS_MAX);
    let mut members = 0;
    for bin in bins {
        match out.last_mut() {
            Some(last) if members < most && last.at.distance_m(bin.at) < JOIN_MAX_M => {
                let (before, added) = (f64::from(last.count), f64::from(bin.count));
                let share = added / (before + added);
                last.at = last.at + (bin.at - last.at) * share;
                last.value += (bin.value - last.value) * share;
                last.count += bin.count;
                members += 1;
            }
            Some(_) | None => {
                out.push(*bin);
                members = 1;
            }
        }
    }
    out
}

fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// A plane through the background: fitted to all values, then repeatedly to those that are not far above it.
fn background(bins: &[Bin]) -> Option<[f64; 3]> {
    let mut plane: Option<[f64; 3]> = None;
    let mut most_over = f64::INFINITY;
    for _ in 0..BACKGROUND_ROUNDS {
        let over = |bin: &Bin| {
            plane.map_or(0.0, |[middle, east, north]| {
                bin.value - (middle + east * bin.at.east_m + north * bin.at.north_m)
            })
        };
        let mut squares = LeastSquares::<3>::new();
        let kept = bins.iter().filter(|bin| over(bin) <= most_over);
        for bin in kept {
            squares.add([1.0, bin.at.east_m, bin.at.north_m], bin.value, f64::from(bin.count));
        }
        let Some([middle, east, north]) = squares.solve() else {
            break;
        };
        let mut sizes: Vec<f64> = bins
            .iter()
            .map(|bin| (bin.value - (middle + east * bin.at.east_m + north * bin.at.north_m)).abs())
            .collect();
        plane = Some([middle, east, north]);
        most_over = BACKGROUND_SIGMAS * median(&mut sizes)? / 0.6745;
    }
    plane
}

/// The highest of the kernel means at the bins.
fn highest(values: &[(EastNorth, f64, f64)], reach_m: f64) -> Option<(EastNorth, f64)> {
    let square = reach_m * reach_m;
    let mut best: Option<(EastNorth, f64)> = None;
    // Every other bin is close enough to the highest for a first guess.
    for &(middle, _, _) in values.iter().step_by(2) {
        let (mut sum, mut weights, mut used) = (0.0, 0.0, 0);
        for &(at, value, count) in values {
            let from = at - middle;
            let near = 1.0 - (from.east_m * from.east_m + from.north_m * from.north_m) / square;
            if near > 0.0 {
                sum += count * near * value;
                weights += count * near;
                used += 1;
            }
        }
        let mean = sum / weights;
        if used >= 3 && best.is_none_or(|(_, highest)| mean > highest) {
            best = Some((middle, mean));
        }
    }
    best
}

/// The mean position of values above half the height, weighted by their excess.
fn centroid(values: &[(EastNorth, f64, f64)], around: EastNorth, reach_m: f64, height: f64) -> EastNorth {
    let (mut sum, mut weights) = (EastNorth::default(), 0.0);
    for &(at, value, count) in values {
        let weight = count * (value - 0.5 * height);
        if weight > 0.0 && at.distance_m(around) < reach_m {
            sum = sum + at * weight;
            weights += weight;
        }
    }
    if weights > 0.0 { sum * (1.0 / weights) } else { around }
}

#[cfg(test)]
mod tests {
    use backseat_sdk::units::Position;
    use backseat_sdk::units::math::{exp, sin};

    use super::*;

    fn area() -> Area {
        Area::new(
            Position::from_deg(42.0, -70.0).unwrap(),
            EastNorth::new(600.0, 500.0),
            0.0,
        )
    }

    /// Lines 70 m apart over a field, with an oscillation as noise.
    fn map(field: impl Fn(EastNorth) -> f64) -> Vec<Bin> {
        area()
            .lawnmower(70.0, EastNorth::default())
            .iter()
            .flat_map(|line| (0..60).map(|step| line.start + (line.end - line.start) * (f64::from(step) / 59.0)))
            .enumerate()
            .map(|(index, at)| {
                let wobble = 0.01 * (sin(index as f64 * 12.9898) * 43_758.545_3).fract();
                Bin {
                    at,
                    value: field(at) + wobble,
                    count: 6,
                }
            })
            .collect()
    }

    #[test]
    fn no_maximum_is_found_where_there_is_none() {
        assert_eq!(locate(&[], &area(), 70.0), None);
        assert_eq!(locate(&map(|at| 12.0 + 4e-4 * at.east_m), &area(), 70.0), None);
    }

    #[test]
    fn a_peak_that_is_not_gaussian_is_found_too() {
        // A flat disc: its logarithm is not a parabola.
        let middle = EastNorth::new(120.0, -60.0);
        let disc = |at: EastNorth| if at.distance_m(middle) < 90.0 { 12.8 } else { 12.0 };
        let found = locate(&map(disc), &area(), 70.0).unwrap();
        assert!(found.centre.distance_m(middle) < 25.0, "{found:?}");
    }

    #[test]
    fn a_peak_on_a_slope_is_found_inside_the_area() {
        for middle in [EastNorth::new(-250.0, 200.0), EastNorth::new(0.0, 0.0)] {
            let field = |at: EastNorth| {
                let from_m = at.distance_m(middle);
                12.0 + 5e-4 * at.east_m + 0.6 * exp(-0.5 * from_m * from_m / (80.0 * 80.0))
            };
            let found = locate(&map(field), &area(), 70.0).unwrap();
            assert!(found.centre.distance_m(middle) < 10.0, "{found:?}");
            assert_eq!(found.method, Method::Fit);
            assert!(area().rectangle().contains(found.centre, 1e-6));
        }
    }
}
