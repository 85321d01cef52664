//! The pages in `tests/cmd/`: what a user types, and every word of the answer.
//!
//! The blocks marked `console` of a page are followed in one folder, which holds the shipped cases and the files that
//! its blocks ```` ```toml NAME ```` are. A line that begins with `$ ` is given to a shell. `? CODE` below it is the
//! exit code, where that is not 0. The rest is what standard output and standard error say together, and `[..]` stands
//! for anything within a line. The format is that of `trycmd`, which has no pipes and no files within a page.
//!
//! `TRANSCRIPTS=overwrite cargo test --profile tests --test program transcripts` writes down what the program says now.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{ROOT, shell, tree};
use crate::documentation::commands::folder;
use crate::documentation::pages::Page;

/// Returns true if a line is what a line with elisions stands for.
fn is_shown(line: &str, shown: &str) -> bool {
    let Some((begin, shown)) = shown.split_once("[..]") else { return line == shown };
    let Some(rest) = line.strip_prefix(begin) else { return false };
    rest.char_indices().map(|(at, _)| at).chain([rest.len()]).any(|at| is_shown(&rest[at..], shown))
}

/// Returns the exit code of a line and what it prints. A refusal prints nothing on standard output, and leaves the
/// folder as it was.
fn answer(folder: &Path, line: &str) -> (i32, String) {
    let printed = |line: &str| {
        let output = shell(folder, line);
        (output.status.code().unwrap_or(-1), String::from_utf8(output.stdout).unwrap())
    };
    let before = tree(folder);
    let (code, said) = printed(&format!("exec 2>&1\n{line}"));
    if matches!(code, 1 | 2) {
        assert!(tree(folder) == before, "{line}: files were written or removed");
        assert_eq!(printed(line), (code, String::new()), "{line}: it prints on standard output");
    }
    (code, said)
}

/// The page with the answers of today. A line that stands for the one of today stays.
fn followed(path: &Path, text: &str) -> String {
    let folder = folder(&Page::read(path.to_owned()));
    let (mut page, mut is_console, mut lines) = (String::new(), false, text.lines().peekable());
    while let Some(line) = lines.next() {
        is_console = line == "```console" || is_console && line != "```";
        page += &format!("{line}\n");
        let Some(command) = line.strip_prefix("$ ").filter(|_| is_console) else { continue };
        let mut shown = Vec::new();
        while let Some(line) = lines.next_if(|line| !line.starts_with("$ ") && *line != "```") {
            shown.push(line);
        }
        let (code, said) = answer(folder.path(), command);
        let code = if code == 0 { String::new() } else { format!("? {code}\n") };
        for line in code.lines().chain(said.lines()) {
            page += shown.iter().find(|shown| is_shown(line, shown)).unwrap_or(&line);
            page.push('\n');
        }
    }
    page
}

#[test]
fn the_program_answers_as_in_the_transcripts() {
    let entries = fs::read_dir(Path::new(ROOT).join("tests/cmd")).unwrap();
    let pages: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    let overwrites = std::env::var("TRANSCRIPTS").is_ok_and(|what| what == "overwrite");
    let wrong = |path: &Path| {
        let shown = fs::read_to_string(path).unwrap();
        let now = followed(path, &shown);
        if overwrites {
            fs::write(path, &now).unwrap();
        }
        let first = now.lines().zip(shown.lines()).take_while(|(now, shown)| now == shown).count();
        let around = |text: &str| text.lines().skip(first.saturating_sub(3)).take(9).collect::<Vec<_>>().join("\n");
        (now != shown)
            .then(|| format!("{}:{}\n{}\n--- and now\n{}", path.display(), first + 1, around(&shown), around(&now)))
    };
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = pages.iter().map(|path| scope.spawn(|| wrong(path))).collect();
        threads.into_iter().filter_map(|thread| thread.join().unwrap()).collect()
    });
    assert!(pages.len() > 10 && (overwrites || wrong.is_empty()), "{}", wrong.join("\n\n"));
}

#[test]
fn an_elision_stands_for_anything_within_a_line() {
    assert!(is_shown("one", "one") && is_shown("one", "o[..]e") && is_shown("x = 1, y = 2!", "x = [..], y = [..]!"));
    assert!(
        !is_shown("one", "on") && !is_shown("on", "one") && !is_shown("one", "t[..]e") && !is_shown("oe", "oe[..]e")
    );
}
