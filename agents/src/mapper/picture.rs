//! The map as people like to see it: free ground white, walls black, the unknown grey, the robot's path in colour and a bar
//! that gives the scale, each of its segments one metre (or five, or twenty on large maps) long.

use std::path::Path;

use image::{Rgb, RgbImage};
use nalgebra::Point2;

use super::files::{MapFileError, cell_at, encode, printed_window, replace};
use crate::certainty_grid::{Grid, Window};

/// How the picture is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureStyle {
    /// Cells become squares of whole pixels, as large as keeps the longer side of the picture within this many pixels.
    pub longest_side: u32,
}

impl Default for PictureStyle {
    fn default() -> Self {
        Self { longest_side: 1600 }
    }
}

const GREY: Rgb<u8> = Rgb([176, 178, 182]);
const PATH: Rgb<u8> = Rgb([214, 60, 40]);
const START: Rgb<u8> = Rgb([30, 130, 70]);
const INK: Rgb<u8> = Rgb([20, 20, 24]);
const PAPER: Rgb<u8> = Rgb([250, 250, 250]);

/// Draws the map, and a path (map frame, m; may be empty) whose start is a green dot.
#[must_use]
pub fn draw(grid: &Grid, path: &[Point2<f32>], style: PictureStyle) -> RgbImage {
    let window = printed_window(grid);
    let longest = window.width.max(window.height) as u32;
    let scale = (style.longest_side / longest).clamp(1, 16);
    let (width, height) = (window.width as u32 * scale, window.height as u32 * scale);
    let bar = ScaleBar::fitting(f64::from(scale) / grid.cell_size(), width);
    let mut image = RgbImage::from_fn(width, height + bar.height(), |x, y| {
        if y < height { shade(grid, window, x / scale, y / scale) } else { PAPER }
    });
    let corner = grid.corner_of(window.first);
    let to_pixel = |point: &Point2<f32>| {
        let offset = (point.cast::<f64>() - corner) * f64::from(scale) / grid.cell_size();
        (offset.x, f64::from(height) - offset.y)
    };
    let thick = f64::from(scale.div_ceil(2));
    for leg in path.windows(2) {
        let (from, to) = (to_pixel(&leg[0]), to_pixel(&leg[1]));
        // A gap is a correction of the pose, which the robot has not driven.
        if (leg[1] - leg[0]).norm() < 1.0 || path.len() > 4096 {
            line(&mut image, from, to, thick, height);
        }
    }
    if let Some(start) = path.first() {
        dot(&mut image, to_pixel(start), 1.5 * thick + 2.0, START, height);
    }
    bar.draw(&mut image, height);
    image
}

/// Draws the map into a PNG file; see [`draw`].
///
/// # Errors
/// [`MapFileError`] names the file; no half-written file stays behind.
pub fn save(grid: &Grid, path: &[Point2<f32>], style: PictureStyle, file: &Path) -> Result<(), MapFileError> {
    let png = encode(&draw(grid, path, style).into(), file)?;
    replace(file, &png).map_err(|source| MapFileError::Io { path: file.to_owned(), source })
}

/// Unknown is grey; the more certainly a cell is free or occupied, the whiter or blacker.
fn shade(grid: &Grid, window: Window, x: u32, y: u32) -> Rgb<u8> {
    let index = cell_at(window, x, y);
    if grid.is_unknown(index) {
        return GREY;
    }
    let c = grid.probability(index);
    let mix = |from: u8, to: u8, share: f32| (f32::from(from) + (f32::from(to) - f32::from(from)) * share).round() as u8;
    let (target, share) = if c < 0.5 { (PAPER, 1.0 - 2.0 * c) } else { (INK, 2.0 * c - 1.0) };
    Rgb([0, 1, 2].map(|i| mix(GREY.0[i], target.0[i], share)))
}

fn line(image: &mut RgbImage, from: (f64, f64), to: (f64, f64), thick: f64, bottom: u32) {
    let steps = (to.0 - from.0).abs().max((to.1 - from.1).abs()).ceil().clamp(1.0, 1e5);
    for step in 0..=steps as u32 {
        let t = f64::from(step) / steps;
        dot(image, (from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t), 0.5 * thick, PATH, bottom);
    }
}

fn dot(image: &mut RgbImage, centre: (f64, f64), radius: f64, colour: Rgb<u8>, bottom: u32) {
    let range = |middle: f64, end: u32| {
        let start = (middle - radius).floor().max(0.0) as u32;
        start..((middle + radius).ceil().max(0.0) as u32).min(end)
    };
    for y in range(centre.1, bottom) {
        for x in range(centre.0, image.width()) {
            let (dx, dy) = (f64::from(x) + 0.5 - centre.0, f64::from(y) + 0.5 - centre.1);
            if dx * dx + dy * dy <= radius * radius + 0.3 {
                image.put_pixel(x, y, colour);
            }
        }
    }
}

