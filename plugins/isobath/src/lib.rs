//! Follows a depth contour.
