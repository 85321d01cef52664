//! Numbers of the start, and parameters, that are given as intervals: `x = [0.99, 1.01]`. A run takes the middle, and a
//! proof all of it.

use std::cmp::Ordering;

use super::CaseError;
use super::keys::PARAMETERS;
use super::reader::Field;
use crate::geometry::{uses, value_of, with_dependent};

/// A number of the start, or a parameter, between two ends, as formulas.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interval {
    /// Its dotted key.
    pub key: String,
    /// The lower end and the upper one.
    pub ends: [String; 2],
}

impl Field<'_> {
    /// The two ends of the interval that the value is, if it is an array.
    fn interval(&self) -> Result<Option<[String; 2]>, CaseError> {
        if !self.is_array() {
            return Ok(None);
        }
        let ends: Result<[String; 2], _> = self.formulas()?.try_into();
        let wrong = |all: Vec<String>| {
            let help = "an interval has a lower end and an upper one: [0.99, 1.01]";
            let found = all.len();
            let message = format!("'{}' must be a number, a formula or two ends, found an array of {found}", self.path);
            self.error(message).with_help(help)
        };
        ends.map(Some).map_err(wrong)
    }

    /// The number or formula that the value is, or the middle of the interval.
    pub(super) fn number_of_start(&self) -> Result<String, CaseError> {
        let middle = |[low, high]: [String; 2]| format!("(({low}) + ({high}))/2");
        self.interval()?.map_or_else(|| self.formula(), |ends| Ok(middle(ends)))
    }
}

/// The intervals of a case with these parameters.
pub(super) fn intervals(root: &Field<'_>, parameters: &[(String, String)]) -> Result<Vec<Interval>, CaseError> {
    let (mut found, mut wide) = (Vec::new(), Vec::new());
    let tables = [root.table(PARAMETERS), root.table("initial")].map(|table| table.fields());
    for field in &tables[0] {
        wide.extend(field.interval()?.map(|_| field.key.clone()));
    }
    let wide = with_dependent(parameters, wide);
    for field in tables.iter().flatten() {
        let Some(ends) = field.interval()? else { continue };
        if let Some(other) = wide.iter().find(|other| ends.iter().any(|end| uses(end, other))) {
            let message = format!("an end of the interval '{}' depends on '{other}', which is no number", field.path);
            return Err(field.error(message).with_help("give ends that no other interval changes"));
        }
        let values = [0, 1].map(|end| value_of::<f64>(&ends[end], parameters).unwrap_or(f64::NAN));
        if values[0].partial_cmp(&values[1]) != Some(Ordering::Less) {
            let message = format!("the interval from {} to {} has no inside", ends[0], ends[1]);
            return Err(field.error(message).with_help("give the lower end first"));
        }
        found.push(Interval { key: field.path.clone(), ends });
    }
    Ok(found)
}
