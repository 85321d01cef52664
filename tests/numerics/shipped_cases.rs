//! Every case in cases/ meets its own expectations, in both systems and in the precision it asks for.

use std::path::PathBuf;

use super::common::distance;
use geodesic_ivp::scalar::{Extended, Real};
use geodesic_ivp::{Case, Status, solve};

fn shipped() -> Vec<(PathBuf, String)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("cases");
    let mut cases: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| (path.clone(), std::fs::read_to_string(path).unwrap()))
        .collect();
    cases.sort();
    assert!(cases.len() >= 19, "found only {} cases", cases.len());
    cases
}

#[test]
fn every_case_meets_its_expectations_in_both_systems() {
    for (path, text) in shipped() {
        let name = path.display().to_string();
        if text.contains("\naccuracy = ") {
            check_accuracy(&name, &Case::parse(&name, &text, &[]).unwrap());
            continue;
        }
        let with = |system: &str| Case::parse(&name, &text, &[format!("solver.system={system}")]).unwrap();
        let cases = [with("physical-limit"), with("doubled")];
        if cases[0].is_extended() { check::<Extended>(&name, &cases) } else { check::<f64>(&name, &cases) }
    }
}

fn check<S: Real>(name: &str, [limit, doubled]: &[Case; 2]) {
    let expect = limit.expect.as_ref().unwrap_or_else(|| panic!("{name} has no [expect]"));
    let (limit, doubled) = (solve::<S>(limit), solve::<S>(doubled));
    if expect.status != Status::Converged {
        assert_eq!(limit.expect_err("the case is designed to fail").status, expect.status, "{name}");
        assert_eq!(doubled.expect_err("the case is designed to fail").status, expect.status, "{name}");
        return;
    }
    let (limit, doubled) = (limit.unwrap(), doubled.unwrap());
    let tolerance: S = expect.tolerance.as_ref().unwrap().to();
    for end in [limit.end, doubled.end] {
        let (t, x) = (expect.t_final.as_ref().unwrap().to::<S>(), expect.x_final.as_ref().unwrap().to::<S>());
        assert!((end.t - t).abs() <= tolerance, "{name}: t = {:?}", end.t);
        assert!((end.x - x).abs() <= tolerance, "{name}: x = {:?}", end.x);
    }
    // Six digits are for the size of t and for rounding that grows like N.
    let small = S::from_decimal(&format!("1e-{}", limit.digits - 6)).unwrap();
    assert!(limit.gradient_norm < small && doubled.gradient_norm < small, "{name}: {:?}", limit.gradient_norm);
    let (t, x) = (distance(&limit.elapsed, &doubled.elapsed), distance(&limit.x, &doubled.x));
    assert!(t < small && x < small, "{name}: the systems differ by {t:?} in t and {x:?} in x");
}

/// An accuracy is a matter of the physical limit in `f64`.
fn check_accuracy(name: &str, case: &Case) {
    let (expect, solution) = (case.expect.as_ref().unwrap(), solve::<f64>(case).unwrap());
    let accuracy = case.solver.accuracy.as_ref().unwrap().value();
    let [t, x] = [&expect.t_final, &expect.x_final].map(|number| number.as_ref().unwrap().value());
    assert!((solution.end.t - t).abs() < accuracy * t.abs().max(1.0), "{name}: t = {}", solution.end.t);
    assert!((solution.end.x - x).abs() < accuracy * x.abs().max(1.0), "{name}: x = {}", solution.end.x);
    assert!(solution.error_estimate.unwrap() <= accuracy && solution.gradient_norm < 1e-9, "{name}");
}

#[test]
fn the_effective_case_reads_back_as_the_same_case() {
    for (path, text) in shipped() {
        let case = Case::parse("original", &text, &[]).unwrap();
        let again = Case::parse("effective", &case.to_toml(), &[]).unwrap();
        assert_eq!(case, again, "{}", path.display());
    }
}
