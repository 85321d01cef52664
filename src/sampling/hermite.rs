//! Quintic Hermite interpolation.

use crate::scalar::Real;

/// A function and its first two derivatives with respect to γ.
pub(super) type Jet<S> = [S; 3];

/// The quintic Hermite polynomial on [0, `h`], evaluated at `s`. The arguments are the function at both ends.
pub(super) fn hermite<S: Real>([f0, d0, c0]: Jet<S>, [f1, d1, c1]: Jet<S>, h: S, s: S) -> S {
    let number = |n: f64| S::from(n);
    let (change, d0, d1, c0, c1) = (f1 - f0, h * d0, h * d1, h * h * c0.half(), h * h * c1.half());
    // The coefficients in powers of s/h. From here on, c0 and c1 are halves of the second derivatives.
    let cubic = number(10.0) * change - number(6.0) * d0 - number(4.0) * d1 - number(3.0) * c0 + c1;
    let quartic = number(-15.0) * change + number(8.0) * d0 + number(7.0) * d1 + number(3.0) * c0 - number(2.0) * c1;
    let quintic = number(6.0) * change - number(3.0) * (d0 + d1) - c0 + c1;
    let s = s / h;
    f0 + s * (d0 + s * (c0 + s * (cubic + s * (quartic + s * quintic))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quintics_are_interpolated_exactly() {
        let f = |x: f64| 1.0 - 2.0 * x + x.powi(2) / 3.0 + x.powi(3) - x.powi(4) / 7.0 + 0.3 * x.powi(5);
        let d = |x: f64| -2.0 + 2.0 * x / 3.0 + 3.0 * x.powi(2) - 4.0 * x.powi(3) / 7.0 + 1.5 * x.powi(4);
        let c = |x: f64| 2.0 / 3.0 + 6.0 * x - 12.0 * x.powi(2) / 7.0 + 6.0 * x.powi(3);
        let jet = |x: f64| [f(x), d(x), c(x)];
        let (a, h) = (0.4, 0.7);
        for k in 0..=10 {
            let s = h * f64::from(k) / 10.0;
            assert!((hermite(jet(a), jet(a + h), h, s) - f(a + s)).abs() < 1e-14, "at {s}");
        }
    }
}
