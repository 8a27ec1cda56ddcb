//! Reading from the disk, with an answer for people when it fails.

use std::{
    fs::File,
    io::{ErrorKind, Read},
    path::Path,
};

use super::MAX_FILE_SIZE;
use crate::config::suggest;

/// Directories with more entries are not searched for near names.
const MOST_ENTRIES: usize = 10_000;

/// The bytes of a file, or what is wrong and a hint.
pub(super) fn read(root: &Path, name: &str) -> Result<Vec<u8>, (String, String)> {
    let path = root.join(name);
    let shown = path.display();
    let metadata = path.metadata().map_err(|error| match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => (format!("there is no file `{shown}`"), nearest(root, name)),
        _ => refused(&path, &error),
    })?;
    if metadata.is_dir() {
        return Err((format!("`{shown}` is a directory"), format!("name a file in it: {}", entries_of(&path))));
    }
    // Opening a pipe or a device may block for ever.
    if !metadata.is_file() {
        return Err((format!("`{shown}` is not a regular file"), "name a file on the disk".to_owned()));
    }
    let mut bytes = Vec::with_capacity(metadata.len().min(MAX_FILE_SIZE as u64) as usize);
    let file = File::open(&path).map_err(|error| refused(&path, &error))?;
    file.take(MAX_FILE_SIZE as u64 + 1).read_to_end(&mut bytes).map_err(|error| refused(&path, &error))?;
    if bytes.len() > MAX_FILE_SIZE {
        let hint = "a configuration can't be that large: name another file".to_owned();
        return Err((format!("`{shown}` is larger than {} MiB", MAX_FILE_SIZE >> 20), hint));
    }
    Ok(bytes)
}

fn refused(path: &Path, error: &std::io::Error) -> (String, String) {
    let hint = match error.kind() {
        ErrorKind::PermissionDenied => "make the file readable for this user, or name another".to_owned(),
        _ => "check the name and the disk".to_owned(),
    };
    (format!("can't read `{}`: {error}", path.display()), hint)
}

/// What the person may have meant: looks at the first part of the path that does not exist.
fn nearest(root: &Path, name: &str) -> String {
    let mut folder = if name.starts_with('/') { "/".into() } else { root.to_path_buf() };
    let mut parts = name.split('/').filter(|part| !part.is_empty()).peekable();
    let mut before = String::new();
    while let Some(part) = parts.next() {
        let next = folder.join(part);
        if !next.exists() || (parts.peek().is_some() && !next.is_dir()) {
            let names = names_in(&folder);
            let near = suggest::nearest(part, names.iter().map(String::as_str));
            return match (parts.peek().is_some(), near) {
                (true, Some(near)) => format!("there is no directory `{before}{part}`; did you mean `{before}{near}`?"),
                (true, None) => format!("there is no directory `{before}{part}`"),
                (false, Some(near)) => format!("did you mean `{before}{near}`?"),
                (false, None) => format!("the directory holds: {}", suggest::list(names.iter().map(String::as_str))),
            };
        }
        before = format!("{before}{part}/");
        folder = next;
    }
    "check the name".to_owned()
}

fn entries_of(folder: &Path) -> String {
    suggest::list(names_in(folder).iter().map(String::as_str))
}

fn names_in(folder: &Path) -> Vec<String> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().take(MOST_ENTRIES);
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| !name.starts_with('.'));
    names.sort_unstable();
    names
}
