//! The picture of a robot's map of places, laid over its metric map.

use std::{convert::Infallible, io};

use embedded_graphics::{
    Drawable, Pixel,
    draw_target::DrawTarget,
    geometry::{OriginDimensions, Point, Size},
    mono_font::{MonoTextStyle, ascii::FONT_9X15},
    pixelcolor::{Rgb888, RgbColor},
    text::Text,
};
use image::{Rgb, RgbImage};
use nalgebra::Point2;
use orienteer_agents::geographer::export::PlacesFile;
use orienteer_hardware::world::{
    draw::Canvas,
    geometry::{Bounds, Disc},
    map::{Cell, Grid, Header},
};
use orienteer_runtime::agent::OutputFile;

/// Metres per pixel, and round the outermost place, m.
const RESOLUTION: f64 = 0.025;
const MARGIN: f64 = 1.5;
const FREE: Rgb<u8> = Rgb([250, 250, 250]);
const OCCUPIED: Rgb<u8> = Rgb([40, 42, 48]);
const UNKNOWN: Rgb<u8> = Rgb([200, 202, 206]);
const CORRIDOR: Rgb<u8> = Rgb([38, 110, 190]);
const PLACE: Rgb<u8> = Rgb([214, 60, 40]);
/// What is written stands on a ground of this colour.
const PAPER: Rgb<u8> = Rgb([255, 252, 240]);

/// Draws what a robot has left: places and corridors, over the map of its mapper if there is one. `None` if it has left no places.
pub(super) fn picture(files: &[OutputFile]) -> Option<Result<OutputFile, String>> {
    let bytes = |name: &str| files.iter().find(|file| file.name == name).map(|file| &file.bytes);
    let places: PlacesFile =
        serde_json::from_slice(bytes("places.json")?).ok().filter(|map: &PlacesFile| !map.places.is_empty())?;
    let grid = bytes("map.yaml").zip(bytes("map.png")).and_then(|(yaml, png)| Header::parse(yaml).ok()?.grid(png).ok());
    let canvas = draw(&places, grid.as_ref())?;
    let mut png = io::Cursor::new(Vec::new());
    let written = canvas.image.write_to(&mut png, image::ImageFormat::Png);
    let file = OutputFile { name: "places.png".to_owned(), bytes: png.into_inner() };
    Some(written.map(|()| file).map_err(|error| format!("the picture of the places can't be drawn: {error}")))
}

fn draw(map: &PlacesFile, grid: Option<&Grid>) -> Option<Canvas> {
    let mut bounds = Bounds::around(map.places.iter().map(|place| Point2::from(place.at)))?;
    let margin = nalgebra::Vector2::repeat(MARGIN);
    (bounds.min, bounds.max) = (bounds.min - margin, bounds.max + margin);
    if let Some(drawn) = grid.and_then(extent) {
        bounds = bounds.union(&drawn);
    }
    let mut canvas = Canvas::new(bounds, RESOLUTION);
    if let Some(grid) = grid {
        lay_under(&mut canvas, grid);
    }
    let at = |name: &str| map.places.iter().find(|place| place.name == name).map(|place| Point2::from(place.at));
    for corridor in &map.corridors {
        canvas.path(at(&corridor.from).into_iter().chain(at(&corridor.to)), 0.10, CORRIDOR);
    }
    for place in &map.places {
        canvas.disc(Disc::new(Point2::from(place.at), 0.28), PLACE);
    }
    for place in &map.places {
        write(&mut canvas, Point2::from(place.at), &format!("{} {}", place.name, place.title));
    }
    Some(canvas)
}

/// The part of a map in which anything is known.
fn extent(grid: &Grid) -> Option<Bounds> {
    let known = (0..grid.height).flat_map(|row| (0..grid.width).map(move |column| (column, row)));
    let known =
        known.filter(|(column, row)| grid.cells.get(row * grid.width + column).is_some_and(|cell| *cell != Cell::Unknown));
    let middle = |(column, row): (usize, usize)| {
        grid.origin.transform(Point2::new(column as f64 + 0.5, row as f64 + 0.5) * grid.resolution)
    };
    Bounds::around(known.map(middle))
}

