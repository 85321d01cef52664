//! The table of a set of motions.

use std::io::Write;

use csv::Writer;

use crate::number::{Extended, Real};
use crate::study::proof::OnWay;

/// The digits of a γ that no double is.
const DIGITS: u32 = 40;

/// What the columns of the least and the largest value of a coordinate begin with.
pub(crate) const HULL: [&str; 2] = ["hull_low_", "hull_high_"];

/// The columns of the least and the largest value of these coordinates.
pub(crate) fn hull_header(names: &[String]) -> impl Iterator<Item = String> {
    names.iter().flat_map(|name| HULL.map(|end| format!("{end}{name}")))
}

/// γ in the digits of a double if that is it, and else in so many that what is left moves nothing.
fn decimal(gamma: Extended) -> String {
    let double = gamma.to_f64();
    let is_double = Extended::from(double) == gamma;
    if is_double { double.to_decimal(f64::MOST_DIGITS) } else { gamma.to_decimal(DIGITS) }
}

/// Writes `hull.csv`: gamma, and between which values every coordinate is there in all motions from the intervals of a
/// case. A cell is empty where that is not known.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_hull(out: impl Write, names: &[String], way: &[OnWay]) -> csv::Result<()> {
    let mut writer = Writer::from_writer(out);
    writer.write_record(std::iter::once("gamma".to_owned()).chain(hull_header(names)))?;
    for OnWay { gamma, ends } in way {
        let ends = ends[..names.len()].iter().flat_map(|ends| match ends {
            Some(ends) => ends.map(|end| end.to_decimal(f64::MOST_DIGITS)),
            None => [String::new(), String::new()],
        });
        writer.write_record(std::iter::once(decimal(*gamma)).chain(ends))?;
    }
    Ok(writer.flush()?)
}
