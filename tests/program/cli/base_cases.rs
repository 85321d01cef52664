//! `converge`, `work-precision` and `stability` without a case.

use tempfile::TempDir;

use crate::common::{failed, json, names, run_in, succeeded};

#[test]
fn converge_without_a_case_sweeps_the_paper_s_four_and_puts_its_slopes_beside() {
    let folder = TempDir::new().unwrap();
    let table = succeeded(&run_in(folder.path(), "converge"));
    let verbose = succeeded(&run_in(folder.path(), "converge --verbose"));
    for (row, paper, inverse) in [
        ("linear     SBP21       eps_x_final  2.000", "2.08  16 … 64", "2.070"),
        ("linear     SBP42       eps_t_final  3.514", "3.48  16 … 64", "3.638"),
        ("quartic    SBP21       eps_x_final  2.007", "2.08  16 … 64", "2.078"),
        ("quartic    SBP42       eps_x_final  2.866", "2.84  64 … 256", "2.891"),
        ("quartic    SBP42       eps_t_final  3.024", "3.13  64 … 256", "3.050"),
        ("quartic    SBP42       eps_x_l2     2.999", "-  64 … 256", "3.024"),
    ] {
        let line = |table: &str| table.lines().find(|line| line.contains(row)).map(str::to_owned).unwrap();
        assert!(line(&table).ends_with(paper), "{row}\n{table}");
        assert!(line(&verbose).contains(paper) && line(&verbose).contains(inverse), "{verbose}");
    }
    assert_eq!(table.lines().filter(|line| line.contains("eps_")).count(), 16, "{table}");
    let results = folder.path().join("results/converge");
    assert_eq!(names(&results), ["linear", "quartic"]);
    for case in ["linear", "quartic"] {
        let files = names(&results.join(case));
        for name in ["convergence.csv", "slopes.csv", "summary.json"] {
            assert!(files.iter().any(|file| file == name), "{files:?}");
        }
        assert_eq!(json(&results.join(case).join("summary.json"))["status"], "complete");
    }
    // Other grids, operators and cases: the paper's numbers stand only where they belong.
    let output = run_in(folder.path(), "converge --out out --n-gamma 32,64 --sbp SBP42,GLL8 --plot");
    let table = succeeded(&output);
    assert!(table.contains("3.48") && table.contains("GLL8") && table.contains("32 … 64"), "{table}");
    assert!(names(&folder.path().join("out/linear")).contains(&"errors_final.svg".to_owned()));
    let output = run_in(folder.path(), "converge --out out --n-gamma 32,64 --set grid.gamma_f=2.0");
    let table = succeeded(&output);
    assert!(table.contains("changed by --set") && !table.contains("3.48"), "{table}");
    let message = failed(&run_in(folder.path(), "converge --out out --n-gamma 4"), 2);
    assert!(message.contains("SBP42"), "{message}");
}

#[test]
fn charts_without_a_case_are_those_of_the_quartic_one() {
    let folder = TempDir::new().unwrap();
    for command in ["work-precision --methods rk4 --longest 1e-4", "stability --methods rk4 --gamma-f 1"] {
        let output = run_in(folder.path(), command);
        assert!(succeeded(&output).starts_with("Quartic oscillator"));
    }
}
