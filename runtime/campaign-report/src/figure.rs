/// A number with four significant digits.
pub(crate) fn figure(value: f64) -> String {
    let size = value.abs();
    let text = if size == 0.0 {
        "0".to_owned()
    } else if !(1e-4..1e7).contains(&size) {
        format!("{value:.2e}")
    } else {
        let digits = [1000.0, 100.0, 10.0, 1.0, 0.1, 0.01]
            .iter()
            .filter(|step| size < **step)
            .count();
        format!("{value:.digits$}")
    };
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A share as a percentage.
pub(crate) fn percent(share: f64) -> String {
    let hundred = 100.0 * share;
    if hundred.abs() < 5e-4 || (hundred - 100.0).abs() < 5e-4 {
        format!("{hundred:.0} %")
    } else if (1.0..=99.0).contains(&hundred) {
        format!("{hundred:.1} %")
    } else {
        format!("{hundred:.3} %")
    }
}

/// A measure's name in words, with its unit: `contour_rms_m` is `contour rms, m`.
pub(crate) fn words(name: &str) -> String {
    const UNITS: [(&str, &str); 9] = [
        ("_mps", "m/s"),
        ("_percent", "%"),
        ("_deg", "degrees"),
        ("_degc", "°C"),
        ("_c", "°C"),
        ("_m", "m"),
        ("_s", "s"),
        ("_km", "km"),
        ("_h", "h"),
    ];
    for (suffix, unit) in UNITS {
        if let Some(stem) = name.strip_suffix(suffix) {
            return format!("{}, {unit}", stem.replace('_', " "));
        }
    }
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_four_digits() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (1.23456, "1.235"),
            (-12.3456, "-12.35"),
            (1234.56, "1235"),
            (0.012_347, "0.01235"),
            (0.000_01, "1.00e-5"),
            (2.5e8, "2.50e8"),
        ] {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn shares_are_percentages() {
        for (share, text) in [
            (0.0, "0 %"),
            (1e-17, "0 %"),
            (1.0, "100 %"),
            (0.5, "50.0 %"),
            (0.0012, "0.120 %"),
            (0.999, "99.900 %"),
        ] {
            assert_eq!(percent(share), text);
        }
    }

    #[test]
    fn measures_are_named_in_words() {
        assert_eq!(words("contour_rms_m"), "contour rms, m");
        assert_eq!(words("published.plume.maximum"), "published.plume.maximum");
    }
}
