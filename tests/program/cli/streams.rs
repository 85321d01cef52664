//! Standard output that cannot be written is noticed.

use std::process::{Command, Output};

use crate::common::{CASES, failed, stderr};

/// Runs a line of the shell in which PROGRAM is the program and CASES the folder of the shipped cases.
pub(crate) fn shell(line: &str) -> Output {
    let line = line.replace("PROGRAM", concat!("'", env!("CARGO_BIN_EXE_geodesic-ivp"), "'")).replace("CASES", CASES);
    let folder = tempfile::TempDir::new().unwrap();
    Command::new("sh").current_dir(folder.path()).args(["-c", &line]).output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn lost_output_is_an_error() {
    for command in ["run CASES/quartic.toml --stdout", "run quartic --json", "init quartic", "completions bash", "man"]
    {
        let message = failed(&shell(&format!("PROGRAM {command} >&-")), 1);
        assert!(message.contains("standard output is closed"), "{command}: {message}");
        let message = failed(&shell(&format!("PROGRAM {command} >/dev/full")), 1);
        assert!(message.contains("No space left"), "{command}: {message}");
    }
    for command in
        ["run CASES/quartic.toml", "check CASES/quartic.toml", "check --run CASES/quartic.toml", "init --list"]
    {
        failed(&shell(&format!("PROGRAM {command} >/dev/full")), 1);
    }
}

#[test]
fn output_that_nobody_wants_is_no_error() {
    for line in [
        "PROGRAM run CASES/quartic.toml --stdout >/dev/null",
        "PROGRAM check CASES/quartic.toml >&-",
        "PROGRAM run CASES/quartic.toml --json >/dev/null",
        "PROGRAM run CASES/quartic.toml --quiet >&-",
        "PROGRAM run CASES/quartic.toml --stdout --set grid.n_gamma=200000 | head -1",
    ] {
        let output = shell(line);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
    }
}
