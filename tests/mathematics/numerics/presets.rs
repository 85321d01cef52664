//! The metrics by name: vacuum solutions solve Einstein's equations, and different coordinates say the same.

use geodesic_ivp::geometry::{Geometry, PRESETS};
use proptest::prelude::*;

use super::curvature::Curvature;
use crate::common::{assert_near, geometry, preset, reference, start, start_with_momenta};

/// R_abcd R^abcd of a mass m with angular momentum m a (R. C. Henry, Astrophys. J. 535 (2000) 350).
fn kretschmann(m: f64, a: f64, r: f64, z: f64) -> f64 {
    let (r2, c2) = (r * r, (a * z / r).powi(2));
    48.0 * m * m * (r2 - c2) * ((r2 + c2).powi(2) - 16.0 * r2 * c2) / (r2 + c2).powi(6)
}

/// r of Kerr–Schild coordinates.
fn radius(a: f64, [x, y, z]: [f64; 3]) -> f64 {
    let d = x * x + y * y + z * z - a * a;
    ((d + (d * d + 4.0 * a * a * z * z).sqrt()) / 2.0).sqrt()
}

#[test]
fn every_preset_compiles() {
    for listed in &PRESETS {
        let text = listed.text();
        let geometry: Geometry = geometry(&text);
        assert_eq!(geometry.names(), text.coordinates);
        let names: Vec<&str> = text.parameters.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(listed.parameters().collect::<Vec<_>>(), names);
    }
}

#[test]
fn flat_ones_are_flat_and_the_universe_is_not() {
    let flat: Geometry = geometry(&preset("polar", &[("c", "3")]));
    assert!(Curvature::new(&flat, &[0.3, 1.7, 0.4]).kretschmann().abs() < 1e-14);
    let flat: Geometry = geometry(&preset("minkowski", &[]));
    assert_eq!(Curvature::new(&flat, &[0.3, 1.7, 0.4, 0.1]).kretschmann(), 0.0);
    let universe: Geometry = geometry(&preset("flrw", &[]));
    let curvature = Curvature::new(&universe, &[1.7, 0.0, 0.0, 0.0]);
    assert!(curvature.ricci() > 0.1);
    // With ä/a = −2/(9t²) and ȧ/a = 2/(3t) it is 12 ((ä/a)² + (ȧ/a)⁴).
    let t = 1.7_f64;
    let want = 12.0 * ((2.0 / 9.0_f64).powi(2) + (2.0 / 3.0_f64).powi(4)) / t.powi(4);
    assert_near(curvature.kretschmann(), want, 1e-13, "the curvature of the universe");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn kerr_is_a_vacuum(r in 2.1..20.0_f64, theta in 0.2..2.9_f64) {
        let kerr: Geometry = geometry(&preset("kerr", &[("m", "1.05"), ("a", "0.9")]));
        let curvature = Curvature::new(&kerr, &[0.4, r, theta, 1.1]);
        assert_near(curvature.ricci(), 0.0, 1e-11, "Ricci");
        let want = kretschmann(1.05, 0.9, r, r * theta.cos());
        let size = 48.0 * 1.05 * 1.05 / r.powi(6);
        assert_near(curvature.kretschmann() / size, want / size, 1e-10, "Kretschmann");
    }

    /// Inside the horizon, too.
    #[test]
    fn kerr_schild_is_the_same_vacuum(x in -6.0..6.0_f64, y in -6.0..6.0_f64, z in -6.0..6.0_f64) {
        let a = 0.9;
        let r = radius(a, [x, y, z]);
        prop_assume!(r > 0.5);
        let scene: Geometry = geometry(&preset("kerr-schild", &[("m", "1.05"), ("a", "0.9")]));
        let curvature = Curvature::new(&scene, &[0.4, x, y, z]);
        assert_near(curvature.ricci(), 0.0, 1e-10, "Ricci");
        let size = 48.0 * 1.05 * 1.05 / r.powi(6);
        let want = kretschmann(1.05, a, r, z);
        assert_near(curvature.kretschmann() / size, want / size, 1e-8, "Kretschmann");
    }

    #[test]
    fn slices_of_kerr(r in 2.2..20.0_f64) {
        let plane = std::f64::consts::FRAC_PI_2;
        let at = |name: &str, parameters: &[(&str, &str)], q: &[f64]| {
            Curvature::new(&geometry(&preset(name, parameters)), q)
        };
        let kerr = at("kerr", &[("a", "0.8")], &[0.0, r, plane, 0.0]);
        let equatorial = at("kerr-equatorial", &[("a", "0.8")], &[0.0, r, 0.0]);
        let still = at("kerr", &[], &[0.0, r, plane, 0.0]);
        let schwarzschild = at("schwarzschild", &[], &[0.0, r, 0.0]);
        for (a, in_space) in [0, 1, 3].into_iter().enumerate() {
            for (b, other) in [0, 1, 3].into_iter().enumerate() {
                assert_near(equatorial.metric(a, b), kerr.metric(in_space, other), 1e-14, "kerr-equatorial");
                assert_near(schwarzschild.metric(a, b), still.metric(in_space, other), 1e-14, "schwarzschild");
            }
        }
        // v = t + r + 2 ln(r/2 − 1), dv = dt + dr/f.
        let ingoing = at("schwarzschild-ef", &[], &[0.0, r, 0.0]);
        let f = 1.0 - 2.0 / r;
        let [vv, vr] = [ingoing.metric(0, 0), ingoing.metric(0, 1)];
        assert_near(vv, schwarzschild.metric(0, 0), 1e-14, "t t");
        assert_near(vv / f + vr, 0.0, 1e-14, "t r");
        assert_near(vv / (f * f) + 2.0 * vr / f, schwarzschild.metric(1, 1), 1e-13, "r r");
        assert_near(ingoing.metric(2, 2), schwarzschild.metric(2, 2), 1e-14, "phi phi");
    }
}

