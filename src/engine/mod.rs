//! What integrates motion window after window: weak spectral elements at speed, and what formulas do between their
//! nodes.

pub(crate) mod enclosure;
pub mod lobatto;
