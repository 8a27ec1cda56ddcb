//! From the elements of a plan to its outline.

use std::path::Path;

use nalgebra::Point2;

use super::{
    ReadFile, WorldError,
    error::Element,
    geometry::{Disc, Material, Outline, Pillar},
    map::{self, MapError},
    plan::{WorldPlan, Xy},
    region::{REACH, Region, Ring},
    shapes,
};

/// A surface as an element brought it in, before the elements are merged.
struct Side {
    a: Point2<f64>,
    b: Point2<f64>,
    material: Material,
}

/// The pieces of a plan by what they do.
#[derive(Default)]
struct Pieces {
    /// Carves free space.
    free: Vec<Ring>,
    /// Walls, and the doors through them.
    walls: Vec<Ring>,
    wall_doors: Vec<Ring>,
    /// Other matter.
    solid: Vec<Ring>,
    /// Imported matter, with holes.
    imported: Vec<Ring>,
    /// Where each material is.
    sides: Vec<Side>,
}

/// The outline of a plan whose numbers have been checked.
pub(super) fn outline(plan: &WorldPlan, files: &ReadFile<'_>) -> Result<Outline, WorldError> {
    let mut pieces = Pieces::default();
    pieces.carve(plan)?;
    pieces.put_up_walls(plan)?;
    pieces.fill(plan)?;
    pieces.import(plan, files)?;

    let walls = Region::covered_by(&pieces.walls).minus(&Region::covered_by(&pieces.wall_doors));
    let solid = Region::covered_by(&pieces.solid).union(&Region::bordered_by(&pieces.imported)).union(&walls);
    let enclosed = !pieces.free.is_empty();
    let rings = if enclosed {
        Region::covered_by(&pieces.free).minus(&solid).rings()
    } else {
        // Matter is on the left of its border; free space shall be.
        solid.rings().into_iter().map(|ring| ring.into_iter().rev().collect()).collect()
    };
    let pillars = plan
        .disc
        .iter()
        .map(|d| Pillar { disc: Disc::new(d.center.point(), d.radius), material: Material { reflectance: d.reflectance } });
    Ok(Outline::from_rings(&rings, pillars.collect(), enclosed, |a, b| material_between(&pieces.sides, a, b)))
}

impl Pieces {
    fn carve(&mut self, plan: &WorldPlan) -> Result<(), WorldError> {
        for corridor in &plan.corridor {
            let strokes = shapes::stroke(&corridor.along, corridor.closed, corridor.width);
            self.cover(&strokes, corridor.reflectance);
            self.free.extend(strokes);
        }
        let corridors = self.free.len();
        for (i, room) in plan.room.iter().enumerate() {
            let on = Element::nth("room", i, room.name.as_deref());
            let ring = shapes::closed_outline(&on, &room.corners)?;
            self.cover(std::slice::from_ref(&ring), room.reflectance);
            self.free.push(ring);
        }
        let (free, mut openings) = (&self.free, Vec::new());
        for (i, room) in plan.room.iter().enumerate() {
            let on = Element::nth("room", i, room.name.as_deref());
            let own = corridors + i;
            let others: Vec<&Ring> = free.iter().enumerate().filter(|(j, _)| *j != own).map(|(_, ring)| ring).collect();
            for door in &room.doors {
                let opening = shapes::door_of_room(&on, &free[own], door, &others)?;
                openings.extend(door.open.then_some((opening, room.reflectance)));
            }
        }
        for (opening, reflectance) in openings {
            self.cover(std::slice::from_ref(&opening), reflectance);
            self.free.push(opening);
        }
        Ok(())
    }

    fn put_up_walls(&mut self, plan: &WorldPlan) -> Result<(), WorldError> {
        for (i, wall) in plan.wall.iter().enumerate() {
            let on = Element::nth("wall", i, wall.name.as_deref());
            let strokes = shapes::stroke(&wall.along, wall.closed, wall.thickness);
            self.cover(&strokes, wall.reflectance);
            self.walls.extend(strokes);
            for door in &wall.doors {
                let opening = shapes::door_through_wall(&on, &wall.along, wall.closed, wall.thickness, door)?;
                if door.open {
                    self.cover(std::slice::from_ref(&opening), wall.reflectance);
                    self.wall_doors.push(opening);
                }
            }
        }
        Ok(())
    }

