//! Every command of the documentation that starts with the program's name.
//!
//! A page is followed as a reader follows it: all its blocks in one folder, one after the other, with the files in
//! place that its blocks are said to be (```` ```toml NAME ````). Blocks marked ```` ```sh slow ```` are only parsed.
//! What a block of text after commands shows is compared with what the last of them prints: words and their order, but
//! not the digits of numbers.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use super::pages::{Block, Page, Part};
use crate::common::{ROOT, program};

/// Commands of a block: lines that start with the program's name, without comments. A backslash continues a line.
fn commands(block: &Block) -> Vec<String> {
    let text = block.text.replace("\\\n", "");
    let lines = text.lines().filter(|line| line.starts_with("geodesic-ivp "));
    lines.map(|line| line.split_once("  #").map_or(line, |(command, _)| command).trim_end().to_owned()).collect()
}

/// Runs a line in a shell that finds the program; standard output.
pub(crate) fn shell(directory: &Path, line: &str) -> Result<String, String> {
    let own = Path::new(env!("CARGO_BIN_EXE_geodesic-ivp")).parent().unwrap();
    let path = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", line])
        .current_dir(directory)
        .env("PATH", format!("{}:{path}", own.display()))
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}

/// A line with every number as #, and white space as one blank.
fn without_numbers(line: &str) -> String {
    let mut masked = String::new();
    let mut characters =
        line.split_whitespace().collect::<Vec<_>>().join(" ").chars().collect::<Vec<_>>().into_iter().peekable();
    while let Some(c) = characters.next() {
        if !c.is_ascii_digit() {
            masked.push(c);
            continue;
        }
        masked.push('#');
        let mut last = c;
        while let Some(&next) = characters.peek() {
            if !(next.is_ascii_digit() || matches!(next, '.' | 'e') || (last == 'e' && next == '-')) {
                break;
            }
            last = next;
            characters.next();
        }
    }
    masked
}

/// A folder with the shipped cases and the files that a page's blocks are.
pub(crate) fn folder(page: &Page) -> TempDir {
    let folder = TempDir::new().unwrap();
    for cases in ["cases", "cases/hard", "cases/scenes"] {
        fs::create_dir(folder.path().join(cases)).unwrap();
        for entry in fs::read_dir(Path::new(ROOT).join(cases)).unwrap() {
            let entry = entry.unwrap();
            if entry.path().is_file() {
                fs::copy(entry.path(), folder.path().join(cases).join(entry.file_name())).unwrap();
            }
        }
    }
    for block in page.blocks() {
        if let Some(name) = block.info.strip_prefix("toml ") {
            fs::write(folder.path().join(name), &block.text).unwrap();
        }
    }
    folder
}

/// The page that a script writes from runs of its commands: they are long, and its numbers are those of that day.
const MEASURED: &str = "docs/measured.md";

/// Says what is wrong with a page's commands.
fn follow(page: &Page) -> Vec<String> {
    let all_are_slow = page.name() == MEASURED;
    let folder = folder(page);
    let mut wrong = Vec::new();
    let mut printed: Option<String> = None;
    for part in &page.parts {
        match part {
            Part::Block(block) if block.info == "sh" && !all_are_slow => {
                for line in commands(block) {
                    match shell(folder.path(), &line) {
                        Ok(output) => printed = Some(output),
                        Err(error) => wrong.push(format!("{}: {line}\n{error}", page.name())),
                    }
                }
            }
            Part::Block(block) if block.info == "sh slow" || block.info == "sh" => {
                wrong.extend(
                    commands(block)
                        .iter()
                        .filter_map(|line| misread(folder.path(), line))
                        .map(|error| format!("{}: {error}", page.name())),
                );
            }
            Part::Block(block) if block.info == "text" => {
                if let Some(printed) =
                    printed.take().filter(|printed| without_numbers(printed) != without_numbers(&block.text))
                {
                    wrong.push(format!("{} shows\n{}and the program prints\n{printed}", page.name(), block.text));
                }
            }
            Part::Line(line) if line.is_empty() => {}
            // Text that does not follow its commands at once is not said to be theirs.
            _ => printed = None,
        }
    }
    wrong
}

/// Why a command that is not run cannot be: its options, or the case that `--set` makes.
fn misread(directory: &Path, line: &str) -> Option<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let case = words.get(2).filter(|word| !word.starts_with('-')).copied().unwrap_or("quartic");
    let settings = words.windows(2).filter(|pair| pair[0] == "--set").map(|pair| format!("--set {}", pair[1]));
    let check = format!("geodesic-ivp check {case} {}", settings.collect::<Vec<_>>().join(" "));
    [format!("{line} --help"), check]
        .iter()
        .find_map(|line| shell(directory, line).err().map(|error| format!("{line}\n{error}")))
}

#[test]
fn every_command_of_every_page_runs_and_prints_what_the_page_shows() {
    let pages = Page::all();
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let runs: Vec<_> = pages.iter().map(|page| scope.spawn(|| follow(page))).collect();
        runs.into_iter().flat_map(|run| run.join().unwrap()).collect()
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let count: usize = pages.iter().flat_map(Page::blocks).map(|block| commands(block).len()).sum();
    assert!(count > 30, "{count} commands");
}

#[test]
fn a_wrong_command_or_output_would_be_found() {
    let folder = TempDir::new().unwrap();
    assert!(misread(folder.path(), "geodesic-ivp converge quartic --sbp SBP99").is_some());
    assert!(misread(folder.path(), "geodesic-ivp converge quartic --set grid.n_gama=7").is_some());
    assert!(misread(folder.path(), "geodesic-ivp stability quartic --gamma-f 4,8").is_none());
    let masked = without_numbers("  K  1.990000; |dK| <= 6.16e-3 at x = -0.5");
    assert_eq!(masked, "K #; |dK| <= # at x = -#");
    assert!(program(folder.path()).arg("--version").status().unwrap().success());
}
