//! Tables as arrays of records for NumPy, in its format NPY.
//!
//! An array is made of the finished table. It has the same columns and rows, and its numbers are the doubles that the
//! decimals of the table stand for.
//!
//! Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use csv::{Reader, ReaderBuilder, StringRecord};

/// The tables that are also written as arrays, each with the name of its array.
const ARRAYS: [(&str, &str); 12] = [
    ("trajectory.csv", "trajectory.npy"),
    ("residuals.csv", "residuals.npy"),
    ("branches.csv", "branches.npy"),
    ("samples.csv", "samples.npy"),
    ("events.csv", "events.npy"),
    ("sensitivity.csv", "sensitivity.npy"),
    ("growth.csv", "growth.npy"),
    ("hull.csv", "hull.npy"),
    ("until_failure.csv", "until_failure.npy"),
    ("runs.csv", "runs.npy"),
    ("runs-events.csv", "runs-events.npy"),
    ("runs-samples.csv", "runs-samples.npy"),
];
/// Tables are read and written in blocks of this many bytes.
const BUFFER: usize = 1 << 18;
/// Columns of text and of whole numbers. Coordinates and invariants may have these names, too, but stand behind them.
const TEXTS: [&str; 6] = ["event", "status", "ended_by", "verdict", "message", "proof_status"];
const WHOLE: [&str; 3] = ["row", "exit_code", "window"];
/// The tables that have columns of text.
const WITH_TEXTS: [&str; 3] = ["events.csv", "runs.csv", "runs-events.csv"];
/// A header ends at a multiple of this many bytes.
const ALIGNED: usize = 64;

/// The name of the array of a table.
///
/// # Panics
/// If it has none.
pub fn array_of(table: &str) -> &'static str {
    ARRAYS.iter().find(|(name, _)| *name == table).map(|(_, array)| *array).expect("the table has an array")
}

/// The kind of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// 64 bits.
    Integer,
    /// A double; an empty cell is NaN.
    Float,
    /// So many characters at most.
    Text(usize),
}

/// The meaning of a column, by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    Text,
    Integer,
    Float,
    /// A key that varies, whose values are anything.
    Any,
}

/// A column while its cells are looked through.
struct Column {
    name: String,
    known: Known,
    characters: usize,
    is_whole: bool,
    is_number: bool,
}

impl Column {
    fn see(&mut self, cell: &str) {
        self.characters = self.characters.max(cell.chars().count());
        let is_looked_at = self.known != Known::Text;
        self.is_whole &= is_looked_at && self.known != Known::Float && cell.parse::<i64>().is_ok();
        self.is_number &= is_looked_at && (self.is_whole || cell.is_empty() || cell.parse::<f64>().is_ok());
    }

    fn kind(&self) -> Kind {
        match self.known {
            Known::Text => Kind::Text(self.characters.max(1)),
            _ if !self.is_number => Kind::Text(self.characters.max(1)),
            Known::Integer | Known::Any if self.is_whole => Kind::Integer,
            _ => Kind::Float,
        }
    }
}

/// Writes a table of this name, which is in a file, as an array.
///
/// # Errors
/// If the table cannot be read, or the array cannot be written.
pub fn write_array(table: &str, csv: &File, out: impl Write) -> csv::Result<()> {
    let (names, rows, kinds) = looked_through(table, csv)?;
    let mut out = BufWriter::with_capacity(BUFFER, out);
    out.write_all(&header(&names, &kinds, rows))?;
    let (mut reader, mut record) = (reader(csv)?, StringRecord::new());
    while reader.read_record(&mut record)? {
        record.iter().zip(&kinds).try_for_each(|(cell, kind)| write_cell(&mut out, cell, *kind))?;
    }
    Ok(out.flush()?)
}

/// A reader of a table from its beginning.
fn reader(mut csv: &File) -> io::Result<Reader<&File>> {
    csv.seek(SeekFrom::Start(0))?;
    Ok(ReaderBuilder::new().buffer_capacity(BUFFER).from_reader(csv))
}

/// The names of the columns, the number of rows, and the kinds of the columns.
fn looked_through(table: &str, csv: &File) -> csv::Result<(Vec<String>, usize, Vec<Kind>)> {
    let mut reader = reader(csv)?;
    let mut columns: Vec<Column> = Vec::new();
    for name in reader.headers()? {
        // No array may have two columns of one name: the second one gets another.
        let mut unique = name.to_owned();
        while columns.iter().any(|other| other.name == unique) {
            unique.push('_');
        }
        let is_first = unique == name;
        let known = match name {
            _ if name.contains('.') => Known::Any,
            _ if is_first && WITH_TEXTS.contains(&table) && TEXTS.contains(&name) => Known::Text,
            _ if is_first && WHOLE.contains(&name) => Known::Integer,
            _ => Known::Float,
        };
        columns.push(Column { name: unique, known, characters: 0, is_whole: true, is_number: true });
    }
    let (mut record, mut rows) = (StringRecord::new(), 0);
    while reader.read_record(&mut record)? {
        rows += 1;
        columns.iter_mut().zip(&record).for_each(|(column, cell)| column.see(cell));
    }
    let kinds = columns.iter().map(Column::kind).collect();
    Ok((columns.into_iter().map(|column| column.name).collect(), rows, kinds))
}

