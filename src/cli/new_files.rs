//! Files that a command makes: each whole or not at all, and over no other file unless told to.

use std::{
    fs::{self, Permissions},
    io::{self, Write},
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use super::Refusal;

/// A file to be made.
#[derive(Debug)]
pub struct NewFile {
    /// Where.
    pub path: PathBuf,
    /// What is in it.
    pub bytes: Vec<u8>,
    /// The option that names it, for messages.
    pub option: &'static str,
}

/// Writes all of them, or none if one can't be.
///
/// # Errors
/// [`Refusal`] if a file is there already and `force` is not set, if two go to one place, or if the disk does not take them.
pub fn write(files: &[NewFile], force: bool) -> Result<(), Refusal> {
    let mut places: Vec<PathBuf> = Vec::new();
    for file in files {
        let place = file.place(force)?;
        if places.contains(&place) {
            let message = format!("`{}` can't be two files at once", file.path.display());
            return Err(Refusal::misused(message, file.another()));
        }
        places.push(place);
    }
    let drafts = files.iter().zip(&places).map(|(file, place)| file.draft(place)).collect::<Result<Vec<_>, _>>()?;
    for ((file, place), draft) in files.iter().zip(&places).zip(drafts) {
        let kept = if force { draft.persist(place) } else { draft.persist_noclobber(place) };
        kept.map_err(|error| file.lost(&error.error))?;
    }
    Ok(())
}

impl NewFile {
    /// Where it really goes.
    fn place(&self, force: bool) -> Result<PathBuf, Refusal> {
        let shown = self.path.display();
        match fs::metadata(&self.path) {
            Ok(there) if !there.is_file() => Err(Refusal::misused(format!("`{shown}` is there, and is no file"), self.another())),
            Ok(_) if !force => {
                let hint = format!("`--force` writes over it; or {}", self.another());
                Err(Refusal::misused(format!("there is a file `{shown}` already"), hint))
            }
            // Through links, so that they go on leading to it.
            Ok(_) => fs::canonicalize(&self.path).map_err(|error| self.lost(&error)),
            Err(_) => {
                let folder = fs::canonicalize(folder(&self.path)).map_err(|error| self.lost(&error))?;
                let name = self.path.file_name().ok_or_else(|| self.lost(&io::ErrorKind::InvalidInput.into()))?;
                Ok(folder.join(name))
            }
        }
    }

    /// Its contents beside its place.
    fn draft(&self, place: &Path) -> Result<NamedTempFile, Refusal> {
        // As any new file, not for its owner alone.
        let mut builder = tempfile::Builder::new();
        builder.prefix(".orienteer-").suffix(".part").permissions(Permissions::from_mode(0o666));
        let made = builder.tempfile_in(folder(place)).and_then(|mut draft| {
            draft.write_all(&self.bytes)?;
            draft.as_file().sync_all().map(|()| draft)
        });
        made.map_err(|error| self.lost(&error))
    }

    fn lost(&self, error: &io::Error) -> Refusal {
        Refusal::failed(
            format!("`{}` can't be written: {error}", self.path.display()),
            format!("{}, in a directory that exists", self.another()),
        )
    }

    fn another(&self) -> String {
        format!("name another with `{}`", self.option)
    }
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
