//! Functions that are tables: in the case, in a file beside it, and with mistakes.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::common::{failed, json, run_in, succeeded};

const REST: &str = "potential = { formula = \"v(x)\" }\nparticle.law = \"newtonian\"\n\
                    initial = { x = 0.5, x_dot = 0.0 }\ngrid.t_f = 6.0\nsolver.accuracy = 1e-9\n";
const ARRAYS: &str = "tables.v = { x = [-2.0, -1.0, 0.0, 1.0, 2.0], y = [2.0, 0.5, 0.0, 0.5, 2.0] }\n";
const FILE: &str = "tables.v = { file = \"points.csv\", x = \"r\", y = \"v\" }\n";
const POINTS: &str = "# measured\nv, other, r\n2.0,1,-2.0\n0.5,2,-1.0\n0.0,3,0.0\n0.5,4,1.0\n2.0,5,2.0\n";

fn write(folder: &Path, name: &str, text: &str) {
    fs::create_dir_all(folder.join(name).parent().unwrap()).unwrap();
    fs::write(folder.join(name), text).unwrap();
}

/// Columns in any order, with a comment, from the folder of the case; the effective case leads to the same file.
#[test]
fn a_table_in_a_file_is_the_one_in_the_case() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "arrays.toml", &format!("{ARRAYS}{REST}"));
    write(folder.path(), "inner/file.toml", &format!("{FILE}{REST}"));
    write(folder.path(), "inner/points.csv", POINTS);
    let run = |case: &str, out: &str| {
        succeeded(&run_in(folder.path(), &format!("run {case} --out {out}")));
        let summary = json(&folder.path().join(out).join("summary.json"));
        assert_eq!(summary["verdict"], "trusted");
        summary["final"].clone()
    };
    let arrays = run("arrays.toml", "one");
    assert_eq!(arrays, run("inner/file.toml", "two"));
    assert_eq!(arrays, run("two/case.toml", "three"));
}

/// V = x²/2 at its points is far from a parabola at the ends, where a natural spline is straight; outside it ends, or
/// goes on as a line, on which the motion is one of constant force.
#[test]
fn outside_of_its_points_a_table_ends_or_is_a_line() {
    let folder = TempDir::new().unwrap();
    let start = REST.replace("x = 0.5, x_dot = 0.0", "x = 1.9, x_dot = 3.0").replace("t_f = 6.0", "t_f = 1.0");
    write(folder.path(), "refused.toml", &format!("{ARRAYS}{start}"));
    let message = failed(&run_in(folder.path(), "run refused.toml"), 4);
    assert!(message.contains("x = 2") || message.contains("x = 1.99"), "{message}");
    let linear = ARRAYS.replace(" }", ", outside = \"linear\" }");
    let beyond = start.replace("x = 1.9, x_dot = 3.0", "x = 3.0, x_dot = 1.0");
    write(folder.path(), "linear.toml", &format!("{linear}{beyond}"));
    succeeded(&run_in(folder.path(), "run linear.toml --out linear"));
    let end = json(&folder.path().join("linear/summary.json"))["final"]["x"].as_f64().unwrap();
    // The slope of the natural spline at x = 2 is 12/7.
    assert!((end - (3.0 + 1.0 - 0.5 * 12.0 / 7.0)).abs() < 1e-8, "{end}");
}

#[test]
fn mistakes_in_tables_say_where_and_what_to_do() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "points.csv", POINTS);
    write(folder.path(), "words.csv", "r,v\n1,2\n2,high\n");
    for (table, messages) in [
        ("tables.v = { x = [1.0, 2.0, 3.0] }", &["a table needs x and y", "file = \"points.csv\""][..]),
        ("tables.v = { x = [1.0, 2.0], y = [0.0, 1.0] }", &["a table needs three points at least"]),
        ("tables.v = { x = [1.0, 2.0, 2.0], y = [0.0, 1.0, 2.0] }", &["must increase, and that of point 3 does not"]),
        ("tables.v = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0] }", &["x has 3 numbers and y has 2"]),
        ("tables.v = { file = \"none.csv\", x = \"r\", y = \"v\" }", &["cannot read the table", "none.csv"]),
        (
            "tables.v = { file = \"points.csv\", x = \"s\", y = \"v\" }",
            &["has no column 's'", "its columns are v, other, r"],
        ),
        (
            "tables.v = { file = \"words.csv\", x = \"r\", y = \"v\" }",
            &["line 3 of", "\"high\" where a number must be"],
        ),
        ("tables.v = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0, 4.0], spline = \"cubik\" }", &["did you mean \"cubic\"?"]),
        (
            "tables.x = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0, 4.0] }",
            &["the table name 'x' is already that of a coordinate"],
        ),
        ("tables.w = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0, 4.0] }", &["unknown function 'v'"]),
    ] {
        write(folder.path(), "case.toml", &format!("{table}\n{REST}"));
        let message = failed(&run_in(folder.path(), "check case.toml"), 2);
        messages.iter().for_each(|part| assert!(message.contains(part), "{part} is not in\n{message}"));
    }
    // A user would try this first.
    write(folder.path(), "case.toml", &REST.replace("{ formula = \"v(x)\" }", "{ table = { x = [0.0], V = [0.0] } }"));
    let message = failed(&run_in(folder.path(), "check case.toml"), 2);
    assert!(message.contains("unknown field `table`") && message.contains("write [tables] v = "), "{message}");
}