/// Five segments in black and white below the map, labelled with their whole length.
struct ScaleBar {
    segment: u32,
    metres: u32,
    left: u32,
}

impl ScaleBar {
    const SEGMENTS: u32 = 5;
    const THICK: u32 = 6;

    fn fitting(pixels_per_metre: f64, width: u32) -> Self {
        let fits = |metres: u32| f64::from(Self::SEGMENTS * metres) * pixels_per_metre;
        // As long as is readable and still leaves room on either side.
        let metres = [20, 5, 1].into_iter().find(|metres| fits(*metres) < 0.5 * f64::from(width)).unwrap_or(1);
        Self { segment: (f64::from(metres) * pixels_per_metre).round() as u32, metres, left: 8.min(width / 10) }
    }

    fn height(&self) -> u32 {
        Self::THICK + 16
    }

    fn draw(&self, image: &mut RgbImage, top: u32) {
        let mut fill = |x0: u32, y0: u32, w: u32, h: u32, colour: Rgb<u8>| {
            for y in y0..(y0 + h).min(image.height()) {
                for x in x0..(x0 + w).min(image.width()) {
                    image.put_pixel(x, y, colour);
                }
            }
        };
        let y = top + 8;
        fill(self.left, y, self.segment * Self::SEGMENTS, Self::THICK, INK);
        for segment in (1..Self::SEGMENTS).step_by(2) {
            fill(self.left + segment * self.segment, y + 1, self.segment, Self::THICK - 2, PAPER);
        }
        let mut x = self.left + self.segment * Self::SEGMENTS + 8;
        for letter in format!("{} m", self.metres * Self::SEGMENTS).chars() {
            for (row, bits) in glyph(letter).into_iter().enumerate() {
                for column in (0..5u32).filter(|column| bits >> (4 - column) & 1 == 1) {
                    fill(x + 2 * column, y - 2 + 2 * row as u32, 2, 2, INK);
                }
            }
            x += 12;
        }
    }
}

/// Five rows of five dots.
fn glyph(letter: char) -> [u8; 5] {
    match letter {
        '0' => [0b01110, 0b10001, 0b10001, 0b10001, 0b01110],
        '1' => [0b00100, 0b01100, 0b00100, 0b00100, 0b01110],
        '2' => [0b11110, 0b00001, 0b01110, 0b10000, 0b11111],
        '5' => [0b11111, 0b10000, 0b11110, 0b00001, 0b11110],
        'm' => [0b00000, 0b11010, 0b10101, 0b10101, 0b10101],
        _ => [0; 5],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::certainty_grid::{CellIndex, Layout, Rules};

    #[test]
    fn a_picture_shows_ground_walls_path_and_scale() {
        let layout = Layout { cell: 0.1, width: 120, height: 80, origin: Point2::new(0.0, 0.0) };
        let mut grid = Grid::new(layout, Rules::default()).unwrap();
        (0..100).for_each(|x| grid.force(CellIndex::new(x, 10), 0.0));
        (0..100).for_each(|x| grid.force(CellIndex::new(x, 40), 1.0));
        let path = [Point2::new(1.0, 3.0), Point2::new(1.5, 3.0), Point2::new(2.0, 3.0)];
        let image = draw(&grid, &path, PictureStyle { longest_side: 500 });
        // 102 columns with the margin fit four pixels each
        let scale = 4;
        let window = printed_window(&grid);
        assert_eq!((window.width, window.height), (102, 35));
        assert_eq!(image.width(), 102 * scale);
        let bottom = 35 * scale;
        let row = |cell: u32| bottom - (cell - 8) * scale - scale / 2;
        assert_eq!(*image.get_pixel(50 * scale, row(10)), PAPER);
        assert_eq!(*image.get_pixel(50 * scale, row(40)), INK);
        assert_eq!(*image.get_pixel(50 * scale, row(25)), GREY);
        assert_eq!(*image.get_pixel(18 * scale, bottom - 22 * scale), PATH);
        assert_eq!(*image.get_pixel(10 * scale, bottom - 22 * scale), START);
        // segments of 1 m: black, white, black
        let bar = bottom + 8 + ScaleBar::THICK / 2;
        let along = |metre: f64| *image.get_pixel(8 + (metre * 10.0 * f64::from(scale)) as u32, bar);
        assert_eq!([0.5, 1.5, 2.5, 4.5, 5.1].map(along), [INK, PAPER, INK, INK, PAPER]);
    }
}
