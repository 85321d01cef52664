//! Each lemma of a window by itself, on Hénon and Heiles' motion written out by hand: what is bounded is computed in
//! another way, and is never above the bound, nor far below it where the bound is to be sharp.

use super::approximate::Approximate;
use super::defect::Defect;
use super::ellipse::Ellipse;
use super::matrices::{Matrices, inverse};
use super::proved::{Added, Proved};
use super::set::{Differences, Set, Zonotope};
use super::tests::henon_heiles;
use super::window::Prover;
use super::*;
use crate::geometry::{Geometry, Start};
use crate::number::Real;

/// The length of the window.
const H: f64 = 0.5;

type Complex = [f64; 2];

fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn plus([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a + c, b + d]
}

fn by([a, b]: Complex, factor: f64) -> Complex {
    [a * factor, b * factor]
}

fn size([a, b]: Complex) -> f64 {
    a.hypot(b)
}

/// f of x, y and their momenta, which are `c` times the velocities.
fn slopes(c: f64, [x, y, p, s]: [Complex; 4]) -> [Complex; 4] {
    let force_x = plus(x, by(times(x, y), 2.0));
    let force_y = plus(plus(y, times(x, x)), by(times(y, y), -1.0));
    [by(p, 1.0 / c), by(s, 1.0 / c), by(force_x, -c), by(force_y, -c)]
}

/// The entry of J.
fn jacobian(c: f64, [x, y, ..]: [Complex; 4], row: usize, column: usize) -> Complex {
    let one = [1.0, 0.0];
    match (row, column) {
        (0, 2) | (1, 3) => by(one, 1.0 / c),
        (2, 0) => by(plus(one, by(y, 2.0)), -c),
        (3, 1) => by(plus(one, by(y, -2.0)), -c),
        (2, 1) | (3, 0) => by(x, -2.0 * c),
        _ => [0.0; 2],
    }
}

/// P_k and their integrals from −1 at a place.
fn legendre(z: Complex) -> (Vec<Complex>, Vec<Complex>) {
    let mut p: Vec<Complex> = vec![[1.0, 0.0], z];
    for k in 1..33_usize {
        let next = plus(by(times(z, p[k]), (2 * k + 1) as f64), by(p[k - 1], -(k as f64)));
        p.push(by(next, 1.0 / (k + 1) as f64));
    }
    let integral = |k: usize| match k {
        0 => plus([1.0, 0.0], z),
        _ => by(plus(p[k + 1], by(p[k - 1], -1.0)), 1.0 / (2 * k + 1) as f64),
    };
    let integrals = (0..32).map(integral).collect();
    (p, integrals)
}

/// Numbers that look random, in [−1, 1].
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn sign(&mut self) -> f64 {
        if self.unit() < 0.0 { -1.0 } else { 1.0 }
    }
}

