//! `[tables]`: functions of one argument that are known by values, for the formulas of a case.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use super::CaseError;
use super::files::{MOST_OF_TABLE, read_file};
use super::names::NameTable;
use super::reader::Field;
use crate::geometry::GeometryText;
use crate::number::spline::{Kind, Outside, Table, TableError};
use crate::number::{Extended, Real};

/// A spline through more points takes gigabytes while it is made.
const MOST_POINTS: usize = 2_000_000;

/// The words for splines.
pub(super) const SPLINES: [(&str, Kind); 3] =
    [("cubic", Kind::Natural), ("clamped", Kind::Clamped), ("quintic", Kind::Quintic)];
/// The words for what is outside of the points.
pub(super) const OUTSIDE: [(&str, Outside); 2] = [("refused", Outside::Refused), ("linear", Outside::Linear)];

/// Reads `[tables]`. Their names must differ from all others in formulas of the scene.
pub(super) fn read(section: &Field<'_>, scene: &GeometryText) -> Result<Vec<(String, Table)>, CaseError> {
    let mut taken = NameTable::new(&scene.names());
    taken.extend(&scene.parameters, "a parameter");
    taken.extend(&scene.definitions, "a definition");
    let read = |field: Field<'_>| {
        taken.take(&field, "a table")?;
        Ok((field.key.clone(), table(&field)?))
    };
    section.fields().into_iter().map(read).collect()
}

/// A path, counted from the folder of the case.
pub(super) fn absolute(folder: &Path, path: impl AsRef<Path>) -> PathBuf {
    let beside = folder.join(path);
    std::path::absolute(&beside).unwrap_or(beside)
}

fn table(field: &Field<'_>) -> Result<Table, CaseError> {
    let (Some(x), Some(y)) = (field.get("x"), field.get("y")) else {
        let help = "give x = [numbers] and y = [numbers], or file = \"points.csv\" and the names of its columns";
        return Err(field.key_error("a table needs x and y").with_help(help));
    };
    let kind = field.given("spline", kind)?;
    let outside = field.given("outside", outside)?;
    let file = field.get("file");
    let rows = rows(file.as_ref(), &[&x, &y])?;
    let points: Vec<[Extended; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
    let mistake = |TableError(message, help)| file.as_ref().unwrap_or(&x).error(message).with_hint(help);
    Table::new(&points, kind, outside).map_err(mistake)
}

/// The value of `spline`.
pub(super) fn kind(field: &Field<'_>) -> Result<Kind, CaseError> {
    field.one_of("word", "\"cubic\" or \"clamped\" or \"quintic\"", &SPLINES)
}

/// The value of `outside`.
pub(super) fn outside(field: &Field<'_>) -> Result<Outside, CaseError> {
    field.one_of("word", "\"refused\" or \"linear\"", &OUTSIDE)
}

/// An unknown key of `[potential]`, with what to do where a table was meant.
pub(super) fn explain_table(error: CaseError) -> CaseError {
    let is_table = error.message.starts_with("unknown field `table`");
    let help = "write [tables] v = { x = [numbers], y = [numbers] }, and potential.formula = \"v(x)\"";
    error.with_hint(is_table.then(|| help.to_owned()))
}

/// The numbers of these columns, of which there is one at least, row by row: columns of a file, or else arrays.
pub(super) fn rows(file: Option<&Field<'_>>, columns: &[&Field<'_>]) -> Result<Vec<Vec<Extended>>, CaseError> {
    match file {
        Some(file) => from_file(file, columns),
        None => from_arrays(columns),
    }
}

fn from_arrays(columns: &[&Field<'_>]) -> Result<Vec<Vec<Extended>>, CaseError> {
    let arrays: Vec<Vec<String>> = columns.iter().map(|column| column.numbers()).collect::<Result<_, _>>()?;
    let count = arrays[0].len();
    if let Some((other, array)) = columns.iter().zip(&arrays).find(|(_, array)| array.len() != count) {
        let message = format!("{} has {count} numbers and {} has {}", columns[0].key, other.key, array.len());
        return Err(other.error(message).with_help("give one value for each argument"));
    }
    let number = |text: &String| Extended::from_decimal(text).expect("a number of the case is a decimal");
    Ok((0..count).map(|row| arrays.iter().map(|array| number(&array[row])).collect()).collect())
}

fn from_file(file: &Field<'_>, columns: &[&Field<'_>]) -> Result<Vec<Vec<Extended>>, CaseError> {
    let path = absolute(&file.source.folder, file.string()?);
    let unreadable = |error: &dyn Display| file.error(format!("cannot read the table {}: {error}", path.display()));
    let bytes = read_file(&path, MOST_OF_TABLE).map_err(|error| unreadable(&error))?;
    let cannot = |error: &csv::Error| unreadable(error);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes.as_slice());
    let heads = reader.headers().map_err(|error| cannot(&error))?.clone();
    let place = |column: &&Field<'_>| {
        let name = column.string()?;
        heads.iter().position(|head| head == name).ok_or_else(|| {
            let list = heads.iter().collect::<Vec<_>>().join(", ");
            let message = format!("the table {} has no column '{name}'", path.display());
            column.error(message).with_help(format!("its columns are {list}"))
        })
    };
    let places: Vec<usize> = columns.iter().map(place).collect::<Result<_, CaseError>>()?;
    let mut rows = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|error| cannot(&error))?;
        let line = row.position().map_or(0, csv::Position::line);
        let number = |place: &usize| {
            let text = row.get(*place).unwrap_or_default();
            Extended::from_decimal(text).filter(|number| number.is_finite()).ok_or_else(|| {
                file.error(format!("line {line} of {} has \"{text}\" where a number must be", path.display()))
            })
        };
        rows.push(places.iter().map(number).collect::<Result<Vec<_>, CaseError>>()?);
        if rows.len() > MOST_POINTS {
            let error = file.error(format!("the table {} has more than {MOST_POINTS} points", path.display()));
            return Err(error.with_help("leave points out where the function is smooth"));
        }
    }
    Ok(rows)
}
