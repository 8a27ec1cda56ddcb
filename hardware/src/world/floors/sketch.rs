//! A floor in letters, for the head of its file.

use super::{Place, layout::Layout};

/// Letters from one column of the grid to the next.
const ACROSS: usize = 8;
/// Lines from one row of the grid to the next.
const DOWN: usize = 4;
/// Wider floors are not drawn.
const WIDEST: usize = 120;

/// Corridors as lines, places by their numbers; empty if the floor is too wide for a text.
pub(super) fn draw(layout: &Layout, places: &[Place]) -> String {
    let size = (ACROSS * (layout.x.len().max(1) - 1) + 4, DOWN * (layout.y.len().max(1) - 1) + 1);
    if size.0 > WIDEST {
        return String::new();
    }
    let mut lines = vec![vec![' '; size.0]; size.1];
    let locate = |[x, y]: [f64; 2]| (letters(&layout.x, x, ACROSS), size.1 - 1 - letters(&layout.y, y, DOWN));
    for run in &layout.runs {
        let ends = [run.nodes.first(), run.nodes.last()].map(|node| node.map_or((0, 0), |node| locate(layout.at(*node).into())));
        let [(left, low), (right, high)] = ends;
        let letter = if low == high { '-' } else { '|' };
        for line in &mut lines[high..=low] {
            line[left..=right].fill(letter);
        }
    }
    for (i, place) in places.iter().enumerate() {
        let (column, line) = locate(place.at);
        for (k, digit) in (i + 1).to_string().chars().enumerate() {
            lines[line][column + k] = digit;
        }
    }
    let line = |letters: Vec<char>| letters.into_iter().collect::<String>().trim_end().to_owned() + "\n";
    lines.into_iter().map(line).collect()
}

/// How many letters from the first line of the grid a coordinate is.
fn letters(lines: &[f64], at: f64, step: usize) -> usize {
    let before = lines.iter().rposition(|line| *line <= at + 1e-9).unwrap_or(0);
    let share = match lines.get(before + 1) {
        Some(next) => (at - lines[before]) / (next - lines[before]),
        None => 0.0,
    };
    before * step + (share.max(0.0) * step as f64).round() as usize
}
