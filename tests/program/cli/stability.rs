//! The command `stability`, and the hard scenes: whatever happens, it ends as it should.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::common::{CASES, case_file, json, names, program, run_in, succeeded};

/// No cell of any table in `directory` is NaN or infinite.
fn check_tables(directory: &Path) {
    for name in names(directory).into_iter().filter(|name| name.ends_with(".csv")) {
        let mut reader = csv::Reader::from_path(directory.join(&name)).unwrap();
        for row in reader.records() {
            for cell in row.unwrap().iter() {
                assert!(cell.parse::<f64>().map_or(true, f64::is_finite), "{name} has {cell}");
            }
        }
    }
}

const SMALL: &str = "--methods sbp21,sbp42,gll8,accuracy,rk4,dop853 --gamma-f 1,4 --delta-gamma 0.05,0.2,0.5";

#[test]
fn the_atlas_has_its_columns_its_summary_and_its_pictures() {
    let folder = TempDir::new().unwrap();
    let output = run_in(folder.path(), &format!("stability CASES/quartic.toml {SMALL} --plot --out out"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("runs are accurate") && text.contains("SBP21 windows strong") && text.contains("1.372"),
        "{text}"
    );
    let out = folder.path().join("out");
    let pictures = ["last_node.svg", "map.svg", "map_others.svg", "sawtooth.svg", "stability.csv", "summary.json"];
    assert_eq!(names(&out), pictures);
    let columns = "method,form,n_gamma,gamma_f,t_dot,delta_gamma_omega,status,delta_k_max,delta_q_t_max,error_x_max,\
         sawtooth,iterations,seconds";
    let table = fs::read_to_string(out.join("stability.csv")).unwrap();
    assert_eq!(table.lines().next(), Some(columns));
    assert!(table.contains("SBP21,strong,21,1.0,1.0,0.10") && table.contains("DOP853 tol=1e-6,,"), "{table}");
    check_tables(&out);
    for picture in ["map.svg", "map_others.svg", "sawtooth.svg", "last_node.svg"] {
        let svg = fs::read_to_string(out.join(picture)).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"), "{picture}");
    }
    let summary = json(&out.join("summary.json"));
    assert_eq!(
        (summary["status"].as_str(), summary["methods"][0]["linear_limit"].as_f64()),
        (Some("complete"), Some(1.0))
    );
    assert!(summary["last_node"].as_array().unwrap().iter().any(|row| row["method"] == "SBP42 strong"));
    // Again from standard input, by the tangent, without pictures: the old ones are gone.
    let case = fs::File::open(format!("{CASES}/quartic.toml")).unwrap();
    let arguments = "stability - --methods sbp42 --gamma-f 1 --t-dot 1,4 --out out --quiet";
    let output = program(folder.path()).args(arguments.split(' ')).stdin(case).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(0), 0));
    assert_eq!(names(&out), ["stability.csv", "summary.json"]);
    assert!(fs::read_to_string(out.join("stability.csv")).unwrap().contains(",1.0,4.0,"));
}

