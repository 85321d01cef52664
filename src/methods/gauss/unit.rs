//! The tables of the Gauss methods for a step of length 1, and the polynomials through their stages.

use std::sync::OnceLock;

/// The tables for a step of length 1, made once in the life of the program; matrices by columns.
pub(super) struct Unit {
    pub(super) c: Vec<f64>,
    pub(super) b: Vec<f64>,
    /// A, and A².
    pub(super) first: Vec<f64>,
    pub(super) square: Vec<f64>,
    /// Values of the interpolating polynomial at the nodes of the next step.
    pub(super) next: Vec<f64>,
    /// Coefficients of the interpolating polynomial: that of P_k over 2(2k + 1), as
    /// ∫P_k = (P_{k+1} − P_{k−1})/(2(2k + 1)) with P_{−1} = −1.
    modes: Vec<f64>,
}

/// P_0 … P_n at z.
fn legendre(n: usize, z: f64) -> Vec<f64> {
    let mut p = vec![1.0, z];
    for k in 1..n {
        p.push(((2 * k + 1) as f64 * z * p[k] - k as f64 * p[k - 1]) / (k + 1) as f64);
    }
    p
}

impl Unit {
    /// Most stages.
    const MOST: usize = 12;

    pub(super) fn shared(s: usize) -> &'static Self {
        static UNITS: [OnceLock<Unit>; Unit::MOST + 1] = [const { OnceLock::new() }; Unit::MOST + 1];
        UNITS[s].get_or_init(|| Self::new(s))
    }

    fn new(s: usize) -> Self {
        let slope = |p: &[f64], z: f64| s as f64 * (p[s - 1] - z * p[s]) / (1.0 - z * z);
        let node = |i: usize| {
            let mut z = -(std::f64::consts::PI * (i as f64 + 0.75) / (s as f64 + 0.5)).cos();
            for _ in 0..20 {
                let p = legendre(s, z);
                z -= p[s] / slope(&p, z);
            }
            z
        };
        let z: Vec<f64> = (0..s).map(node).collect();
        let c: Vec<f64> = z.iter().map(|z| 0.5 * (1.0 + z)).collect();
        let weight = |&z: &f64| {
            let slope = slope(&legendre(s, z), z);
            1.0 / ((1.0 - z * z) * slope * slope)
        };
        let b: Vec<f64> = z.iter().map(weight).collect();
        // A_ij = b_j Σ_k (2k+1) P_k(c_j) ∫_0^{c_i} P_k, exact for the polynomials that matter.
        let a = |i: usize, j: usize| {
            let (at_i, at_j) = (legendre(s + 1, z[i]), legendre(s, z[j]));
            let terms = (1..s).map(|k| at_j[k] * (at_i[k + 1] - at_i[k - 1]));
            0.5 * b[j] * (terms.sum::<f64>() + 1.0 + z[i])
        };
        let square = |i: usize, j: usize| (0..s).map(|k| a(i, k) * a(k, j)).sum::<f64>();
        let lagrange = |i: usize, j: usize| {
            let others = (0..s).filter(|&k| k != j);
            others.map(|k| (1.0 + c[i] - c[k]) / (c[j] - c[k])).product::<f64>()
        };
        let columns =
            |f: &dyn Fn(usize, usize) -> f64| (0..s).flat_map(|j| (0..s).map(move |i| f(i, j))).collect::<Vec<f64>>();
        // The norm of P_k cancels the denominator but for a half.
        let mode = |k: usize, j: usize| 0.5 * b[j] * legendre(s, z[j])[k];
        let modes = columns(&mode);
        Self {
            first: columns(&a),
            square: columns(&square),
            next: columns(&lagrange),
            modes,
            c: c.clone(),
            b: b.clone(),
        }
    }
}

/// Points that are computed together.
pub(super) const TOGETHER: usize = 8;

/// Differences P_{k+1} − P_{k−1} at 2s − 1 for several s, up to k = `degree`.
#[inline(always)]
pub(super) fn differences(degree: usize, s: [f64; TOGETHER]) -> [[f64; TOGETHER]; Unit::MOST + 1] {
    let mut out = [[0.0; TOGETHER]; Unit::MOST + 1];
    let (mut p, mut before) = ([1.0; TOGETHER], [-1.0; TOGETHER]);
    for (k, out) in out[..=degree].iter_mut().enumerate() {
        let (next, last) = ((2 * k + 1) as f64 / (k + 1) as f64, k as f64 / (k + 1) as f64);
        for l in 0..TOGETHER {
            let after = next * (2.0 * s[l] - 1.0) * p[l] - last * before[l];
            out[l] = after - before[l];
            (before[l], p[l]) = (p[l], after);
        }
    }
    out
}

/// The coefficients of the polynomial through the values of `v` at the stages.
#[inline(always)]
pub(super) fn modes<const S: usize>(unit: &Unit, v: &[f64; S]) -> [f64; S] {
    let mut modes = [0.0; S];
    for (column, v) in unit.modes.chunks_exact(S).zip(v) {
        for k in 0..S {
            modes[k] += column[k] * v;
        }
    }
    modes
}

/// The integral of a polynomial over [0, s] for several s.
#[inline(always)]
pub(super) fn once<const S: usize>(
    modes: &[f64; S],
    differences: &[[f64; TOGETHER]; Unit::MOST + 1],
) -> [f64; TOGETHER] {
    let mut out = [0.0; TOGETHER];
    for (mode, difference) in modes.iter().zip(differences) {
        for l in 0..TOGETHER {
            out[l] += mode * difference[l];
        }
    }
    out
}

/// The integral of that integral.
#[inline(always)]
pub(super) fn twice<const S: usize>(
    modes: &[f64; S],
    differences: &[[f64; TOGETHER]; Unit::MOST + 1],
) -> [f64; TOGETHER] {
    let mut out = [0.0; TOGETHER];
    for (k, difference) in differences[..=S].iter().enumerate() {
        let share = 0.5 / (2 * k + 1) as f64;
        let [before, after] = [modes[k.saturating_sub(1)], modes.get(k + 1).copied().unwrap_or(0.0)];
        let mode = share * (before - after);
        for l in 0..TOGETHER {
            out[l] += mode * difference[l];
        }
    }
    out
}
