//! Newton's method for a window, for when an evaluation of the force costs more than many products.

use pulp::Simd;

use super::State;
use super::force::{Force, evaluate_apart};
use super::product::product_apart;
use super::tables::Tables;
use super::window::{Precision, Window};
use crate::number::vector::{Nodes, abs, distance, largest, multiply_add, vectors, vectors_mut};

/// Newton's method takes four steps; if it takes more, it is unlikely to converge.
const MOST_NEWTON_STEPS: usize = 8;
/// Iterations for a correction.
const MOST_SWEEPS: usize = 40;

/// The largest (u′δ/u)²: about what u, continued by its slope, lacks relative to itself.
#[inline(always)]
fn bend<S: Simd>(s: S, du: &[f64], delta: &[f64], u: &[f64]) -> f64 {
    let (du, delta, u) = (vectors::<S>(du), vectors::<S>(delta), vectors::<S>(u));
    let mut most = s.splat_f64s(0.0);
    for i in 0..u.len() {
        most = s.max_f64s(most, abs(s, s.div_f64s(s.mul_f64s(du[i], delta[i]), u[i])));
    }
    let most = s.reduce_max_f64s(most);
    most * most
}

/// `a` − `b` in place of `a`.
#[inline(always)]
fn subtract<S: Simd>(s: S, a: &mut [f64], b: &[f64]) {
    let (a, b) = (vectors_mut::<S>(a), vectors::<S>(b));
    for i in 0..a.len() {
        a[i] = s.sub_f64s(a[i], b[i]);
    }
}

/// Solves δ = defect + h² A² a′ δ by iteration until δ is good to `enough`; whether that succeeds.
#[inline(always)]
fn correct<S: Simd, const P: usize>(
    s: S,
    t: &Tables<P>,
    [slope, defect]: [&Nodes<P>; 2],
    enough: f64,
    delta: &mut Nodes<P>,
) -> bool {
    let [mut next, mut image] = [const { Nodes::<P>::ZERO }; 2];
    delta.0 = defect.0;
    // The first iterate, the defect itself, is a change from zero.
    let mut change = largest(s, &defect.0);
    for sweeps in 1..=MOST_SWEEPS {
        {
            let (image, slope, delta) =
                (vectors_mut::<S>(&mut image.0), vectors::<S>(&slope.0), vectors::<S>(&delta.0));
            for i in 0..image.len() {
                image[i] = s.mul_f64s(slope[i], delta[i]);
            }
        }
        product_apart(s, &defect.0, &t.force[..t.columns], &image.0, &mut next.0);
        let before = change;
        change = distance(s, &next.0, &delta.0);
        std::mem::swap(delta, &mut next);
        // The first rate is that of another kind of change.
        let rate = if sweeps > 1 { (change / before).min(1.0) } else { 1.0 };
        if change * rate <= enough {
            return true;
        }
        if !change.is_finite() {
            return false;
        }
    }
    false
}

impl<const P: usize> Window<P> {
    /// Solves X = line + low + h² A² a(X): a correction δ to X solves δ = defect + h² A² a′(X) δ, by an iteration that
    /// needs the slopes a′ and no evaluation. Near the solution a and u need none either: their slopes continue them to
    /// X + δ. The number of evaluations after which a(X) and u(X) are known, or after which it is given up.
    #[inline(always)]
    pub(super) fn newton<S: Simd, F: Force>(
        &mut self,
        s: S,
        t: &Tables<P>,
        force: &mut F,
        low: &Nodes<P>,
        start: &State,
        precision: Precision,
    ) -> Result<usize, usize> {
        let mut slopes = [Nodes::<P>::ZERO, Nodes::<P>::ZERO];
        let [mut defect, mut delta] = [const { Nodes::<P>::ZERO }; 2];
        let mut last = f64::INFINITY;
        for evaluations in 1..=MOST_NEWTON_STEPS {
            self.add_up(s);
            evaluate_apart(s, force, &self.x.0, [&mut self.a.0, &mut self.u.0], false);
            let [da, du] = &mut slopes;
            force.slopes(s, [&self.a.0, &self.u.0], [&mut da.0, &mut du.0]);
            product_apart(s, &low.0, &t.force[..t.columns], &self.a.0, &mut defect.0);
            subtract(s, &mut defect.0, &self.rest.0);
            let scale = self.scale(t, start);
            let wanted = precision.tolerance * scale;
            // The correction need not be better than the step itself will be.
            let size = largest(s, &defect.0);
            let enough = (0.1 * wanted).max(0.1 * size * (size / scale));
            if !correct(s, t, [da, &defect], enough, &mut delta) {
                return Err(evaluations);
            }
            {
                let (rest, delta) = (vectors_mut::<S>(&mut self.rest.0), vectors::<S>(&delta.0));
                for i in 0..rest.len() {
                    rest[i] = s.add_f64s(rest[i], delta[i]);
                }
            }
            let size = largest(s, &delta.0);
            // The error of the step is its square times a number that two steps show; before, V is taken to vary on the
            // scale of the motion.
            let motion = (t.length.hi * start.w.hi).abs() + largest(s, &self.rest.0);
            let factor = (size / (last * last)).max(1.0 / motion);
            let error = if size == 0.0 { 0.0 } else { factor * size * size };
            if error <= 0.25 * wanted && bend(s, &du.0, &delta.0, &self.u.0) <= precision.tolerance {
                let (a, u) = (vectors_mut::<S>(&mut self.a.0), vectors_mut::<S>(&mut self.u.0));
                let (da, du, delta) = (vectors::<S>(&da.0), vectors::<S>(&du.0), vectors::<S>(&delta.0));
                for i in 0..a.len() {
                    a[i] = multiply_add(s, da[i], delta[i], a[i]);
                    u[i] = multiply_add(s, du[i], delta[i], u[i]);
                }
                self.add_up(s);
                return Ok(evaluations);
            }
            let shrinks = size <= 0.5 * last || evaluations < 3;
            if !shrinks {
                return Err(evaluations);
            }
            last = size;
        }
        Err(MOST_NEWTON_STEPS)
    }

    /// X = line + rest.
    #[inline(always)]
    fn add_up<S: Simd>(&mut self, s: S) {
        let (x, line, rest) = (vectors_mut::<S>(&mut self.x.0), vectors::<S>(&self.line.0), vectors::<S>(&self.rest.0));
        for i in 0..x.len() {
            x[i] = s.add_f64s(line[i], rest[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::bend;

    #[test]
    fn a_bend_is_the_square_of_the_largest_relative_change() {
        let (du, delta, u) = ([3.0, -8.0, 1.0, 0.0], [0.25, 0.5, 1.0, 7.0], [1.0, 2.0, 4.0, 0.5]);
        assert_eq!(bend(Scalar, &du, &delta, &u), 4.0);
    }
}