/// Does something with the window from a start that is off by at most `rest`, and p/q̇.
pub(super) fn with_window<T>(rest: f64, work: impl FnOnce(&mut Prover<'_>, &Set, f64) -> T) -> T {
    let scene = henon_heiles("100");
    let geometry: Geometry<Extended> = Geometry::new(&scene.text).unwrap();
    let (q, q_dot) = (scene.numbers(scene.q), scene.numbers("1, 0.2, 0.5, 0"));
    let start = Start { p: geometry.momenta(&q, &q_dot), q, q_dot };
    let c = (start.p[1] / start.q_dot[1]).to_f64();
    let equations = Equations::new(&geometry, &start, [Some(3), None], &[]);
    assert_eq!(equations.of, [(1, false), (2, false), (1, true), (2, true)]);
    let mut set = Set::new(&equations, equations.columns(&[]).unwrap());
    set.errors.rest.fill(rest);
    let (approximate, defect) = (Approximate::new(&equations), Defect::new(&equations));
    let ellipse = Ellipse::new(&equations);
    work(&mut Prover { equations, approximate, defect, ellipse }, &set, c)
}

fn proved(prover: &mut Prover<'_>, set: &Set) -> Proved {
    prover.window(set, H).unwrap_or_else(|_| panic!("a window of {H} is proved"))
}

/// y and v at a place, by their coefficients.
fn motion((start, h): (&[f64], f64), modes: &[algebras::Row], z: Complex) -> ([Complex; 4], [Complex; 4]) {
    let (p, integrals) = legendre(z);
    let sum = |k: usize, of: &[Complex]| modes[k].iter().zip(of).fold([0.0; 2], |sum, (c, p)| plus(sum, by(*p, *c)));
    let y = std::array::from_fn(|k| plus([start[k], 0.0], by(sum(k, &integrals), 0.5 * h)));
    (y, std::array::from_fn(|k| sum(k, &p)))
}

#[test]
fn bounds_hold_on_the_ellipse_and_within_it() {
    let mut random = Random(1);
    with_window(0.0, |prover, set, c| {
        let Proved { bounds, modes, .. } = proved(prover, set);
        let mut largest = [0.0_f64; 4];
        for i in 0..600 {
            let angle = std::f64::consts::TAU * f64::from(i) / 600.0;
            let rho = if i % 3 == 0 { 1.0 + random.unit().abs() * 2.0 } else { 3.0 };
            let z = [0.5 * (rho + 1.0 / rho) * angle.cos(), 0.5 * (rho - 1.0 / rho) * angle.sin()];
            let (y, v) = motion((&set.start, H), &modes, z);
            let defect = slopes(c, y).into_iter().zip(v).map(|(f, v)| size(plus(f, by(v, -1.0))));
            let e = bounds.reach.iter().map(|reach| {
                let phase = 4.0 * random.unit();
                [reach * phase.cos(), reach * phase.sin()]
            });
            let (mut there, mut opposite) = (y, y);
            for ((there, opposite), e) in there.iter_mut().zip(&mut opposite).zip(e) {
                (*there, *opposite) = (plus(*there, e), plus(*opposite, by(e, -1.0)));
            }
            let slope = slopes(c, there).map(size);
            for (k, defect) in defect.enumerate() {
                assert!(defect <= bounds.defect[k] && slope[k] <= bounds.slope[k], "{k} at {z:?}");
                largest[0] = largest[0].max(slope[k] / bounds.slope[k]);
            }
            let at = |place| prover.equations.entries.iter().map(move |e| jacobian(c, place, e.row, e.column));
            let entries: Vec<Complex> = at(there).collect();
            for (entry, most) in entries.iter().zip(&bounds.jacobian) {
                assert!(size(*entry) <= *most * (1.0 + 1e-14), "{entry:?} {most}");
                largest[1] = largest[1].max(size(*entry) / most);
            }
            for ((one, other), spread) in entries.into_iter().zip(at(opposite)).zip(&bounds.spread) {
                let gap = size(plus(one, by(other, -1.0)));
                assert!(gap <= 2.0 * spread + 1e-15, "{gap} {spread}");
                largest[2] = largest[2].max(gap / (2.0 * spread + 1e-15));
            }
        }
        assert!(largest[..3].iter().all(|share| *share > 0.4), "{largest:?}");
    });
}

#[test]
fn the_adjoint_matrix_and_its_inverse_are_bounded_between_the_nodes() {
    with_window(0.0, |prover, set, c| {
        let Proved { modes, matrices, .. } = proved(prover, set);
        let Prover { equations, approximate, .. } = prover;
        let coefficients = approximate.adjoint(equations, &set.start, H, &modes).unwrap();
        let Matrices { b_most, e_most, a_most, .. } = &matrices;
        let mut largest = [0.0_f64; 3];
        for i in 0..=400 {
            let z = [f64::from(i) / 200.0 - 1.0, 0.0];
            let ((p, integrals), (y, _)) = (legendre(z), motion((&set.start, H), &modes, z));
            let sum = |at: usize, of: &[Complex]| coefficients[at].iter().zip(of).map(|(c, p)| c * p[0]).sum::<f64>();
            let one = |at: usize| if at.is_multiple_of(5) { 1.0 } else { 0.0 };
            let b: Vec<f64> = (0..16).map(|at| one(at) + 0.5 * H * sum(at, &integrals)).collect();
            let a = inverse(&b, 4).unwrap();
            for at in 0..16 {
                let of_j = (0..4).map(|l| b[at / 4 * 4 + l] * jacobian(c, y, l, at % 4)[0]).sum::<f64>();
                let e = (sum(at, &p) + of_j).abs();
                assert!(b[at].abs() <= b_most[at] && a[at].abs() <= a_most[at] && e <= e_most[at] + 1e-14, "{at} {i}");
                let shares = [b[at].abs() / b_most[at], a[at].abs() / a_most[at], e / e_most[at]];
                largest = std::array::from_fn(|k| largest[k].max(shares[k]));
            }
        }
        // Λ = 11 is lost on E.
        assert!(largest[0] > 0.8 && largest[1] > 0.8 && largest[2] > 0.01, "{largest:?}");
    });
}

/// One step of the classical Runge–Kutta method.
fn step(c: f64, x: [f64; 4], h: f64) -> [f64; 4] {
    let f = |x: [f64; 4]| slopes(c, x.map(|x| [x, 0.0])).map(|f| f[0]);
    let on = |k: [f64; 4], share: f64| std::array::from_fn(|i| x[i] + share * h * k[i]);
    let first = f(x);
    let second = f(on(first, 0.5));
    let third = f(on(second, 0.5));
    let last = f(on(third, 1.0));
    std::array::from_fn(|i| x[i] + h / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i]))
}

