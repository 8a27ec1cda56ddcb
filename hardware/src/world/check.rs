//! Every number of a plan within its range, checked once more in code.
//!
//! The JSON schema says the same to whoever validates a file first; this is for plans that come any other way, and for NaN
//! and infinity, which TOML can write and a schema can't refuse.

use super::{
    WorldError,
    error::Element,
    plan::{Door, FAR, Loop, WorldPlan, Xy},
    shapes::SHORTEST,
};

/// Checks all numbers of a plan.
pub(super) fn ranges(plan: &WorldPlan) -> Result<(), WorldError> {
    for (i, it) in plan.corridor.iter().enumerate() {
        let on = Element::nth("corridor", i, it.name.as_deref());
        number(&on, "width", it.width, 0.3, 50.0)?;
        reflectance(&on, it.reflectance)?;
        line(&on, &it.along)?;
    }
    for (i, it) in plan.room.iter().enumerate() {
        let on = Element::nth("room", i, it.name.as_deref());
        reflectance(&on, it.reflectance)?;
        points(&on, "corners", &it.corners)?;
        doors(&on, &it.doors)?;
    }
    for (i, it) in plan.wall.iter().enumerate() {
        let on = Element::nth("wall", i, it.name.as_deref());
        number(&on, "thickness", it.thickness, 0.01, 10.0)?;
        reflectance(&on, it.reflectance)?;
        line(&on, &it.along)?;
        doors(&on, &it.doors)?;
    }
    for (i, it) in plan.polygon.iter().enumerate() {
        let on = Element::nth("polygon", i, it.name.as_deref());
        reflectance(&on, it.reflectance)?;
        points(&on, "corners", &it.corners)?;
    }
    for (i, it) in plan.boxes.iter().enumerate() {
        let on = Element::nth("box", i, it.name.as_deref());
        it.size.iter().try_for_each(|v| number(&on, "size", *v, 0.01, 500.0))?;
        number(&on, "rotation_deg", it.rotation_deg, -360.0, 360.0)?;
        reflectance(&on, it.reflectance)?;
        points(&on, "center", &[it.center])?;
    }
    for (i, it) in plan.disc.iter().enumerate() {
        let on = Element::nth("disc", i, it.name.as_deref());
        number(&on, "radius", it.radius, 0.01, 50.0)?;
        reflectance(&on, it.reflectance)?;
        points(&on, "center", &[it.center])?;
    }
    imports(plan)?;
    people(plan)
}

fn imports(plan: &WorldPlan) -> Result<(), WorldError> {
    if let Some(map) = &plan.map {
        let on = Element::only("map");
        number(&on, "tolerance", map.tolerance, 0.0, 5.0)?;
        number(&on, "min_speck", f64::from(map.min_speck), 0.0, 10_000.0)?;
        reflectance(&on, map.reflectance)?;
    }
    if let Some(image) = &plan.image {
        let on = Element::only("image");
        number(&on, "resolution", image.resolution, 0.001, 5.0)?;
        number(&on, "rotation_deg", image.rotation_deg, -360.0, 360.0)?;
        number(&on, "threshold", f64::from(image.threshold), 1.0, 255.0)?;
        number(&on, "tolerance", image.tolerance, 0.0, 5.0)?;
        number(&on, "min_speck", f64::from(image.min_speck), 0.0, 10_000.0)?;
        reflectance(&on, image.reflectance)?;
        points(&on, "origin", &[image.origin])?;
    }
    Ok(())
}

fn people(plan: &WorldPlan) -> Result<(), WorldError> {
    for (i, it) in plan.person.iter().enumerate() {
        let on = Element::nth("person", i, it.name.as_deref());
        number(&on, "radius", it.radius, 0.05, 1.0)?;
        number(&on, "speed", it.speed, 0.0, 3.0)?;
        number(&on, "speed_variation", it.speed_variation, 0.0, 0.3)?;
        number(&on, "pause", it.pause, 0.0, 3600.0)?;
        number(&on, "start", it.start, 0.0, 10_000.0)?;
        number(&on, "patience", it.patience.unwrap_or(0.0), 0.0, 3600.0)?;
        points(&on, "path", &it.path)?;
        if it.path.is_empty() {
            return Err(on.refuse("path needs a waypoint"));
        }
        distinct(&on, "path", &it.path)?;
        if it.looping == Loop::Round && it.path.len() > 1 && near(it.path[0], it.path[it.path.len() - 1]) {
            return Err(on.refuse("the last waypoint is the first again; a round closes by itself"));
        }
    }
    for (i, it) in plan.place.iter().enumerate() {
        let on = Element::nth("place", i, Some(&it.name));
        number(&on, "heading_deg", it.heading_deg, -360.0, 360.0)?;
        points(&on, "at", &[it.at])?;
        if plan.place[..i].iter().any(|other| other.name == it.name) {
            return Err(on.refuse("another place has this name"));
        }
    }
    Ok(())
}

fn number(on: &Element, key: &str, value: f64, min: f64, max: f64) -> Result<(), WorldError> {
    if (min..=max).contains(&value) { Ok(()) } else { Err(on.refuse(format!("{key} is {value}, not within {min} to {max}"))) }
}

fn reflectance(on: &Element, value: f64) -> Result<(), WorldError> {
    number(on, "reflectance", value, 0.01, 1.0)
}

fn points(on: &Element, key: &str, all: &[Xy]) -> Result<(), WorldError> {
    all.iter().flat_map(|xy| xy.0).try_for_each(|v| number(on, key, v, -FAR, FAR))
}

fn doors(on: &Element, all: &[Door]) -> Result<(), WorldError> {
    all.iter().try_for_each(|door| {
        number(on, "width of a door", door.width, 0.3, 20.0)?;
        points(on, "position of a door", &[door.at])
    })
}

fn line(on: &Element, along: &[Xy]) -> Result<(), WorldError> {
    points(on, "along", along)?;
    if along.len() < 2 {
        return Err(on.refuse("along needs at least two points"));
    }
    distinct(on, "along", along)
}

fn near(a: Xy, b: Xy) -> bool {
    (a.point() - b.point()).norm() < SHORTEST
}

fn distinct(on: &Element, key: &str, line: &[Xy]) -> Result<(), WorldError> {
    match line.windows(2).position(|w| near(w[0], w[1])) {
        Some(i) => Err(on.refuse(format!("points {} and {} of {key} are the same", i + 1, i + 2))),
        None => Ok(()),
    }
}
