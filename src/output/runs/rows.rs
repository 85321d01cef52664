//! Tables whose rows begin with their numbers, and where each row stands in its file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::Context;
use csv::{ReaderBuilder, StringRecord};

use super::RunsSummary;

/// Tables are written in blocks of this many bytes.
const BUFFER: usize = 1 << 18;

/// A CSV file whose records begin with the number of a row; several records of a row follow each other.
#[derive(Debug)]
pub(super) struct RowFile {
    pub(super) path: PathBuf,
    file: File,
    pub(super) header: StringRecord,
    places: BTreeMap<usize, Range<u64>>,
    /// Where the last whole record ends.
    length: u64,
}

impl RowFile {
    /// Finds the rows of a file that begin at byte `begin` with a header. A record that is torn, and what is after it,
    /// does not count.
    pub(super) fn read(path: &Path, mut file: File, begin: u64) -> anyhow::Result<Self> {
        let cannot = || format!("cannot read {}", path.display());
        let size = file.seek(SeekFrom::End(0)).with_context(cannot)?;
        let mut last = [b'\n'];
        if size > 0 {
            file.seek(SeekFrom::End(-1)).and_then(|_| file.read_exact(&mut last)).with_context(cannot)?;
        }
        file.seek(SeekFrom::Start(begin)).with_context(cannot)?;
        let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(BufReader::new(&file));
        let (mut header, mut record) = (StringRecord::new(), StringRecord::new());
        let (mut places, mut length): (BTreeMap<usize, Range<u64>>, u64) = (BTreeMap::new(), begin);
        // Text that was cut in the middle of a character is torn, too.
        while reader.read_record(&mut record).unwrap_or(false) {
            let end = begin + reader.position().byte();
            let is_torn = end == size && last != *b"\n";
            if length == begin && !is_torn {
                header = record.clone();
            } else if let Some(number) = record[0].parse().ok().filter(|_| !is_torn && record.len() == header.len()) {
                places.entry(number).and_modify(|place| place.end = end).or_insert(length..end);
            } else {
                break;
            }
            length = end;
        }
        drop(reader);
        Ok(Self { path: path.to_owned(), file, header, places, length })
    }

    /// The table of that name in a folder; `None` if there is none.
    pub(super) fn open(folder: &Path, name: &str) -> anyhow::Result<Option<Self>> {
        let path = folder.join(name);
        if !path.exists() {
            return Ok(None);
        }
        let file = File::open(&path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::read(&path, file, 0).map(Some)
    }

    /// The numbers of its rows, in ascending order.
    pub(super) fn numbers(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.places.keys().copied()
    }

    pub(super) fn has(&self, row: usize) -> bool {
        self.places.contains_key(&row)
    }

    /// Cuts off the records of rows that are not `wanted`, which must be its last ones, and what is torn.
    pub(super) fn cut(&mut self, wanted: impl Fn(usize) -> bool) -> anyhow::Result<()> {
        let unwanted = self.places.iter().filter(|(row, _)| !wanted(**row)).map(|(_, place)| place.start);
        self.length = unwanted.min().unwrap_or(self.length);
        self.places.retain(|_, place| place.end <= self.length);
        self.written(self.file.set_len(self.length))
    }

    /// Begins the file with these lines, the last of which is the header.
    pub(super) fn begin(&mut self, first: &[u8], header: &[String]) -> anyhow::Result<()> {
        self.places.clear();
        self.length = 0;
        self.cut(|_| true)?;
        self.header = StringRecord::from(header.to_vec());
        self.append(None, &[first, &line_of(header.iter().map(String::as_str))].concat())
    }

    /// Appends the records of a row.
    pub(super) fn append(&mut self, row: Option<usize>, records: &[u8]) -> anyhow::Result<()> {
        let mut file = &self.file;
        self.written(file.seek(SeekFrom::Start(self.length)).and_then(|_| file.write_all(records)))?;
        let end = self.length + records.len() as u64;
        if let Some(row) = row.filter(|_| !records.is_empty()) {
            self.places.insert(row, self.length..end);
        }
        self.length = end;
        Ok(())
    }

    /// Brings it to the disk.
    pub(super) fn sync(&self) -> anyhow::Result<()> {
        self.written(self.file.sync_data())
    }

    fn written(&self, done: io::Result<()>) -> anyhow::Result<()> {
        done.with_context(|| format!("cannot write {}", self.path.display()))
    }

    /// The records of a row; nothing if it has none.
    pub(super) fn row(&mut self, row: usize) -> anyhow::Result<Vec<u8>> {
        let Some(place) = self.places.get(&row) else { return Ok(Vec::new()) };
        let mut records = vec![0; (place.end - place.start) as usize];
        self.file
            .seek(SeekFrom::Start(place.start))
            .and_then(|_| self.file.read_exact(&mut records))
            .with_context(|| format!("cannot read row {row} of {}", self.path.display()))?;
        Ok(records)
    }
}

/// A record as a line of CSV.
pub(super) fn line_of<'c>(cells: impl IntoIterator<Item = &'c str>) -> Vec<u8> {
    let mut line = Vec::new();
    write_line(cells, &mut line);
    line
}

