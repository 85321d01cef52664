//! The classical Runge–Kutta method, for first guesses and to look ahead.

/// A step of the classical method of Runge and Kutta. `rates` gets the stage from 0, the state there and where its
/// rates are to be written.
pub(crate) fn runge_kutta<E>(
    state: &mut [f64],
    h: f64,
    slopes: &mut [Vec<f64>; 4],
    mut rates: impl FnMut(usize, &[f64], &mut [f64]) -> Result<(), E>,
) -> Result<(), E> {
    let mut trial = state.to_vec();
    for (stage, share) in [0.0, 0.5, 0.5, 1.0].into_iter().enumerate() {
        if let Some(before) = stage.checked_sub(1) {
            let fields = trial.iter_mut().zip(&*state).zip(&slopes[before]);
            fields.for_each(|((trial, state), slope)| *trial = state + share * h * slope);
        }
        rates(stage, &trial, &mut slopes[stage])?;
    }
    let [k1, k2, k3, k4] = &*slopes;
    for (field, value) in state.iter_mut().enumerate() {
        *value += h / 6.0 * (k1[field] + 2.0 * (k2[field] + k3[field]) + k4[field]);
    }
    Ok(())
}
