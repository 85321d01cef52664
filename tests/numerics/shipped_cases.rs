//! Every case in cases/ meets its own expectations, in both systems.

use std::path::PathBuf;

use super::common::distance;
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
    assert!(cases.len() >= 15, "found only {} cases", cases.len());
    cases
}

#[test]
fn every_case_meets_its_expectations_in_both_systems() {
    for (path, text) in shipped() {
        let name = path.display();
        let solve_with = |system: &str| {
            let case = Case::parse(&name.to_string(), &text, &[format!("solver.system={system}")]).unwrap();
            (solve(&case), case.expect.unwrap_or_else(|| panic!("{name} has no [expect]")))
        };
        let (limit, expect) = solve_with("physical-limit");
        let (doubled, _) = solve_with("doubled");
        if expect.status != Status::Converged {
            assert_eq!(limit.expect_err("the case is designed to fail").status, expect.status, "{name}");
            assert_eq!(doubled.expect_err("the case is designed to fail").status, expect.status, "{name}");
            continue;
        }
        let (limit, doubled) = (limit.unwrap(), doubled.unwrap());
        let tolerance = expect.tolerance.unwrap();
        assert!((limit.end.t - expect.t_final.unwrap()).abs() <= tolerance, "{name}: t = {}", limit.end.t);
        assert!((limit.end.x - expect.x_final.unwrap()).abs() <= tolerance, "{name}: x = {}", limit.end.x);
        assert!(limit.gradient_norm < 1e-10, "{name}: {}", limit.gradient_norm);
        let (t, x) = (distance(&limit.elapsed, &doubled.elapsed), distance(&limit.x, &doubled.x));
        assert!(t < 1e-10 && x < 1e-10, "{name}: the systems differ by {t:e} in t and {x:e} in x");
    }
}

#[test]
fn the_effective_case_reads_back_as_the_same_case() {
    for (path, text) in shipped() {
        let case = Case::parse("original", &text, &[]).unwrap();
        let again = Case::parse("effective", &case.to_toml(), &[]).unwrap();
        assert_eq!(case, again, "{}", path.display());
    }
}
