//! `orienteer world`: floors of corridors, and single junctions, as world files.

use std::{fmt::Write as _, io, path::PathBuf};

use clap::Args;
use image::{ImageFormat, Rgb};
use serde::Serialize;

use crate::{
    hardware::world::{
        World, draw,
        floors::{Floor, FloorError, FloorSpec, MOST_PERTURBED, Perturbation, Width, junction_world},
        geometry::Disc,
        plan::WorldPlan,
    },
    runtime::random::Streams,
};

use super::{
    Outcome, Refusal, WorldArguments,
    new_files::{self, NewFile},
    style::{self, Paint},
};

/// Metres per pixel of a picture, unless it would get larger than this many pixels.
const RESOLUTION: f64 = 0.05;
const MOST_PIXELS: f64 = 4000.0;
/// How places look in it, and their radius, m.
const PLACE: (Rgb<u8>, f64) = (Rgb([200, 60, 40]), 0.2);

/// What a floor shall be like.
#[derive(Debug, Args)]
#[command(next_help_heading = "What a floor is like, in metres and shares of 1")]
pub struct FloorArguments {
    /// At least so many places, on a grid that fits
    #[arg(long, value_name = "N", conflicts_with_all = ["columns", "rows"])]
    places: Option<u32>,
    /// Corridors from north to south
    #[arg(long, value_name = "N", default_value_t = FloorSpec::default().columns)]
    columns: u32,
    /// Corridors from east to west
    #[arg(long, value_name = "N", default_value_t = FloorSpec::default().rows)]
    rows: u32,
    /// Widths; 1-1.5 is any between
    #[arg(long, value_name = "M,..", value_delimiter = ',', default_value = "1.12")]
    corridor_width: Vec<Width>,
    /// From corridor to corridor
    #[arg(long, value_name = "M", default_value_t = FloorSpec::default().pitch)]
    pitch: f64,
    /// The pitch may be so much off
    #[arg(long, value_name = "M", default_value_t = FloorSpec::default().jitter)]
    jitter: f64,
    /// Least wall from place to place
    #[arg(long, value_name = "M", default_value_t = FloorSpec::default().gap)]
    gap: f64,
    /// Edges kept that close loops
    #[arg(long, value_name = "SHARE", default_value_t = FloorSpec::default().loops)]
    loops: f64,
    /// Crossings that may be dead ends
    #[arg(long, value_name = "SHARE", default_value_t = FloorSpec::default().dead_ends)]
    dead_ends: f64,
    /// Doorways, where there is room
    #[arg(long, value_name = "SHARE", default_value_t = FloorSpec::default().doors)]
    doors: f64,
    /// Width of doorways
    #[arg(long, value_name = "M", default_value_t = FloorSpec::default().door_width)]
    door_width: f64,
    /// Corridors with a box in them
    #[arg(long, value_name = "SHARE", default_value_t = FloorSpec::default().boxes)]
    boxes: f64,
    /// No box is nearer to a centre line
    #[arg(long, value_name = "M", default_value_t = FloorSpec::default().berth)]
    berth: f64,
    /// No box is nearer to a place
    #[arg(long, value_name = "M", default_value_t = FloorSpec::default().clear)]
    clear: f64,
    /// People who walk in corridors
    #[arg(long, value_name = "N", default_value_t = FloorSpec::default().people)]
    people: u32,
}

/// Makes a world and writes it, with what is true of it.
pub fn world(arguments: &WorldArguments) -> Result<Outcome, Refusal> {
    let made = Made::new(arguments)?;
    let picture = if arguments.picture.is_some() { picture(&made.world)? } else { Vec::new() };
    let wanted = [
        (&arguments.out, "--out", made.text.clone().into_bytes()),
        (&arguments.truth, "--truth", made.truth.into_bytes()),
        (&arguments.picture, "--picture", picture),
    ];
    let file = |(path, option, bytes): (&Option<PathBuf>, _, _)| Some(NewFile { path: path.clone()?, bytes, option });
    let files: Vec<NewFile> = wanted.into_iter().filter_map(file).collect();
    new_files::write(&files, arguments.force)?;
    if arguments.out.is_none() {
        style::print(&made.text)?;
    } else {
        let mut text = format!("{}\n\n{}\n", style::wrap(&made.summary, 0), Paint::stdout().bold("written"));
        for file in files {
            let _ = writeln!(text, "{}", file.path.display());
        }
        style::print(&text)?;
    }
    Ok(Outcome::Well)
}

