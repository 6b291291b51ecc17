use backseat_units::Position;
#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Strategy};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::number::two_digits;

const NOT_A_LATITUDE: Fault = Fault::expected("two digits of degrees, then minutes below 60");
const NOT_A_LONGITUDE: Fault = Fault::expected("three digits of degrees, then minutes below 60");

/// Latitude, hemisphere, longitude, hemisphere. Degrees and minutes with six decimals (2 mm), padded to fixed width.
impl Field for Position {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["ddmm.mmmmmm", "N/S", "dddmm.mmmmmm", "E/W"];
    const RANGE: &'static str = "90 S..90 N, 180 W..180 E";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        let latitude = angle(reader.digits_and_decimal::<2>(NOT_A_LATITUDE)?).ok_or(NOT_A_LATITUDE)?;
        let latitude = match reader.trimmed()? {
            b"N" => latitude,
            b"S" => 0.0 - latitude,
            _ => return Err(Fault::expected("N or S")),
        };
        let longitude = angle(reader.digits_and_decimal::<3>(NOT_A_LONGITUDE)?).ok_or(NOT_A_LONGITUDE)?;
        let longitude = match reader.trimmed()? {
            b"E" => longitude,
            b"W" => 0.0 - longitude,
            _ => return Err(Fault::expected("E or W")),
        };
        Ok(Self::from_deg(latitude, longitude)?)
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        let latitude = micro_minutes(value.latitude.as_deg());
        let [.., d1, d2, m1, m2, p, a, b, c, d, e, f] = angle_digits(latitude.unsigned_abs());
        let north = if latitude < 0 { b'S' } else { b'N' };
        writer
            .field()
            .extend_from_slice(&[d1, d2, m1, m2, p, a, b, c, d, e, f, b',', north]);
        let longitude = micro_minutes(value.longitude.as_deg());
        let east = if longitude < 0 { b'W' } else { b'E' };
        let out = writer.field();
        out.extend_from_slice(&angle_digits(longitude.unsigned_abs()));
        out.extend_from_slice(&[b',', east]);
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<Self> {
        (-5_400_000_000..=5_400_000_000i64, -10_800_000_000..=10_800_000_000i64)
            .prop_map(|(latitude, longitude)| {
                let degrees = |micro: i64| {
                    let sign = if micro < 0 { -1.0 } else { 1.0 };
                    let micro = micro.abs();
                    sign * ((micro / 60_000_000) as f64 + (micro % 60_000_000) as f64 / 1e6 / 60.0)
                };
                Self::from_deg(degrees(latitude), degrees(longitude)).expect("within the ranges")
            })
            .boxed()
    }
}

/// Combines degrees and minutes. Sixty minutes are accepted, because careless rounding prints them.
fn angle((degrees, minutes): (u32, f64)) -> Option<f64> {
    (minutes <= 60.0).then(|| f64::from(degrees) + minutes / 60.0)
}

/// Millionths of a minute as one integer, from which whole degrees and minutes are taken, so that 59.9999999 minutes
/// carry.
fn micro_minutes(deg: f64) -> i64 {
    let magnitude = (deg.abs() * 6e7 + 0.5) as i64;
    if deg < 0.0 { -magnitude } else { magnitude }
}