    fn fill(&mut self, plan: &WorldPlan) -> Result<(), WorldError> {
        for (i, polygon) in plan.polygon.iter().enumerate() {
            let on = Element::nth("polygon", i, polygon.name.as_deref());
            let ring = shapes::closed_outline(&on, &polygon.corners)?;
            self.cover(std::slice::from_ref(&ring), polygon.reflectance);
            self.solid.push(ring);
        }
        for block in &plan.boxes {
            let ring = shapes::block(block);
            self.cover(std::slice::from_ref(&ring), block.reflectance);
            self.solid.push(ring);
        }
        Ok(())
    }

    fn import(&mut self, plan: &WorldPlan, files: &ReadFile<'_>) -> Result<(), WorldError> {
        if let Some(ros) = &plan.map {
            let on = Element::only("map");
            let yaml = read(&on, &ros.file, files)?;
            let wrong = |path: &Path, reason: MapError| WorldError::Map {
                element: on.clone(),
                path: path.to_owned(),
                reason: Box::new(reason),
            };
            let header = map::Header::parse(&yaml).map_err(|e| wrong(&ros.file, e))?;
            let picture = ros.file.parent().map_or_else(|| header.image.clone(), |folder| folder.join(&header.image));
            let grid = header.grid(&read(&on, &picture, files)?).map_err(|e| wrong(&picture, e))?;
            let rings = grid.rings(ros.unknown, ros.min_speck, ros.tolerance);
            self.add_import(rings, ros.reflectance).map_err(|e| wrong(&ros.file, e))?;
        }
        if let Some(image) = &plan.image {
            let on = Element::only("image");
            let wrong =
                |reason: MapError| WorldError::Map { element: on.clone(), path: image.file.clone(), reason: Box::new(reason) };
            let grid = map::Grid::from_floor_plan(image, &read(&on, &image.file, files)?).map_err(wrong)?;
            let rings = grid.rings(map::Unknown::Free, image.min_speck, image.tolerance);
            self.add_import(rings, image.reflectance).map_err(wrong)?;
        }
        Ok(())
    }

    fn add_import(&mut self, rings: Vec<Ring>, reflectance: f64) -> Result<(), MapError> {
        if rings.iter().flatten().any(|p| p.x.abs() >= REACH || p.y.abs() >= REACH) {
            return Err(MapError::TooFar { reach: REACH });
        }
        self.cover(&rings, reflectance);
        self.imported.extend(rings);
        Ok(())
    }

    /// Remembers what the sides of these rings are made of.
    fn cover(&mut self, rings: &[Ring], reflectance: f64) {
        let material = Material { reflectance };
        if material == Material::default() {
            // Whatever no side claims is hard.
            return;
        }
        for ring in rings {
            let sides = ring.iter().zip(ring.iter().cycle().skip(1));
            self.sides.extend(sides.map(|(&a, &b)| Side { a, b, material }));
        }
    }
}

/// The material of the last element that has a side along `a → b`.
fn material_between(sides: &[Side], a: Point2<f64>, b: Point2<f64>) -> Material {
    /// Merged borders lie this near to the sides they came from, m.
    const NEAR: f64 = 1e-4;
    let middle = nalgebra::center(&a, &b);
    let along = b - a;
    let claims = |side: &&Side| {
        let own = side.b - side.a;
        let t = (middle - side.a).dot(&own) / own.norm_squared();
        let parallel = own.perp(&along).abs() <= NEAR * own.norm().max(along.norm());
        parallel && (0.0..=1.0).contains(&t) && (middle - (side.a + own * t)).norm() < NEAR
    };
    sides.iter().rev().find(claims).map_or_else(Material::default, |side| side.material)
}

fn read(on: &Element, path: &Path, files: &ReadFile<'_>) -> Result<Vec<u8>, WorldError> {
    files(path).map_err(|reason| WorldError::File { element: on.clone(), path: path.to_owned(), reason })
}

/// The points of a path as the world knows them.
pub(super) fn points(path: &[Xy]) -> Vec<Point2<f64>> {
    path.iter().map(|xy| xy.point()).collect()
}
