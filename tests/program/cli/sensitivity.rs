//! `solver.sensitivity`: its table, its keys of the summary, its columns of many runs, and where it is refused.

use std::fs;

use tempfile::TempDir;

use crate::common::{failed, json, run_in, succeeded};

#[test]
fn a_run_has_a_table_and_says_how_changes_grow() {
    let folder = TempDir::new().unwrap();
    let told = succeeded(&run_in(folder.path(), "run henon-heiles-megno --set grid.gamma_f=20 --out out"));
    let out = folder.path().join("out");
    let summary = &json(&out.join("summary.json"))["sensitivity"];
    let [lyapunov, megno] = ["lyapunov", "megno"].map(|key| format!("{:.6}", summary[key].as_f64().unwrap()));
    let growth = format!("  growth   largest Lyapunov exponent {lyapunov}, MEGNO {megno} (2: regular)\n");
    assert!(told.contains(&growth), "{told}{growth}");
    let table = fs::read_to_string(out.join("sensitivity.csv")).unwrap();
    let header = "gamma,d_x_d_x,d_x_d_y,d_x_d_p_x,d_x_d_p_y,d_y_d_x,d_y_d_y,d_y_d_p_x,d_y_d_p_y,d_p_x_d_x,d_p_x_d_y,\
                  d_p_x_d_p_x,d_p_x_d_p_y,d_p_y_d_x,d_p_y_d_y,d_p_y_d_p_x,d_p_y_d_p_y";
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(header));
    let start = "0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,0.0,1.0";
    assert_eq!(lines.next(), Some(start));
    assert!(lines.last().unwrap().starts_with("20.0,"), "{table}");
}

#[test]
fn many_runs_have_the_growth_of_each_in_columns() {
    let folder = TempDir::new().unwrap();
    let set = "--set grid.gamma_f=20 --set potential.parameters.v_i=0.1";
    let vary = format!("run henon-heiles-megno {set} --vary potential.parameters.y_i=0.1,0.2 --out many");
    succeeded(&run_in(folder.path(), &vary));
    let one = format!("run henon-heiles-megno {set} --set potential.parameters.y_i=0.2 --out one");
    succeeded(&run_in(folder.path(), &one));
    let mut table = csv::Reader::from_path(folder.path().join("many/runs.csv")).unwrap();
    let names = table.headers().unwrap().clone();
    let last = table.records().last().unwrap().unwrap();
    let summary = &json(&folder.path().join("one/summary.json"))["sensitivity"];
    for key in ["lyapunov", "megno"] {
        let place = names.iter().position(|name| name == key).unwrap();
        assert_eq!(last[place].parse::<f64>().ok(), summary[key].as_f64(), "{key}");
    }
}

#[test]
fn without_chosen_windows_it_is_refused() {
    let folder = TempDir::new().unwrap();
    let message = failed(&run_in(folder.path(), "run henon-heiles --set solver.sensitivity=true"), 2);
    assert!(message.contains("solver.sensitivity needs solver.accuracy or solver.tolerance"), "{message}");
    assert!(message.contains("give solver.tolerance in place of scheme and grid"), "{message}");
}
