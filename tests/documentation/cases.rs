//! Case files in the pages.

use std::fs;
use std::path::Path;

use geodesic_ivp::case::builtin;
use tempfile::TempDir;

use super::pages::{Page, ROOT, program};

#[test]
fn every_case_in_a_page_is_valid() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("case.toml");
    let mut count = 0;
    for page in Page::all() {
        for block in page.blocks().filter(|block| block.info.split(' ').next() == Some("toml")) {
            count += 1;
            fs::write(&path, &block.text).unwrap();
            let output = program(folder.path()).args(["check", "case.toml"]).output().unwrap();
            let error = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}\n{}\n{error}", page.name(), block.text);
        }
    }
    assert!(count >= 6, "{count} cases");
}

#[test]
fn every_built_in_case_begins_with_a_sentence() {
    for name in builtin::NAMES {
        let about = builtin::description(builtin::text(name).expect("it is built in"));
        assert!(about.ends_with('.') && about.chars().count() <= 118, "{name}: {about}");
    }
}

#[test]
fn the_readme_knows_how_many_cases_there_are() {
    let count = format!("has all {})", builtin::NAMES.len());
    let readme = fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap();
    assert!(readme.contains(&count), "{count}");
}
