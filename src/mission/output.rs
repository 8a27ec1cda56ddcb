//! The files that a run leaves.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use orienteer_runtime::config::Sources;

use super::{Outcome, paths::Trails};

/// The output directory can't be used.
#[derive(Debug, thiserror::Error)]
#[error("the output directory `{}` can't be used: {source}\nhint: name another with `--out`", path.display())]
pub struct OutputError {
    path: PathBuf,
    source: io::Error,
}

/// Makes the output directory.
pub(super) fn prepare(directory: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(directory).map_err(|source| OutputError { path: directory.to_owned(), source })
}

/// Gathers what nodes could not leave behind.
pub(super) fn collect_failures(outcome: &mut Outcome) {
    for robot in &mut outcome.robots {
        for node in &mut robot.nodes {
            let (robot, name) = (&robot.name, &node.name);
            let told = node.finish.failures.drain(..).map(|failure| format!("`{name}` on robot `{robot}`: {failure}"));
            outcome.failures.extend(told);
        }
    }
}

/// Writes the files that nodes leave behind, and the picture of the whole mission.
///
/// A file that the mission was read from stays as it is: the next run would begin with another world.
pub(super) fn write(directory: &Path, outcome: &mut Outcome, trails: &Trails, sources: &Sources) {
    let mut left = Vec::new();
    for robot in &mut outcome.robots {
        // A directory for each robot, since files name each other: a map's YAML its image.
        for file in robot.nodes.iter_mut().flat_map(|node| node.finish.files.drain(..)) {
            left.push((directory.join(&robot.name).join(&file.name), file));
        }
    }
    for (path, file) in left {
        put(&path, &file.bytes, outcome, sources);
    }
    if let Some(canvas) = trails.picture() {
        let mut png = io::Cursor::new(Vec::new());
        match canvas.image.write_to(&mut png, image::ImageFormat::Png) {
            Ok(()) => {
                let path = directory.join(format!("{}.png", outcome.name));
                put(&path, &png.into_inner(), outcome, sources);
            }
            Err(error) => outcome.failures.push(format!("the picture can't be drawn: {error}")),
        }
    }
}

/// Writes a file so that at any moment there is either the old one or the whole new one.
fn put(path: &Path, bytes: &[u8], outcome: &mut Outcome, sources: &Sources) {
    if sources.holds(path) {
        outcome.failures.push(format!("`{}` was not written: the mission was read from it", path.display()));
        return;
    }
    if outcome.files.iter().any(|file| is_same(file, path)) {
        outcome.failures.push(format!("`{}` was left twice; the first is kept", path.display()));
        return;
    }
    let draft = path.with_extension(format!("part-{}", std::process::id()));
    let made = path.parent().map_or(Ok(()), fs::create_dir_all);
    let written = made.and_then(|()| fs::write(&draft, bytes)).and_then(|()| fs::rename(&draft, path));
    match written {
        Ok(()) => outcome.files.push(path.to_owned()),
        Err(error) => {
            // The first error is the one to tell of.
            let _ = fs::remove_file(&draft);
            outcome.failures.push(format!("`{}` can't be written: {error}", path.display()));
        }
    }
}

/// True if both lead to one file, whatever they are called.
fn is_same(one: &Path, other: &Path) -> bool {
    one == other || matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}
