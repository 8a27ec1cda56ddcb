//! Missions and worlds that are built into the program, so that it runs without any file.

/// Names of the missions that are built in; the first is what runs if none is named.
pub const EMBEDDED: [&str; 2] = ["office-floor", "hallway"];

macro_rules! files {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../../configs/", $name)))),+]
    };
}

/// All files that are built in, with their names below `configs/`.
pub fn embedded_files() -> impl Iterator<Item = (String, Vec<u8>)> {
    files!["office-floor.toml", "hallway.toml", "worlds/office-floor.toml", "worlds/hallway.toml"]
        .into_iter()
        .map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()))
}
