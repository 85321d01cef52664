//! Ctrl-C and SIGTERM end every command soon, whatever it computes, with 130 and with the rows that were finished.

use std::io::Read;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::Folder;

/// The program promises one second; a machine that is busy may take longer to let it have its turn.
const SOON: Duration = Duration::from_secs(4);

/// Starts the program twice, sends each one of the signals after a while, and returns the folders with what is said
/// until the end.
fn interrupted(arguments: &str, milliseconds: u64) -> [(Folder, String); 2] {
    let started = ["INT", "TERM"].map(|signal| {
        let folder = Folder::new();
        let child = folder.program(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        (signal, folder, child)
    });
    sleep(Duration::from_millis(milliseconds));
    started.map(|(signal, folder, mut child)| {
        let sent = Instant::now();
        let kill = [format!("-{signal}"), child.id().to_string()];
        assert!(Command::new("kill").args(kill).status().unwrap().success());
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{arguments:.60}: {stderr}");
        assert!(sent.elapsed() < SOON, "{arguments:.60} took {:?} to end", sent.elapsed());
        (folder, stderr)
    })
}

/// Much to do for a single computation, in little memory.
const DOUBLED: &str = "--set solver.system=doubled --set grid.gamma_f=1000.0 --set scheme.sbp=SBP42";

/// Computations that take seconds each, and so many small ones that some are done and some are left at the signal.
#[test]
fn a_study_ends_in_the_middle_and_keeps_its_rows() {
    let sweep = format!("converge quartic {DOUBLED} --n-gamma 80001,160001,320001 --sbp SBP42");
    // The reference alone takes seconds.
    let atlas = "stability quartic --methods rk4 --gamma-f 1,30000 --delta-gamma 0.05";
    let grids = (20_000..24_000).map(|n| n.to_string()).collect::<Vec<_>>().join(",");
    let steps = (0..3000).map(|k| format!("{:e}", 1e-4 + 1e-9 * f64::from(k))).collect::<Vec<_>>().join(",");
    let grids = format!("converge quartic --n-gamma {grids}");
    let steps = format!("stability quartic --methods sbp42,rk4 --gamma-f 1,2 --delta-gamma {steps}");
    for (study, milliseconds, table, words, rows) in [
        (sweep.as_str(), 1500, "convergence.csv", "grids were finished", 0..9),
        (atlas, 1500, "stability.csv", "cells were finished", 0..9),
        ("work-precision quartic --longest 20", 1500, "work_precision.csv", "settings were finished", 2..999),
        (&*grids, 700, "convergence.csv", "grids were finished", 2..8000),
        (&*steps, 700, "stability.csv", "cells were finished", 2..15_000),
    ] {
        for (folder, stderr) in interrupted(&format!("{study} --out out"), milliseconds) {
            // On a busy machine the reference may not be there yet, and then there is nothing to write.
            if rows.start == 0 && stderr.contains("interrupted before anything was finished: no file was written") {
                assert!(!folder.has(&format!("out/{table}")), "{stderr}");
                continue;
            }
            assert!(stderr.contains("interrupted:") && stderr.contains(words), "{study:.60}: {stderr}");
            assert_eq!(folder.summary("out")["status"], "interrupted");
            let count = folder.read(&format!("out/{table}")).lines().count();
            assert!(rows.contains(&count), "{study:.60}: {count} rows");
        }
    }
}

#[test]
fn every_other_command_ends_too() {
    let spectral = "--set scheme.sbp=GLL20 --set grid.n_gamma=20 --set grid.gamma_f=1e6 --set grid.windows=4000000";
    let grids = (20_000..22_000).map(|n| n.to_string()).collect::<Vec<_>>().join(",");
    for arguments in [
        format!("run quartic {DOUBLED} --set grid.n_gamma=320001 --out out"),
        format!("check quartic {DOUBLED} --set grid.n_gamma=320001 --run"),
        format!("run quartic-windows {spectral} --sample-gamma 0:1e6:1000 --samples-only --out out"),
        format!("converge --n-gamma {grids} --out out"),
    ] {
        for (folder, _) in interrupted(&arguments, 1000) {
            assert!(!folder.has("out/trajectory.csv") && !folder.has("out/samples.csv"), "{arguments}");
        }
    }
}
