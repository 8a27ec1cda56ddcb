//! The mapper as an agent.

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    geometry::Pose,
    recording::GridImage,
    time::Time,
    topics::{PoseEstimate, SonarScan},
};

use super::{
    Config, Mapper,
    files::{self, Mode},
    picture::{self, PictureStyle},
};

/// The mapper as an agent: poses and scans in, a map in the recording and in files.
#[derive(Debug)]
pub struct MapperAgent {
    mapper: Mapper,
    scans: u64,
    every: u64,
    picture_period: f64,
    next_picture: f64,
}

impl MapperAgent {
    fn image(&self) -> GridImage {
        let grid = self.mapper.grid();
        let window = grid.window();
        let corner = grid.corner_of(window.first);
        let mut cells = Vec::new();
        grid.occupancy_bytes(&mut cells);
        GridImage {
            origin: Pose::new(corner.x, corner.y, 0.0),
            resolution: grid.cell_size(),
            width: window.width as u32,
            height: window.height as u32,
            cells,
        }
    }
}

impl Behaviour for MapperAgent {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        for estimate in inputs.each::<PoseEstimate>() {
            self.mapper.track(estimate.stamp, estimate.pose);
        }
        for scan in inputs.each::<SonarScan>() {
            if self.scans.is_multiple_of(self.every) {
                self.mapper.scan(scan);
            }
            self.scans += 1;
        }
        if self.picture_period > 0.0 && now.as_secs_f64() >= self.next_picture {
            self.next_picture = now.as_secs_f64() + self.picture_period;
            out.record_grid(self.image());
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let grid = self.mapper.grid();
        let summary = files::summarize(grid);
        last_words.fact("free_cells", summary.free as f64);
        last_words.fact("occupied_cells", summary.occupied as f64);
        last_words.fact("free_area_m2", summary.free_area);
        match files::encode_map(grid, "map", Mode::Trinary) {
            Ok(map) => map.into_iter().for_each(|(name, bytes)| last_words.file(name, bytes)),
            Err(error) => last_words.failure(format!("the map can't be drawn: {error}")),
        }
        let drawn = picture::draw(grid, self.mapper.path(), PictureStyle::default());
        match files::encode_png(&drawn.into()) {
            Ok(png) => last_words.file("map-picture.png", png),
            Err(error) => last_words.failure(format!("the picture of the map can't be drawn: {error}")),
        }
    }
}

impl Agent for MapperAgent {
    const KIND: &'static str = "mapper";
    const HELP: &'static str = "draws what the sonar hears into a certainty grid, and saves it as a map";
    const CLAIMS: bool = false;
    type Config = Config;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<SonarScan>().draws_map();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        let (every, picture_period) = (u64::from(config.every.max(1)), config.picture_period);
        let mapper = Mapper::new(config, &robot.ring, robot.start).map_err(|error| BuildError::new(error.to_string()))?;
        Ok(Self { mapper, scans: 0, every, picture_period, next_picture: picture_period })
    }
}
