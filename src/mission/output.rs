//! The files that a run leaves.

use std::{
    collections::BTreeSet,
    fs, io,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
};

use orienteer_runtime::{agent::OutputFile, config::Sources};

use super::{Outcome, paths::Trails, places};

/// The output directory can't be used.
#[derive(Debug, thiserror::Error)]
#[error("the output directory `{}` can't be used: {source}\nhint: name another with `--out`", path.display())]
pub struct OutputError {
    path: PathBuf,
    source: io::Error,
}

impl OutputError {
    /// What sort of answer the system gave.
    #[must_use]
    pub fn kind(&self) -> io::ErrorKind {
        self.source.kind()
    }
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
        let mut files: Vec<OutputFile> = robot.nodes.iter_mut().flat_map(|node| node.finish.files.drain(..)).collect();
        match places::picture(&files) {
            Some(Ok(picture)) => files.push(picture),
            Some(Err(failure)) => outcome.failures.push(failure),
            None => {}
        }
        // A directory for each robot, since files name each other: a map's YAML its image.
        left.extend(files.into_iter().map(|file| (directory.join(&robot.name).join(&file.name), file)));
    }
    let mut shelf = Shelf { sources, kept: outcome.files.iter().filter_map(|path| identity(path)).collect() };
    for (path, file) in left {
        shelf.put(&path, &file.bytes, outcome);
    }
    if let Some(canvas) = trails.picture() {
        let mut png = io::Cursor::new(Vec::new());
        match canvas.image.write_to(&mut png, image::ImageFormat::Png) {
            Ok(()) => {
                let path = directory.join(format!("{}.png", outcome.name));
                shelf.put(&path, &png.into_inner(), outcome);
            }
            Err(error) => outcome.failures.push(format!("the picture can't be drawn: {error}")),
        }
    }
}

/// Where files go, none of them over another.
struct Shelf<'a> {
    sources: &'a Sources,
    /// What is there already, whatever it is called.
    kept: BTreeSet<(u64, u64)>,
}

impl Shelf<'_> {
    /// Writes a file so that at any moment there is either the old one or the whole new one.
    fn put(&mut self, path: &Path, bytes: &[u8], outcome: &mut Outcome) {
        if self.sources.holds(path) {
            outcome.failures.push(format!("`{}` was not written: the mission was read from it", path.display()));
            return;
        }
        if identity(path).is_some_and(|file| self.kept.contains(&file)) {
            outcome.failures.push(format!("`{}` was left twice; the first is kept", path.display()));
            return;
        }
        let draft = path.with_extension(format!("part-{}", std::process::id()));
        let made = path.parent().map_or(Ok(()), fs::create_dir_all);
        let written = made.and_then(|()| fs::write(&draft, bytes)).and_then(|()| fs::rename(&draft, path));
        match written {
            Ok(()) => {
                self.kept.extend(identity(path));
                outcome.files.push(path.to_owned());
            }
            Err(error) => {
                // The first error is the one to tell of.
                let _ = fs::remove_file(&draft);
                outcome.failures.push(format!("`{}` can't be written: {error}", path.display()));
            }
        }
    }
}

/// The file that a path leads to, if there is one: its device and its number there.
fn identity(path: &Path) -> Option<(u64, u64)> {
    fs::metadata(path).ok().map(|file| (file.dev(), file.ino()))
}