/// From all corners of a box of starts the motion stays within ε, and ends where the window says: what is not linear in
/// the error of the start is not small.
#[test]
fn every_start_of_a_box_ends_in_its_image() {
    const STEPS: usize = 800;
    let rest = 1e-4;
    with_window(rest, |prover, set, c| {
        let Proved { modes, added: Added { delta, epsilon }, gain, matrices, .. } = proved(prover, set);
        let mut largest = [0.0_f64; 2];
        for corner in 0..16 {
            let e_0: [f64; 4] = std::array::from_fn(|k| if corner >> k & 1 == 0 { rest } else { -rest });
            let mut x: [f64; 4] = std::array::from_fn(|k| set.start[k] + e_0[k]);
            for i in 1..=STEPS {
                x = step(c, x, H / STEPS as f64);
                let (y, _) = motion((&set.start, H), &modes, [2.0 * i as f64 / STEPS as f64 - 1.0, 0.0]);
                for k in 0..4 {
                    let share = (x[k] - y[k][0]).abs() / epsilon[k];
                    assert!(share < 1.0, "{k} at {i}: {share}");
                    largest[0] = largest[0].max(share);
                }
            }
            for i in 0..4 {
                let row = |k: usize| matrices.a_end[i * 4 + k];
                let linear = (0..4).map(|k| row(k) * (e_0[k] + gain[k])).sum::<f64>();
                let most = (0..4).map(|k| row(k).abs() * delta[k] + matrices.miss[i * 4 + k] * epsilon[k]).sum::<f64>();
                let off = (x[i] - set.start[i] - H * modes[i][0] - linear).abs();
                assert!(off <= most + 1e-14, "{i}: {off:e} {most:e}");
                largest[1] = largest[1].max(off / most);
            }
        }
        // S and s are bounds over all of the polydisc.
        assert!(largest[0] > 0.5 && largest[1] > 2e-3, "{largest:?}");
    });
}

/// Any two of the motions from a box of starts are no further apart on the way, and at the end, than the window says:
/// what is not linear in their difference is not small.
#[test]
fn every_two_starts_of_a_box_end_as_far_apart_as_it_says() {
    const STEPS: usize = 800;
    let rest = 1e-4;
    with_window(rest, |prover, set, c| {
        let start = Zonotope { columns: vec![Vec::new(); 4], generators: 0, rest: vec![2.0 * rest; 4] };
        let differences = Some(Differences { within: start.radii(), set: start });
        let mut set = set.clone();
        set.differences = differences;
        let proved = proved(prover, &set);
        let Added { delta, epsilon } = proved.apart.unwrap();
        let end = |corner: usize, i: usize| -> [f64; 4] {
            let sign = |k: usize| if corner >> k & 1 == 0 { rest } else { -rest };
            let mut x: [f64; 4] = std::array::from_fn(|k| set.start[k] + sign(k));
            (0..i).for_each(|_| x = step(c, x, H / STEPS as f64));
            x
        };
        let mut largest = [0.0_f64; 2];
        for (one, other) in (0..16).flat_map(|one| (0..one).map(move |other| (one, other))) {
            let [middle, last] = [STEPS / 2, STEPS].map(|i| {
                let (x, y) = (end(one, i), end(other, i));
                std::array::from_fn::<f64, 4, _>(|k| x[k] - y[k])
            });
            let first: [f64; 4] = std::array::from_fn(|k| end(one, 0)[k] - end(other, 0)[k]);
            for i in 0..4 {
                let share = middle[i].abs().max(last[i].abs()) / epsilon[i];
                let row = |k: usize| proved.matrices.a_end[i * 4 + k];
                let linear = (0..4).map(|k| row(k) * first[k]).sum::<f64>();
                let miss = |k: usize| proved.matrices.miss[i * 4 + k] * epsilon[k];
                let most = (0..4).map(|k| row(k).abs() * delta[k] + miss(k)).sum::<f64>();
                let off = (last[i] - linear).abs();
                assert!(share < 1.0 && off <= most + 1e-14, "{i}: {share} {off:e} {most:e}");
                largest = [largest[0].max(share), largest[1].max(off / most)];
            }
        }
        assert!(largest[0] > 0.5 && largest[1] > 2e-3, "{largest:?}");
    });
}

