//! The colours of everything but the ground. They are distinct to colour-blind readers (orange and violet after Wong,
//! Nature Methods 8, 441 (2011), and Okabe and Ito) and darker than any ground.

use crate::picture::Steer;

pub(crate) const TEXT: &str = "#22303a";
pub(crate) const FAINT: &str = "#5c6b75";
pub(crate) const FRAME: &str = "#8a979f";
pub(crate) const PLANNED: &str = "#3f4a52";
pub(crate) const KEEP_IN: &str = "#00695c";
pub(crate) const KEEP_OUT: &str = "#4e342e";
pub(crate) const REJECTED: &str = "#c1121f";
pub(crate) const HIGHLIGHT: &str = "#0b3c8c";
pub(crate) const INSERT: &str = "#6a1b9a";
pub(crate) const MODIFY: &str = "#e66100";
pub(crate) const NOW: &str = "#0072b2";
pub(crate) const FRONT_SEAT: &str = "#1f2a30";

pub(crate) const fn steer(steer: Steer) -> &'static str {
    match steer {
        Steer::FrontSeat => FRONT_SEAT,
        Steer::Modify => MODIFY,
        Steer::Insert => INSERT,
    }
}
