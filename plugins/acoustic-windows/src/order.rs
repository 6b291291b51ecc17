/// The depth that a frame orders, metres: the letter D and the depth in tenths of a metre in two bytes, the higher
/// first. `None` if the frame says anything else.
#[must_use]
pub fn depth_ordered(frame: &[u8]) -> Option<f64> {
    match frame {
        [b'D', high, low] => Some(f64::from(u16::from_be_bytes([*high, *low])) / 10.0),
        _ => None,
    }
}
