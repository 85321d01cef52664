//! Sparse square matrices, and linear systems with them.
//!
//! The Newton system of the doubled action is sparse, symmetric and indefinite. Its unknowns have an order in which all
//! entries are close to the diagonal: along the branches. An elimination in that order needs neither a search for
//! another one nor indices for what it fills in, only the [`Envelope`] of the matrix.
//!
//! ```
//! use geodesic_ivp::linalg::sparse::{Envelope, Pattern};
//!
//! // The rows (0, 1) and (1, 2), the last entry in two parts.
//! let pattern = Pattern::new(2, &[(0, 1), (1, 0), (1, 1), (1, 1)]);
//! let mut sum = pattern.sum();
//! [1.0, 1.0, 1.5, 0.5].into_iter().for_each(|part| sum.add(part));
//! let matrix = sum.matrix();
//! assert_eq!(matrix.multiply(&[2.0, 3.0]), [3.0, 8.0]);
//!
//! let mut b = [3.0, 8.0];
//! Envelope::new(&pattern, &[0, 1]).factor(&matrix)?.solve_in_place(&mut b);
//! assert_eq!(b, [2.0, 3.0]);
//! # Ok::<(), geodesic_ivp::linalg::banded::Singular>(())
//! ```

mod envelope;
mod matrix;

pub use envelope::{Envelope, Lu};
pub use matrix::{Pattern, SparseMatrix, Sum};
