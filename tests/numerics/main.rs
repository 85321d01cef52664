//! The mathematics: identities, published digits, symmetries, long runs. One binary, so that it links once.

mod action_derivatives;
mod adaptive;
mod common;
mod convergence;
mod elementary_functions;
mod extended;
mod formula;
mod invariances;
mod lobatto;
mod long_runs;
mod methods;
mod promises;
mod published_numbers;
mod random_verdicts;
mod reference;
mod sampling;
mod sbp_identities;
mod shipped_cases;
mod spectral_elements;
mod stability;
mod study_orders;
mod verdicts;
mod weak;
mod window_by_window;
mod windows;
mod work_precision;
