//! Lines have at most 120 columns.

use std::fs;
use std::path::{Path, PathBuf};

use super::layers::sources;
use super::pages::{Page, Part};
use crate::common::ROOT;

const MOST: usize = 120;

/// The page that a script writes has longer lines.
const LONGER: [&str; 1] = ["docs/measured.md"];

fn is_long(line: &str) -> bool {
    line.chars().count() > MOST && !line.contains("://")
}

/// The long lines of a page. Rows of tables cannot be broken, nor can what the program prints.
fn long_in_page(page: &Page) -> Vec<&str> {
    let lines = page.parts.iter().flat_map(|part| match part {
        Part::Line(line) if line.starts_with('|') => Vec::new(),
        Part::Line(line) => vec![line.as_str()],
        Part::Block(block) if block.info == "text" => Vec::new(),
        Part::Block(block) => block.text.lines().collect(),
    });
    lines.filter(|line| is_long(line)).collect()
}

fn report(path: &Path, line: &str) -> String {
    format!("{}: {line}", path.strip_prefix(ROOT).unwrap().display())
}

#[test]
fn lines_of_pages_and_programs_fit_into_120_columns() {
    let (root, mut files) = (Path::new(ROOT), Vec::<PathBuf>::new());
    ["src", "tests", "examples", "benches"].iter().for_each(|folder| sources(&root.join(folder), &mut files));
    let pages = Page::all().into_iter().chain([Page::named("CHANGELOG.md")]);
    let is_checked = |path: &Path| !LONGER.iter().any(|place| path.starts_with(root.join(place)));
    let mut long = Vec::new();
    for file in files.into_iter().filter(|file| is_checked(file)) {
        let text = fs::read_to_string(&file).unwrap();
        long.extend(text.lines().filter(|line| is_long(line)).map(|line| report(&file, line)));
    }
    for page in pages.filter(|page| is_checked(&page.path)) {
        long.extend(long_in_page(&page).into_iter().map(|line| report(&page.path, line)));
    }
    assert!(long.is_empty(), "more than {MOST} columns:\n{}", long.join("\n"));
}

#[test]
fn a_long_line_would_be_found() {
    let (long, row) = ("ö".repeat(MOST + 1), format!("|{}|", "x".repeat(MOST)));
    let url = format!("https://example.org/{long}");
    assert!(is_long(&long) && !is_long(&"ö".repeat(MOST)) && !is_long(&url));
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("page.md");
    fs::write(&path, format!("{long}\n{row}\n```text\n{long}\n```\n```sh\n{long}\n```\n")).unwrap();
    assert_eq!(long_in_page(&Page::read(path)), [&long, &long]);
}
