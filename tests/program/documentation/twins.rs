//! What is there for scenes has no twin for one coordinate: solvers, references, samplers, diagnostics, tables and
//! studies have the space-time as a parameter.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use super::layers::{SOURCE, sources};

/// The public types, traits and functions of a text.
fn public(text: &str) -> impl Iterator<Item = &str> {
    let items = text.lines().filter_map(|line| line.trim_start().strip_prefix("pub "));
    items.filter_map(|item| {
        let item = item.strip_prefix("const ").unwrap_or(item);
        let named = ["struct ", "enum ", "trait ", "type ", "fn "].iter().find_map(|kind| item.strip_prefix(kind))?;
        named.split(|c: char| !c.is_alphanumeric() && c != '_').next()
    })
}

#[test]
fn nothing_comes_in_two_kinds() {
    let mut names = BTreeSet::new();
    let mut files = Vec::new();
    sources(Path::new(SOURCE), &mut files);
    for file in files {
        let text = fs::read_to_string(file).unwrap();
        names.extend(public(&text).map(str::to_owned));
    }
    assert!(names.contains("Sampler") && names.contains("solve") && names.contains("Case"), "{names:?}");
    let twins = |name: &str| -> Vec<String> {
        let bare = name.strip_prefix("Scene").map(|bare| vec![bare.to_owned(), format!("Reference{bare}")]);
        let function = || [name.replacen("_scene", "", 1), name.replacen("scene_", "", 1)].to_vec();
        bare.unwrap_or_else(function)
    };
    // What is left of `of_scene`, a way to make something, is no name.
    let is_name = |twin: &&String| twin.len() > 2 && names.contains(*twin);
    let has_twin = |name: &&str| twins(name).iter().filter(is_name).any(|twin| twin != name);
    let of_scenes = names.iter().map(String::as_str).filter(|name| name.to_lowercase().contains("scene"));
    let found: Vec<&str> = of_scenes.filter(has_twin).collect();
    assert!(found.is_empty(), "{found:?}");
}
