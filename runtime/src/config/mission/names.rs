//! Which names robots and agents may have: they become parts of topics, of file names and of random streams.

/// Longer names are refused, characters.
const LONGEST: usize = 48;

/// Longer names of missions are refused, bytes: most file systems end at 255.
const LONGEST_TITLE: usize = 200;

/// Robots can't be called this: the world has random streams of its own.
pub(super) const TAKEN_FROM_ROBOTS: &[&str] = &["world", "mission"];

/// Agents can't be called this: these are the other nodes of a robot.
pub(super) const TAKEN_FROM_AGENTS: &[&str] = &["base", "sonar", "arbitration", "recorder"];

/// What is wrong with a name, and a hint.
pub(super) fn check(name: &str, what: &str, taken: &[&str]) -> Result<(), (String, String)> {
    let rule = "a letter first, then letters without accents, digits, `-` or `_`";
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let message = if name.is_empty() {
        "is empty".to_owned()
    } else if let Some(odd) = name.chars().find(|c| !allowed(*c)) {
        format!("has {odd:?} in it")
    } else if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        "does not begin with a letter".to_owned()
    } else if name.len() > LONGEST {
        format!("is longer than {LONGEST} characters")
    } else if taken.contains(&name) {
        return Err((
            format!("no {what} can be called `{name}`"),
            format!("choose another name; Orienteer uses `{name}` itself"),
        ));
    } else {
        return Ok(());
    };
    let better: String =
        name.chars().map(|c| if allowed(c) { c } else { '-' }).skip_while(|c| !c.is_ascii_alphabetic()).take(LONGEST).collect();
    let hint = if better.is_empty() { format!("names are made of {rule}") } else { format!("call it `{better}`: {rule}") };
    Err((format!("the {what}'s name `{name}` {message}"), hint))
}

/// What is wrong with the name of a mission, and a hint: the files that a run leaves are called after it.
pub(super) fn check_title(name: &str) -> Result<(), (String, String)> {
    let odd = name.chars().find(|c| c.is_control() || matches!(c, '/' | '\\'));
    let message = match odd {
        Some(odd) => format!("has {odd:?} in it"),
        None if name.starts_with('.') => "begins with a dot".to_owned(),
        None if name.len() > LONGEST_TITLE => format!("is longer than {LONGEST_TITLE} bytes"),
        None => return Ok(()),
    };
    let hint = "the picture and the recording are called after it: one word or a few, without `/`";
    Err((format!("the mission's name {name:?} {message}"), hint.to_owned()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_mission_has_a_name_that_files_can_have() {
        for good in ["office floor", "Büro 2", "a.b", ""] {
            assert_eq!(check_title(good), Ok(()));
        }
        for bad in ["../evil", "/tmp/abs", "a\\b", ".hidden", "a\u{1b}[31mb", &"x".repeat(201)] {
            assert!(check_title(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn names_that_make_topics_are_fine_and_others_are_not() {
        for good in ["ann", "Huey-2", "a", "wall_left"] {
            assert_eq!(check(good, "robot", TAKEN_FROM_ROBOTS), Ok(()));
        }
        let long = "x".repeat(49);
        for bad in ["", "2nd", "a b", "a/b", "é", "-", "world", "a\n", long.as_str()] {
            assert!(check(bad, "robot", TAKEN_FROM_ROBOTS).is_err(), "{bad}");
        }
        assert_eq!(
            check("my robot", "robot", &[]).unwrap_err().1,
            "call it `my-robot`: a letter first, then letters without accents, digits, `-` or `_`"
        );
    }
}
