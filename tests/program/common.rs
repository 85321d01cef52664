//! Running the program.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// The folder of the project.
pub(crate) const ROOT: &str = env!("CARGO_MANIFEST_DIR");

pub(crate) const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");

/// The program keeps a record of its files here.
pub(crate) const MANIFEST: &str = ".geodesic-ivp-manifest.json";

/// A folder of its own, in which the program is run.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    /// Writes a file, and the folders that it stands in.
    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn first_line(&self, name: &str) -> String {
        self.read(name).lines().next().unwrap().to_owned()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// The summary in a folder of results.
    pub(crate) fn summary(&self, out: &str) -> Value {
        self.json(&format!("{out}/summary.json"))
    }

    pub(crate) fn table(&self, name: &str) -> Table {
        let text = self.read(name);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let cells = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect();
        let columns = cells(reader.headers().unwrap());
        Table { columns, rows: reader.records().map(|row| cells(&row.unwrap())).collect() }
    }

    /// The names of all that is in a folder but for the program's own record.
    pub(crate) fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|name| name != MANIFEST);
        names.sort();
        names
    }

    /// Every picture of a folder is one, without a number that is none; their names.
    pub(crate) fn pictures(&self, folder: &str) -> Vec<String> {
        let pictures: Vec<String> = self.names(folder).into_iter().filter(|name| name.ends_with(".svg")).collect();
        for name in &pictures {
            let svg = self.read(&format!("{folder}/{name}"));
            assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"), "{name}");
        }
        pictures
    }

    /// The program with blank-separated arguments, in which CASES is the folder of the shipped cases.
    pub(crate) fn program(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_geodesic-ivp"));
        command.args(arguments.replace("CASES", CASES).split_whitespace()).current_dir(self.0.path());
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Output {
        self.program(arguments).output().unwrap()
    }

    /// Standard output of a command that must end well.
    pub(crate) fn succeeds(&self, arguments: &str) -> String {
        succeeded(&self.run(arguments))
    }

    /// Standard error of a command that must end with `code`.
    pub(crate) fn fails(&self, arguments: &str, code: i32) -> String {
        failed(&self.run(arguments), code)
    }

    /// Commands that must end with a code and a message, in which all words stand that a row has between " … ". Refused
    /// ones print nothing on standard output and leave the folder as it was. All failed rows are in one message.
    pub(crate) fn refuses<A: AsRef<str>, W: AsRef<str>>(&self, rows: &[(A, i32, W)]) {
        let mut complaints = Vec::new();
        for (arguments, code, words) in rows {
            let before = tree(self.0.path());
            let output = self.run(arguments.as_ref());
            let said = stderr(&output);
            let is_told = words.as_ref().split(" … ").all(|words| said.contains(words));
            let is_clean = *code > 2 || output.stdout.is_empty() && tree(self.0.path()) == before;
            if output.status.code() != Some(*code) || !is_told || !is_clean {
                let (arguments, words) = (arguments.as_ref(), words.as_ref());
                complaints.push(format!("{arguments}\n  {code} and {words:?}, but {output:?}, clean: {is_clean}"));
            }
        }
        assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    }
}

/// A table in CSV.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) columns: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

impl Table {
    /// The cells of a column.
    pub(crate) fn column(&self, name: &str) -> Vec<&str> {
        let place = self.columns.iter().position(|other| other == name);
        let place = place.unwrap_or_else(|| panic!("{name} is not in {:?}", self.columns));
        self.rows.iter().map(|row| row[place].as_str()).collect()
    }

    pub(crate) fn numbers(&self, name: &str) -> Vec<f64> {
        self.column(name).iter().map(|cell| cell.parse().unwrap()).collect()
    }
}

/// Gives a line to a shell in a folder, where the program is found by its name.
pub(crate) fn shell(folder: &Path, line: &str) -> Output {
    let own = Path::new(env!("CARGO_BIN_EXE_geodesic-ivp")).parent().unwrap();
    let path = format!("{}:{}", own.display(), env::var("PATH").unwrap_or_default());
    let mut shell = Command::new("sh");
    // Help is as wide as the terminal where there is one.
    shell.args(["-c", line]).current_dir(folder).env("PATH", path).env_remove("COLUMNS").stdin(Stdio::null());
    shell.output().unwrap()
}

/// Standard output of a run that must end well.
pub(crate) fn succeeded(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Standard error of a run that must end with `code`.
pub(crate) fn failed(output: &Output, code: i32) -> String {
    assert_eq!(output.status.code(), Some(code), "{}", stderr(output));
    stderr(output)
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Every file below `directory` with its content, every directory with none.
pub(crate) fn tree(directory: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(directory).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            found.extend(tree(&path).into_iter().map(|(inner, content)| (name.join(inner), content)));
            found.insert(name, None);
        } else {
            found.insert(name, Some(fs::read(path).unwrap()));
        }
    }
    found
}
