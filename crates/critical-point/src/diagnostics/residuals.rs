//! How well the nodes satisfy the second-order geodesic equations. In the strong form these are written with D, in the
//! weak form with D̄ and an initial value for every derivative.

/// Residuals of the geodesic equations on the nodes.
#[derive(Debug, Clone)]
pub struct GeodesicResiduals<S = f64> {
    /// ΔGᵗ = D( g00(x)∘Dt ); in the weak form D̄( g00(x)∘D̄t ) − H⁻¹e_1 Q_t.
    pub delta_g_t: Vec<S>,
    /// ΔGˣ = DDx + ½ g00′(x)∘(Dt)²; in the weak form D̄D̄x − H⁻¹e_1 ẋ_i + ½ g00′(x)∘(D̄t)².
    pub delta_g_x: Vec<S>,
}
