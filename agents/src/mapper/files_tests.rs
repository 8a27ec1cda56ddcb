#![allow(clippy::unwrap_used)]
use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::certainty_grid::{Layout, Rules, Thresholds};

fn grid(width: usize, height: usize, thresholds: Thresholds) -> Grid {
    let layout = Layout { cell: 0.05, width, height, origin: Point2::new(-1.35, 2.6) };
    Grid::new(layout, Rules { thresholds, ..Rules::default() }).unwrap()
}

/// A `map_server` of our own, written from its documentation: value by world coordinates.
struct Loaded {
    image: DynamicImage,
    mode: String,
    resolution: f64,
    origin: [f64; 2],
    occupied: f64,
    free: f64,
}

impl Loaded {
    fn read(yaml: &Path) -> Self {
        let text = fs::read_to_string(yaml).unwrap();
        let value = |key: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": "));
            line.unwrap_or_else(|| panic!("{key} in {text}")).to_owned()
        };
        let origin = value("origin");
        let numbers: Vec<f64> = origin.trim_matches(['[', ']']).split(',').map(|n| n.trim().parse().unwrap()).collect();
        assert_eq!((numbers.len(), numbers[2], value("negate").as_str()), (3, 0.0, "0"));
        let name = value("image").trim_matches('"').to_owned();
        Self {
            image: image::open(yaml.with_file_name(name)).unwrap(),
            mode: value("mode"),
            resolution: value("resolution").parse().unwrap(),
            origin: [numbers[0], numbers[1]],
            occupied: value("occupied_thresh").parse().unwrap(),
            free: value("free_thresh").parse().unwrap(),
        }
    }

    fn at(&self, point: Point2<f64>) -> Occupancy {
        let column = ((point.x - self.origin[0]) / self.resolution).floor();
        let row = ((point.y - self.origin[1]) / self.resolution).floor();
        let height = f64::from(self.image.height());
        if column < 0.0 || row < 0.0 || column >= f64::from(self.image.width()) || row >= height {
            return Occupancy::Unknown;
        }
        let LumaA([grey, alpha]) = self.image.to_luma_alpha8().get_pixel(column as u32, (height - 1.0 - row) as u32).to_owned();
        let p = (255.0 - f64::from(grey)) / 255.0;
        match self.mode.as_str() {
            "scale" if alpha < 255 => Occupancy::Unknown,
            "trinary" | "scale" if p > self.occupied => Occupancy::Occupied,
            "trinary" | "scale" if p < self.free => Occupancy::Free,
            "trinary" | "scale" => Occupancy::Unknown,
            mode => panic!("{mode}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn a_map_server_sees_the_same_classes(
        cells in prop::collection::vec((0.0..=1.0f32, -6i8..=6), 1..120), width in 1usize..12,
        empty in 0.0..=0.5f32, occupied in 0.5..=1.0f32, mode in prop_oneof![Just(Mode::Trinary), Just(Mode::Scale)],
    ) {
        let height = cells.len().div_ceil(width);
        let mut grid = grid(width, height, Thresholds { empty, occupied, path: 0.25 });
        for (i, (c, f)) in cells.iter().enumerate() {
            // Values on the thresholds themselves are where rounding could matter.
            let c = match i % 5 { 0 => empty, 1 => occupied, _ => *c };
            grid.restore(CellIndex::new((i % width) as i32, (i / width) as i32), c, (*f).into());
        }
        let dir = tempfile::tempdir().unwrap();
        let files = save(&grid, &dir.path().join("floor 2"), mode).unwrap();
        let loaded = Loaded::read(&files.yaml);
        for row in -3..height as i32 + 3 {
            for column in -3..width as i32 + 3 {
                let index = CellIndex::new(column, row);
                prop_assert_eq!(loaded.at(grid.centre_of(index)), grid.occupancy(index), "{:?}", index);
            }
        }
        let found = fs::read_dir(dir.path()).unwrap().count();
        prop_assert_eq!(found, 2);
    }
}

#[test]
fn the_first_row_is_the_top() {
    let mut grid = grid(30, 20, Thresholds::default());
    grid.force(CellIndex::new(10, 15), 1.0);
    grid.force(CellIndex::new(12, 5), 0.0);
    let dir = tempfile::tempdir().unwrap();
    let files = save(&grid, &dir.path().join("map"), Mode::Trinary).unwrap();
    let image = image::open(&files.image).unwrap().to_luma8();
    assert_eq!((image.width() as usize, image.height() as usize), (3 + 2 * MARGIN, 11 + 2 * MARGIN));
    assert_eq!(image.get_pixel(MARGIN as u32, MARGIN as u32).0, [OCCUPIED]);
    assert_eq!(image.get_pixel(MARGIN as u32 + 2, MARGIN as u32 + 10).0, [FREE]);
    let text = fs::read_to_string(&files.yaml).unwrap();
    let want = "image: map.png\nmode: trinary\nresolution: 0.05\norigin: [-0.95, 2.75, 0.0]\n\
                negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
    assert_eq!(text, want);
    let Summary { free, occupied, unknown, occupied_area, .. } = files.summary;
    assert_eq!((free, occupied, unknown), (1, 1, 7 * 15 - 2));
    assert!((occupied_area - 0.0025).abs() < 1e-12);
}

#[test]
fn a_blank_map_is_one_unknown_cell() {
    let dir = tempfile::tempdir().unwrap();
    let files = save(&grid(5, 5, Thresholds::default()), &dir.path().join("map"), Mode::Scale).unwrap();
    let Summary { width, height, free, occupied, unknown, .. } = files.summary;
    assert_eq!((width, height, free, occupied, unknown), (1, 1, 0, 0, 1));
}

#[test]
fn saving_again_replaces_both_files() {
    let dir = tempfile::tempdir().unwrap();
    let stem = dir.path().join("map");
    let mut grid = grid(9, 9, Thresholds::default());
    save(&grid, &stem, Mode::Trinary).unwrap();
    grid.force(CellIndex::new(4, 4), 1.0);
    let files = save(&grid, &stem, Mode::Trinary).unwrap();
    assert_eq!(Loaded::read(&files.yaml).at(grid.centre_of(CellIndex::new(4, 4))), Occupancy::Occupied);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
}

#[test]
fn a_directory_that_is_not_there_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let error = save(&grid(2, 2, Thresholds::default()), &dir.path().join("no/map"), Mode::Trinary).unwrap_err();
    assert!(error.to_string().contains("no/map.png"), "{error}");
}

#[test]
fn a_failed_write_leaves_the_old_file_and_no_draft() {
    let dir = tempfile::tempdir().unwrap();
    let target = dir.path().join("map.png");
    // A directory in the way makes the rename fail.
    fs::create_dir(&target).unwrap();
    assert!(replace(&target, b"new").is_err());
    assert!(target.is_dir());
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn odd_names_are_quoted() {
    assert_eq!(quoted("map-1.png"), "map-1.png");
    assert_eq!(quoted("floor 2.png"), "\"floor 2.png\"");
    assert_eq!(quoted("a\"b\\c\n.png"), "\"a\\\"b\\\\c\\u000a.png\"");
    assert_eq!(quoted("- x: [1].png"), "\"- x: [1].png\"");
    assert_eq!([decimal(3.0), decimal(-0.000_000_000_1), decimal(0.1 + 0.2)], ["3.0", "0.0", "0.3"]);
}
