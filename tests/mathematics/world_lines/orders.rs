//! Orders of convergence at γ_f, in both forms: 2, 3, 4, 6 at least for SBP21, 42, 63, 84 and 2n − 2 for elements.
