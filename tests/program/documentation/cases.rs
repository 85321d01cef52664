//! Case files in the pages.

use std::fs;
use std::path::Path;

use geodesic_ivp::case::Case;
use geodesic_ivp::case::builtin::{self, ALL, BuiltIn};

use super::pages::Page;
use crate::common::{Folder, ROOT, stderr};

#[test]
fn every_case_in_a_page_is_valid() {
    let folder = Folder::new();
    let mut count = 0;
    for page in Page::all() {
        for block in page.blocks().filter(|block| block.info.split(' ').next() == Some("toml")) {
            count += 1;
            folder.write("case.toml", &block.text);
            let output = folder.run("check case.toml");
            assert!(output.status.success(), "{}\n{}\n{}", page.name(), block.text, stderr(&output));
        }
    }
    assert!(count >= 6, "{count} cases");
}

#[test]
fn every_built_in_case_begins_with_a_sentence_of_its_own() {
    let sentences: Vec<&str> = ALL.iter().map(|case| builtin::description(case.text)).collect();
    for about in &sentences {
        assert!(about.len() > 20 && about.ends_with('.') && about.chars().count() <= 118, "{about}");
        assert_eq!(sentences.iter().filter(|other| *other == about).count(), 1, "{about}");
    }
}

#[test]
fn the_readme_knows_how_many_cases_there_are() {
    let count = format!("has all {})", ALL.len());
    let readme = fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap();
    assert!(readme.contains(&count), "{count}");
}

#[test]
fn every_file_in_the_folders_is_built_in_and_described() {
    for folder in ["", "find", "hard", "scenes"] {
        let path = Path::new(ROOT).join("cases").join(folder);
        let mut files: Vec<String> = fs::read_dir(&path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter_map(|name| name.strip_suffix(".toml").map(str::to_owned))
            .collect();
        files.sort();
        let mut built_in: Vec<&BuiltIn> = ALL.iter().filter(|case| case.folder == folder).collect();
        built_in.sort_by_key(|case| case.name);
        assert_eq!(files, built_in.iter().map(|case| case.name).collect::<Vec<_>>());
        for BuiltIn { name, text, .. } in built_in {
            assert_eq!(*text, fs::read_to_string(path.join(name).with_extension("toml")).unwrap());
            let case = Case::parse(name, text, &[]).unwrap();
            assert!(case.title.as_deref().is_some(), "{name}");
            assert_eq!(!case.is_of_x, ["find", "scenes"].contains(&folder), "{name}");
            assert_eq!(case.find.is_some(), folder == "find", "{name}");
        }
    }
}
