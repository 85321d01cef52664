//! `converge` and `work-precision`: files, and what they refuse. `tests/cmd/studies.md` has what they print. That
//! columns are those of the page is tested beside the pages.

use crate::common::{Folder, stderr, succeeded};

/// Every row below this heading has a cell that begins where the heading does.
fn assert_column(text: &str, heading: &str) {
    let (above, below) = text.split_once(heading).unwrap_or_else(|| panic!("no {heading} in {text}"));
    let column = above.lines().last().map_or(0, |line| line.chars().count());
    let ends =
        |line: &&str| ["written", "error", "ratio", "length"].iter().any(|end| line.trim_start().starts_with(end));
    let rows: Vec<&str> = below.lines().skip(1).take_while(|line| !ends(line)).collect();
    assert!(rows.len() >= 4, "{rows:?} below {heading} in {text}");
    for line in rows {
        let cell: Vec<char> = line.chars().skip(column - 1).take(2).collect();
        assert!(cell[0] == ' ' && cell[1] != ' ', "{heading}: {line}");
    }
}

const CONVERGENCE: [&str; 5] = ["convergence.csv", "errors_final.svg", "errors_l2.svg", "slopes.csv", "summary.json"];

#[test]
fn converge_writes_errors_slopes_and_pictures() {
    let folder = Folder::new();
    let text = folder.succeeds("converge quartic --n-gamma 64,32,16 --sbp SBP21 --out out --plot --verbose");
    assert!(text.contains("2.007") && text.contains("2.078"), "{text}");
    ["slope", "grids", "against 1/N", "points"].iter().for_each(|heading| assert_column(&text, heading));
    assert_eq!(folder.names("out"), CONVERGENCE);
    let slopes = folder.read("out/slopes.csv");
    assert!(slopes.lines().nth(1).unwrap().starts_with("SBP21,strong,eps_t_final,1.98"), "{slopes}");
    assert_eq!(folder.summary("out")["status"], "complete");
    let ranged = folder.succeeds("converge quartic --fit-range 64:256 --out out");
    assert!(ranged.contains("64 … 256") && !ranged.contains("16 …"), "{ranged}");
}

#[test]
fn converge_without_a_case_sweeps_the_paper_s_four_and_puts_its_slopes_beside() {
    let folder = Folder::new();
    let [table, verbose] = ["converge", "converge --verbose"].map(|command| folder.succeeds(command));
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
    assert_eq!(folder.names("results/converge"), ["linear", "quartic"]);
    for case in ["results/converge/linear", "results/converge/quartic"] {
        assert_eq!(folder.names(case), ["convergence.csv", "slopes.csv", "summary.json"]);
        assert_eq!(folder.summary(case)["status"], "complete");
    }
    // Other grids, operators and cases: the paper's numbers stand only where they belong.
    let table = folder.succeeds("converge --out out --n-gamma 32,64 --sbp SBP42,GLL8 --plot");
    assert!(table.contains("3.48") && table.contains("GLL8") && table.contains("32 … 64"), "{table}");
    assert_eq!(folder.names("out/linear"), CONVERGENCE);
    let table = folder.succeeds("converge --out out --n-gamma 32,64 --set grid.gamma_f=2.0");
    assert!(table.contains("changed by --set") && !table.contains("3.48"), "{table}");
    let table = folder.succeeds("converge quartic --sbp SBP21 --n-gamma 16,32,64");
    assert!(table.contains("SBP21       eps_x_final  2.007 ± 0.002   2.08  16 … 64\n"), "{table}");
    let table = folder.succeeds("converge quartic --sbp SBP21 --set particle.mass=2.0");
    assert!(!table.contains("paper"), "{table}");
}

#[test]
fn charts_without_a_case_are_those_of_the_quartic_one() {
    let folder = Folder::new();
    for (arguments, table) in [
        ("work-precision --methods rk4 --longest 1e-3 --out work", "work/work_precision.csv"),
        ("stability --methods rk4 --gamma-f 1 --delta-gamma 0.1 --out map", "map/stability.csv"),
    ] {
        let output = folder.run(arguments);
        assert!(succeeded(&output).starts_with("Quartic oscillator"), "{arguments}");
        assert!(stderr(&output).contains("no CASE is given: the built-in case 'quartic' is used"), "{arguments}");
        assert!(folder.has(table), "{arguments}");
    }
}