/// A world in all its forms.
struct Made {
    /// What it is, in a sentence.
    summary: String,
    /// The world file.
    text: String,
    /// What is true of it, as JSON.
    truth: String,
    /// Itself.
    world: World,
}

impl Made {
    fn new(arguments: &WorldArguments) -> Result<Self, Refusal> {
        let refuse = |error: FloorError| Refusal::misused(error.to_string(), error.hint());
        let seed = arguments.seed;
        if let Some(hypothesis) = arguments.junction {
            let mut random = Streams::new(seed).stream("junction", "perturbation");
            let perturbation = arguments.perturb.map_or(Perturbation::NONE, |share| Perturbation::draw(share, &mut random));
            let made = junction_world(hypothesis, &perturbation).map_err(refuse)?;
            let summary = format!("{hypothesis}: {}", hypothesis.title());
            return Ok(Self { summary, text: made.text(), truth: json(&made)?, world: build(&made.plan)? });
        }
        let floor = Floor::generate(seed, &arguments.floor.spec()).map_err(refuse)?;
        let world = build(&floor.plan)?;
        let (places, corridors, size) = (floor.truth.places.len(), floor.truth.corridors.len(), world.outline.bounds.size());
        let summary = format!("{places} places, {corridors} corridors between them, {:.0} x {:.0} m", size.x, size.y);
        Ok(Self { summary: format!("{}: {summary}", floor.truth.name), text: floor.text(), truth: json(&floor.truth)?, world })
    }
}

impl FloorArguments {
    fn spec(&self) -> FloorSpec {
        FloorSpec {
            places: self.places,
            columns: self.columns,
            rows: self.rows,
            corridor_width: self.corridor_width.clone(),
            pitch: self.pitch,
            jitter: self.jitter,
            gap: self.gap,
            loops: self.loops,
            dead_ends: self.dead_ends,
            doors: self.doors,
            door_width: self.door_width,
            boxes: self.boxes,
            berth: self.berth,
            clear: self.clear,
            people: self.people,
        }
    }
}

/// A share by which measures are perturbed.
pub(super) fn perturbation(text: &str) -> Result<f64, String> {
    super::within(text, 0.0, MOST_PERTURBED, "a share from 0 to 0.1 is needed: 0.1 for up to a tenth more or less")
}

/// The world itself, as whoever loads the file will have it.
fn build(plan: &WorldPlan) -> Result<World, Refusal> {
    World::from_plan(plan, &|_| Err(io::ErrorKind::NotFound.into()))
        .map_err(|error| Refusal::failed(format!("the world can't be built: {error}"), "take another `--seed`"))
}

fn json(truth: &impl Serialize) -> Result<String, Refusal> {
    let text = serde_json::to_string_pretty(truth);
    text.map(|text| text + "\n")
        .map_err(|error| Refusal::failed(format!("the truth can't be told: {error}"), "leave out `--truth`"))
}

fn picture(world: &World) -> Result<Vec<u8>, Refusal> {
    let resolution = RESOLUTION.max(world.outline.bounds.size().max() / MOST_PIXELS);
    let mut canvas = draw::outline(&world.outline, resolution);
    for place in &world.places {
        canvas.disc(Disc::new(place.pose.point(), PLACE.1), PLACE.0);
    }
    let mut png = io::Cursor::new(Vec::new());
    match canvas.image.write_to(&mut png, ImageFormat::Png) {
        Ok(()) => Ok(png.into_inner()),
        Err(error) => Err(Refusal::failed(format!("the picture can't be drawn: {error}"), "leave out `--picture`")),
    }
}
