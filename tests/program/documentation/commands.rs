//! Every command of the documentation that starts with the program's name.
//!
//! A page is followed as a reader follows it: all its blocks in one folder, one after the other, with the files in
//! place that its blocks are said to be (```` ```toml NAME ````). Blocks marked ```` ```sh slow ```` are only parsed.
//! What a block of text after commands shows is compared with what the last of them prints: words and their order, but
//! not the digits of numbers.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::pages::{Block, Page, Part};
use crate::common::{ROOT, shell};

/// Commands of a block: lines that start with the program's name, without comments. A backslash continues a line.
fn commands(block: &Block) -> Vec<String> {
    let text = block.text.replace("\\\n", "");
    let lines = text.lines().filter(|line| line.starts_with("geodesic-ivp "));
    lines.map(|line| line.split_once("  #").map_or(line, |(command, _)| command).trim_end().to_owned()).collect()
}

/// Standard output of a line, or standard error where it does not end well.
pub(crate) fn printed(directory: &Path, line: &str) -> Result<String, String> {
    let output = shell(directory, line);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}

/// A text with every number as #, and white space as one blank.
fn without_numbers(text: &str) -> String {
    let mut masked = String::new();
    // The last character of the number that is being read.
    let mut last = None;
    for c in text.split_whitespace().collect::<Vec<_>>().join(" ").chars() {
        let goes_on = last.is_some_and(|last| matches!(c, '.' | 'e') || last == 'e' && c == '-');
        if c.is_ascii_digit() || goes_on {
            if last.is_none() {
                masked.push('#');
            }
            last = Some(c);
        } else {
            masked.push(c);
            last = None;
        }
    }
    masked
}

/// A folder with the shipped cases and the files that a page's blocks are.
pub(crate) fn folder(page: &Page) -> TempDir {
    let folder = TempDir::new().unwrap();
    for cases in ["cases", "cases/find", "cases/hard", "cases/scenes"] {
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
    let (folder, name) = (folder(page), page.name());
    let mut wrong = Vec::new();
    let mut last: Option<String> = None;
    for part in &page.parts {
        match part {
            Part::Block(block) if block.info == "sh" && name != MEASURED => {
                for line in commands(block) {
                    match printed(folder.path(), &line) {
                        Ok(output) => last = Some(output),
                        Err(error) => wrong.push(format!("{name}: {line}\n{error}")),
                    }
                }
            }
            Part::Block(block) if block.info == "sh slow" || block.info == "sh" => {
                let misread = commands(block).into_iter().filter_map(|line| misread(folder.path(), &line));
                wrong.extend(misread.map(|error| format!("{name}: {error}")));
            }
            Part::Block(block) if block.info == "text" => {
                let differs = |output: &String| without_numbers(output) != without_numbers(&block.text);
                if let Some(output) = last.take().filter(differs) {
                    wrong.push(format!("{name} shows\n{}and the program prints\n{output}", block.text));
                }
            }
            Part::Line(line) if line.is_empty() => {}
            // Text that does not follow its commands at once is not said to be theirs.
            _ => last = None,
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
        .find_map(|line| printed(directory, line).err().map(|error| format!("{line}\n{error}")))
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
}
