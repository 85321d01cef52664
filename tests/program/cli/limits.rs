//! Work and memory are bounded before they are spent.

use std::fs::File;
use std::time::{Duration, Instant};

use crate::common::{Folder, stderr};
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

/// Every file that a command names is read up to a limit, or a device without an end would fill the memory.
#[cfg(target_os = "linux")]
#[test]
fn an_endless_file_is_refused_wherever_it_is_named() {
    let folder = Folder::new();
    folder.write(
        "table.toml",
        "tables.v = { file = \"/dev/zero\", x = \"r\", y = \"v\" }\npotential.formula = \"v(x)\"\n",
    );
    for (line, words) in [
        ("run /dev/zero", "too long for a case: it has more bytes, 1048576 at most"),
        ("run quartic --from /dev/zero", "cannot read /dev/zero: it has more than 16777216 bytes"),
        ("run quartic --sample-t @/dev/zero:t", "cannot read /dev/zero: it has more than 268435456 bytes"),
        ("run table.toml", "cannot read the table /dev/zero: it has more than 268435456 bytes"),
    ] {
        let limit = format!("ulimit -v 2000000; exec geodesic-ivp {line}");
        let message = failed(&shell(&folder.path(""), &limit), 2);
        assert!(message.contains(words), "{line}: {message}");
    }
}

/// The system kills a program that writes beyond the limit, unless it asks for an error in place of that.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_the_size_of_files_is_an_error_like_any_other() {
    let folder = Folder::new();
    for line in ["run quartic --out a", "run quartic --vary initial.x=0:1:100 --out a", "run quartic --stdout"] {
        let message = failed(&shell(&folder.path(""), &format!("ulimit -f 1; exec geodesic-ivp {line}")), 1);
        assert!(message.contains("File too large") && message.contains("ulimit -f"), "{line}: {message}");
        assert!(!folder.has("a/summary.json"));
    }
}

#[test]
fn more_threads_than_are_of_use_are_not_started() {
    let folder = Folder::new();
    let run = |threads: &str| {
        let mut run = folder.program("run free --vary initial.x=0,1 --stdout");
        let output = run.env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        stderr(&output)
    };
    let told = run("100000");
    assert!(told.contains("RAYON_NUM_THREADS = 100000 is more than 4 threads for each of"), "{told}");
    assert!(!run("2").contains("RAYON_NUM_THREADS"));
}

/// With a spline through so many points the program is in the profile of the tests twice as slow as in a release.
#[test]
fn a_table_of_a_million_points_is_read_in_seconds() {
    let folder = Folder::new();
    let row = |k: u32| format!("{},{:?}\n", f64::from(k) * 1e-5, (f64::from(k) * 1e-5).cos());
    folder.write("points.csv", format!("r,v\n{}", (0..1_000_000).map(row).collect::<String>()));
    folder.write(
        "table.toml",
        "tables.v = { file = \"points.csv\", x = \"r\", y = \"v\" }\npotential.formula = \"v(x)\"\n\
         particle.law = \"newtonian\"\ninitial = { x = 3, x_dot = 0 }\ngrid.t_f = 1\nsolver.accuracy = 1e-6\n",
    );
    let start = Instant::now();
    folder.succeeds("check table.toml --quiet");
    assert!(start.elapsed() < Duration::from_secs(15), "{:?}", start.elapsed());
}
