//! Malformed cases that no page can show, and runs without a result: each ends with the exit code and the message that
//! say what is wrong and where, prints nothing on standard output and leaves no result behind. What people write by
//! mistake is in `tests/cmd/malformed-cases.md` and the pages beside it.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::Stdio;

use tempfile::TempDir;

use crate::common::tree;

const PROGRAM: &str = env!("CARGO_BIN_EXE_geodesic-ivp");

const HORIZON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/hard/horizon.toml");

/// A valid case.
const QUARTIC: &str = r#"title = "Quartic"

[potential]
quartic = { kappa = 0.5 }

[particle]
mass = 1.0
c = 1.0

[initial]
t = 0.0
x = 1.0
x_dot = 0.1
t_dot = 1.0

[grid]
gamma_f = 1.0
n_gamma = 32

[scheme]
sbp = "SBP21"

[solver]
max_iterations = 50
"#;

const POTENTIAL: &str = "quartic = { kappa = 0.5 }";

/// A directory to run the program in.
struct Workspace(TempDir);

struct Outcome {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Workspace {
    fn new() -> Self {
        let workspace = Self(TempDir::new().unwrap());
        workspace.write("case.toml", QUARTIC);
        workspace.write("earlier/trajectory.csv", "of an earlier run");
        workspace
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.0.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    fn run(&self, arguments: &[&str], stdin: &str) -> Outcome {
        let mut command = assert_cmd::Command::new(PROGRAM);
        let output = command.args(arguments).current_dir(self.0.path()).write_stdin(stdin).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Runs what must fail without a trace, and says what is not as it should be.
    fn complaints(&self, arguments: &[&str], stdin: &str, code: i32, fragments: &[&str]) -> Vec<String> {
        let before = tree(self.0.path());
        let Outcome { code: found, stdout, stderr } = self.run(arguments, stdin);
        let mut complaints = Vec::new();
        if found != Some(code) {
            complaints.push(format!("exit code {found:?} instead of {code}"));
        }
        if !stdout.is_empty() {
            complaints.push(format!("standard output: {stdout}"));
        }
        if tree(self.0.path()) != before {
            complaints.push("files were written or removed".to_owned());
        }
        complaints.extend(fragments.iter().filter(|f| !stderr.contains(**f)).map(|f| format!("no {f:?}")));
        if !complaints.is_empty() {
            complaints.push(format!("{arguments:?} said: {stderr}"));
        }
        complaints
    }

    fn names_in(&self, directory: &str) -> Vec<PathBuf> {
        let all = tree(&self.0.path().join(directory)).into_keys();
        // But for the program's own record of them.
        all.filter(|name| name != Path::new(crate::common::MANIFEST)).collect()
    }
}

/// All failed rows in one message.
fn report(rows: impl Iterator<Item = (String, Vec<String>)>) {
    let failed: Vec<String> = rows
        .filter(|(_, complaints)| !complaints.is_empty())
        .map(|(name, complaints)| format!("{name}:\n  {}", complaints.join("\n  ")))
        .collect();
    assert!(failed.is_empty(), "{} rows failed\n{}", failed.len(), failed.join("\n"));
}

fn edited(from: &str, to: &str) -> String {
    assert_eq!(QUARTIC.matches(from).count(), 1, "{from:?} must stand in the case once");
    QUARTIC.replace(from, to)
}

fn with_formula(expression: &str) -> String {
    edited(POTENTIAL, &format!("formula = {{ expression = \"{expression}\" }}"))
}

/// (name, text, line:column, message) of every invalid case.
fn invalid_cases() -> Vec<(String, String, String, String)> {
    let row = |name: &str, text: String, at: &str, message: &str| (name.into(), text, at.into(), message.into());
    let formula = |name: &str, expression: &str, character: usize, message: &str| {
        let column = "formula = { expression = \"".len() + character;
        row(&format!("formula: {name}"), with_formula(expression), &format!("4:{column}"), message)
    };
    let not_finite = edited("x = 1.0", "x = nan");
    vec![
        formula("nested too deep", &"(".repeat(1000), 65, "nested more than 64 deep"),
        formula("functions nested too deep", &"sin(".repeat(100), 257, "nested more than 64 deep"),
        formula("signs without end", &"-".repeat(60_000), 60_001, "found the end"),
        formula("powers without end", &"2^".repeat(30_000), 1026, "more than 512 powers of powers"),
        formula("too long", &"-".repeat(70_000), 1, "longer than 65536 bytes"),
        row("no text", String::new(), "1:1", "missing fields `potential`, `initial`, `scheme`, `grid`"),
        row("JSON", "{\"title\": 1}".to_owned(), "1:1", "expected key"),
        row("nested arrays", edited("x = 1.0", &format!("x = {}", "[".repeat(100_000))), "12:85", "recursion"),
        row("CRLF line ends", not_finite.replace('\n', "\r\n"), "12:5", "'initial.x' must be a finite number"),
        row("byte-order mark", format!("\u{feff}{not_finite}"), "12:5", "'initial.x' must be a finite number"),
    ]
}

#[test]
fn invalid_cases_are_refused_where_they_are_wrong() {
    let workspace = Workspace::new();
    let rows = invalid_cases();
    report(rows.into_iter().map(|(name, text, at, message)| {
        workspace.write("case.toml", &text);
        let commands: [(&str, &[&str]); 4] = [
            ("case.toml", &["check", "case.toml"]),
            ("case.toml", &["run", "case.toml", "--out", "new"]),
            ("case.toml", &["run", "case.toml", "--out", "earlier"]),
            ("<stdin>", &["run", "-", "--out", "new"]),
        ];
        let complaints = commands.into_iter().map(|(source, arguments)| {
            let place = format!("{source}:{at}\n");
            workspace.complaints(arguments, &text, 2, &["error: ", &message, &place])
        });
        // The four differ in little; the first that complains says it all.
        (name, complaints.into_iter().find(|complaints| !complaints.is_empty()).unwrap_or_default())
    }));
}

#[test]
fn extreme_formulas_end_in_order() {
    let workspace = Workspace::new();
    let rows = [
        ("63 parentheses", format!("{}x{}", "(".repeat(63), ")".repeat(63)), 0),
        ("1000 signs", format!("{}x", "-".repeat(1000)), 0),
        ("500 powers", format!("x{}", "^x".repeat(500)), 0),
        ("huge exponent", "x^1e300".to_owned(), 2),
    ];
    report(rows.into_iter().map(|(name, expression, code)| {
        let outcome = workspace.run(&["run", "-", "--out", "new", "--quiet"], &with_formula(&expression));
        let wrong = (outcome.code != Some(code)).then(|| format!("{:?}: {}", outcome.code, outcome.stderr));
        (name.to_owned(), wrong.into_iter().collect())
    }));
}

#[test]
fn a_spacelike_start_is_a_warning() {
    let workspace = Workspace::new();
    let outcome = workspace.run(&["run", "case.toml", "--out", "new", "--quiet", "--set", "initial.x_dot=10.0"], "");
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stderr.starts_with("warning: the initial tangent is spacelike"), "{}", outcome.stderr);
    assert!(workspace.names_in("new").contains(&PathBuf::from("trajectory.csv")));
}

/// A solve without a result explains itself in `summary.json` and takes the tables of an earlier run away.
#[test]
fn failed_runs_leave_no_tables() {
    const TOO_COARSE: &str = "scheme.sbp=SBP42 grid.n_gamma=8 grid.gamma_f=20.0";
    let rows = [
        (
            HORIZON,
            "",
            4,
            "outside-domain",
            ["leaves the domain at gamma = 1.", ", x = ", "help: g00 = c^2 + 2V/m must"],
        ),
        ("case.toml", TOO_COARSE, 3, "stalled", ["no critical point found (stalled)", ", x = ", "help: raise n_gamma"]),
    ];
    report(rows.into_iter().map(|(case, settings, code, status, fragments)| {
        let workspace = Workspace::new();
        let good = workspace.run(&["run", "case.toml", "--out", "used", "--quiet"], "");
        let all = ["case.toml", "residuals.csv", "summary.json", "trajectory.csv"].map(PathBuf::from);
        assert_eq!((good.code, workspace.names_in("used")), (Some(0), all.to_vec()), "{}", good.stderr);
        let mut complaints = Vec::new();
        for out in ["new", "used"] {
            let settings = settings.split_whitespace().flat_map(|setting| ["--set", setting]);
            let arguments: Vec<&str> = ["run", case, "--out", out].into_iter().chain(settings).collect();
            let outcome = workspace.run(&arguments, "");
            let summary = fs::read_to_string(workspace.0.path().join(out).join("summary.json")).unwrap_or_default();
            let as_expected = outcome.code == Some(code)
                && outcome.stdout.is_empty()
                && fragments.iter().all(|f| outcome.stderr.contains(f))
                && workspace.names_in(out) == ["case.toml", "summary.json"].map(PathBuf::from)
                && summary.contains(&format!("\"status\": \"{status}\""));
            if !as_expected {
                let Outcome { code, stdout, stderr } = outcome;
                complaints.push(format!("{out}: {code:?}\n{stdout}{stderr}\n{summary}"));
            }
        }
        (status.to_owned(), complaints)
    }));
}

/// `run CASE --stdout | head -1`
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let workspace = Workspace::new();
    let mut child = std::process::Command::new(PROGRAM)
        .args(["run", "case.toml", "--stdout", "--set", "grid.n_gamma=200000", "--set", "particle.c=2000.0"])
        .current_dir(workspace.0.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut header = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut header).unwrap();
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert!(header.starts_with("gamma,t,x,"), "{header}");
    assert_eq!((child.wait().unwrap().code(), stderr.as_str()), (Some(0), ""));
}
