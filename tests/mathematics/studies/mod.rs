//! Studies of many runs: orders, maps and charts of all methods, and what the verdict says of random scenes.

mod atlas;
mod convergence;
mod families;
mod find;
mod find_proved;
mod find_published;
mod orders;
mod random_verdicts;
mod stability;
mod work_precision;

use geodesic_ivp::study::stability::{Arena, Atlas, Method, Plan, measure};

/// The map of these methods.
fn charted(arena: &Arena, methods: Vec<Method>, lengths: &[f64], spacings: &[f64]) -> Atlas {
    let plan = Plan { methods, lengths: lengths.to_vec(), tangents: vec![1.0], spacings: spacings.to_vec() };
    let atlas = measure(arena, &plan, &|_, _| {});
    assert!(!atlas.interrupted);
    atlas
}
