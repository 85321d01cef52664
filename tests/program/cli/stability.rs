//! The command `stability`, and the hard scenes: whatever happens, it ends as it should.

use std::fs::File;

use crate::common::{CASES, Folder, failed, stderr, succeeded};

/// No cell of any table of a folder is NaN or infinite.
fn check_tables(folder: &Folder, out: &str) {
    for name in folder.names(out).into_iter().filter(|name| name.ends_with(".csv")) {
        for cell in folder.table(&format!("{out}/{name}")).rows.concat() {
            assert!(cell.parse::<f64>().map_or(true, f64::is_finite), "{name} has {cell}");
        }
    }
}

const FILES: [&str; 6] =
    ["last_node.svg", "map.svg", "map_others.svg", "sawtooth.svg", "stability.csv", "summary.json"];

#[test]
fn the_atlas_has_its_columns_its_summary_and_its_pictures() {
    let folder = Folder::new();
    let small = "--methods sbp21,sbp42,gll8,accuracy,rk4,dop853 --gamma-f 1,4 --delta-gamma 0.05,0.2,0.5";
    let text = folder.succeeds(&format!("stability quartic {small} --plot --out out"));
    for words in ["runs are accurate", "SBP21 windows strong", "1.372"] {
        assert!(text.contains(words), "{text}");
    }
    assert_eq!(folder.names("out"), FILES);
    assert_eq!(folder.pictures("out").len(), 4);
    let table = folder.read("out/stability.csv");
    assert!(table.contains("SBP21,strong,21,1.0,1.0,0.10") && table.contains("DOP853 tol=1e-6,,"), "{table}");
    check_tables(&folder, "out");
    let summary = folder.summary("out");
    assert_eq!(summary["status"], "complete");
    assert_eq!(summary["methods"][0]["linear_limit"], 1.0);
    assert!(summary["last_node"].as_array().unwrap().iter().any(|row| row["method"] == "SBP42 strong"));
    // Again from standard input, by the tangent, without pictures: the old ones are gone.
    let case = File::open(format!("{CASES}/quartic.toml")).unwrap();
    let mut again = folder.program("stability - --methods sbp42 --gamma-f 1 --t-dot 1,4 --out out --quiet");
    assert_eq!(succeeded(&again.stdin(case).output().unwrap()), "");
    assert_eq!(folder.names("out"), FILES[4..]);
    assert!(folder.read("out/stability.csv").contains(",1.0,4.0,"));
    // Where there are only methods of one group, there is no map of the other one.
    for (methods, missing) in [("sbp42", "map_others.svg"), ("rk4", "map.svg")] {
        let lone =
            format!("stability quartic --methods {methods} --gamma-f 1 --delta-gamma 0.1 --plot --out {methods}");
        folder.succeeds(&lone);
        let names = folder.names(methods);
        assert!(FILES.iter().all(|name| names.contains(&(*name).to_owned()) == (*name != missing)), "{names:?}");
    }
}

#[test]
fn the_atlas_of_a_scene_has_the_errors_of_all_coordinates() {
    let folder = Folder::new();
    // One of each kind.
    let methods = "--methods sbp21,sbp42,gll8,accuracy,rk4,dop853,verlet,gauss,radau,taylor";
    let grid = "--gamma-f 2,20 --delta-gamma 0.05,0.3,0.7 --plot";
    let text = folder.succeeds(&format!("stability henon-heiles {methods} {grid} --out out"));
    assert!(text.contains("SBP21 strong") && text.contains("Verlet") && !text.contains("left out"), "{text}");
    assert_eq!(folder.names("out"), FILES);
    assert_eq!(folder.pictures("out").len(), 4);
    let table = folder.table("out/stability.csv");
    check_tables(&folder, "out");
    let mut accurate = 0;
    for row in &table.rows {
        let cell = |name: &str| &row[table.columns.iter().position(|column| column == name).unwrap()];
        let number = |name: &str| cell(name).parse::<f64>().ok();
        let is_own = ["SBP", "GLL", "accuracy"].iter().any(|own| row[0].starts_with(own));
        // Charges are exact whatever becomes of the trajectory; those of other methods are parameters.
        let exact =
            ["delta_q_t", "delta_q_s"].map(number).iter().all(|charge| charge.is_some_and(|charge| charge < 1e-10));
        assert!(exact == (is_own && number("delta_k_max").is_some()), "{row:?}");
        if cell("status") == "accurate" {
            accurate += 1;
            // With Newton's law K is -2 p_s (energy off) with p_s = 1, and t is exact.
            let (k, energy) = (number("delta_k_max").unwrap(), number("delta_energy_max").unwrap());
            assert!(energy >= 0.5 * k * (1.0 - 1e-9) && number("error_t").unwrap() < 1e-12, "{row:?}");
            assert!(number("error_x").unwrap().max(number("error_y").unwrap()) < 1e-2, "{row:?}");
        }
    }
    assert!(accurate > 10, "{accurate}");
    let summary = folder.summary("out");
    let last = summary["last_node"].as_array().unwrap();
    assert!(last.iter().any(|row| row["charge"] == "t" && row["delta_q_last"].as_f64() != Some(0.0)), "{last:?}");
}

#[test]
fn methods_that_a_scene_does_not_have_are_left_out() {
    let folder = Folder::new();
    let text = folder.succeeds("stability kerr-inclined --gamma-f 10,40 --delta-gamma 1 --out out");
    assert!(text.contains("left out Verlet, Kahan-Li 6, Kahan-Li 8: the scene is not separable"), "{text}");
    assert!(!text.contains("unregularised") && text.contains("Gauss 8"), "{text}");
    let error = failed(&folder.program("stability kepler --methods").arg("sbp21 unreg").output().unwrap(), 2);
    assert!(error.contains("SBP21 unregularised is for one coordinate"), "{error}");
}

