//! Pictures of worlds.

use image::{Rgb, RgbImage};
use nalgebra::Point2;

use super::geometry::{Bounds, Disc, Outline};

/// Colour of solid matter.
pub const SOLID: Rgb<u8> = Rgb([52, 58, 70]);
/// Colour of free space.
pub const FREE: Rgb<u8> = Rgb([255, 255, 255]);
/// Longest side of a picture, pixels.
const MOST_PIXELS: f64 = 16_384.0;

/// A picture to draw on in metres.
#[derive(Debug, Clone)]
pub struct Canvas {
    /// The picture so far; row 0 is the top.
    pub image: RgbImage,
    bounds: Bounds,
    resolution: f64,
}

impl Canvas {
    /// A white picture of a part of the world at `resolution` metres per pixel, coarser if it would get more than 16 384 pixels
    /// long.
    #[must_use]
    pub fn new(bounds: Bounds, resolution: f64) -> Self {
        let size = bounds.size();
        let resolution = resolution.max(size.max() / MOST_PIXELS).max(1e-6);
        let pixels = |length: f64| ((length / resolution).ceil() as u32).max(1);
        Self { image: RgbImage::from_pixel(pixels(size.x), pixels(size.y), FREE), bounds, resolution }
    }

    /// Metres per pixel.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// The middle of a pixel in the world.
    #[must_use]
    pub fn to_world(&self, column: u32, row: u32) -> Point2<f64> {
        let at = |i: u32| (f64::from(i) + 0.5) * self.resolution;
        Point2::new(self.bounds.min.x + at(column), self.bounds.max.y - at(row))
    }

    /// The pixel of a point of the world, column and row; outside the picture too.
    #[must_use]
    pub fn to_pixel(&self, p: Point2<f64>) -> (f64, f64) {
        ((p.x - self.bounds.min.x) / self.resolution, (self.bounds.max.y - p.y) / self.resolution)
    }

    /// Fills solid matter: row by row between crossings with the outline, then the pillars.
    pub fn fill(&mut self, outline: &Outline, color: Rgb<u8>) {
        let mut crossings: Vec<f64> = Vec::new();
        for row in 0..self.image.height() {
            let y = self.to_world(0, row).y;
            crossings.clear();
            let crossing = outline.segments.iter().filter(|s| (s.a.y <= y) != (s.b.y <= y));
            crossings.extend(crossing.map(|s| s.a.x + (y - s.a.y) / (s.b.y - s.a.y) * (s.b.x - s.a.x)));
            crossings.sort_by(f64::total_cmp);
            let mut passed = 0;
            for column in 0..self.image.width() {
                let x = self.to_world(column, row).x;
                while crossings.get(passed).is_some_and(|c| *c < x) {
                    passed += 1;
                }
                if (passed % 2 == 1) != outline.enclosed {
                    self.image.put_pixel(column, row, color);
                }
            }
        }
        for pillar in &outline.pillars {
            self.disc(pillar.disc, color);
        }
    }

    /// Fills a disc; a small one still gets its middle pixel.
    pub fn disc(&mut self, disc: Disc, color: Rgb<u8>) {
        let (x, y) = self.to_pixel(disc.center);
        let r = disc.radius / self.resolution;
        let range = |c: f64, size: u32| ((c - r).floor().max(0.0) as u32)..((c + r).ceil().max(0.0) as u32).min(size);
        for row in range(y, self.image.height()) {
            for column in range(x, self.image.width()) {
                let (dx, dy) = (f64::from(column) + 0.5 - x, f64::from(row) + 0.5 - y);
                if dx.hypot(dy) <= r.max(0.71) {
                    self.image.put_pixel(column, row, color);
                }
            }
        }
    }

    /// Draws a line through the points with a round pen of `width` metres, at least one pixel.
    pub fn path(&mut self, points: impl IntoIterator<Item = Point2<f64>>, width: f64, color: Rgb<u8>) {
        let mut last: Option<Point2<f64>> = None;
        for to in points {
            let from = last.unwrap_or(to);
            let steps = ((to - from).norm() / (0.5 * self.resolution)).ceil().clamp(1.0, 4.0 * MOST_PIXELS) as u32;
            for i in 0..=steps {
                let p = from + (to - from) * (f64::from(i) / f64::from(steps));
                self.disc(Disc::new(p, 0.5 * width), color);
            }
            last = Some(to);
        }
    }
}

/// The world as a picture: walls dark, free space white, with a margin of half a metre.
///
/// ```
/// use nalgebra::Point2;
/// use orienteer_hardware::world::{World, draw, plan::WorldPlan};
/// let plan = WorldPlan::parse("[[corridor]]\nalong = [[0, 0], [4, 0]]\nwidth = 1.0")?;
/// let world = World::from_plan(&plan, &|_| unreachable!())?;
/// let mut canvas = draw::outline(&world.outline, 0.05);
/// assert_eq!(canvas.image.dimensions(), (100, 40));
/// assert_eq!(*canvas.image.get_pixel(50, 20), draw::FREE);
/// canvas.path([Point2::new(0.5, 0.0), Point2::new(3.5, 0.0)], 0.05, image::Rgb([200, 0, 0]));
/// # Ok::<(), orienteer_hardware::world::WorldError>(())
/// ```
#[must_use]
pub fn outline(outline: &Outline, resolution: f64) -> Canvas {
    let mut canvas = Canvas::new(outline.bounds.grown(0.5), resolution);
    canvas.fill(outline, SOLID);
    canvas
}
