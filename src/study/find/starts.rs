//! Searches from several starts, and which of them have found the same.

use rayon::prelude::*;

use super::{Found, NotFound, find};
use crate::case::CaseError;
use crate::study::many::ManyRuns;

/// Numbers that differ by no more than so many times their errors are the same.
const SAME: f64 = 10.0;

/// What a search from one of several starts has come to.
#[derive(Debug)]
pub enum FromStart {
    /// It has found something.
    Found(Box<Found>),
    /// It has not.
    NotFound(NotFound),
    /// There is no such case, or it has nothing to find.
    Invalid(CaseError),
}

impl FromStart {
    /// What was found, if something was.
    pub fn found(&self) -> Option<&Found> {
        if let Self::Found(found) = self { Some(found) } else { None }
    }
}

/// Searches from each of these cases. `tell` hears when one is done, in any order.
pub fn find_each(starts: &ManyRuns, tell: &(dyn Fn() + Sync)) -> Vec<FromStart> {
    let one = |run: usize| {
        let result = match starts.case(run) {
            Ok(case) => match &case.find {
                Some(wanted) => match find(&case, wanted, false, &mut |_| {}) {
                    Ok(found) => FromStart::Found(Box::new(found)),
                    Err(none) => FromStart::NotFound(none),
                },
                None => FromStart::Invalid(CaseError::without_place("the case", "there is nothing to find".to_owned())),
            },
            Err(error) => FromStart::Invalid(error),
        };
        tell();
        result
    };
    (0..starts.len()).into_par_iter().map(one).collect()
}

/// The number of the solution that each search has found, from 1 on in their order: those that agree up to their errors
/// are one.
pub fn solutions(searches: &[FromStart]) -> Vec<Option<usize>> {
    let mut known: Vec<&Found> = Vec::new();
    let is_same = |one: &Found, other: &Found| {
        let errors = one.errors.iter().zip(&other.errors);
        let mut all = one.values.iter().zip(&other.values).zip(errors);
        all.all(|((a, b), (error, other))| (a - b).abs() <= SAME * (error + other))
    };
    let mut numbers = Vec::with_capacity(searches.len());
    for search in searches {
        numbers.push(search.found().map(|found| {
            let place = known.iter().position(|other| is_same(found, other));
            1 + place.unwrap_or_else(|| {
                known.push(found);
                known.len() - 1
            })
        }));
    }
    numbers
}