#[test]
fn the_atlas_of_a_scene_has_the_errors_of_all_coordinates() {
    let folder = TempDir::new().unwrap();
    let grid = "--gamma-f 2,20 --delta-gamma 0.05,0.3,0.7 --plot";
    let output = run_in(folder.path(), &format!("stability henon-heiles --methods {METHODS} {grid} --out out"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("SBP21 strong") && text.contains("Verlet") && !text.contains("left out"), "{text}");
    let out = folder.path().join("out");
    let pictures = ["last_node.svg", "map.svg", "map_others.svg", "sawtooth.svg", "stability.csv", "summary.json"];
    assert_eq!(names(&out), pictures);
    let columns = "method,form,n_gamma,gamma_f,t_dot,delta_gamma_omega,status,delta_k_max,sawtooth,iterations,seconds,\
         error_t,error_x,error_y,error_s,delta_q_t,delta_q_s,delta_energy_max";
    let mut table = csv::Reader::from_path(out.join("stability.csv")).unwrap();
    assert_eq!(table.headers().unwrap().iter().collect::<Vec<_>>().join(","), columns);
    check_tables(&out);
    let mut accurate = 0;
    for row in table.records().map(Result::unwrap) {
        let number = |column: usize| row[column].parse::<f64>().ok();
        let is_own = row[0].starts_with("SBP") || row[0].starts_with("GLL") || row[0].starts_with("accuracy");
        // Charges are exact whatever becomes of the trajectory; those of other methods are parameters.
        let charges = [15, 16].map(number);
        let exact = charges.iter().all(|charge| charge.is_some_and(|charge| charge < 1e-10));
        assert!(exact == (is_own && number(7).is_some()), "{row:?}");
        if &row[6] == "accurate" {
            accurate += 1;
            // With Newton's law K is -2 p_s (energy off) with p_s = 1, and t is exact.
            let (k, energy) = (number(7).unwrap(), number(17).unwrap());
            assert!(energy >= 0.5 * k * (1.0 - 1e-9) && number(11).unwrap() < 1e-12, "{row:?}");
            assert!(number(12).unwrap().max(number(13).unwrap()) < 1e-2, "{row:?}");
        }
    }
    assert!(accurate > 10, "{accurate}");
    let summary = json(&out.join("summary.json"));
    let last = summary["last_node"].as_array().unwrap();
    assert!(last.iter().any(|row| row["charge"] == "t" && row["delta_q_last"].as_f64() != Some(0.0)), "{last:?}");
    for picture in ["map.svg", "map_others.svg", "sawtooth.svg", "last_node.svg"] {
        let svg = fs::read_to_string(out.join(picture)).unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"), "{picture}");
    }
}

/// One of each kind.
const METHODS: &str = "sbp21,sbp42,gll8,accuracy,rk4,dop853,verlet,gauss,radau,taylor";

#[test]
fn methods_that_a_scene_does_not_have_are_left_out() {
    let folder = TempDir::new().unwrap();
    let small = "--gamma-f 10,40 --delta-gamma 1 --out out";
    let output = run_in(folder.path(), &format!("stability kerr-inclined {small}"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("left out Verlet, Kahan-Li 6, Kahan-Li 8: the scene is not separable"), "{text}");
    assert!(!text.contains("unregularised") && text.contains("Gauss 8"), "{text}");
    let unregularised =
        program(folder.path()).args(["stability", "kepler", "--methods", "sbp21 unreg"]).output().unwrap();
    let stderr = String::from_utf8_lossy(&unregularised.stderr);
    assert!(stderr.contains("SBP21 unregularised is for one coordinate"), "{stderr}");
}

#[test]
fn scenes_without_time_or_oscillation_and_with_an_end_are_charted() {
    let folder = TempDir::new().unwrap();
    let methods = "--methods sbp42,gll8,rk4,accuracy";
    // Light has no coordinate t here.
    let output =
        run_in(folder.path(), &format!("stability fish-eye {methods} --gamma-f 3 --delta-gamma 0.1 --out eye"));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let table = fs::read_to_string(folder.path().join("eye/stability.csv")).unwrap();
    assert!(table.lines().nth(1).unwrap().starts_with("SBP42,strong,31,3.0,,"), "{table}");
    let falls = "potential = { coordinates = [\"x\", \"y\"], formula = \"x/10\" }\nparticle.law = \"newtonian\"\n\
         initial = { x = 0.0, y = 0.0, x_dot = 0.0, y_dot = 1.0 }\ngrid = { gamma_f = 4.0, n_gamma = 21 }\n\
         scheme = { sbp = \"SBP42\" }\n";
    fs::write(folder.path().join("falls.toml"), falls).unwrap();
    let output = run_in(folder.path(), &format!("stability falls.toml {methods} --plot --out falls"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("times 2 pi over the length, 1.5708: nothing oscillates"), "{text}");
    let table = fs::read_to_string(folder.path().join("falls/stability.csv")).unwrap();
    assert!(table.lines().skip(1).all(|row| row.contains(",accurate,")), "{table}");
    // Into the hole: accurate up to the horizon, and nothing behind it.
    let plunge = "stability schwarzschild-orbit --set initial={r=6.0,p_t=1.0,p_phi=-1.0,r_dot=-0.5}";
    let output = run_in(folder.path(), &format!("{plunge} {methods} --gamma-f 1,400 --delta-gamma 0.05,1 --out hole"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("the reference trajectory ends at") && text.contains("leaves the domain"), "{text}");
    let table = fs::read_to_string(folder.path().join("hole/stability.csv")).unwrap();
    let statuses = |length: &str| {
        let rows = table.lines().filter(|row| row.split(',').nth(3) == Some(length));
        rows.map(|row| row.split(',').nth(6).unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert!(statuses("1.0").contains(&"accurate".to_owned()), "{table}");
    assert!(!statuses("400.0").contains(&"accurate".to_owned()), "{table}");
    assert!(statuses("400.0").contains(&"outside-domain".to_owned()), "{table}");
}

#[test]
fn what_cannot_be_charted_is_refused() {
    let folder = TempDir::new().unwrap();
    let rough =
        "stability CASES/quartic.toml --set potential={formula={expression=\"abs(x)^2.5\"}} --set initial.x=0.0";
    for (arguments, code, message) in [
        ("stability CASES/quartic.toml --methods euler", 2, "no method is called 'euler'"),
        ("stability CASES/quartic.toml --gamma-f 0", 2, "expected a positive number"),
        (rough, 3, "no Taylor series"),
        ("stability CASES/hard/horizon.toml --methods sbp42 --gamma-f 5", 4, "leaves the domain on every grid"),
        ("stability CASES/quartic.toml --methods sbp63 --gamma-f 100 --delta-gamma 1", 3, "no method has a result"),
    ] {
        let output = run_in(folder.path(), arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {stderr}");
        assert!(stderr.contains(message), "{arguments}: {stderr}");
    }
}

#[test]
fn hard_scenes_end_as_they_should() {
    let folder = TempDir::new().unwrap();
    let scenes = "horizon horizon-near nearly-spacelike double-well-barrier power-20 huge-units tiny-units gamma-short \
                  gamma-long linear-unregularised quartic-unregularised pendulum-separatrix tanh-wall free";
    for scene in scenes.split_whitespace() {
        let variants =
            ["", " --set scheme.sbp=SBP21 --set grid.n_gamma=9", " --set scheme.sbp=SBP84 --set grid.n_gamma=16"];
        for variant in variants {
            let output = run_in(folder.path(), &format!("run {} --out run --plot{variant}", case_file(scene)));
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!([Some(0), Some(3), Some(4)].contains(&output.status.code()), "{scene}{variant}: {stderr}");
            assert!(!stderr.contains("panicked"), "{scene}{variant}: {stderr}");
            check_tables(&folder.path().join("run"));
            let summary = json(&folder.path().join("run/summary.json"));
            assert_eq!(summary["status"] == "converged", output.status.success(), "{scene}{variant}");
        }
        // On grids of the default plan there would be thousands; a few of each kind are as hard.
        let small = "--methods sbp21,sbp84,gll8,accuracy,verlet,gauss,radau --out map --plot";
        let output = run_in(folder.path(), &format!("stability {} {small} {}", case_file(scene), grid(scene)));
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!([Some(0), Some(3), Some(4)].contains(&output.status.code()), "{scene}: {stderr}");
        check_tables(&folder.path().join("map"));
    }
}

/// Two lengths and three steps of about the size that the scene has.
fn grid(scene: &str) -> &'static str {
    match scene {
        "huge-units" => "--gamma-f 1e100,5e100 --delta-gamma 5e98,1e99,3e99",
        "tiny-units" => "--gamma-f 1e-100,5e-100 --delta-gamma 5e-102,1e-101,3e-101",
        "gamma-short" => "--gamma-f 1e-8,5e-8 --delta-gamma 5e-10,1e-9,3e-9",
        "gamma-long" => "--gamma-f 1e8,5e8 --delta-gamma 5e6,1e7,3e7",
        _ => "--gamma-f 1.5,5 --delta-gamma 0.02,0.1,0.5",
    }
}

#[test]
fn what_is_not_resolved_is_told() {
    let folder = TempDir::new().unwrap();
    // One window of two nodes does not resolve the motion at all.
    let unresolved = "--set scheme.sbp=GLL2 --set scheme.form=weak --set grid.n_gamma=2";
    let output = run_in(folder.path(), &format!("run CASES/quartic.toml {unresolved} --verbose --out out"));
    let told = succeeded(&output);
    assert!(told.contains("K drifts by") && told.contains("raise n_gamma or windows"), "{told}");
    // The bound has its own keys.
    let summary = json(&folder.path().join("out/summary.json"));
    assert!(summary["h_bvp_bound_kept"].is_boolean() && summary["h_bvp_defect"].is_number());
}