/// `dddmm.mmmmmm`.
fn angle_digits(micro_minutes: u64) -> [u8; 12] {
    let degrees = (micro_minutes / 60_000_000) as u32;
    let rest = (micro_minutes % 60_000_000) as u32;
    let [_, d1] = two_digits(degrees / 100);
    let [d2, d3] = two_digits(degrees % 100);
    let [m1, m2] = two_digits(rest / 1_000_000);
    let [a, b] = two_digits(rest / 10_000 % 100);
    let [c, d] = two_digits(rest / 100 % 100);
    let [e, f] = two_digits(rest % 100);
    [d1, d2, d3, m1, m2, b'.', a, b, c, d, e, f]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::forms::{read, written};

    fn at(latitude: f64, longitude: f64) -> Position {
        Position::from_deg(latitude, longitude).unwrap()
    }

    #[test]
    fn degrees_have_a_fixed_width_and_minutes_have_any() {
        for (text, position) in [
            (
                "4221.81092,N,07106.84603,W",
                at(42.0 + 21.810_92 / 60.0, -(71.0 + 6.846_03 / 60.0)),
            ),
            ("421.5,S,0716.75,E", at(-(42.0 + 1.5 / 60.0), 71.0 + 6.75 / 60.0)),
            (" 4200 , N ,00000, W ", at(42.0, 0.0)),
            ("9000.000,N,18000.000,W", at(90.0, -180.0)),
            ("4159.9999999999999999,N,07060.000,E", at(42.0, 71.0)),
            ("42.5,N,071.5,E", at(42.0 + 0.5 / 60.0, 71.0 + 0.5 / 60.0)),
        ] {
            let read = read::<Position>(text).unwrap();
            assert!(
                (read.latitude.as_deg() - position.latitude.as_deg()).abs() < 1e-12,
                "{text}"
            );
            assert!(
                (read.longitude.as_deg() - position.longitude.as_deg()).abs() < 1e-12,
                "{text}"
            );
        }
        assert!(
            read::<Position>("0000.0,S,00000.0,W")
                .unwrap()
                .latitude
                .as_deg()
                .is_sign_positive()
        );
    }

    #[test]
    fn an_invalid_position_is_refused() {
        for bad in [
            "",
            "4221.8",
            "4221.8,N",
            "4221.8,n,07106.8,W",
            "4221.8,N,07106.8,",
            "4221.8,E,07106.8,N",
            "9000.1,N,07106.8,W",
            "4221.8,N,18000.1,W",
            "-421.8,N,07106.8,W",
            "42-1.8,N,07106.8,W",
            "42,N,071,W",
            "4,N,071,W",
            "4260.1,N,07106.8,W",
            "4221.8,N,7106.8,W",
            "4221.8e0,N,07106.8,W",
            "4 21.8,N,07106.8,W",
            ",N,07106.8,W",
            "42 1.8,N,07106.8,W",
        ] {
            assert!(read::<Position>(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn minutes_carry_and_are_padded() {
        assert_eq!(
            written::<Position>(&at(41.999_999_999_9, -70.999_999_999_9)).unwrap(),
            ",4200.000000,N,07100.000000,W"
        );
        assert_eq!(
            written::<Position>(&at(-1.025, 1.025)).unwrap(),
            ",0101.500000,S,00101.500000,E"
        );
        assert_eq!(
            written::<Position>(&at(-0.0, -1e-12)).unwrap(),
            ",0000.000000,N,00000.000000,E"
        );
        assert_eq!(
            written::<Position>(&at(-90.0, 180.0)).unwrap(),
            ",9000.000000,S,18000.000000,E"
        );
    }

    #[test]
    fn poles_and_the_antimeridian_survive_and_are_never_passed() {
        for latitude in [-90.0, -89.999_999_999_9, -0.0, 89.999_999_999_9, 90.0] {
            for longitude in [-180.0, -179.999_999_999_9, 0.0, 179.999_999_999_9, 180.0] {
                let text = written::<Position>(&at(latitude, longitude)).unwrap();
                let back = read::<Position>(&text[1..]).unwrap();
                assert!((back.latitude.as_deg() - latitude).abs() < 1e-9, "{text}");
                assert!((back.longitude.as_deg() - longitude).abs() < 1e-9, "{text}");
            }
        }
    }

    proptest! {
        #[test]
        fn positions_survive_to_under_a_centimetre(latitude in -90.0..=90.0f64, longitude in -180.0..=180.0f64) {
            let text = written::<Position>(&at(latitude, longitude)).unwrap();
            let back = read::<Position>(&text[1..]).unwrap();
            // A degree is 111.2 km: 1 mm is 9e-9 of it.
            prop_assert!((back.latitude.as_deg() - latitude).abs() < 9e-9);
            prop_assert!((back.longitude.as_deg() - longitude).abs() < 9e-9);
            prop_assert_eq!(written::<Position>(&back).unwrap(), text);
        }
    }
}
