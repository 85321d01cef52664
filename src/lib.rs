//! Initial value problems as geodesics, with an exactly conserved Noether charge and an emergent time mesh.
//!
//! The method is that of A. Rothkopf and J. Nordström, "A symmetry and Noether charge preserving discretization of
//! initial value problems" (2023), [arXiv:2307.04490](https://arxiv.org/abs/2307.04490).
//!
//! # The method
//!
//! A point mass m in a potential V(x) is a free particle in the space-time with the metric diag(g00(x), −1),
//! g00 = c² + 2V(x)/m. Its world-line (t(γ), x(γ)) makes the action ∫ ½ (g00(x) ṫ² − ẋ²) dγ stationary, where ˙ is
//! d/dγ, and has the constants of motion
//!
//! ```text
//! Q_t = g00(x) ṫ        (time translation)          K = g00(x) ṫ² − ẋ²        (length of the tangent).
//! ```
//!
//! Only γ is discretised, by a summation-by-parts operator D on N nodes; t stays a continuous variable, and the
//! symmetry under t → t + const survives. The world-line is doubled into a forward and a backward branch, which turns
//! the boundary value problem into an initial value problem. At the critical point of the doubled action both are the
//! same. In this *physical limit* its equations are the first-order collocation system
//!
//! ```text
//! (Dt)_k = Q_t/g00(x_k),    (Dx)_k = w_k,    (Dw)_k = −½ g00′(x_k) (Q_t/g00(x_k))²,       k = 1 … N−1,
//! ```
//!
//! so Q_t has its continuum value at every node but the last, and Lagrange multipliers say by how much that deviates.
//!
//! That is the paper's *strong* form. Its outlook asks for a *weak* one without multipliers: `form = "weak"` here. Its
//! physical limit is the same system with an invertible D̄ at *all* nodes: Q_t is exact at the last one too, the
//! initial data are met up to the truncation error, and t_N and x_N have the order of the interior stencil. [`action`]
//! has both actions, and `docs/method.md` derives all of this. See [`solve`](crate::solve()) for the two ways to
//! compute the critical point. Both are certified by the gradient of the doubled action itself.
//!
//! # Using the library
//!
//! ```
//! use geodesic_ivp::diagnostics::Diagnostics;
//! use geodesic_ivp::{Case, Solution, solve};
//!
//! let text = r#"
//!     potential.quartic.kappa = 0.5
//!     initial = { t = 0.0, x = 1.0, t_dot = 1.0, x_dot = 0.1 }
//!     grid = { gamma_f = 1.0, n_gamma = 32 }
//!     scheme.sbp = "SBP42"
//! "#;
//! let case = Case::parse("example", text, &[])?;
//! let solution: Solution = solve(&case)?;
//! let diagnostics = Diagnostics::new(&solution);
//!
//! assert!((solution.end_state().t - 1.468_700_371_198).abs() < 1e-11);
//! assert!(diagnostics.charges[0].max_interior < 1e-13);
//! assert!(solution.gradient_norm < 1e-10);
//!
//! // The same in forty digits: what was 1e-14 is a true zero.
//! use geodesic_ivp::number::{Extended, Real};
//! let case = Case::parse("example", text, &["solver.digits=40".to_owned()])?;
//! let solution: Solution<Extended> = solve(&case)?;
//! assert!(Diagnostics::new(&solution).charges[0].max_interior.to_f64() < 1e-36);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Scenes of several coordinates are solved in the same way. There is a solution or the reason why there is none, never
//! an unconverged trajectory:
//!
//! ```
//! use geodesic_ivp::case::builtin;
//! use geodesic_ivp::{Case, NoSolution, Solution, Status, solve};
//!
//! let case = Case::parse("horizon", builtin::text("horizon").expect("it is built in"), &[])?;
//! let result: Result<Solution, NoSolution> = solve(&case);
//! assert_eq!(result.expect_err("it falls into a horizon").status, Status::OutsideDomain);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The modules
//!
//! Where a name says so (`elapsed` for t, `length` for γ), t and γ count from the start of a run. Data flows one way: a
//! module imports only what stands above it in this table, which a test checks.
//!
//! | module | what it knows |
//! |---|---|
//! | [`number`] | `f64` and extended precision, what both offer, and vectors of the machine |
//! | [`formula`] | formulas: graph, derivatives, program |
//! | [`linalg`], [`sbp`] | elimination, and operators with exact coefficients, but no physics |
//! | [`geometry`] | scenes of n coordinates: metric, one-form and force as programs; V and g00 of one coordinate |
//! | [`engine`] | a fast march over windows of weak spectral elements; what formulas do between two nodes |
//! | [`mod@proof`] | where a motion ends, with a proved bound of the error |
//! | [`mod@reference`] | the trajectory to compare with, by a Taylor method |
//! | [`methods`] | other integrators to compare with |
//! | [`action`] | the doubled action E_IVP in both forms, its gradient and its sparse Hessian |
//! | [`mod@solve`] | Newton on ∇E_IVP = 0; the physical limit; every way it can end; knows a setup, but no case |
//! | [`diagnostics`] | charges, residuals, bound, sawtooth, gaps between nodes; never calls a solver |
//! | [`trajectory`] | values between the nodes, and events |
//! | [`case`] | the strict TOML case file, and the setup that it describes |
//! | [`study`] | the error of a run by a second solve; searches, sweeps and fits, on top of [`solve`](crate::solve()) |
//! | [`output`] | CSV, JSON and SVG; prints nothing |
//! | [`cli`] | arguments, messages and exit codes; alone touches the terminal |

// So that `cli` can refer to the library by its name, as any other program would.
extern crate self as geodesic_ivp;

pub mod action;
pub mod case;
// The doc comments of `cli` are the help texts of the command line, where <case> is a placeholder and not an HTML tag.
#[allow(rustdoc::invalid_html_tags)]
pub mod cli;
pub mod diagnostics;
pub mod engine;
pub mod formula;
pub mod geometry;
pub mod linalg;
pub mod methods;
pub mod number;
pub mod output;
pub mod proof;
pub mod reference;
pub mod sbp;
pub mod solve;
pub mod study;
pub mod trajectory;

pub use case::{Case, CaseError};
pub use solve::{NoSolution, Solution, Status, solve};
