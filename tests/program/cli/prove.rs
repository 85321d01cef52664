//! `run --prove`: the proof of where a motion ends.

use serde_json::Value;

use crate::common::{Folder, stderr, succeeded};

/// Returns what a run tells, and its summary.
fn run(folder: &Folder, arguments: &str) -> (String, Value) {
    (folder.succeeds(&format!("run {arguments} --out out --force")), folder.summary("out"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

#[test]
fn a_proof_has_the_end_a_radius_and_how_far_the_run_is_from_it() {
    let folder = Folder::new();
    // Ends that are known to 45 digits, rounded to doubles, or by Kepler's laws.
    for (arguments, coordinate, end, most) in [
        ("henon-heiles", "y", 0.679_016_921_772_021_6, 1e-18),
        ("kepler", "x", 0.4, 1e-19),
        ("kepler-levi-civita", "u", -0.1_f64.sqrt(), 1e-20),
        ("pendulum --set grid.t_f=10 --set particle.c=10", "x", 2.454_073_165_169_335_9, 1e-20),
        ("satellite-backward", "z", 19_379.109_195_700_287, 1e-15),
        ("three-bodies", "x1", 0.970_004_357_544_238_9, 1e-18),
    ] {
        let (told, summary) = run(&folder, &format!("{arguments} --prove"));
        let proof = &summary["proof"];
        assert_eq!((&summary["verdict"], &proof["status"]), (&"proved".into(), &"proved".into()), "{summary}");
        assert!(told.lines().next().unwrap().contains(": proved, good to "), "{told}");
        assert!(told.contains("  proved   ") && told.contains("this run is off by"), "{told}");
        let (found, radius) = (number(&proof["end"][coordinate]), number(&proof["radius"][coordinate]));
        assert!((found - end).abs() <= 2.0 * f64::EPSILON * end.abs(), "{arguments}: {found} {end}");
        assert!(radius > 0.0 && radius < most, "{arguments}: {radius:e}");
        let own = summary.get("final").map_or(&summary["x_final"], |all| &all[coordinate]);
        let off = (number(own) - found).abs();
        assert!((number(&proof["run_off_by"][coordinate]) - off).abs() <= 2e-16 * end.abs(), "{arguments}: {off:e}");
        assert!((number(&proof["reached"]) - number(&summary["gamma_final"])).abs() < 1e-6, "{arguments}");
        assert!(number(&proof["windows"]) >= 5.0 && number(&proof["seconds"]) > 0.0);
    }
}

#[test]
fn what_is_not_proved_is_told_and_changes_nothing_else() {
    let folder = Folder::new();
    for (case, reason, reached) in [
        ("dry-friction", "an event or a kink that the motion may graze", std::f64::consts::TAU),
        ("horizon-near", "steps that become ever shorter", 1.571),
    ] {
        let (_, without) = run(&folder, &format!("{case} --no-prove"));
        let files = folder.names("out");
        let (told, with) = run(&folder, &format!("{case} --prove"));
        let proof = &with["proof"];
        // Near a pole of the formulas either may be told, as rounding has it.
        let is_pole = case == "horizon-near" && proof["reason"] == "a divisor that may be 0";
        let reason = if is_pole { "a divisor that may be 0" } else { reason };
        assert_eq!((&proof["status"], &proof["reason"]), (&"unproved".into(), &reason.into()), "{case}");
        assert!((number(&proof["reached"]) - reached).abs() < 1e-3 && proof.get("end").is_none(), "{proof}");
        let words = told.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(&format!("no proof {reason}")), "{told}");
        assert_eq!(folder.names("out"), files);
        for (key, value) in without.as_object().unwrap() {
            assert!(key.ends_with("_seconds") || *value == with[key], "{case}: {key}");
        }
    }
}

/// The decimals of a start near a turning point say that it moves, which 16 digits do not; and no force shows a wall.
#[test]
fn starts_without_digits_and_jumps_without_a_force_are_not_proved() {
    let folder = Folder::new();
    let metric = "grid.gamma_f = 10.0\nsolver.accuracy = 1e-9\n[metric]\ncoordinates = [\"t\", \"x\"]\n\
                  components = { \"t t\" = \"1 + x^2\", \"x x\" = \"-1\" }\n";
    let turning = |t_dot: &str| {
        format!("{metric}[initial]\nt = 0.0\nt_dot = {t_dot}\nx = 0.0\nnorm = 1.0\nsolve = {{ x_dot = \"+\" }}\n")
    };
    let wall = "potential = { coordinates = [\"x\", \"y\"], definitions = { d = \"(x-0.3)^2 + (y-0.2)^2\" },\n\
                formula = \"(x^2 + y^2)/2 + 5*step(1e-4 - d)\" }\n\
                particle.law = \"newtonian\"\ninitial = { x = 0.6, y = 0.4, x_dot = 0.0, y_dot = 0.0 }\n\
                grid = { t_f = 3.0, n_gamma = 20, windows = 5 }\nscheme = { sbp = \"GLL20\", form = \"weak\" }\n";
    for (text, reason) in [
        (turning("1.000000000000001"), Some("a rate at the start whose two values agree to 16 digits, and no further")),
        (turning("1.0"), None),
        (wall.to_owned(), Some("a jump of step")),
    ] {
        folder.write("case.toml", text);
        let (told, summary) = run(&folder, "case.toml --prove");
        assert_eq!(summary["proof"]["reason"].as_str(), reason, "{told}");
    }
}

#[test]
fn a_run_with_an_accuracy_proves_itself_where_that_takes_little() {
    let folder = Folder::new();
    for (arguments, verdict, status) in [
        ("quartic-accuracy", "proved", Some("proved")),
        ("quartic --set solver.accuracy=1e-8", "proved", Some("proved")),
        ("rocket", "proved", Some("proved")),
        ("molecule-table", "proved", Some("proved")),
        // The others take too many operations, or promise nothing, or nobody judges them.
        ("outer-planets", "trusted", Some("unproved")),
        ("quartic", "trusted", None),
        ("henon-heiles --set solver.tolerance=1e-10", "trusted", None),
        ("quartic-accuracy --no-error", "doubtful", None),
        ("quartic-accuracy --no-prove", "trusted", None),
        ("quartic-accuracy --set solver.proof=false", "trusted", None),
    ] {
        let (told, summary) = run(&folder, arguments);
        assert_eq!(summary["verdict"], verdict, "{arguments}: {told}");
        assert_eq!(summary.get("proof").map(|proof| proof["status"].as_str().unwrap()), status, "{arguments}");
        // Nobody asked why there is no proof.
        assert_eq!(told.contains("  proved   "), status == Some("proved"), "{told}");
    }
    assert_eq!(run(&folder, "outer-planets --prove").1["proof"]["status"], "proved");
    run(&folder, "quartic-accuracy");
    folder.succeeds("run quartic-accuracy --from out --set grid.gamma_f=2.0 --out further");
    assert!(folder.summary("further").get("proof").is_none());
    let rows = folder.succeeds("run quartic-accuracy --vary initial.x=1,2 --stdout");
    assert!(!rows.contains("proof_status") && !rows.contains("proved"), "{rows}");
}

/// An oscillator, x = cos t, whose values at 0.5 and events at x = 0.5 are known.
#[test]
fn samples_and_events_of_a_proved_run_have_radii() {
    let folder = Folder::new();
    folder.write(
        "cos.toml",
        "particle.law = \"newtonian\"\npotential.formula = \"x^2/2\"\ninitial = { x = 1.0, x_dot = 0.0 }\n\
         grid.t_f = 12.0\nsolver.accuracy = 1e-9\nevents.half = { when = \"x - 0.5\" }\n",
    );
    run(&folder, "cos.toml --sample-t 0:12:0.5");
    let radius = |table: &str, columns: [&str; 2], exact: &dyn Fn(usize) -> f64| {
        let rows = folder.table(&format!("out/{table}"));
        let [value, radius] = columns.map(|column| rows.numbers(column));
        for (k, (value, radius)) in value.iter().zip(&radius).enumerate() {
            let off = (value - exact(k)).abs();
            assert!(off <= *radius && *radius < 1e-10, "{table} {columns:?} {k}: {off:e} of {radius:e}");
        }
        value.len()
    };
    let place = |k: usize| (6 * (k / 2) + if k.is_multiple_of(2) { 1 } else { 5 }) as f64 * std::f64::consts::PI / 3.0;
    assert_eq!(radius("samples.csv", ["x", "x_radius"], &|k| (0.5 * k as f64).cos()), 25);
    assert_eq!(radius("events.csv", ["gamma", "gamma_radius"], &place), 4);
    assert_eq!(radius("events.csv", ["x", "x_radius"], &|_| 0.5), 4);
    run(&folder, "cos.toml --sample-t 0:12:0.5 --no-prove");
    assert!(!folder.read("out/samples.csv").contains("radius") && !folder.read("out/events.csv").contains("radius"));
}

#[test]
fn what_a_proof_may_take_unasked_is_a_count_and_the_reason_says_so() {
    let folder = Folder::new();
    let (_, summary) = run(&folder, "outer-planets");
    let proof = &summary["proof"];
    assert_eq!(proof["reason"], "a proof that takes longer than a run may without --prove");
    let (_, again) = run(&folder, "outer-planets");
    assert_eq!((&proof["windows"], &proof["reached"]), (&again["proof"]["windows"], &again["proof"]["reached"]));
}

#[test]
fn the_key_is_the_option_and_the_case_keeps_its_expectations() {
    let folder = Folder::new();
    let (_, by_key) = run(&folder, "quartic --set solver.proof=true");
    let effective = folder.read("out/case.toml");
    let (_, by_option) = run(&folder, "quartic --prove");
    assert_eq!(by_key["proof"]["end"], by_option["proof"]["end"]);
    let with = folder.read("out/case.toml");
    assert!(effective.contains("proof = true") && effective.contains("[expect]"), "{effective}");
    assert_eq!(with, effective);
    let (_, without) = run(&folder, "quartic");
    assert!(without.get("proof").is_none() && without["verdict"] == "trusted");
}

/// A grid of which signs of coarseness are told, and the end is right all the same; one whose end is wrong; and a run
/// that begins with the error of another one.
#[test]
fn a_proof_lifts_doubts_about_the_error_and_no_others() {
    let folder = Folder::new();
    let coarse = "quartic --set scheme.sbp=SBP42 --set grid.n_gamma=32 --set solver.system=doubled";
    let (_, summary) = run(&folder, &format!("{coarse} --prove"));
    assert_eq!(summary["verdict"], "proved", "{summary}");
    let (_, summary) = run(&folder, "linear-unregularised --prove");
    assert_eq!((&summary["verdict"], &summary["proof"]["status"]), (&"doubtful".into(), &"proved".into()));
    folder.succeeds("run henon-heiles --out first --set grid.gamma_f=50.0 --set grid.windows=50");
    let continued = "henon-heiles --from first --set grid.gamma_f=100.0 --set grid.windows=50";
    let (told, summary) = run(&folder, &format!("{continued} --prove"));
    assert_eq!((&summary["verdict"], &summary["proof"]["status"]), (&"trusted".into(), &"proved".into()), "{told}");
}

#[test]
fn rows_have_the_status_and_the_largest_radius() {
    let folder = Folder::new();
    let told = folder.succeeds("run kepler --prove --vary initial.x=0.4,0.5,-0.3 --out out");
    assert!(told.contains(": 3 proved, 0 trusted, 0 doubtful, 0 refused"), "{told}");
    let table = folder.table("out/runs.csv");
    assert_eq!(table.column("proof_status"), ["proved"; 3]);
    assert!(table.numbers("proof_radius").iter().all(|radius| *radius > 0.0 && *radius < 1e-15), "{table:?}");
    folder.succeeds("run dry-friction --prove --vary initial.x=0.8,1.0 --out other");
    let table = folder.table("other/runs.csv");
    assert_eq!((table.column("proof_status"), table.column("proof_radius")), (vec!["unproved"; 2], vec![""; 2]));
}

#[test]
fn a_table_to_standard_output_has_a_note() {
    let folder = Folder::new();
    let output = folder.run("run kepler --prove --stdout");
    assert!(succeeded(&output).lines().count() > 10);
    assert!(stderr(&output).contains("note: proof: x(6.283185) = 0.4"), "{}", stderr(&output));
}

/// A proof of sixteen thousand periods takes seconds; the run is kept, and the program ends well. On a busy machine the
/// first interrupts may come before the proof.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_proof_and_keeps_the_run() {
    let arguments = "run long-run --set solver.tolerance=1e-10 --set grid.gamma_f=100000 --prove --quiet --out out";
    for seconds in [2, 4, 8, 16] {
        let folder = Folder::new();
        let child = folder.program(arguments).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_secs(seconds));
        let kill = ["-INT".to_owned(), child.id().to_string()];
        let _ = std::process::Command::new("kill").args(kill).status();
        if child.wait_with_output().unwrap().status.code() == Some(130) {
            continue;
        }
        let summary = folder.summary("out");
        assert_eq!((&summary["verdict"], &summary["proof"]["status"]), (&"trusted".into(), &"interrupted".into()));
        assert!(number(&summary["proof"]["reached"]) > 0.0 && folder.has("out/trajectory.csv"));
        return;
    }
    panic!("every interrupt came before the proof");
}

/// `grid.until` ends the run, and the event that may end it, too, is nothing but its start.
#[test]
fn what_ends_a_run_is_named_where_there_are_more_ends_than_one() {
    let folder = Folder::new();
    folder.write(
        "cos.toml",
        "particle.law = \"newtonian\"\npotential.formula = \"x^2/2\"\ninitial = { x = 1.0, x_dot = 0.0 }\n\
         grid = { gamma_f = 5.0, until = \"t - 1\" }\nsolver.accuracy = 1e-10\n\
         events.e = { when = \"x - 0.3\", until = true }\n",
    );
    for (set, ended_by, met) in [("", "grid.until", 0), ("--set events.e.when=x-0.9", "e", 1)] {
        let (_, summary) = run(&folder, &format!("cos.toml {set}"));
        assert_eq!(
            (&summary["verdict"], &summary["proof"]["ended_by"]),
            (&"proved".into(), &ended_by.into()),
            "{summary}"
        );
        assert_eq!(folder.table("out/events.csv").numbers("x").len(), met, "{set}");
    }
}
