//! Small tables, of which every row is a value of one type.

use std::io::Write;

use csv::Writer;

use crate::number::Real;

/// A table: its rows, and the names of its columns with the cells that a row has in them.
pub struct StudyTable<'c, R> {
    rows: &'c [R],
    columns: Vec<(String, Cell<'c, R>)>,
}

type Cell<'c, R> = Box<dyn Fn(&R) -> String + 'c>;

impl<'c, R> StudyTable<'c, R> {
    /// A table of these rows, without columns.
    pub(super) fn of(rows: &'c [R]) -> Self {
        Self { rows, columns: Vec::new() }
    }

    /// The same columns and one more.
    pub(super) fn with(mut self, name: impl Into<String>, cell: impl Fn(&R) -> String + 'c) -> Self {
        self.columns.push((name.into(), Box::new(cell)));
        self
    }

    /// The same columns and one more with numbers, which is empty where there is none.
    pub(super) fn with_number(self, name: impl Into<String>, number: impl Fn(&R) -> Option<f64> + 'c) -> Self {
        self.with(name, move |row| number(row).map_or_else(String::new, |number| number.to_decimal(f64::MOST_DIGITS)))
    }

    /// The same columns and one more for each of these names, with the numbers of its place.
    pub(super) fn with_each(
        self,
        names: impl Iterator<Item = String>,
        number: impl Fn(&R, usize) -> Option<f64> + Copy + 'c,
    ) -> Self {
        names.enumerate().fold(self, |table, (k, name)| table.with_number(name, move |row| number(row, k)))
    }

    /// Writes the header and the rows.
    ///
    /// # Errors
    /// If `out` cannot be written.
    pub fn write(&self, out: impl Write) -> csv::Result<()> {
        let mut writer = Writer::from_writer(out);
        writer.write_record(self.columns.iter().map(|(name, _)| name))?;
        let cells = |row| self.columns.iter().map(move |(_, cell)| cell(row));
        self.rows.iter().try_for_each(|row| writer.write_record(cells(row)))?;
        Ok(writer.flush()?)
    }
}
