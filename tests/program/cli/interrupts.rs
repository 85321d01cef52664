//! Ctrl-C and SIGTERM end every command soon, whatever it computes, with 130 and with the rows that were finished.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::common::{CASES, json, program};

/// The program promises one second; a machine that is busy may take longer to let it have its turn.
const SOON: Duration = Duration::from_secs(4);

/// Starts the program, sends the signal after a while, and returns what it says until it ends.
fn interrupted(directory: &Path, arguments: &str, signal: &str, after: Duration) -> String {
    let mut child = program(directory)
        .args(arguments.replace("CASES", CASES).split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    sleep(after);
    let sent = Instant::now();
    assert!(Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap().success());
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{arguments}: {stderr}");
    assert!(sent.elapsed() < SOON, "{arguments} took {:?} to end", sent.elapsed());
    println!("{signal} {:.60}: {:.3} s", arguments, sent.elapsed().as_secs_f64());
    stderr
}

/// Much to do for a single computation, in little memory.
const DOUBLED: &str = "--set solver.system=doubled --set grid.gamma_f=1000.0 --set scheme.sbp=SBP42";

#[test]
fn a_study_ends_in_the_middle_of_a_computation_and_keeps_its_rows() {
    let sweep = format!("converge CASES/quartic.toml {DOUBLED} --n-gamma 80001,160001,320001 --sbp SBP42 --out out");
    let chart = "work-precision CASES/quartic.toml --longest 20 --out out";
    // The reference alone takes seconds.
    let atlas = "stability CASES/quartic.toml --methods rk4 --gamma-f 1,30000 --delta-gamma 0.05 --out out";
    for (arguments, table) in
        [(sweep.as_str(), "convergence.csv"), (chart, "work_precision.csv"), (atlas, "stability.csv")]
    {
        for signal in ["INT", "TERM"] {
            let folder = TempDir::new().unwrap();
            let stderr = interrupted(folder.path(), arguments, signal, Duration::from_millis(1500));
            let out = folder.path().join("out");
            // On a busy machine the reference may not be there yet, and then there is nothing to write.
            let nothing = stderr.contains("interrupted before anything was finished: no file was written");
            assert!(nothing || stderr.contains("were finished and are in"), "{arguments}: {stderr}");
            assert_eq!(out.join(table).exists(), !nothing, "{stderr}");
            if !nothing {
                assert_eq!(json(&out.join("summary.json"))["status"], "interrupted");
            }
            if arguments == chart && !nothing {
                let rows = fs::read_to_string(out.join(table)).unwrap().lines().count();
                assert!(rows > 1, "settings that take milliseconds have their rows");
            }
        }
    }
}

#[test]
fn every_other_command_ends_too() {
    let grids: Vec<String> = (20_000..22_000).map(|n| n.to_string()).collect();
    let spectral = "--set scheme.sbp=GLL20 --set grid.n_gamma=20 --set grid.gamma_f=1e6 --set grid.windows=4000000";
    for arguments in [
        format!("run CASES/quartic.toml {DOUBLED} --set grid.n_gamma=320001 --out out"),
        format!("check CASES/quartic.toml {DOUBLED} --set grid.n_gamma=320001 --run"),
        format!("run CASES/quartic-windows.toml {spectral} --sample-gamma 0:1e6:1000 --samples-only --out out"),
        format!("converge --n-gamma {} --out out", grids.join(",")),
    ] {
        for signal in ["INT", "TERM"] {
            let folder = TempDir::new().unwrap();
            interrupted(folder.path(), &arguments, signal, Duration::from_millis(1000));
            assert!(
                !folder.path().join("out/trajectory.csv").exists() && !folder.path().join("out/samples.csv").exists()
            );
        }
    }
}