/// Writes a record as a line of CSV, with quotes around cells that need them. A writer for all dialects is made of
/// tables, which take longer than a line.
pub(super) fn write_line<'c>(cells: impl IntoIterator<Item = &'c str>, lines: &mut Vec<u8>) {
    let begin = lines.len();
    for (place, cell) in cells.into_iter().enumerate() {
        lines.extend((place > 0).then_some(b','));
        if cell.contains(['"', ',', '\r', '\n']) {
            lines.extend(format!("\"{}\"", cell.replace('"', "\"\"")).bytes());
        } else {
            lines.extend_from_slice(cell.as_bytes());
        }
    }
    // Readers skip an empty line, and a record of one empty cell would be one: quotes make it a record.
    if lines.len() == begin {
        lines.extend_from_slice(b"\"\"");
    }
    lines.push(b'\n');
}

/// Writes the rows of `order`, each with the place of its source, to tables, which have names: the first has the rows,
/// and the others what a row has several of. A source has a file for each. The rows are counted in the summary. Returns
/// the cells of each of some columns, in their order.
pub(super) fn write<W: Write>(
    sources: &mut [&mut Vec<RowFile>],
    order: impl Iterator<Item = (usize, usize)>,
    tables: Vec<(&str, W)>,
    summary: &mut RunsSummary,
    columns: &[String],
) -> anyhow::Result<Vec<Vec<String>>> {
    let cannot = |name: &str| format!("cannot write {name}");
    let tables = tables.into_iter().map(|(name, table)| (name, BufWriter::with_capacity(BUFFER, table)));
    let mut tables: Vec<_> = tables.collect();
    for ((name, out), table) in tables.iter_mut().zip(&*sources[0]) {
        out.write_all(&line_of(&table.header)).with_context(|| cannot(name))?;
    }
    let header = sources[0][0].header.clone();
    let places: Vec<_> = columns.iter().map(|name| header.iter().position(|cell| cell == name)).collect();
    let (mut wanted, mut lines) = (vec![Vec::new(); columns.len()], Vec::new());
    let mut count = |lines: &mut Vec<u8>| {
        summary.see(&header, lines, |cells| {
            let cell = |place: Option<usize>| place.and_then(|place| cells.get(place)).unwrap_or_default().to_owned();
            wanted.iter_mut().zip(&places).for_each(|(cells, place)| cells.push(cell(*place)));
        });
        lines.clear();
    };
    for (row, source) in order {
        for (place_of_table, ((name, out), table)) in tables.iter_mut().zip(sources[source].iter_mut()).enumerate() {
            let records = table.row(row)?;
            out.write_all(&records).with_context(|| cannot(name))?;
            if place_of_table == 0 {
                lines.extend_from_slice(&records);
            }
        }
        // They are read again in blocks, for each of which there is a reader.
        if lines.len() > BUFFER {
            count(&mut lines);
        }
    }
    count(&mut lines);
    tables.iter_mut().try_for_each(|(name, out)| out.flush().with_context(|| cannot(name)))?;
    Ok(wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_those_of_a_writer_for_all_dialects() {
        let records: [&[&str]; 6] =
            [&["1", "x, y", "a"], &["a \"quoted\" word", ""], &[""], &["", ""], &["two\nlines", "\r"], &["#", " b "]];
        for cells in records {
            let mut writer = csv::Writer::from_writer(Vec::new());
            writer.write_record(cells).unwrap();
            assert_eq!(line_of(cells.iter().copied()), writer.into_inner().unwrap(), "{cells:?}");
        }
    }
}