fn lay_under(canvas: &mut Canvas, grid: &Grid) {
    let from_world = grid.origin.inverse();
    for row in 0..canvas.image.height() {
        for column in 0..canvas.image.width() {
            let at = from_world.transform(canvas.to_world(column, row)) / grid.resolution;
            let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < grid.width as f64 && at.y < grid.height as f64;
            let cell = if inside { grid.cells.get(at.y as usize * grid.width + at.x as usize) } else { None };
            let colour = match cell {
                Some(Cell::Free) => FREE,
                Some(Cell::Occupied) => OCCUPIED,
                Some(Cell::Unknown) | None => UNKNOWN,
            };
            canvas.image.put_pixel(column, row, colour);
        }
    }
}

/// Writes something beside a point, on a ground of its own, and wholly in the picture.
fn write(canvas: &mut Canvas, beside: Point2<f64>, text: &str) {
    let font = &FONT_9X15;
    let (width, height) = (font.character_size.width * text.chars().count() as u32, font.character_size.height);
    let (x, y) = canvas.to_pixel(beside);
    let [whole_width, whole_height] = [canvas.image.width(), canvas.image.height()];
    let left = (x + 14.0).min(f64::from(whole_width) - f64::from(width) - 4.0).max(4.0);
    let top = (y - 0.5 * f64::from(height) - 18.0).min(f64::from(whole_height) - f64::from(height) - 4.0).max(4.0);
    let (left, top) = (left as u32, top as u32);
    for row in top.saturating_sub(2)..(top + height + 2).min(whole_height) {
        for column in left.saturating_sub(3)..(left + width + 3).min(whole_width) {
            canvas.image.put_pixel(column, row, PAPER);
        }
    }
    let baseline = Point::new(left as i32, (top + font.baseline) as i32);
    let style = MonoTextStyle::new(font, Rgb888::new(20, 20, 24));
    // Drawing on an image can't fail.
    let _ = Text::new(text, baseline, style).draw(&mut Ink(&mut canvas.image));
}

/// An image on which text can be drawn.
struct Ink<'i>(&'i mut RgbImage);

impl OriginDimensions for Ink<'_> {
    fn size(&self) -> Size {
        Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Ink<'_> {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, colour) in pixels {
            let (Ok(x), Ok(y)) = (u32::try_from(at.x), u32::try_from(at.y)) else { continue };
            if x < self.0.width() && y < self.0.height() {
                self.0.put_pixel(x, y, Rgb([colour.r(), colour.g(), colour.b()]));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use orienteer_agents::geographer::export::{CorridorEntry, PlaceEntry};

    fn places() -> PlacesFile {
        let place =
            |name: &str, at: [f64; 2]| PlaceEntry { name: name.into(), title: "dead end".into(), at, ..PlaceEntry::default() };
        PlacesFile {
            places: vec![place("A", [0.0, 0.0]), place("B", [4.0, 0.0])],
            corridors: vec![CorridorEntry { from: "A".into(), to: "B".into(), heading_deg: 0.0, length: 4.0 }],
        }
    }

    #[test]
    fn places_and_corridors_are_where_they_should_be() {
        let canvas = draw(&places(), None).unwrap();
        let colour = |x: f64, y: f64| {
            let (column, row) = canvas.to_pixel(Point2::new(x, y));
            *canvas.image.get_pixel(column as u32, row as u32)
        };
        assert_eq!([colour(0.0, 0.0), colour(4.0, 0.0)], [PLACE; 2]);
        assert_eq!(colour(3.0, 0.0), CORRIDOR);
    }

    #[test]
    fn who_left_no_places_gets_no_picture() {
        assert!(picture(&[]).is_none());
        let nonsense = OutputFile { name: "places.json".into(), bytes: b"{".to_vec() };
        assert!(picture(&[nonsense]).is_none());
    }
}
