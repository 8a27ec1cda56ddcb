//! A problem as a compiler would print it.

use annotate_snippets::{AnnotationKind, Element, Group, Level, Origin, Renderer, Snippet, renderer::DEFAULT_TERM_WIDTH};

use super::{Location, Problem};

/// Several lines, without a line break at the end.
pub(super) fn render(problem: &Problem, colour: bool) -> String {
    let mut groups = vec![primary(problem)];
    for note in &problem.0.notes {
        let title = Level::NOTE.secondary_title(note.message.as_str());
        groups.push(match &note.location {
            Some(location) => title.element(place(location, None)),
            None => Group::with_title(title),
        });
    }
    let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
    renderer.term_width(DEFAULT_TERM_WIDTH).render(&groups)
}

fn primary(problem: &Problem) -> Group<'_> {
    let title = Level::ERROR.primary_title(problem.0.message.as_str());
    let hint = Level::HELP.message(problem.0.hint.as_str());
    match &problem.0.location {
        Some(location) => title.element(place(location, problem.0.label.as_deref())).element(hint),
        None => title.element(hint),
    }
}

fn place<'a>(location: &'a Location, label: Option<&'a str>) -> Element<'a> {
    if location.source_line.is_empty() {
        return Origin::path(location.file.as_str()).line(location.line).char_column(location.column).into();
    }
    let mark = AnnotationKind::Primary.span(location.marked.clone());
    let mark = match label {
        Some(label) => mark.label(label),
        None => mark,
    };
    Snippet::source(location.source_line.as_str()).path(location.file.as_str()).line_start(location.line).annotation(mark).into()
}
