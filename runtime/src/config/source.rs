//! The files a configuration is made of.
//!
//! A mission names a world, a world names an image, and each mistake in any of them must be shown where it stands. [`Sources`]
//! remembers every file that was read, in memory, so that a recording can carry them all and a replay reads the very same
//! bytes without a disk.
//!
//! All files share one address space, as in compilers: the first file starts at position 1, the next one behind its end. A
//! [`Span`] therefore says which file it means, and a table merged from two files needs no bookkeeping.

mod disk;

use std::{
    collections::BTreeMap,
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};

use super::{
    problem::{Location, Problem},
    suggest,
};

/// Positions (bytes) in the address space of a [`Sources`]. `0..0` is nowhere.
pub type Span = Range<usize>;

/// Larger files are refused, bytes.
pub const MAX_FILE_SIZE: usize = 64 << 20;

/// A file that was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(usize);

#[derive(Debug, Clone)]
struct Source {
    name: String,
    bytes: Arc<[u8]>,
    start: usize,
}

#[derive(Debug, Clone)]
enum Store {
    Disk(PathBuf),
    Memory(BTreeMap<String, Arc<[u8]>>),
}

/// All files that a configuration reads, from the disk or from memory.
///
/// Names are relative to one root directory, use `/`, and hold no `.` or needless `..`, so that they mean the same on another
/// machine.
///
/// ```
/// use orienteer_runtime::config::Sources;
/// let mut sources = Sources::embedded([("hall.toml".to_owned(), b"seed = 7".to_vec())]);
/// let id = sources.read("hall.toml").unwrap();
/// assert_eq!(sources.text(id).unwrap(), "seed = 7");
/// let problem = sources.read("hal.toml").unwrap_err();
/// assert_eq!(problem.hint(), "did you mean `hall.toml`?");
/// ```
#[derive(Debug, Clone)]
pub struct Sources {
    store: Store,
    files: Vec<Source>,
}

impl Sources {
    /// Files below (or, with `..`, beside) a directory.
    #[must_use]
    pub fn from_disk(root: impl Into<PathBuf>) -> Self {
        Self { store: Store::Disk(root.into()), files: Vec::new() }
    }

    /// Files from memory; nothing else can be read.
    #[must_use]
    pub fn embedded(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        let files = files.into_iter().map(|(name, bytes)| (clean(&name), bytes.into())).collect();
        Self { store: Store::Memory(files), files: Vec::new() }
    }

    /// Opens the file a person named on the command line; its directory becomes the root.
    ///
    /// # Errors
    /// A [`Problem`] without a place if the file can't be read.
    pub fn open(path: impl Into<PathBuf>) -> Result<(Self, SourceId), Problem> {
        let path: PathBuf = path.into();
        let Some(name) = path.file_name().map(|name| name.to_string_lossy().into_owned()) else {
            let message = format!("`{}` names no file", path.display());
            return Err(Problem::nowhere(message, "give the path of a TOML file, such as `configs/office-floor.toml`"));
        };
        let mut sources = Self::from_disk(path.parent().unwrap_or(&path));
        let id = sources.read(&name)?;
        Ok((sources, id))
    }

    /// Reads a file by its name below the root. A file is read once only.
    ///
    /// # Errors
    /// A [`Problem`] without a place: not there, a directory, too large, not readable.
    pub fn read(&mut self, name: &str) -> Result<SourceId, Problem> {
        self.load(&clean(name)).map_err(|(message, hint)| Problem::nowhere(message, hint))
    }

    /// Reads a file that a value at `asked` names; the name is relative to the file in which the value stands.
    ///
    /// # Errors
    /// A [`Problem`] at that value: not there, a directory, too large, not readable.
    pub fn read_for(&mut self, name: &str, asked: &Span) -> Result<SourceId, Problem> {
        let beside = self.at(asked.start).map_or("", |source| source.name.as_str());
        let directory = beside.rfind('/').map_or("", |end| &beside[..=end]);
        let full = if name.starts_with('/') { clean(name) } else { clean(&format!("{directory}{name}")) };
        self.load(&full).map_err(|(message, hint)| Problem::new(self, asked, message, hint))
    }

    /// The bytes of a file.
    #[must_use]
    pub fn bytes(&self, id: SourceId) -> &[u8] {
        self.files.get(id.0).map_or(&[], |source| &source.bytes)
    }

    /// The text of a file.
    ///
    /// # Errors
    /// A [`Problem`] at the first byte that is not UTF-8.
    pub fn text(&self, id: SourceId) -> Result<&str, Problem> {
        std::str::from_utf8(self.bytes(id)).map_err(|error| {
            let at = self.start(id) + error.valid_up_to();
            let byte = self.bytes(id).get(error.valid_up_to()).copied().unwrap_or_default();
            let message = format!("this file is not text: byte 0x{byte:02x} is not UTF-8");
            Problem::new(self, &(at..at + 1), message, "save the file as UTF-8 text, or name another file")
        })
    }

    /// The name of a file below the root.
    #[must_use]
    pub fn name(&self, id: SourceId) -> &str {
        self.files.get(id.0).map_or("", |source| &source.name)
    }

    /// All files read so far, sorted by name, for a recording to carry.
    #[must_use]
    pub fn files(&self) -> Vec<(&str, &[u8])> {
        let mut files: Vec<(&str, &[u8])> = self.files.iter().map(|source| (source.name.as_str(), &*source.bytes)).collect();
        files.sort_unstable();
        files
    }

    /// True if one of the files that were read lies on the disk at this path.
    #[must_use]
    pub fn holds(&self, path: &Path) -> bool {
        let Ok(path) = path.canonicalize() else { return false };
        matches!(self.store, Store::Disk(_))
            && self.files.iter().any(|source| Path::new(&self.shown(&source.name)).canonicalize().is_ok_and(|read| read == path))
    }

