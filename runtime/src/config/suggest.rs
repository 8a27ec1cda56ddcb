//! "Did you mean": near names, and lists short enough to read.

/// Names less alike than this (Jaro–Winkler) are not offered.
const ALIKE: f64 = 0.88;
/// At most this many names are listed.
const LISTED: usize = 16;

/// The candidate most like `name`, if one is like it at all. Of equals, the first.
pub(crate) fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let wanted = plain(name);
    let mut best: Option<(&str, f64)> = None;
    for candidate in candidates.filter(|candidate| *candidate != name) {
        let other = plain(candidate);
        let slips = strsim::damerau_levenshtein(&wanted, &other);
        let shorter = wanted.chars().count().min(other.chars().count());
        // A slip or two in a word, or the same beginning: either way a person sees the likeness.
        let near = slips * 3 <= shorter || (slips == 1 && shorter > 1);
        let likeness = strsim::jaro_winkler(&wanted, &other) + if near { 1.0 } else { 0.0 } - 0.02 * slips as f64;
        if (near || strsim::jaro_winkler(&wanted, &other) >= ALIKE) && best.is_none_or(|(_, most)| likeness > most) {
            best = Some((candidate, likeness));
        }
    }
    best.map(|(candidate, _)| candidate)
}

/// The question, or `None` if nothing is like `name`.
#[must_use]
pub fn did_you_mean<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    nearest(name, candidates).map(|near| format!("did you mean `{near}`?"))
}

/// The names, quoted and separated by commas; the first few if there are many.
#[must_use]
pub fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => "nothing".to_owned(),
        many if many > LISTED => format!("{} and {} more", names[..LISTED].join(", "), many - LISTED),
        _ => names.join(", "),
    }
}

/// Both for a hint: the question, if there is one, and what there is, after words like `there are`.
#[must_use]
pub fn hint<'a>(name: &str, there_are: &str, candidates: impl Iterator<Item = &'a str> + Clone) -> String {
    let all = format!("{there_are} {}", list(candidates.clone()));
    match did_you_mean(name, candidates) {
        Some(question) => format!("{question} ({all})"),
        None => all,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let keys = ["priority", "kind", "enabled", "deadline_ms", "x", "y", "heading_deg"];
        let near = |name: &str| nearest(name, keys.into_iter());
        assert_eq!(near("priorty"), Some("priority"));
        assert_eq!(near("Priority"), Some("priority"));
        assert_eq!(near("knid"), Some("kind"));
        assert_eq!(near("deadline"), Some("deadline_ms"));
        assert_eq!(near("heading"), Some("heading_deg"));
        assert_eq!(near("colour"), None);
        assert_eq!(near("z"), None);
        assert_eq!(near(""), None);
    }

    #[test]
    fn long_lists_are_cut() {
        let names: Vec<String> = (0..20).map(|n| n.to_string()).collect();
        assert!(list(names.iter().map(String::as_str)).ends_with("`15` and 4 more"));
        assert_eq!(list(std::iter::empty()), "nothing");
    }
}
