//! Tables of text.

use super::style::{Paint, WIDTH, wrap_to};

/// Columns between two columns.
const GAP: usize = 2;
/// A column that takes what others leave is never narrower than this.
const NARROWEST: usize = 16;

/// Where a column's text stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
    /// Words that are broken into lines if the table becomes too wide.
    Wrap,
}

/// A table with a heading above each column. Columns that do not fit are put into further tables below, each with the
/// first column repeated.
#[derive(Debug, Default)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new<'a>(columns: impl IntoIterator<Item = (&'a str, Align)>) -> Self {
        Self { columns: columns.into_iter().map(|(name, align)| (name.to_owned(), align)).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells stay empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let mut cells: Vec<String> = cells.into_iter().collect();
        cells.resize(self.columns.len(), String::new());
        self.rows.push(cells);
    }

    /// The table, each line ended. `shade` may colour a cell that has been padded: row, column, text.
    pub fn render(&self, paint: Paint, shade: impl Fn(usize, usize, &str) -> String) -> String {
        let widths = self.widths();
        let mut text = String::new();
        for group in self.groups(&widths) {
            if !text.is_empty() {
                text.push('\n');
            }
            let heads: Vec<String> = self.columns.iter().map(|(name, _)| name.clone()).collect();
            self.put(&mut text, &group, &widths, &heads, |_, cell| paint.bold(cell));
            for (number, row) in self.rows.iter().enumerate() {
                self.put(&mut text, &group, &widths, row, |column, cell| shade(number, column, cell));
            }
        }
        text
    }

    /// The width of each column.
    fn widths(&self) -> Vec<usize> {
        let widest = |column: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(column));
            cells.chain(self.columns.get(column).map(|(name, _)| name)).map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let mut widths: Vec<usize> = (0..self.columns.len()).map(widest).collect();
        let elastic: Vec<usize> = (0..widths.len()).filter(|column| self.columns[*column].1 == Align::Wrap).collect();
        let gaps = GAP * widths.len().saturating_sub(1);
        // The widest gives way first.
        while widths.iter().sum::<usize>() + gaps > WIDTH {
            let Some(column) = elastic.iter().copied().max_by_key(|column| widths[*column]) else { break };
            if widths[column] <= NARROWEST {
                break;
            }
            widths[column] -= 1;
        }
        widths
    }

    /// Which columns stand side by side.
    fn groups(&self, widths: &[usize]) -> Vec<Vec<usize>> {
        let mut groups = vec![Vec::new()];
        let first = widths.first().copied().unwrap_or(0);
        let mut used = 0;
        for (column, width) in widths.iter().enumerate() {
            if used > first + GAP && used + width > WIDTH {
                groups.push(vec![0]);
                used = first + GAP;
            }
            if let Some(group) = groups.last_mut() {
                group.push(column);
            }
            used += width + GAP;
        }
        groups
    }

    fn put(&self, text: &mut String, group: &[usize], widths: &[usize], cells: &[String], shade: impl Fn(usize, &str) -> String) {
        let broken: Vec<Vec<String>> = group
            .iter()
            .map(|column| match self.columns[*column].1 {
                Align::Wrap => wrap_to(&cells[*column], 0, widths[*column]),
                Align::Left | Align::Right => vec![cells[*column].clone()],
            })
            .collect();
        let height = broken.iter().map(Vec::len).max().unwrap_or(0);
        for line in 0..height {
            let mut shown = String::new();
            // Spaces are held back until something follows them, so that no line ends with any.
            let mut blanks = 0;
            for (place, column) in group.iter().enumerate() {
                let cell = broken[place].get(line).map_or("", String::as_str);
                let free = widths[*column].saturating_sub(cell.chars().count());
                let (before, after) = if self.columns[*column].1 == Align::Right { (free, 0) } else { (0, free) };
                if cell.is_empty() {
                    blanks += widths[*column] + GAP;
                    continue;
                }
                shown.push_str(&" ".repeat(blanks + before));
                shown.push_str(&shade(*column, cell));
                blanks = after + GAP;
            }
            text.push_str(&shown);
            text.push('\n');
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(table: &Table) -> String {
        table.render(Paint::plain(), |_, _, cell| cell.to_owned())
    }

    #[test]
    fn numbers_stand_right_and_words_left() {
        let mut table = Table::new([("robot", Align::Left), ("distance", Align::Right)]);
        table.row(["ann".to_owned(), "12.0 m".to_owned()]);
        table.row(["bartholomew".to_owned()]);
        assert_eq!(plain(&table), "robot        distance\nann            12.0 m\nbartholomew\n");
    }

    #[test]
    fn long_words_are_broken_and_wide_tables_divided() {
        let mut table = Table::new([("row", Align::Wrap), ("goal", Align::Right)]);
        table.row([["word"; 40].join(" "), "= 0".to_owned()]);
        let text = plain(&table);
        assert!(text.lines().count() == 4 && text.lines().all(|line| line.len() <= WIDTH), "{text}");

        let names: Vec<String> = (0..11).map(|n| format!("column-{n:03}")).collect();
        let mut table = Table::new(names.iter().map(|name| (name.as_str(), Align::Left)));
        table.row((0..11).map(|n| n.to_string()));
        let text = plain(&table);
        assert!(text.lines().all(|line| line.len() <= WIDTH), "{text}");
        assert_eq!(text.matches("column-000").count(), 2);
        assert_eq!(text.matches("column-010").count(), 1);
    }
}
