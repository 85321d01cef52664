//! Functions that are tables: in the case, in a file beside it, and with mistakes.

use crate::common::Folder;

const REST: &str = "potential = { formula = \"v(x)\" }\nparticle.law = \"newtonian\"\n\
                    initial = { x = 0.5, x_dot = 0.0 }\ngrid.t_f = 6.0\nsolver.accuracy = 1e-9\n";
const ARRAYS: &str = "tables.v = { x = [-2.0, -1.0, 0.0, 1.0, 2.0], y = [2.0, 0.5, 0.0, 0.5, 2.0] }\n";
const FILE: &str = "tables.v = { file = \"points.csv\", x = \"r\", y = \"v\" }\n";
const POINTS: &str = "# measured\nv, other, r\n2.0,1,-2.0\n0.5,2,-1.0\n0.0,3,0.0\n0.5,4,1.0\n2.0,5,2.0\n";

/// Columns in any order, with a comment, from the folder of the case; the effective case leads to the same file.
#[test]
fn a_table_in_a_file_is_the_one_in_the_case() {
    let folder = Folder::new();
    folder.write("arrays.toml", format!("{ARRAYS}{REST}"));
    folder.write("inner/file.toml", format!("{FILE}{REST}"));
    folder.write("inner/points.csv", POINTS);
    let [arrays, file, again] =
        [("arrays.toml", "one"), ("inner/file.toml", "two"), ("two/case.toml", "three")].map(|(case, out)| {
            folder.succeeds(&format!("run {case} --out {out}"));
            let summary = folder.summary(out);
            assert_eq!(summary["verdict"], "proved");
            summary["final"].clone()
        });
    assert_eq!((&file, &again), (&arrays, &arrays));
}

/// V = x²/2 at its points is far from a parabola at the ends, where a natural spline is straight; outside it ends, or
/// goes on as a line, on which the motion is one of constant force.
#[test]
fn outside_of_its_points_a_table_ends_or_is_a_line() {
    let folder = Folder::new();
    let start = REST.replace("x = 0.5, x_dot = 0.0", "x = 1.9, x_dot = 3.0").replace("t_f = 6.0", "t_f = 1.0");
    folder.write("refused.toml", format!("{ARRAYS}{start}"));
    let message = folder.fails("run refused.toml", 4);
    assert!(message.contains("x = 2") || message.contains("x = 1.99"), "{message}");
    let linear = ARRAYS.replace(" }", ", outside = \"linear\" }");
    let beyond = start.replace("x = 1.9, x_dot = 3.0", "x = 3.0, x_dot = 1.0");
    folder.write("linear.toml", format!("{linear}{beyond}"));
    folder.succeeds("run linear.toml --out linear");
    let end = folder.summary("linear")["final"]["x"].as_f64().unwrap();
    // The slope of the natural spline at x = 2 is 12/7.
    assert!((end - (3.0 + 1.0 - 0.5 * 12.0 / 7.0)).abs() < 1e-8, "{end}");
}

#[test]
fn mistakes_in_tables_say_where_and_what_to_do() {
    let folder = Folder::new();
    folder.write("points.csv", POINTS);
    folder.write("words.csv", "r,v\n1,2\n2,high\n");
    for (table, words) in [
        ("v = { x = [1.0, 2.0, 3.0] }", "a table needs x and y … file = \"points.csv\""),
        ("v = { x = [1.0, 2.0], y = [0.0, 1.0] }", "a table needs three points at least"),
        ("v = { x = [1.0, 2.0, 2.0], y = [0.0, 1.0, 2.0] }", "must increase, and that of point 3 does not"),
        ("v = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0] }", "x has 3 numbers and y has 2"),
        ("v = { file = \"none.csv\", x = \"r\", y = \"v\" }", "cannot read the table … none.csv"),
        ("v = { file = \"points.csv\", x = \"s\", y = \"v\" }", "has no column 's' … its columns are v, other, r"),
        ("v = { file = \"words.csv\", x = \"r\", y = \"v\" }", "line 3 of … \"high\" where a number must be"),
        ("v = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0, 4.0], spline = \"cubik\" }", "did you mean \"cubic\"?"),
        ("x = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0, 4.0] }", "the table name 'x' is already that of a coordinate"),
        ("w = { x = [1.0, 2.0, 3.0], y = [0.0, 1.0, 4.0] }", "unknown function 'v'"),
    ] {
        folder.write("case.toml", format!("tables.{table}\n{REST}"));
        folder.refuses(&[("check case.toml", 2, words)]);
    }
}
