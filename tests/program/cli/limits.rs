//! Work and memory are bounded before they are spent.

use std::fs::File;
use std::time::{Duration, Instant};

use crate::common::Folder;
#[cfg(unix)]
use crate::common::{failed, shell};

#[test]
fn a_case_as_long_as_a_book_is_not_read() {
    let folder = Folder::new();
    File::create(folder.path("huge.toml")).unwrap().set_len(1 << 30).unwrap();
    let start = Instant::now();
    let message = folder.fails("run huge.toml", 2);
    assert!(message.contains("too long for a case: it has 1073741824 bytes, 1048576 at most"), "{message}");
    assert!(start.elapsed() < Duration::from_millis(300));
}

#[cfg(unix)]
#[test]
fn an_endless_case_is_not_read() {
    let message = failed(&shell(&Folder::new().path(""), "yes | geodesic-ivp run -"), 2);
    assert!(message.contains("<stdin>: too long for a case"), "{message}");
}

/// What does not fit is refused with the number, and with less room than a command begins with it ends with a message,
/// and is not aborted somewhere on its way. What is said to fit does. Of the scenes two-bodies has SBP42 in one window.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_address_space_is_told_of_at_the_start() {
    const DIGITS: &str = "needs about 73.61 GB of memory for 100000000 nodes in 70 digits … take fewer nodes";
    const FEWER: &str = "GB of memory for … take fewer nodes";
    const LEFT: &str = "a limit leaves … ulimit -v";
    let folder = Folder::new();
    // A plus stands for --set.
    for (gigabytes, line, code, words) in [
        (2.0, "run quartic + grid.n_gamma=100000000 + solver.digits=70", 2, DIGITS),
        (2.0, "run quartic + grid.n_gamma=1000 + grid.windows=100000", 2, "needs about 18.45 GB … take fewer nodes"),
        (2.0, "run quartic + grid.n_gamma=2000000 + solver.system=doubled", 2, "needs about 2.13 GB … fewer nodes"),
        (2.0, "run quartic + grid.n_gamma=20000000 + scheme.sbp=SBP84", 2, "needs about 7.47 GB … take fewer nodes"),
        (2.0, "run two-bodies + grid.n_gamma=50000000", 2, FEWER),
        (2.0, "run two-bodies + grid.n_gamma=1000000 + solver.system=doubled", 2, FEWER),
        (2.0, "run kepler + grid.windows=2000000", 2, FEWER),
        (2.0, "run quartic + grid.n_gamma=300000", 0, ""),
        (2.0, "run quartic + grid.n_gamma=50000 + scheme.sbp=SBP42 + solver.system=doubled", 0, ""),
        (2.0, "run two-bodies + grid.n_gamma=100000", 0, ""),
        (0.1, "run quartic", 1, LEFT),
        (0.1, "check quartic", 1, LEFT),
        (0.2, "converge", 1, LEFT),
        (0.2, "stability quartic", 1, LEFT),
        (0.2, "work-precision quartic", 1, LEFT),
        (0.2, "run quartic --vary initial.x=0:1:10", 1, LEFT),
        (0.1, "init quartic", 0, ""),
    ] {
        let start = Instant::now();
        let limit = format!("ulimit -v {}; exec geodesic-ivp {}", 1e6 * gigabytes, line.replace('+', "--set"));
        let message = failed(&shell(&folder.path(""), &limit), code);
        assert!(words.split(" … ").all(|words| message.contains(words)), "{line}: {message}");
        assert!(code == 0 || start.elapsed() < Duration::from_secs(1), "{line}");
    }
}
