//! The files that a run leaves.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

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
pub(super) fn write(directory: &Path, outcome: &mut Outcome, trails: &Trails) {
    for robot in &mut outcome.robots {
        for file in robot.nodes.iter_mut().flat_map(|node| node.finish.files.drain(..)) {
            // A directory for each robot, since files name each other: a map's YAML its image.
            let path = directory.join(&robot.name).join(&file.name);
            if outcome.files.contains(&path) {
                outcome.failures.push(format!("`{}` was left by two nodes; the first is kept", path.display()));
                continue;
            }
            put(&path, &file.bytes, &mut outcome.files, &mut outcome.failures);
        }
    }
    if let Some(canvas) = trails.picture() {
        let mut png = io::Cursor::new(Vec::new());
        match canvas.image.write_to(&mut png, image::ImageFormat::Png) {
            Ok(()) => {
                let path = directory.join(format!("{}.png", outcome.name));
                put(&path, &png.into_inner(), &mut outcome.files, &mut outcome.failures);
            }
            Err(error) => outcome.failures.push(format!("the picture can't be drawn: {error}")),
        }
    }
}

/// Writes a file so that at any moment there is either the old one or the whole new one.
fn put(path: &Path, bytes: &[u8], files: &mut Vec<PathBuf>, failures: &mut Vec<String>) {
    let draft = path.with_extension(format!("part-{}", std::process::id()));
    let made = path.parent().map_or(Ok(()), fs::create_dir_all);
    let written = made.and_then(|()| fs::write(&draft, bytes)).and_then(|()| fs::rename(&draft, path));
    match written {
        Ok(()) => files.push(path.to_owned()),
        Err(error) => {
            // The first error is the one to tell of.
            let _ = fs::remove_file(&draft);
            failures.push(format!("`{}` can't be written: {error}", path.display()));
        }
    }
}