/// All that stands before the records.
fn header(names: &[String], kinds: &[Kind], rows: usize) -> Vec<u8> {
    let field = |(name, kind): (&String, &Kind)| {
        let name = name.replace('\\', "\\\\").replace('\'', "\\'");
        match kind {
            Kind::Integer => format!("('{name}', '<i8')"),
            Kind::Float => format!("('{name}', '<f8')"),
            Kind::Text(characters) => format!("('{name}', '<U{characters}')"),
        }
    };
    let fields = names.iter().zip(kinds).map(field).collect::<Vec<_>>().join(", ");
    let mut text = format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({rows},), }}");
    // Version 1 has two bytes for the length and no other letters than those of ASCII, 2 and 3 have four, and 3 is in
    // UTF-8.
    let version: u8 = match text.len() {
        _ if !text.is_ascii() => 3,
        length if length + 2 * ALIGNED > usize::from(u16::MAX) => 2,
        _ => 1,
    };
    let before = if version == 1 { 10 } else { 12 };
    let length = (before + text.len() + 1).next_multiple_of(ALIGNED) - before;
    text.push_str(&" ".repeat(length - 1 - text.len()));
    text.push('\n');
    let mut header = [b"\x93NUMPY", &[version, 0][..]].concat();
    match version {
        1 => header.extend((length as u16).to_le_bytes()),
        _ => header.extend((length as u32).to_le_bytes()),
    }
    header.extend(text.as_bytes());
    header
}

/// Writes a cell, of which it is known that it is of this kind.
fn write_cell(out: &mut impl Write, cell: &str, kind: Kind) -> io::Result<()> {
    match kind {
        Kind::Integer => out.write_all(&cell.parse().unwrap_or(0_i64).to_le_bytes()),
        Kind::Float => out.write_all(&cell.parse().unwrap_or(f64::NAN).to_le_bytes()),
        Kind::Text(characters) => {
            let letters = cell.chars().map(u32::from).chain(std::iter::repeat(0)).take(characters);
            letters.map(u32::to_le_bytes).try_for_each(|letter| out.write_all(&letter))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header and the records of the array of a table.
    fn array(table: &str, text: &str) -> (String, Vec<u8>) {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        let mut bytes = Vec::new();
        write_array(table, &file, &mut bytes).unwrap();
        let (start, length) = match bytes[6] {
            1 => (10, usize::from(u16::from_le_bytes([bytes[8], bytes[9]]))),
            _ => (12, u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize),
        };
        assert!((start + length) % ALIGNED == 0 && bytes[start + length - 1] == b'\n');
        let header = String::from_utf8(bytes[start..start + length].to_vec()).unwrap();
        (header.trim_end().to_owned(), bytes[start + length..].to_vec())
    }

    #[test]
    fn columns_are_doubles_integers_or_texts() {
        let text = "row,grid.n,scheme.sbp,initial.x,status,x,message\n\
                    1,16,SBP21,1,converged,0.1,\n2,32,SBP42,0.5,größer,,\"a, b\"\n";
        let (header, records) = array("runs.csv", text);
        let fields = "('row', '<i8'), ('grid.n', '<i8'), ('scheme.sbp', '<U5'), ('initial.x', '<f8'), \
                      ('status', '<U9'), ('x', '<f8'), ('message', '<U4')";
        assert_eq!(header, format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': (2,), }}"));
        let size = 8 + 8 + 20 + 8 + 36 + 8 + 16;
        assert_eq!(records.len(), 2 * size);
        let double = |at: usize| f64::from_le_bytes(records[at..at + 8].try_into().unwrap());
        assert_eq!([double(36), double(80)], [1.0, 0.1]);
        assert!(double(size + 80).is_nan());
        let letters = records[size + 44..size + 80].chunks(4).map(|four| u32::from_le_bytes(four.try_into().unwrap()));
        assert_eq!(letters.filter_map(char::from_u32).collect::<String>(), "größer\0\0\0");
    }

    #[test]
    fn a_table_without_rows_has_the_same_columns() {
        let (header, records) = array("events.csv", "event,gamma,window\n");
        let fields = "('event', '<U1'), ('gamma', '<f8'), ('window', '<i8')";
        assert_eq!(header, format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': (0,), }}"));
        assert!(records.is_empty());
    }

    #[test]
    fn a_coordinate_may_have_any_name() {
        let (header, _) = array("trajectory.csv", "gamma,status,row,row\n0.0,1.0,2.0,3.0\n");
        assert!(header.contains("('status', '<f8'), ('row', '<f8'), ('row_', '<f8')"), "{header}");
        // Very many columns need a longer header.
        let names: Vec<String> = (0..5000).map(|k| format!("column_{k}")).collect();
        let row = vec!["0.5"; 5000].join(",");
        let (header, records) = array("sensitivity.csv", &format!("{}\n{row}\n", names.join(",")));
        assert!(header.contains("column_4999") && records.len() == 40_000);
    }
}
