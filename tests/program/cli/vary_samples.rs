//! `run --vary` with samples: those of all rows in one table.

use crate::common::Folder;

/// Samples of every row are those of the single run, in the digits of the case, and with bounds where a proof is asked
/// for.
#[test]
fn samples_of_a_row_are_those_of_the_single_run() {
    let folder = Folder::new();
    let spring = "run henon-heiles --set grid.gamma_f=2 --set solver.accuracy=1e-8 --sample-t 0,0.5,1.25";
    for (out, run) in [
        ("plain", "run quartic --sample-gamma 1:0:-0.25"),
        ("digits", "run quartic --set solver.digits=30 --sample-t 0:0.5:0.25"),
        ("accuracy", spring),
        ("proved", &format!("{spring} --prove")),
    ] {
        let key = if out == "plain" || out == "digits" { "initial.x" } else { "initial.y" };
        folder.succeeds(&format!("{run} --vary {key}=0.1,0.2 --out {out}"));
        let table = folder.table(&format!("{out}/runs-samples.csv"));
        let own = if out == "proved" { "" } else { " --no-prove" };
        for (row, value) in [("1", "0.1"), ("2", "0.2")] {
            folder.succeeds(&format!("{run} --set {key}={value} --out one --quiet{own}"));
            let single = folder.table("one/samples.csv");
            assert_eq!(table.columns[1..], single.columns, "{out}");
            let rows: Vec<_> = table.rows.iter().filter(|cells| cells[0] == row).map(|cells| &cells[1..]).collect();
            assert!(rows == single.rows && rows.len() >= 3, "{out}: {rows:?}\n{:?}", single.rows);
        }
        assert_eq!(table.columns.iter().any(|name| name.ends_with("_radius")), out == "proved");
        assert!(folder.table(&format!("{out}/runs.csv")).column("message").iter().all(|message| message.is_empty()));
        let asked = folder.summary(out)["samples"].as_str().unwrap().to_owned();
        assert!(run.contains(&asked) && asked.starts_with("--sample-"), "{asked}");
    }
}

#[test]
fn samples_that_a_row_does_not_reach_are_missing_and_it_says_so() {
    let folder = Folder::new();
    folder.succeeds("run quartic --vary grid.gamma_f=0.5,1.0 --sample-gamma -0.25:1:0.25 --out out");
    let table = folder.table("out/runs-samples.csv");
    let places: Vec<(&str, &str)> = table.column("row").into_iter().zip(table.column("gamma")).collect();
    let first = ["0.0", "0.25", "0.5"].map(|gamma| ("1", gamma));
    let second = ["0.0", "0.25", "0.5", "0.75", "1.0"].map(|gamma| ("2", gamma));
    assert_eq!(places, [&first[..], &second].concat());
    let runs = folder.table("out/runs.csv");
    let messages = runs.column("message");
    assert!(messages[0].contains("3 of 6 samples are not in the run, which covers 0.0 to 0.5"), "{messages:?}");
    assert!(messages[1].contains("1 of 6 samples are not in the run, which covers 0.0 to 1.0"), "{messages:?}");
    assert_eq!(runs.column("exit_code"), ["0", "0"]);
    // A row without a solution has none, and no row has any where t turns round.
    folder.succeeds("run linear --set grid.gamma_f=4 --vary initial.x=-0.9,3 --sample-gamma 0,1 --out linear");
    assert_eq!(folder.table("linear/runs-samples.csv").column("row"), ["2", "2"]);
    folder.refuses(&[
        ("run fish-eye --vary initial.x=0.5,0.6 --sample-t 0:1:0.5", 2, "needs a coordinate t"),
        ("run quartic --vary initial.x=1,2 --sample-t 0:1:0.5 --stdout", 2, "--stdout writes one table"),
        ("run quartic --vary initial.x=1,2 --sample-t 0:1:0.5 --samples-only", 2, "--samples-only"),
    ]);
}

#[test]
fn parts_with_samples_are_joined_only_if_these_are_the_same() {
    let folder = Folder::new();
    let table = "run quartic --quiet --vary initial.x=0.5:1.5:5";
    let of =
        |out: &str| ["runs.csv", "runs-samples.csv", "summary.json"].map(|name| folder.read(&format!("{out}/{name}")));
    folder.succeeds(&format!("{table} --sample-t 0:2:0.5 --out whole"));
    for k in 1..=2 {
        folder.succeeds(&format!("{table} --sample-t 0:2:0.5 --part {k}/2 --out p{k}"));
    }
    folder.succeeds("merge p2 p1 --out merged --quiet");
    assert_eq!(of("merged"), of("whole"));
    folder.succeeds(&format!("{table} --sample-t 0:2:0.25 --part 2/2 --out other"));
    folder.succeeds(&format!("{table} --part 2/2 --out without"));
    folder.refuses(&[
        ("merge p1 other --out bad", 2, "parts of different tables … where samples are"),
        ("merge p1 without --out bad", 2, "parts of different tables … where samples are"),
    ]);
    // Without samples the next table has none.
    folder.succeeds(&format!("{table} --out whole"));
    assert!(!folder.has("whole/runs-samples.csv"));
}
