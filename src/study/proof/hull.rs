//! Where the motions end whose starts lie in intervals.

use super::starts::Starts;
use crate::case::Case;
use crate::geometry::value_of;
use crate::number::{Extended, Real};
use crate::proof::{Until, prove};

/// The set of the ends, between two numbers for each coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// The coordinates, with the least and the largest value that they may have.
    pub ends: Vec<(String, [f64; 2])>,
    /// The number of windows of the proof.
    pub windows: usize,
}

/// Proves where the motions of a case with intervals end. `goes_on` hears after every window which part of the motion
/// is done, and may stop the proof.
///
/// # Errors
/// The reason why there is no proof.
pub fn hull(case: &Case, goes_on: &mut dyn FnMut(f64) -> bool) -> Result<Hull, String> {
    let parameters = &case.geometry_text.parameters;
    let end = |text: &String| value_of::<Extended>(text, parameters).map_err(|error| error.to_string());
    let (mut keys, mut middles, mut radii) = (Vec::new(), Vec::new(), Vec::new());
    for interval in &case.intervals {
        let [low, high] = [end(&interval.ends[0])?, end(&interval.ends[1])?];
        keys.push(interval.key.clone());
        middles.push((low + high).half());
        // A little more than it is.
        radii.push((high - low).half().to_f64().next_up());
    }
    let starts = Starts::new(case.text_of_run(), keys, middles)?;
    let generators = starts.generators(&radii)?;
    let geometry = starts.geometry(&generators);
    let motion = starts.motion(&geometry, &generators);
    let length = match motion.until {
        Until::Length(length) => length.to_f64(),
        Until::Value(..) => f64::NAN,
    };
    let proof = prove(&motion, &mut |progress| goes_on(progress.reached / length));
    proof.end.map_err(|reason| reason.to_string())?;
    let of = |(a, name): (usize, &String)| {
        let spread = proof.state[a].as_ref()?;
        let value = spread.value + starts.setup.origin_of(a);
        let reach = Extended::from(spread.reach().next_up());
        // Both are rounded outwards.
        let [low, high] = [value - reach, value + reach].map(Extended::to_f64);
        Some((name.clone(), [low.next_down().next_down(), high.next_up().next_up()]))
    };
    Ok(Hull { ends: geometry.names().iter().enumerate().filter_map(of).collect(), windows: proof.windows })
}
