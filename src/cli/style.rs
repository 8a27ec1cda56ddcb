//! How things look on a terminal, and how they get there.

use std::{
    fmt::Display,
    io::{self, IsTerminal, Write},
};

use crate::runtime::{config::Problem, time::Time};

use super::{Refusal, stderr};

/// Everything fits into a terminal of this many columns.
pub const WIDTH: usize = 80;

/// Puts on colour, or does not.
#[derive(Debug, Clone, Copy)]
pub struct Paint {
    colour: bool,
}

impl Paint {
    /// For standard output.
    pub fn stdout() -> Self {
        Self { colour: wants_colour(&io::stdout()) }
    }

    /// For standard error.
    pub fn stderr() -> Self {
        Self { colour: wants_colour(&io::stderr()) }
    }

    /// For tests.
    #[cfg(test)]
    pub fn plain() -> Self {
        Self { colour: false }
    }

    /// Whether it puts on colour.
    pub fn is_coloured(self) -> bool {
        self.colour
    }

    /// Headings and names.
    pub fn bold(self, text: impl Display) -> String {
        self.put("1", text)
    }

    /// What matters less.
    pub fn dim(self, text: impl Display) -> String {
        self.put("2", text)
    }

    /// What is as it should be.
    pub fn good(self, text: impl Display) -> String {
        self.put("32", text)
    }

    /// What is not.
    pub fn bad(self, text: impl Display) -> String {
        self.put("1;31", text)
    }

    fn put(self, code: &str, text: impl Display) -> String {
        if self.colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_string() }
    }
}

/// People who set `NO_COLOR` or use a dumb terminal get none.
fn wants_colour(stream: &impl IsTerminal) -> bool {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    stream.is_terminal() && !refused && !dumb
}

/// Writes to standard output. Whoever reads it may stop reading: `orienteer list | head -1`.
///
/// # Errors
/// If it gets lost elsewhere, on a full disk for instance.
pub fn print(text: &str) -> Result<(), Refusal> {
    // What was said before stands before it where both go to one terminal.
    stderr::settle();
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            let hint = "look at the disk or device that standard output leads to";
            Err(Refusal::failed(format!("the answer can't be written: {error}"), hint))
        }
        _ => Ok(()),
    }
}

/// Writes a value to standard output as JSON.
///
/// # Errors
/// As [`print`].
pub fn print_json(value: &impl serde::Serialize) -> Result<(), Refusal> {
    match serde_json::to_string_pretty(value) {
        Ok(text) => print(&format!("{text}\n")),
        Err(error) => Err(Refusal::failed(format!("the answer can't be written as JSON: {error}"), "leave out `--json`")),
    }
}

/// Tells on standard error what went wrong and what to do about it.
pub fn complain(message: &str, hint: &str) {
    complain_of(&Problem::nowhere(message, hint).render(Paint::stderr().is_coloured()));
}

/// Writes to standard error.
pub fn complain_of(text: &str) {
    stderr::write(format!("{text}\n").as_bytes());
}

/// The text in lines of at most [`WIDTH`] columns; all but the first are indented.
pub fn wrap(text: &str, indent: usize) -> String {
    wrap_to(text, indent, WIDTH).join(&format!("\n{}", " ".repeat(indent)))
}

/// The lines of a text that begins in column `indent`, none longer than fits into `width` if its words allow.
pub fn wrap_to(text: &str, indent: usize, width: usize) -> Vec<String> {
    let room = width.saturating_sub(indent).max(16);
    let mut lines = vec![String::new()];
    let mut length = 0;
    for word in text.split(' ') {
        let letters = word.chars().count();
        if length > 0 && length + 1 + letters > room {
            lines.push(String::new());
            length = 0;
        }
        if let Some(line) = lines.last_mut() {
            if length > 0 {
                line.push(' ');
                length += 1;
            }
            line.push_str(word);
            length += letters;
        }
    }
    lines
}

/// Minutes and seconds; fractions only if there are any.
pub fn time(time: Time) -> String {
    let text = time.to_string();
    text.strip_suffix(".000").map_or(text.clone(), str::to_owned)
}

/// A size for people.
pub fn bytes(bytes: u64) -> String {
    match bytes {
        0..1000 => format!("{bytes} B"),
        1000..1_000_000 => format!("{:.1} kB", bytes as f64 * 1e-3),
        _ => format!("{:.1} MB", bytes as f64 * 1e-6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_between_words() {
        let text = "the base was taken by avoidance, which is of higher priority";
        let lines = wrap_to(text, 4, 34);
        assert!(lines.iter().all(|line| line.chars().count() <= 30), "{lines:?}");
        assert_eq!(lines.join(" "), text);
        assert_eq!(wrap_to("", 4, 34), [""]);
    }

    #[test]
    fn whole_seconds_have_no_fraction() {
        assert_eq!(time(Time::from_secs_f64(600.0)), "10:00");
        assert_eq!(time(Time::from_secs_f64(61.05)), "1:01.050");
    }
}