    /// The place that a person should look at. Nowhere in particular becomes the start of the first file.
    #[must_use]
    pub fn locate(&self, span: &Span) -> Option<Location> {
        let source = self.at(span.start).or_else(|| self.files.first())?;
        let start = span.start.saturating_sub(source.start).min(source.bytes.len());
        let end = span.end.saturating_sub(source.start).clamp(start, source.bytes.len());
        Some(Location::new(self.shown(&source.name), &source.bytes, start..end, source.start + start))
    }

    /// The beginning of a file, as a place to read further files from.
    #[must_use]
    pub fn start_of(&self, id: SourceId) -> Span {
        let start = self.start(id);
        start..start
    }

    /// The position at which a file starts in the common address space.
    pub(super) fn start(&self, id: SourceId) -> usize {
        self.files.get(id.0).map_or(0, |source| source.start)
    }

    /// The file in which a position lies.
    fn at(&self, position: usize) -> Option<&Source> {
        let after = self.files.partition_point(|source| source.start <= position);
        after.checked_sub(1).and_then(|index| self.files.get(index))
    }

    /// A name as people know it: with the root before it.
    fn shown(&self, name: &str) -> String {
        match &self.store {
            Store::Disk(root) => root.join(name).display().to_string(),
            Store::Memory(_) => name.to_owned(),
        }
    }

    fn load(&mut self, name: &str) -> Result<SourceId, (String, String)> {
        if let Some(index) = self.files.iter().position(|source| source.name == name) {
            return Ok(SourceId(index));
        }
        let bytes = match &self.store {
            Store::Disk(root) => disk::read(root, name)?.into(),
            Store::Memory(files) => files.get(name).cloned().ok_or_else(|| {
                let hint = suggest::did_you_mean(name, files.keys().map(String::as_str))
                    .unwrap_or_else(|| format!("the files at hand are: {}", suggest::list(files.keys().map(String::as_str))));
                (format!("there is no file `{name}`"), hint)
            })?,
        };
        let start = self.files.last().map_or(1, |last| last.start + last.bytes.len() + 1);
        self.files.push(Source { name: name.to_owned(), bytes, start });
        Ok(SourceId(self.files.len() - 1))
    }
}

/// A name without `.`, doubled `/` or needless `..`.
fn clean(name: &str) -> String {
    let name = if cfg!(windows) { name.replace('\\', "/") } else { name.to_owned() };
    let mut parts: Vec<&str> = Vec::new();
    for part in name.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|last| *last != "..") => _ = parts.pop(),
            part => parts.push(part),
        }
    }
    let lead = if name.starts_with('/') { "/" } else { "" };
    format!("{lead}{}", parts.join("/"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_are_cleaned_and_relative_to_the_file_that_names_them() {
        assert_eq!(clean("./worlds//../maps/./a.png"), "maps/a.png");
        assert_eq!(clean("../../data/x"), "../../data/x");
        assert_eq!(clean("/var/log/../run"), "/var/run");
        let files = ["m/a.toml", "m/worlds/w.toml", "m/worlds/i.png"].map(|n| (n.to_owned(), n.as_bytes().to_vec()));
        let mut sources = Sources::embedded(files);
        let mission = sources.read("m/a.toml").unwrap();
        let at = sources.start(mission);
        let world = sources.read_for("worlds/w.toml", &(at..at + 1)).unwrap();
        let at = sources.start(world);
        let image = sources.read_for("i.png", &(at..at + 1)).unwrap();
        assert_eq!(sources.name(image), "m/worlds/i.png");
        assert_eq!(sources.read_for("../a.toml", &(at..at + 1)).unwrap(), mission);
        let names: Vec<&str> = sources.files().iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["m/a.toml", "m/worlds/i.png", "m/worlds/w.toml"]);
    }

    #[test]
    fn what_cannot_be_read_is_a_problem() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("worlds")).unwrap();
        std::fs::write(folder.path().join("mission.toml"), "a = 1\nb = \"\u{e9}\"\n").unwrap();
        std::fs::write(folder.path().join("worlds/office.toml"), [b'a', b'\n', b'b', 0xff]).unwrap();
        let (mut sources, mission) = Sources::open(folder.path().join("mission.toml")).unwrap();
        let at = sources.start(mission) + 6;
        let read = |sources: &mut Sources, name: &str| sources.read_for(name, &(at..at + 1)).unwrap_err();

        let missing = read(&mut sources, "worlds/ofice.toml");
        assert_eq!(missing.hint(), "did you mean `worlds/office.toml`?");
        assert_eq!((missing.location().unwrap().line, missing.location().unwrap().column), (2, 1));
        assert_eq!(read(&mut sources, "wrlds/office.toml").hint(), "there is no directory `wrlds`; did you mean `worlds`?");
        assert!(read(&mut sources, "worlds").message().contains("is a directory"));

        let id = sources.read("worlds/office.toml").unwrap();
        let place = sources.text(id).unwrap_err().location().unwrap().clone();
        assert_eq!((place.line, place.column), (2, 2));
    }

    #[test]
    fn a_file_that_is_too_large_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = std::fs::File::create(folder.path().join("huge")).unwrap();
        file.set_len(MAX_FILE_SIZE as u64 + 1).unwrap();
        assert!(Sources::open(folder.path().join("huge")).unwrap_err().message().contains("larger than 64 MiB"));
        file.set_len(10).unwrap();
        assert!(Sources::open(folder.path().join("huge")).is_ok());
    }
}