#[test]
fn scenes_without_time_or_oscillation_and_with_an_end_are_charted() {
    let folder = Folder::new();
    let methods = "--methods sbp42,gll8,rk4,accuracy";
    // Light has no coordinate t here.
    folder.succeeds(&format!("stability fish-eye {methods} --gamma-f 3 --delta-gamma 0.1 --out eye"));
    let table = folder.read("eye/stability.csv");
    assert!(table.lines().nth(1).unwrap().starts_with("SBP42,strong,31,3.0,,"), "{table}");
    let falls = "potential = { coordinates = [\"x\", \"y\"], formula = \"x/10\" }\nparticle.law = \"newtonian\"\n\
         initial = { x = 0.0, y = 0.0, x_dot = 0.0, y_dot = 1.0 }\ngrid = { gamma_f = 4.0, n_gamma = 21 }\n\
         scheme = { sbp = \"SBP42\" }\n";
    folder.write("falls.toml", falls);
    let text = folder.succeeds(&format!("stability falls.toml {methods} --plot --out falls"));
    assert!(text.contains("times 2 pi over the length, 1.5708: nothing oscillates"), "{text}");
    assert!(folder.table("falls/stability.csv").column("status").iter().all(|status| *status == "accurate"));
    // Into the hole: accurate up to the horizon, and nothing behind it.
    let plunge = "stability schwarzschild-orbit --set initial={r=6.0,p_t=1.0,p_phi=-1.0,r_dot=-0.5}";
    let text = folder.succeeds(&format!("{plunge} {methods} --gamma-f 1,400 --delta-gamma 0.05,1 --out hole"));
    assert!(text.contains("the reference trajectory ends at") && text.contains("leaves the domain"), "{text}");
    let table = folder.table("hole/stability.csv");
    let ends: Vec<_> = table.column("gamma_f").into_iter().zip(table.column("status")).collect();
    assert!(ends.contains(&("1.0", "accurate")) && ends.contains(&("400.0", "outside-domain")), "{ends:?}");
    assert!(!ends.contains(&("400.0", "accurate")), "{ends:?}");
}

#[test]
fn what_cannot_be_charted_is_refused() {
    let rough = "stability quartic --set potential={formula={expression=\"abs(x)^2.5\"}} --set initial.x=0.0";
    Folder::new().refuses(&[
        (rough, 3, "no Taylor series"),
        ("stability horizon --methods sbp42 --gamma-f 5", 4, "leaves the domain on every grid"),
        ("stability quartic --methods sbp63 --gamma-f 100 --delta-gamma 1", 3, "no method has a result"),
    ]);
}

#[test]
fn hard_scenes_end_as_they_should() {
    const OTHERS: &str = "--gamma-f 1.5,5 --delta-gamma 0.02,0.1,0.5";
    let folder = Folder::new();
    let ends = |arguments: &str| {
        let output = folder.run(arguments);
        let said = stderr(&output);
        assert!([Some(0), Some(3), Some(4)].contains(&output.status.code()), "{arguments}: {said}");
        assert!(!said.contains("panicked"), "{arguments}: {said}");
        output.status.success()
    };
    // Two lengths and three steps of about the size that the scene has: on grids of the default plan there would be
    // thousands, and a few of each kind are as hard.
    for (scene, grid) in [
        ("horizon", OTHERS),
        ("horizon-near", OTHERS),
        ("nearly-spacelike", OTHERS),
        ("double-well-barrier", OTHERS),
        ("power-20", OTHERS),
        ("huge-units", "--gamma-f 1e100,5e100 --delta-gamma 5e98,1e99,3e99"),
        ("tiny-units", "--gamma-f 1e-100,5e-100 --delta-gamma 5e-102,1e-101,3e-101"),
        ("gamma-short", "--gamma-f 1e-8,5e-8 --delta-gamma 5e-10,1e-9,3e-9"),
        ("gamma-long", "--gamma-f 1e8,5e8 --delta-gamma 5e6,1e7,3e7"),
        ("linear-unregularised", OTHERS),
        ("quartic-unregularised", OTHERS),
        ("pendulum-separatrix", OTHERS),
        ("tanh-wall", OTHERS),
        ("free", OTHERS),
    ] {
        for variant in
            ["", "--set scheme.sbp=SBP21 --set grid.n_gamma=9", "--set scheme.sbp=SBP84 --set grid.n_gamma=16"]
        {
            let is_solved = ends(&format!("run {scene} --out run --plot {variant}"));
            check_tables(&folder, "run");
            assert_eq!(folder.summary("run")["status"] == "converged", is_solved, "{scene} {variant}");
        }
        ends(&format!(
            "stability {scene} --methods sbp21,sbp84,gll8,accuracy,verlet,gauss,radau --out map --plot {grid}"
        ));
        check_tables(&folder, "map");
    }
}

#[test]
fn what_is_not_resolved_is_told() {
    let folder = Folder::new();
    // One window of two nodes does not resolve the motion at all.
    let unresolved = "--set scheme.sbp=GLL2 --set scheme.form=weak --set grid.n_gamma=2";
    let told = folder.succeeds(&format!("run quartic {unresolved} --verbose --out out"));
    assert!(told.contains("K drifts by") && told.contains("raise n_gamma or windows"), "{told}");
    // The bound has its own keys.
    let summary = folder.summary("out");
    assert!(summary["h_bvp_bound_kept"].is_boolean() && summary["h_bvp_defect"].is_number());
}
