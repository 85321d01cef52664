//! Work and memory are bounded before they are spent.

use std::fs::File;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::common::{failed, run_in};

#[test]
fn a_case_as_long_as_a_book_is_not_read() {
    let folder = TempDir::new().unwrap();
    File::create(folder.path().join("huge.toml")).unwrap().set_len(1 << 30).unwrap();
    let start = Instant::now();
    let message = failed(&run_in(folder.path(), "run huge.toml"), 2);
    assert!(message.contains("too long for a case: it has 1073741824 bytes, 1048576 at most"), "{message}");
    assert!(start.elapsed() < Duration::from_millis(300));
}

#[cfg(unix)]
#[test]
fn an_endless_case_is_not_read() {
    let message = failed(&super::streams::shell("yes | PROGRAM run -"), 2);
    assert!(message.contains("<stdin>: too long for a case"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_that_does_not_fit_is_refused_with_the_number() {
    let limited_case = |case: &str, settings: &str| {
        let settings: String = settings.split_whitespace().map(|setting| format!(" --set {setting}")).collect();
        super::streams::shell(&format!("ulimit -v 2000000; exec PROGRAM run CASES/{case}.toml{settings}"))
    };
    let limited = |settings: &str| limited_case("quartic", settings);
    for (settings, needed) in [
        ("grid.n_gamma=100000000 solver.digits=70", "needs about 73.61 GB of memory for 100000000 nodes in 70 digits"),
        ("grid.n_gamma=1000 grid.windows=100000", "needs about 18.45 GB"),
        ("grid.n_gamma=2000000 solver.system=doubled", "needs about 2.13 GB"),
        ("grid.n_gamma=20000000 scheme.sbp=SBP84", "needs about 7.47 GB"),
    ] {
        let start = Instant::now();
        let message = failed(&limited(settings), 2);
        assert!(message.contains(needed) && message.contains("take fewer nodes"), "{settings}: {message}");
        assert!(start.elapsed() < Duration::from_secs(1));
    }
    // What is said to fit does.
    for settings in ["grid.n_gamma=300000", "grid.n_gamma=50000 scheme.sbp=SBP42 solver.system=doubled"] {
        assert_eq!(limited(settings).status.code(), Some(0), "{settings}");
    }
    // Scenes, of which two-bodies has SBP42 in one window.
    for (scene, settings) in [
        ("two-bodies", "grid.n_gamma=50000000"),
        ("two-bodies", "grid.n_gamma=1000000 solver.system=doubled"),
        ("kepler", "grid.windows=2000000"),
    ] {
        let message = failed(&limited_case(&format!("scenes/{scene}"), settings), 2);
        assert!(message.contains("GB of memory for") && message.contains("take fewer nodes"), "{settings}: {message}");
    }
    assert_eq!(limited_case("scenes/two-bodies", "grid.n_gamma=100000").status.code(), Some(0));
}

/// With less room than a command begins with it ends with a message, and is not aborted somewhere on its way.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_address_space_is_told_of_at_the_start() {
    let limited =
        |kilobytes: u32, line: &str| super::streams::shell(&format!("ulimit -v {kilobytes}; exec PROGRAM {line}"));
    for (kilobytes, line) in [
        (100_000, "run quartic"),
        (100_000, "check quartic"),
        (200_000, "converge"),
        (200_000, "stability quartic"),
        (200_000, "work-precision quartic"),
        (200_000, "run quartic --vary initial.x=0:1:10"),
    ] {
        let message = failed(&limited(kilobytes, line), 1);
        assert!(message.contains("a limit leaves") && message.contains("ulimit -v"), "{line}: {message}");
    }
    assert_eq!(limited(100_000, "init quartic").status.code(), Some(0));
}
