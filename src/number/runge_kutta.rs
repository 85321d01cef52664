//! The classical Runge–Kutta method, to look ahead.

/// A step of the classical method of Runge and Kutta. `rates` gets the state of a stage and where its rates are to be
/// written.
pub(crate) fn runge_kutta<E>(
    state: &mut [f64],
    h: f64,
    mut rates: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
) -> Result<(), E> {
    let (mut slopes, mut trial) = ([(); 4].map(|()| vec![0.0; state.len()]), state.to_vec());
    rates(state, &mut slopes[0])?;
    for (stage, share) in [0.5, 0.5, 1.0].into_iter().enumerate() {
        let fields = trial.iter_mut().zip(&*state).zip(&slopes[stage]);
        fields.for_each(|((trial, state), slope)| *trial = state + share * h * slope);
        rates(&trial, &mut slopes[stage + 1])?;
    }
    let [k1, k2, k3, k4] = &slopes;
    for (field, value) in state.iter_mut().enumerate() {
        *value += h / 6.0 * (k1[field] + 2.0 * (k2[field] + k3[field]) + k4[field]);
    }
    Ok(())
}