/// Points of a set, with all signs of its columns, are mapped to points of the next set with the same signs.
#[test]
fn every_point_of_a_set_is_mapped_into_the_next() {
    let mut random = Random(3);
    with_window(1e-9, |prover, set, _| {
        let mut set = set.clone();
        for i in 0..4 {
            set.errors.columns[i] = (0..7).map(|_| 1e-6 * random.unit()).collect();
            set.centre[i] = 1e-12 * random.unit();
        }
        let proved = proved(prover, &set);
        let exact = Extended::from;
        let mut next = set.clone();
        next.advance(&prover.equations, &proved).unwrap();
        let (a, mut largest) = (&proved.matrices.a_end, 0.0_f64);
        for _ in 0..200 {
            let signs: Vec<f64> = (0..11).map(|_| random.sign()).collect();
            let point = |k: usize| {
                let columns =
                    set.errors.columns[k].iter().zip(&signs).fold(Extended::ZERO, |sum, (g, s)| sum + exact(g * s));
                let own = exact(proved.added.delta[k] * signs[7 + k]) + exact(set.errors.rest[k] * signs[7 + k]);
                exact(set.centre[k]) + exact(proved.gain[k]) + columns + own
            };
            for i in 0..4 {
                let image = (0..4).fold(Extended::ZERO, |sum, k| sum + exact(a[i * 4 + k]) * point(k));
                let miss = (0..4).map(|k| proved.matrices.miss[i * 4 + k] * proved.added.epsilon[k]).sum::<f64>();
                let end = exact(set.start[i]) + exact(H) * exact(proved.modes[i][0]) + image;
                let columns =
                    next.errors.columns[i].iter().zip(&signs).fold(Extended::ZERO, |sum, (g, s)| sum + exact(g * s));
                let off = (end - exact(next.start[i]) - exact(next.centre[i]) - columns).abs().to_f64() + miss;
                assert!(off <= next.errors.rest[i], "{i}: {off:e} {:e}", next.errors.rest[i]);
                largest = largest.max(off / next.errors.rest[i]);
            }
        }
        assert!(largest > 0.02, "{largest}");
    });
}

/// The largest |d| of all unknowns between the nodes of a window of length `h`, the bound of it, and the largest at the
/// nodes. One coefficient of the slopes is off by `wrong`.
fn defects(prover: &mut Prover<'_>, set: &Set, c: f64, (h, wrong): (f64, f64)) -> Option<[[f64; 3]; 4]> {
    let Prover { equations, approximate, defect, ellipse } = prover;
    let mut modes = approximate.slopes(equations, &set.start, h)?;
    modes[0][3] += wrong;
    let bounds = ellipse.bounds(equations, (&set.start, h), &set.sizes(), &modes).ok()?;
    let found = defect.at_nodes(equations, &set.start, h, &modes);
    let most = window::defect_most(&found, &bounds);
    let mut largest = [0.0_f64; 4];
    for i in 0..=500 {
        let (y, v) = motion((&set.start, h), &modes, [f64::from(i) / 250.0 - 1.0, 0.0]);
        let d = slopes(c, y).into_iter().zip(v).map(|(f, v)| (v[0] - f[0]).abs());
        largest.iter_mut().zip(d).for_each(|(largest, d)| *largest = largest.max(d));
    }
    let at_nodes = |k: usize| found.middle[k].iter().fold(0.0_f64, |most, d| most.max(d.abs()));
    Some(std::array::from_fn(|k| [largest[k], most[k], at_nodes(k)]))
}

/// Slopes that are wrong at the nodes, and those of windows so long that they are right at the nodes alone.
#[test]
fn the_defect_is_bounded_between_the_nodes() {
    with_window(0.0, |prover, set, c| {
        let wrong = defects(prover, set, c, (H, 1e-6)).unwrap();
        let [largest, most, at_nodes] = wrong[0];
        assert!(largest <= most && largest > 0.05 * most && at_nodes > 0.5e-6, "{wrong:?}");
        let mut is_needed = false;
        for h in [4.0, 5.0, 6.0, 7.0, 8.0] {
            for [largest, most, at_nodes] in defects(prover, set, c, (h, 0.0)).into_iter().flatten() {
                assert!(largest <= most + 1e-13, "{h}: {largest:e} {most:e}");
                is_needed |= largest > tables::LEBESGUE * at_nodes + 1e-13;
            }
        }
        assert!(is_needed, "between the nodes d is no larger than Λ times that at them");
    });
}
