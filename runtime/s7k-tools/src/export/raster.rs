//! A raster on which swaths are laid, and how they share a cell.

use nalgebra::Vector2;

/// What a cell becomes that several samples hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// The mean of all.
    #[default]
    Mean,
    /// The brightest.
    Brightest,
    /// The last one of the recording.
    Last,
}

/// What becomes of the strip below the vehicle, where a sidescan sees next to nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Nadir {
    /// It shows only where no other swath covers it.
    #[default]
    Below,
    /// It is left out.
    Drop,
    /// It counts as the rest does.
    Keep,
}

/// A raster of shades, from 1 to 255, and of weights.
#[derive(Debug)]
pub(super) struct Raster {
    pub(super) width: usize,
    pub(super) height: usize,
    blend: Blend,
    cells: Vec<Cell>,
}

/// The sum of weighted shades, and the sum of weights; or a shade and its weight.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    shade: f32,
    weight: f32,
}

/// Bytes that a cell takes in memory: while it is filled, and its shade when it is written.
pub(super) const CELL_BYTES: u64 = size_of::<Cell>() as u64 + 1;

/// The weight of a sample that shows only where nothing else is.
pub(super) const WEAK: f32 = 1e-4;

impl Raster {
    pub(super) fn new(width: usize, height: usize, blend: Blend) -> Self {
        Self {
            width,
            height,
            blend,
            cells: vec![Cell::default(); width * height],
        }
    }

    /// Lays a sample on the cell at a place, in cells from the upper left corner. Places outside are left out.
    pub(super) fn lay(&mut self, place: Vector2<f64>, shade: f32, weight: f32) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "inside the raster"
        )]
        let index = {
            let inside =
                place.x >= 0.0 && place.y >= 0.0 && place.x < self.width as f64 && place.y < self.height as f64;
            if !inside {
                return;
            }
            place.y as usize * self.width + place.x as usize
        };
        let Some(cell) = self.cells.get_mut(index) else {
            return;
        };
        match self.blend {
            Blend::Mean => {
                cell.shade += weight * shade;
                cell.weight += weight;
            }
            Blend::Brightest if weight > cell.weight || (weight >= cell.weight && shade > cell.shade) => {
                *cell = Cell { shade, weight };
            }
            Blend::Last if weight >= cell.weight => *cell = Cell { shade, weight },
            Blend::Brightest | Blend::Last => {}
        }
    }

    /// Appends the shades of a row: 1 to 255, or 0 where no sample fell.
    pub(super) fn row(&self, row: usize, out: &mut Vec<u8>) {
        let cells = &self.cells[row * self.width..(row + 1) * self.width];
        out.extend(cells.iter().map(|cell| match (cell.weight > 0.0, self.blend) {
            (false, _) => 0,
            (true, Blend::Mean) => super::waterfall::shade((cell.shade / cell.weight).clamp(1.0, 255.0)),
            (true, Blend::Brightest | Blend::Last) => super::waterfall::shade(cell.shade.clamp(1.0, 255.0)),
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laid(blend: Blend, samples: &[(f32, f32)]) -> u8 {
        let mut raster = Raster::new(3, 2, blend);
        for (shade, weight) in samples {
            raster.lay(Vector2::new(1.5, 1.5), *shade, *weight);
        }
        let mut row = Vec::new();
        raster.row(1, &mut row);
        assert_eq!((row.len(), row[0], row[2]), (3, 0, 0));
        row[1]
    }

    #[test]
    fn samples_share_a_cell_as_it_is_asked() {
        let samples = [(100.0, 1.0), (200.0, 1.0), (60.0, 1.0)];
        assert_eq!(laid(Blend::Mean, &samples), 120);
        assert_eq!(laid(Blend::Brightest, &samples), 200);
        assert_eq!(laid(Blend::Last, &samples), 60);
        assert_eq!(laid(Blend::Mean, &[]), 0);
    }

    #[test]
    fn the_strip_below_the_vehicle_shows_only_where_nothing_else_is() {
        for blend in [Blend::Mean, Blend::Brightest, Blend::Last] {
            assert_eq!(laid(blend, &[(100.0, 1.0), (250.0, WEAK)]), 100, "{blend:?}");
            assert_eq!(laid(blend, &[(250.0, WEAK), (100.0, 1.0)]), 100, "{blend:?}");
            assert_eq!(laid(blend, &[(250.0, WEAK)]), 250, "{blend:?}");
        }
    }

    #[test]
    fn places_outside_are_left_out() {
        let mut raster = Raster::new(2, 2, Blend::Mean);
        for place in [(-0.1, 0.0), (0.0, -0.1), (2.0, 0.0), (0.0, 2.0), (f64::NAN, 0.0)] {
            raster.lay(Vector2::new(place.0, place.1), 9.0, 1.0);
        }
        let mut row = Vec::new();
        raster.row(0, &mut row);
        assert_eq!(row, [0, 0]);
    }
}