#[test]
fn a_warning_of_a_sweep_has_its_remedy_and_stands_only_where_it_belongs() {
    const FIT: &str = "eps_x_final: not asymptotic … fit finer grids: --fit-range 64:1024";
    const MIXED: &str = "even and odd numbers of nodes";
    let folder = Folder::new();
    for (arguments, words, is_warned) in [
        ("--sbp SBP42", FIT, true),
        ("--sbp SBP42 --fit-range 64:1024", "warning", false),
        ("--sbp SBP42 --n-gamma 16,32,64", "sweep finer grids: --n-gamma 64,128,256", true),
        ("--sbp GLL24 --n-gamma 96,192,384", "sweep coarser grids with --n-gamma", true),
        ("--sbp SBP21 --n-gamma 63,64,65,128", MIXED, true),
        ("--sbp SBP21 --n-gamma 64,96,128", MIXED, false),
        ("--sbp SBP21 --n-gamma 65,97,129", MIXED, false),
        ("--sbp SBP21 --n-gamma 63,64,65,128 --form weak", MIXED, false),
    ] {
        let output = folder.run(&format!("converge quartic {arguments}"));
        succeeded(&output);
        let warned = stderr(&output);
        assert_eq!(words.split(" … ").all(|words| warned.contains(words)), is_warned, "{arguments}: {warned}");
        // Where all errors are rounding, one warning is for all of them.
        assert!(!arguments.contains("GLL24") || warned.matches("warning").count() == 1, "{warned}");
    }
}

#[test]
fn tables_fit_a_hundred_columns_and_say_the_answer_first() {
    let folder = Folder::new();
    for (command, answer) in [
        ("converge --n-gamma 16,32,64,128", "The paper's base cases: the slopes against 1/N agree with"),
        ("converge --n-gamma 16,32,64,128 --verbose", "The paper's base cases: the slopes against 1/N agree with"),
        ("converge quartic --n-gamma 16,32,64 --verbose", "Quartic oscillator: the order is 2.0 for SBP21, 1.8 to 3.1"),
        ("work-precision kerr-inclined --methods gauss,gll12 --longest 1e-3", "An inclined orbit around a rotating"),
        ("stability quartic --gamma-f 1,4 --delta-gamma 0.1,0.5", "Quartic oscillator: "),
        ("check quartic --run", "# The case meets its [expect] table:"),
        ("check kerr-inclined --run", "# The case meets its [expect] table:"),
        ("init --list", ""),
    ] {
        let text = folder.succeeds(command);
        assert!(text.starts_with(answer), "{command}: {text}");
        // A comment of a case is as long as its author made it.
        let long = text.lines().find(|line| line.chars().count() > 100 && !line.starts_with("# "));
        assert!(long.is_none(), "{command}: {long:?}");
    }
}

const PLUNGE: &str = "metric.preset = \"schwarzschild\"\n\
                      initial = { r = 3.0, t_dot = 3.0, r_dot = -1.0, phi_dot = 0.0 }\n\
                      grid.gamma_f = 20.0\nscheme.sbp = \"GLL8\"\n";

#[test]
fn converge_takes_scenes() {
    let folder = Folder::new();
    let command = "converge kerr-inclined --set grid.gamma_f=60.0 --n-gamma 128,256,512 --sbp SBP21 --out out --plot";
    let text = folder.succeeds(&format!("{command} --set grid.windows=1"));
    assert!(text.contains("SBP21 weak  eps_theta_l2     2.0"), "{text}");
    assert!(text.contains("the order is 2.0 for SBP21 weak"), "{text}");
    assert_eq!(folder.names("out"), CONVERGENCE);
    assert_eq!(folder.table("out/slopes.csv").rows.len(), 8);
    let reference = &folder.summary("out")["reference"];
    assert!(reference["theta_final"].is_number() && reference["phi_size"].is_number(), "{reference}");
    assert!(folder.read("out/errors_final.svg").contains("slope 2.0"), "the largest error is drawn with its slope");
}

