//! Grids as recordings hold them.

use foxglove::messages::{Grid, PackedElementField, Vector2, packed_element_field::NumericType};

use super::views::{self, to_pose};
use crate::geometry::Pose;

/// Field number of the data in `foxglove.Grid`.
const DATA: u8 = 9;
/// The most cells of a recorded grid; protobuf messages end at 2 GiB.
const MAX_CELLS: usize = 1 << 30;

/// A map of square cells, one byte each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GridImage {
    /// Where the first cell's outer corner is and how the grid lies, map frame. Rows run along its x axis, the next row is
    /// further along its y axis.
    pub origin: Pose,
    /// Side of a cell, m.
    pub resolution: f64,
    /// Cells in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` values, row by row. What they mean is up to the writer.
    pub cells: Vec<u8>,
}

impl GridImage {
    /// True if there are as many cells as the size says, at least one, and the other numbers make sense.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let cells = (self.width as usize).checked_mul(self.height as usize);
        self.origin.is_sound()
            && self.resolution.is_finite()
            && self.resolution > 0.0
            && cells.is_some_and(|cells| cells == self.cells.len() && (1..=MAX_CELLS).contains(&cells))
    }

    /// Reads a message. The error says what is wrong with it.
    pub(super) fn from_message(message: &Grid) -> Result<Self, String> {
        let origin = message.pose.as_ref().and_then(to_pose).ok_or("its origin is not a pose in the plane")?;
        let cell = message.cell_size.ok_or("it has no cell size")?;
        let bytes = message.fields.len() == 1 && message.fields[0].r#type == NumericType::Uint8 as i32;
        let (width, stride) = (message.column_count, message.row_stride);
        if !bytes || message.cell_stride != 1 || stride != width || width == 0 || cell.x != cell.y {
            return Err("its cells are not square or not bytes".into());
        }
        let cells = message.data.to_vec();
        let height = u32::try_from(cells.len() / width as usize).map_err(|error| error.to_string())?;
        let image = Self { origin, resolution: cell.x, width, height, cells };
        if image.is_sound() { Ok(image) } else { Err("its size and its cells do not agree".into()) }
    }
}

/// Turns grids into messages.
#[derive(Debug)]
pub(super) struct GridView(Grid);

impl GridView {
    pub(super) fn new() -> Self {
        let value = PackedElementField { name: "value".into(), offset: 0, r#type: NumericType::Uint8 as i32 };
        Self(Grid { frame_id: views::MAP.into(), cell_stride: 1, fields: vec![value], ..Grid::default() })
    }

    /// Appends the message of a sound grid.
    pub(super) fn encode(&mut self, stamp: crate::time::Time, image: &GridImage, bytes: &mut Vec<u8>) {
        self.0.timestamp = Some(views::timestamp(stamp));
        self.0.pose = Some(views::from_pose(image.origin));
        self.0.cell_size = Some(Vector2 { x: image.resolution, y: image.resolution });
        self.0.column_count = image.width;
        self.0.row_stride = image.width;
        views::encode(&self.0, bytes);
        views::append_bytes_field(DATA, &image.cells, bytes);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use foxglove::Decode;

    use super::*;
    use crate::time::Time;

    #[test]
    fn a_grid_comes_back() {
        let image = GridImage {
            origin: Pose::new(-1.0, 2.0, 0.5),
            resolution: 0.05,
            width: 30,
            height: 20,
            cells: (0..600u32).map(|i| (i % 251) as u8).collect(),
        };
        let mut bytes = Vec::new();
        GridView::new().encode(Time::from_nanos(1_500_000_000), &image, &mut bytes);
        let message = Grid::decode(&bytes[..]).unwrap();
        assert_eq!(message.timestamp.unwrap().sec(), 1);
        let back = GridImage::from_message(&message).unwrap();
        assert!((back.origin.heading - 0.5).abs() < 1e-12);
        assert_eq!(GridImage { origin: image.origin, ..back }, image);
        let mut broken = message.clone();
        broken.data = message.data.slice(1..);
        assert!(GridImage::from_message(&broken).is_err());
    }
}
