//! Case files in the pages.

use std::fs;

use tempfile::TempDir;

use super::pages::{Page, program};

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
