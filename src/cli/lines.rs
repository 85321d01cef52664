//! Lines for people: none is longer than 100 columns.

/// No line is longer.
pub(super) const COLUMNS: usize = 100;
/// So many of a list are named.
const MOST_NAMED: usize = 6;

/// A text in which control characters, which a file name may have, are written as escapes: a terminal obeys them. Ends
/// of lines and tabs stay.
pub(super) fn shown(text: &str) -> String {
    let is_shown = |c: char| !c.is_control() || ['\n', '\t'].contains(&c);
    let one = |c: char| if is_shown(c) { c.to_string() } else { c.escape_default().to_string() };
    text.replace("\r\n", "\n").chars().map(one).collect()
}

/// A line with its name, which goes on below itself where it is too long.
pub(super) fn row(name: &str, text: &str) -> String {
    wrapped(&format!("  {name:<8} {text}"), 11)
}

/// A text in lines that are not too long, the second and further ones indented.
pub(super) fn wrapped(text: &str, indent: usize) -> String {
    broken(text, indent, COLUMNS)
}

/// A text in lines of at most `columns`, the second and further ones indented.
pub(super) fn broken(text: &str, indent: usize, columns: usize) -> String {
    let (mut lines, mut line, mut is_begun) = (String::new(), String::new(), false);
    for word in text.split(' ') {
        if !line.trim().is_empty() && line.chars().count() + 1 + word.chars().count() > columns {
            lines += line.trim_end();
            lines.push('\n');
            (line, is_begun) = (" ".repeat(indent), false);
        }
        if is_begun {
            line.push(' ');
        }
        line += word;
        is_begun = true;
    }
    (lines + line.trim_end() + "\n").replace('\u{a0}', " ")
}

/// The text with spaces at which no line is broken, if it is short.
pub(super) fn unbroken(text: &str) -> String {
    if text.chars().count() < COLUMNS / 2 { text.replace(' ', "\u{a0}") } else { text.to_owned() }
}

/// The first of several, and how many more there are.
pub(super) fn listed(told: impl Iterator<Item = String>) -> String {
    let mut told: Vec<String> = told.collect();
    let more = told.len().saturating_sub(MOST_NAMED);
    if more > 1 {
        told.truncate(MOST_NAMED);
        told.push(format!("{more} more"));
    }
    told.iter().map(|one| unbroken(one)).collect::<Vec<_>>().join(", ")
}

/// A number with six decimals at most, or with four digits and an exponent.
pub(super) fn short(number: f64) -> String {
    let number = if number == 0.0 { 0.0 } else { number };
    if !is_readable(number) {
        return format!("{number:.3e}");
    }
    let text = format!("{number:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Returns true if a number is easy to read without an exponent.
pub(super) fn is_readable(number: f64) -> bool {
    number == 0.0 || (1e-4..1e9).contains(&number.abs())
}
