//! Help: short with `-h`, long with `--help`.

use tempfile::TempDir;

use crate::common::{run_in, succeeded};

const COMMANDS: [&str; 9] =
    ["run", "converge", "work-precision", "stability", "merge", "check", "init", "completions", "man"];

#[test]
fn short_help_has_one_line_for_each_option_and_an_example() {
    let folder = TempDir::new().unwrap();
    for command in COMMANDS {
        let help = succeeded(&run_in(folder.path(), &format!("{command} -h")));
        // A line that goes on below itself begins far to the right.
        let goes_on = |line: &&str| line.starts_with(&" ".repeat(12)) || line.chars().count() > 100;
        assert_eq!(help.lines().find(goes_on), None, "{command}");
        assert!(help.contains(&format!("\n  geodesic-ivp {command}")), "{command}: {help}");
    }
}

#[test]
fn options_of_a_study_stand_below_headings() {
    let folder = TempDir::new().unwrap();
    for command in ["converge", "work-precision", "stability"] {
        let help = succeeded(&run_in(folder.path(), &format!("{command} -h")));
        let places = ["\nWhat to measure:\n", "\nCase:\n", "\nResults:\n"].map(|heading| help.find(heading));
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{command}: {help}");
    }
}

#[test]
fn long_help_names_every_method() {
    let folder = TempDir::new().unwrap();
    for command in ["work-precision", "stability"] {
        let help = succeeded(&run_in(folder.path(), &format!("{command} --help")));
        let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
        let refused = run_in(folder.path(), &format!("{command} --methods euler"));
        let list = String::from_utf8(refused.stderr).unwrap();
        let list = list.split_once("the methods for this case are").unwrap().1;
        for method in list.split(',') {
            let method = method.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(words.contains(&method), "{command}: {method}");
        }
        assert!(list.lines().all(|line| line.chars().count() <= 100), "{list}");
    }
}
