//! Small tables, of which every row is a value of one type.

use std::io::Write;

use csv::Writer;

use crate::number::Real;

/// The columns of a table: their names, and the cells that a row has in them.
pub(super) struct StudyTable<'c, R>(Vec<(String, Cell<'c, R>)>);

type Cell<'c, R> = Box<dyn Fn(&R) -> String + 'c>;

impl<'c, R> StudyTable<'c, R> {
    pub(super) fn new() -> Self {
        Self(Vec::new())
    }

    /// The same columns and one more.
    pub(super) fn with(mut self, name: impl Into<String>, cell: impl Fn(&R) -> String + 'c) -> Self {
        self.0.push((name.into(), Box::new(cell)));
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

    /// Writes a header, and these rows.
    pub(super) fn write(&self, out: impl Write, rows: &[R]) -> csv::Result<()> {
        let mut writer = Writer::from_writer(out);
        writer.write_record(self.0.iter().map(|(name, _)| name))?;
        rows.iter().try_for_each(|row| writer.write_record(self.0.iter().map(|(_, cell)| cell(row))))?;
        Ok(writer.flush()?)
    }
}
