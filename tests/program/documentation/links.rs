//! Links, and the paths that pages name.

use std::collections::HashMap;
use std::path::Path;

use super::pages::Page;
use crate::common::ROOT;

/// The anchor that a forge makes of a heading.
fn anchor(heading: &str) -> String {
    let text = heading.to_lowercase();
    let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(page: &Page) -> Vec<String> {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let headings = page.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| {
            let anchor = anchor(line.trim_start_matches('#').trim());
            let count = seen.entry(anchor.clone()).or_default();
            *count += 1;
            if *count == 1 { anchor } else { format!("{anchor}-{}", *count - 1) }
        })
        .collect()
}

/// The lines of a page as paragraphs, since links and code run over the ends of lines.
fn prose(page: &Page) -> String {
    page.lines().collect::<Vec<_>>().join(" ")
}

/// The code in a text, and the text without it.
fn code_and_rest(text: &str) -> (Vec<&str>, String) {
    let parts: Vec<&str> = text.split('`').collect();
    let every_other = |from| parts.iter().skip(from).step_by(2).copied().collect::<Vec<_>>();
    (every_other(1), every_other(0).join(" "))
}

/// The targets of links in a text without code.
fn targets(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target).collect()
}

#[test]
fn every_internal_link_leads_to_a_page_and_a_heading() {
    let mut broken = Vec::new();
    for page in Page::all() {
        let text = prose(&page);
        let (_, text) = code_and_rest(&text);
        for target in targets(&text).into_iter().filter(|target| !target.contains("://")) {
            let (file, fragment) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() { page.path.clone() } else { page.path.parent().unwrap().join(file) };
            if !path.exists() {
                broken.push(format!("{}: {target} is not there", page.name()));
            } else if !fragment.is_empty() && !anchors(&Page::read(path)).iter().any(|known| known == fragment) {
                broken.push(format!("{}: {target} has no such heading", page.name()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_path_of_the_project_that_a_page_names_is_there() {
    const FOLDERS: [&str; 8] = ["src/", "tests/", "docs/", "cases/", "scripts/", "examples/", "benches/", ".ci/"];
    let mut missing = Vec::new();
    for page in Page::all() {
        let text = prose(&page);
        let (code, _) = code_and_rest(&text);
        let words = code.into_iter().filter_map(|code| code.split_whitespace().next());
        for word in words.filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder))) {
            if !Path::new(ROOT).join(word).exists() {
                missing.push(format!("{}: {word}", page.name()));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

#[test]
fn the_readme_links_every_page() {
    let readme = Page::named("README.md");
    let text = prose(&readme);
    let linked = targets(&text);
    for page in Page::all().iter().filter(|page| page.name().starts_with("docs/")) {
        assert!(linked.contains(&page.name().as_str()), "README.md does not link to {}", page.name());
    }
}