/// The same orbit out of the plane: r and z/r are the same functions of proper time in both.
#[test]
fn an_orbit_in_kerr_schild_and_in_boyer_lindquist_coordinates() {
    let a = 0.9;
    let schild: Geometry = geometry(&preset("kerr-schild", &[("a", "0.9")]));
    let (x, v) = ([7.0, -2.0, 1.5], [0.02, 0.38, 0.12]);
    let q = [0.0, x[0], x[1], x[2]];
    // dt/dτ makes K = 1.
    let k = |t_dot: f64| schild.norm(&q, &[t_dot, v[0], v[1], v[2]]);
    let (k_0, k_1, k_2) = (k(0.0), k(1.0), k(-1.0));
    let (g_tt, half) = ((k_1 + k_2) / 2.0 - k_0, (k_1 - k_2) / 4.0);
    let t_dot = (-half + (half * half - g_tt * (k_0 - 1.0)).sqrt()) / g_tt;
    let first = start(&schild, &q, &[t_dot, v[0], v[1], v[2]]);
    // dr/dτ and dθ/dτ by differences along the velocity.
    let r = |s: f64| radius(a, [0, 1, 2].map(|i| x[i] + s * v[i]));
    let theta = |s: f64| ((x[2] + s * v[2]) / r(s)).acos();
    let slope = |f: &dyn Fn(f64) -> f64| {
        let h = 1e-2;
        let [one, two, three] = [1.0, 2.0, 3.0].map(|k| (f(k * h) - f(-k * h)) / (2.0 * k * h));
        1.5 * one - 0.6 * two + 0.1 * three
    };
    let kerr: Geometry = geometry(&preset("kerr", &[("a", "0.9")]));
    let position = [0.0, r(0.0), theta(0.0), 0.0];
    let samples = kerr.at(&position);
    let g = |a: usize| kerr.structure().values.iter().find(|term| term.ab == [a, a]).map(|t| samples.at(t.value, 0));
    let p_phi = x[0] * first.p[2] - x[1] * first.p[1];
    let p = [first.p[0], g(1).unwrap() * slope(&r), g(2).unwrap() * slope(&theta), p_phi];
    let second = start_with_momenta(&kerr, &position, &p);
    assert_near(kerr.norm(&second.q, &second.q_dot), 1.0, 1e-11, "K");
    let (one, two) = (reference(&schild, &first, 300.0), reference(&kerr, &second, 300.0));
    for i in 1..=30 {
        let tau = 10.0 * f64::from(i);
        let (one, two) = (one.at(tau), two.at(tau));
        let r = radius(a, [one.q[1], one.q[2], one.q[3]]);
        assert_near(r, two.q[1], 1e-9, "r");
        assert_near(one.q[3] / r, two.q[2].cos(), 1e-9, "cos theta");
    }
    // The axis of the angular momentum is one of symmetry.
    let end = one.at(300.0);
    assert_near(end.q[1] * end.p[2] - end.q[2] * end.p[1], p_phi, 1e-11, "angular momentum");
}
