//! `find`: what it writes, that its case runs, and what it refuses.

use crate::common::{Folder, stderr, succeeded};

const OSCILLATOR: &str = r#"
title = "Spring"
potential = { coordinates = ["x"], formula = "k*x^2/2", parameters = { k = 1.0 } }   # my spring
particle.law = "newtonian"
initial = { x = 1.0, x_dot = 0.0 }
grid.t_f = 1.0
solver.accuracy = 1e-12
"#;

fn case(find: &str) -> String {
    format!("{OSCILLATOR}find = {{ {find} }}\n")
}

#[test]
fn what_is_found_runs_to_the_last_bit() {
    let folder = Folder::new();
    folder.write("spring.toml", case("unknowns = [\"initial.x\"], meet = [\"x - 2\"]"));
    let told = folder.succeeds("find spring.toml");
    assert!(told.starts_with("Spring: found in one step\n  found    initial.x = 3.701631"), "{told}");
    let files = ["case.toml", "find.csv", "found.toml", "residuals.csv", "summary.json", "trajectory.csv"];
    assert_eq!(folder.names("results/spring/find"), files);
    let found = folder.read("results/spring/find/found.toml");
    assert!(found.contains("# my spring") && !found.contains("[find]") && !found.contains("find ="), "{found}");
    assert!(folder.read("results/spring/find/case.toml").contains("find ="));
    folder.succeeds("run results/spring/find/found.toml --quiet --out again");
    let [of_search, of_run] = ["results/spring/find", "again"].map(|out| folder.summary(out)["final"].clone());
    assert_eq!(of_search, of_run);
    assert!((of_search["x"].as_f64().unwrap() - 2.0).abs() < 1e-12, "{of_search}");
    let summary = folder.summary("results/spring/find");
    let unknown = &summary["find"]["unknowns"]["initial.x"];
    assert!((unknown.as_f64().unwrap() - 2.0 / 1.0_f64.cos()).abs() < 1e-11, "{unknown}");
    assert_eq!((&summary["find"]["is_met"], &summary["find"]["steps"]), (&true.into(), &1.into()));
    // The end of what was found is one to continue from, and `run` does not look at [find].
    folder.succeeds("run spring.toml --quiet --from results/spring/find --set grid.t_f=2 --out more");
    // An override is one of the search, too.
    let told = folder.succeeds("find spring.toml --json --set find.meet=['x-4']");
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert!((told["final"]["x"].as_f64().unwrap() - 4.0).abs() < 1e-12);
}

#[test]
fn a_fit_reads_a_file_beside_its_case() {
    let folder = Folder::new();
    let rows: Vec<String> = (1..10).map(|i| 0.5 * f64::from(i)).map(|t| format!("{t},{}", (2.0 * t).cos())).collect();
    folder.write("here/obs.csv", format!("when,where\n{}\n", rows.join("\n")));
    let wanted = "unknowns = [\"parameters.k\"], data = { file = \"obs.csv\", t = \"when\", x = \"where\" }";
    folder.write("here/fit.toml", case(wanted).replace("t_f = 1.0", "t_f = 5.0").replace("k = 1.0", "k = 3.7"));
    folder.succeeds("find here/fit.toml --out out");
    let table = folder.table("out/fit.csv");
    assert_eq!(table.columns, ["t", "coordinate", "observed", "computed", "residual"]);
    assert!(table.rows.len() == 9 && table.numbers("residual").iter().all(|residual| residual.abs() < 1e-10));
    let found = &folder.summary("out")["find"];
    assert!((found["unknowns"]["parameters.k"].as_f64().unwrap() - 4.0).abs() < 1e-10, "{found}");
    // The case that is kept reads its file from anywhere.
    folder.succeeds("check out/case.toml");
}

#[test]
fn a_search_that_does_not_converge_has_no_result() {
    let folder = Folder::new();
    folder.write("far.toml", case("unknowns = [\"grid.t_f\"], meet = [\"x - 5\"]"));
    folder.write("results/far/find/mine.txt", "");
    let output = folder.run("find far.toml");
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(output.stdout.is_empty() && stderr(&output).contains("begin nearer"), "{output:?}");
    assert_eq!(folder.names("results/far/find"), ["case.toml", "find.csv", "mine.txt", "summary.json"]);
    let summary = folder.summary("results/far/find");
    assert_eq!(summary["status"], "not-found");
    // A search that finds something and then one that does not leave nothing of the first.
    folder.write("far.toml", case("unknowns = [\"grid.t_f\"], meet = [\"x - 0.5\"]"));
    succeeded(&folder.run("find far.toml"));
    assert!(folder.has("results/far/find/found.toml"));
    folder.fails("find far.toml --set find.meet=['x-5']", 3);
    assert!(!folder.has("results/far/find/found.toml"));
}

#[test]
fn mistakes_are_told_with_their_remedy() {
    let folder = Folder::new();
    let wrong = |name: &str, find: &str| folder.write(&format!("{name}.toml"), case(find));
    wrong("key", "unknowns = [\"initial.z\"], meet = [\"x\"]");
    wrong("setting", "unknowns = [\"solver.accuracy\"], meet = [\"x\"]");
    wrong("twice", "unknowns = [\"initial.x\", \"initial.x\"], meet = [\"x\"]");
    wrong("none", "unknowns = [\"initial.x\"]");
    wrong("both", "unknowns = [\"initial.x\"], meet = [\"x\"], periodic = true");
    wrong("formula", "unknowns = [\"initial.x\"], meet = [\"x - start(z)\"]");
    wrong("open", "unknowns = [\"initial.x\"], meet = [\"x - start(x\"]");
    wrong("data", "unknowns = [\"initial.x\"], data = { t = [1.0], z = [1.0] }");
    wrong("short", "unknowns = [\"initial.x\"], data = { t = [1.0, 2.0], x = [1.0] }");
    wrong("sigma", "unknowns = [\"initial.x\"], data = { t = [0.5], x = [1.0], sigma_x = [0.0] }");
    wrong("late", "unknowns = [\"initial.x\"], data = { t = [0.5, 9.0], x = [1.0, 1.0] }");
    wrong("good", "unknowns = [\"initial.x\"], meet = [\"x - 2\"]");
    wrong("idle", "unknowns = [\"initial.x\"], meet = [\"start(x_dot)\", \"x_dot - x_dot\"]");
    folder.refuses(&[
        ("find quartic", 2, "the case has no [find] … for example"),
        ("find", 2, "<CASE> … `find lambert`"),
        ("find key.toml", 2, "the case gives initial.z no number … begins with"),
        ("find setting.toml", 2, "solver.accuracy is no number that can be found"),
        ("find twice.toml", 2, "initial.x is named twice"),
        ("find none.toml", 2, "not said what is to be met … exactly one"),
        ("check both.toml", 2, "both find.meet and find.periodic"),
        ("run formula.toml", 2, "z … known are"),
        ("find open.toml", 2, "a parenthesis is missing"),
        ("find data.toml", 2, "z"),
        ("find short.toml", 2, "t has 2 numbers and x has 1"),
        ("find sigma.toml", 2, "a standard deviation is not positive"),
        ("find late.toml", 3, "the run covers 0 to 1, and not all of the data"),
        ("find good.toml --set solver.error=false", 2, "errors of runs begin … leave solver.error out"),
        ("find idle.toml", 3, "does not depend on initial.x … take it out"),
    ]);
}
