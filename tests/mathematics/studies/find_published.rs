//! Orbits of the cases of `find` beside published numbers, closed forms and computations in 28 digits and more.

use geodesic_ivp::number::{Extended, Real};
use geodesic_ivp::study::find::{Ended, Found, find, follow};

use crate::common::shipped;

/// What a search of a case finds, with settings.
#[track_caller]
fn found(name: &str, set: &[&str], proves: bool) -> Found {
    let case = shipped(name, set);
    let found = find(&case, case.find.as_ref().unwrap(), proves, &mut |_| {});
    found.unwrap_or_else(|none| panic!("{name} {set:?}: {none}"))
}

/// Asserts that the numbers that are found are these, up to the errors that they claim and this.
#[track_caller]
fn assert_are(found: &Found, truth: &[f64], rounding: f64) {
    for ((value, error), truth) in found.values.iter().zip(&found.errors).zip(truth) {
        assert!((value - truth).abs() <= error + rounding * truth.abs() && *error < 1e-9, "{value} ± {error}: {truth}");
    }
}

/// The stability index of the pair that is not the one along the motion.
fn index(found: &Found) -> f64 {
    let indices = found.multipliers.as_ref().unwrap().indices.as_ref().unwrap();
    indices.iter().map(|index| index.re).max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs())).unwrap()
}

/// The eight of R. C. Churchill, G. Pecelli and D. L. Rod at two energies: y0, the period, the index.
#[test]
fn orbits_of_a_galaxy_have_their_periods_and_indices() {
    for (energy, period, stability) in
        [("1/12", 6.901_643_615_339_256, 0.661_043_382_939_04), ("1/8", 7.543_259_412_675_079, -0.543_472_173_24)]
    {
        for turn in ["0", "2*pi/3", "4*pi/3"] {
            let set = [&format!("parameters.energy={energy}"), &format!("parameters.turn={turn}")];
            let straight = found("henon-heiles-straight", &set.map(String::as_str), false);
            assert_are(&straight, &[period], 1e-15);
            assert!((index(&straight) - stability).abs() < 1e-10, "{energy} {turn}: {}", index(&straight));
        }
    }
    for (energy, start, y0, period, stability) in [
        ("1/12", "0.3", 0.254_806_162_962_425_36, 6.135_235_496_129_222, 0.323_398_322_95),
        ("1/12", "-0.3", -0.303_692_777_295_423, 6.135_235_496_129_222, 0.323_398_322_95),
        ("1/12", "-0.1", -0.120_300_591_321_912_09, 6.715_956_328_547_304, 1.260_345_986_56),
        ("1/8", "0.3", 0.302_666_817_469_829_9, 6.075_615_784_322_902, -0.451_750_853_41),
        ("1/8", "-0.18", -0.185_405_087_090_802_1, 6.900_599_447_648_209, 2.013_297_429_86),
    ] {
        let set = [&format!("parameters.energy={energy}"), &format!("parameters.y0={start}")];
        let orbit = found("henon-heiles-loop", &set.map(String::as_str), false);
        assert_are(&orbit, &[y0, period], 1e-14);
        assert!((index(&orbit) - stability).abs() < 1e-10, "{energy} {start}: {}", index(&orbit));
    }
}

/// M. Brack's energies: from Lamé's equation in 30 digits.
#[test]
fn where_orbits_branch_off_is_proved() {
    let second = ["initial.y=0.93", "initial.u=1", "initial.u_dot=0", "find.meet=[\"y_dot\", \"u_dot\"]"];
    for (set, energy) in [(&[][..], "0.969309090664881664152966"), (&second[..], "0.986709235318161205839779")] {
        let found = found("henon-heiles-branch", set, true);
        let existence = found.existence.unwrap().unwrap_or_else(|reason| panic!("{reason}"));
        let (y, radius) = existence.values[0];
        let e = Extended::from(3.0) * y * y - Extended::from(2.0) * y * y * y;
        let off = (e - Extended::from_decimal(energy).unwrap()).abs().to_f64();
        assert!(
            off <= 2.0 * radius + 1e-23 && radius < 1e-20 && existence.alone_within.is_some(),
            "{off:e} {radius:e}"
        );
    }
    let doubling = found("henon-heiles-doubling", &[], false);
    let [y0, speed] = [doubling.values[0], doubling.values[1]];
    let e = 3.0 * speed * speed + 3.0 * y0 * y0 - 2.0 * y0 * y0 * y0;
    assert!((e - 0.891_902_540_542_254).abs() < 1e-13, "{e}");
}

/// E. Teo's closed forms: the angular momentum, the period of θ by a complete elliptic integral, and the multiplier
/// exp(T √(R″/2)).
#[test]
fn light_goes_around_a_rotating_black_hole() {
    for (set, p_phi, period, multiplier) in [
        (["parameters.a=1", "parameters.radius=3", "initial.p_phi=1.9"], 2.0, 1.122_902_366_394_286_3, 244.955_278_527),
        (
            ["parameters.a=1", "parameters.radius=2", "initial.p_phi=-0.999"],
            -1.0,
            1.505_776_227_721_912_9,
            70.737_675_7,
        ),
    ] {
        let orbit = found("kerr-spherical", &set, false);
        assert_are(&orbit, &[p_phi, period], 1e-14);
        let largest = orbit.multipliers.as_ref().unwrap().values[0].re;
        assert!((largest / multiplier - 1.0).abs() < 1e-8, "{largest}");
    }
}

/// The tallest halo orbit around L2 of earth and moon, from a computation in 28 digits.
#[test]
fn a_family_of_halo_orbits_turns_back_at_the_tallest_one() {
    let keys = "find.unknowns=[\"initial.x\", \"initial.y_dot\", \"grid.t_f\", \"initial.z\"]";
    let case = shipped("halo-moon", &[keys]);
    let family = follow(&case, case.find.as_ref().unwrap(), 0.22, &mut |_| {}).unwrap_or_else(|none| panic!("{none}"));
    assert_eq!(family.ended, Ended::Back);
    let folds: Vec<_> = family.members.iter().filter(|member| member.is_fold).collect();
    assert_eq!(folds.len(), 1);
    let truth = [1.080_606_585_058_53, -0.198_530_020_916_49, 1.174_017_172_894_14, 0.202_357_282_145_833_57];
    for ((value, error), truth) in folds[0].values.iter().zip(&folds[0].errors).zip(truth) {
        assert!((value - truth).abs() <= 2.0 * error && *error < 1e-9, "{value} ± {error}: {truth}");
    }
}

/// The table was made with `einstein` = 1. Another fit of it, by quadratures, gives the same number. The unknowns have
/// units of their own, and a change of a start by a thousandth is far along the orbit after 125 turns.
#[test]
fn mercury_tells_what_einstein_adds() {
    let found = found("mercury-fit", &[], false);
    let fit = found.fit.as_ref().unwrap();
    let [value, error] = [found.values[4], fit.standard_errors()[4]];
    assert!((value - 1.000_939_652_4).abs() < 1e-3 * error && (value - 1.0).abs() < 2.0 * error, "{value} ± {error}");
    assert!((fit.chi_squared - 105.433_72).abs() < 1e-3 && (0.005..0.006).contains(&error), "{}", fit.chi_squared);
}
