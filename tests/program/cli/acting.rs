//! Events that act, as a user meets them: tables, samples, continued runs, failures and refusals.

use crate::common::Folder;

/// At each of the eight bounces the table has two rows of one gamma, and the velocity is turned between them.
#[test]
fn tables_have_the_rows_before_and_after_an_event() {
    let folder = Folder::new();
    let text = folder.succeeds("run restitution --plot --out out");
    assert!(text.contains(": proved") && text.contains("in pieces between 8 events"), "{text}");
    let table = folder.table("out/trajectory.csv");
    let [gamma, z, z_dot, window] = ["gamma", "z", "z_dot", "window"].map(|name| table.numbers(name));
    let rows = gamma.len();
    let turns: Vec<usize> = (1..rows).filter(|&k| gamma[k] == gamma[k - 1] && z_dot[k] * z_dot[k - 1] < 0.0).collect();
    for &k in &turns {
        assert!((z[k] - z[k - 1]).abs() < 1e-12 && (z_dot[k] + 0.9 * z_dot[k - 1]).abs() < 1e-12, "row {k}");
        assert_eq!(window[k], window[k - 1] + 1.0);
    }
    assert_eq!((turns.len(), rows), (8, folder.table("out/residuals.csv").rows.len()));
    let times: Vec<f64> = turns.iter().map(|&k| gamma[k]).collect();
    assert_eq!(folder.table("out/events.csv").numbers("gamma"), times);
    let summary = folder.summary("out");
    assert_eq!((summary["acting_events"].as_u64(), summary["windows"].as_f64()), (Some(8), Some(window[rows - 1])));
    assert_eq!(folder.pictures("out"), ["charges.svg", "mesh.svg", "orbit.svg", "section.svg"]);
    assert_eq!(folder.succeeds("run restitution --stdout --quiet").lines().count(), rows + 1);
}

/// z = v s − g s²/2, s after the first bounce at 0.45 with v = 0.9 g 0.45.
#[test]
fn samples_are_those_of_the_piece_that_they_are_in() {
    let folder = Folder::new();
    let first = (2.0 / 9.81_f64).sqrt();
    for options in ["--sample-t 0.2:1.2:0.25", "--sample-gamma 0.2:1.2:0.25 --samples-only"] {
        folder.succeeds(&format!("run restitution --quiet --out out {options}"));
        let samples = folder.table("out/samples.csv");
        for (t, found) in samples.numbers("t").into_iter().zip(samples.numbers("z")) {
            let s = t - first;
            let z = if s < 0.0 { 1.0 - 4.905 * t * t } else { 0.9 * 9.81 * first * s - 4.905 * s * s };
            assert!((found - z).abs() < 1e-11, "{t}: {found} {z}");
        }
    }
}

#[test]
fn a_run_is_continued_behind_events() {
    let folder = Folder::new();
    folder.succeeds("run restitution --quiet --out first --set grid.t_f=3.0");
    folder.succeeds("run restitution --quiet --out second --set grid.t_f=5.0 --from first");
    let summary = folder.summary("second");
    assert!((summary["final"]["z"].as_f64().unwrap() - 0.121_548_654_839_124).abs() < 1e-11);
    assert_eq!(summary["acting_events"], 4);
}

#[test]
fn bounces_without_an_end_keep_what_was_before() {
    let folder = Folder::new();
    let error = folder.fails("run restitution --quiet --out out --set grid.t_f=20.0", 3);
    assert!(error.contains("events do not end at gamma = 8.578949") && error.contains("end the run before"), "{error}");
    assert_eq!(folder.names("out"), ["case.toml", "events.csv", "summary.json", "until_failure.csv"]);
    let last = folder.table("out/until_failure.csv").numbers("gamma").pop().unwrap();
    assert!((last - 8.578_949).abs() < 1e-6 && folder.table("out/events.csv").rows.len() > 100);
    assert_eq!(folder.summary("out")["status"], "events-pile-up");
}

/// A hull that goes through bounces, where nothing is known as long as some motions have met the floor.
#[test]
fn the_boxes_of_a_set_that_bounces_are_drawn() {
    let folder = Folder::new();
    let text = folder.succeeds("run restitution --set initial.z=[0.99,1.01] --set grid.t_f=1.5 --plot --out out");
    assert!(text.contains("hull     from all of the intervals z in [0."), "{text}");
    let (picture, rows) = (folder.read("out/hull.svg"), folder.read("out/hull.csv"));
    assert!(rows.contains(",,,") && rows.lines().count() == 65);
    assert!(!picture.contains("no data") && picture.matches("<polyline").count() > 2, "{picture}");
}

/// The end of a run does not say what events have made of parameters: to go on from there with those of the file would
/// be another motion.
#[test]
fn many_runs_and_checks_know_events_that_act_and_others_refuse_them() {
    let folder = Folder::new();
    let text = folder.succeeds("run restitution --vary parameters.e=0.5,0.9 --set grid.t_f=1.3");
    assert!(text.contains("2 trusted"), "{text}");
    folder.succeeds("check kick --run --quiet");
    let set = "run restitution --set events.floor.set.g=5";
    let text = folder.succeeds(&format!("{set} --set grid.t_f=1.0 --out first"));
    assert!(text.contains("proved"), "{text}");
    folder.refuses(&[
        ("converge restitution", 2, "knows no events that act"),
        ("stability restitution", 2, "knows no events that act"),
        ("work-precision restitution", 2, "knows no events that act"),
        ("run restitution --reference", 2, "knows no events that act"),
        ("run restitution --quiet --out no --sample-t 4:6:1", 2, "goes beyond the run, which covers 0"),
        (&*format!("{set} --from first --out second"), 2, "goes on from another one … begin at the start"),
    ]);
}