/// Other refusals are in `tests/cmd/studies.md`.
#[test]
fn what_cannot_be_studied_is_refused() {
    let folder = Folder::new();
    folder.write("plunge.toml", PLUNGE);
    let rough = "converge quartic --set potential={formula={expression=\"abs(x)^2.5\"}} --set initial.x=0.0";
    let spacelike = "converge quartic --set initial.x_dot=10.0 --set grid={t_f=10.0,n_gamma=32}";
    let doubled = "converge quartic --form weak --set scheme.regularised=false --set solver.system=doubled";
    folder.refuses(&[
        ("converge quartic --n-gamma 9223372036854775807", 2, "above the limit"),
        (rough, 3, "no Taylor series"),
        (spacelike, 3, "t_f is not reached"),
        ("converge quartic --sbp SBP84 --n-gamma 15", 2, "SBP84 needs at least 16 points"),
        ("converge quartic --sbp GLL3 --n-gamma 1", 2, "2 or more"),
        (doubled, 2, "regularised"),
        ("converge quartic --fit-range 64", 2, "expected MIN:MAX"),
        ("converge --n-gamma 4", 2, "SBP42"),
        ("converge horizon", 4, "the reference trajectory ends at"),
        ("work-precision horizon", 4, "the reference trajectory ends at"),
        ("converge plunge.toml --sbp SBP21 --n-gamma 16", 4, "the reference trajectory ends at"),
        ("work-precision plunge.toml --methods rk4", 4, "the reference trajectory ends at"),
        ("work-precision quartic --gamma-f 1,2,3,4,5", 2, "4 lengths at most"),
        // Nothing is left of what was refused, not even a folder.
        ("converge quartic --n-gamma 7 --out deep/er", 2, ""),
        ("stability quartic --delta-gamma 1e-9 --gamma-f 100 --out deep/er", 2, ""),
        ("run quartic --sample-gamma 0:5:1 --out deep/er", 2, ""),
        ("converge horizon --out deep/er", 4, ""),
    ]);
    assert_eq!(folder.names(""), ["plunge.toml"]);
    folder.fails("converge quartic --set grid.gamma_f=100.0 --sbp SBP42 --n-gamma 16,32", 3);
}

#[test]
fn work_precision_takes_scenes() {
    let folder = Folder::new();
    let orbit = "work-precision schwarzschild-orbit --gamma-f 200 --longest 1e-3";
    let text = folder.succeeds(&format!("{orbit} --methods gll8,sbp21,rk4,dop853 --plot --out out"));
    assert!(text.contains("ratio") && text.contains("1e-12"), "{text}");
    let table = folder.read("out/work_precision.csv");
    assert!(["GLL8 weak", "SBP21 strong", "RK4", "DOP853"].iter().all(|name| table.contains(name)), "{table}");
    assert!(folder.read("out/error_time.svg").contains("largest error of t, r and phi"));
    // Its own table can be read back, and that of another number of coordinates is refused.
    let rows = "--methods rk4 --rows out/work_precision.csv --out again";
    folder.succeeds(&format!("{orbit} {rows}"));
    folder.fails(&format!("work-precision henon-heiles --longest 1e-3 {rows}"), 1);
}

#[test]
fn work_precision_writes_its_table_its_summary_and_pictures() {
    let folder = Folder::new();
    let wall = "work-precision tanh-wall --longest 1e-3";
    // The step of GLL and Gauss methods at its coarsest is too long for the steep wall: a row with its status.
    let text = folder.succeeds(&format!("{wall} --methods gll8,sbp21,rk4,gauss --gamma-f 4,20 --plot --out out"));
    assert!(text.contains("ratio") && text.contains("1e-12"), "{text}");
    ["own s", "this program  ", "others  "].iter().for_each(|heading| assert_column(&text, heading));
    let pictures = ["drift_error", "drift_k", "error_evaluations", "error_evaluations_2", "error_time", "error_time_2"];
    assert_eq!(folder.pictures("out"), pictures.map(|name| format!("{name}.svg")));
    let table = folder.table("out/work_precision.csv");
    assert!(["converged", "not-converged"].iter().all(|status| table.column("status").contains(status)), "{table:?}");
    let summary = folder.summary("out");
    assert_eq!((summary["status"].as_str(), summary["ratios"].as_array().unwrap().len()), (Some("complete"), 20));
    assert!(!summary["fronts"].as_array().unwrap().is_empty());
    // The table of one run can stand beside another's, and pictures of an earlier run do not.
    folder.succeeds(&format!("{wall} --methods rk4 --out out"));
    assert_eq!(folder.names("out"), ["drift.csv", "summary.json", "work_precision.csv"]);
    folder.succeeds(&format!("{wall} --methods rk4 --rows out/work_precision.csv --out again"));
    let rows = |out: &str| folder.table(&format!("{out}/work_precision.csv")).rows.len();
    // On a busy machine the first row may be the only one below the longest time.
    assert!(rows("again") > rows("out"));
}
