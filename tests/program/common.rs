//! Running the program.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The folder of the project.
pub(crate) const ROOT: &str = env!("CARGO_MANIFEST_DIR");

pub(crate) const CASES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");

/// The file of the shipped case of that name.
pub(crate) fn case_file(name: &str) -> String {
    [CASES.to_owned(), format!("{CASES}/hard"), format!("{CASES}/scenes")]
        .map(|folder| format!("{folder}/{name}.toml"))
        .into_iter()
        .find(|path| Path::new(path).exists())
        .unwrap_or_else(|| panic!("there is no case {name}"))
}

/// The program keeps a record of its files here.
pub(crate) const MANIFEST: &str = ".geodesic-ivp-manifest.json";

/// The program, in a folder.
pub(crate) fn program(directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_geodesic-ivp"));
    command.current_dir(directory);
    command
}

/// Runs the program with blank-separated arguments, in which CASES is the folder of the shipped cases.
pub(crate) fn run_in(directory: &Path, arguments: &str) -> Output {
    program(directory).args(arguments.replace("CASES", CASES).split_whitespace()).output().unwrap()
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

/// The files of a folder but for the program's own record of them.
pub(crate) fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.retain(|name| name != MANIFEST);
    names.sort();
    names
}

pub(crate) fn first_line(path: &Path) -> String {
    fs::read_to_string(path).unwrap().lines().next().unwrap().to_owned()
}

pub(crate) fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
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
