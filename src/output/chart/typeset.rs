//! Sub- and superscripts: `γ_f`, `10^{−16}` and `Q_t` in the text of a picture are set as such.
//!
//! The base of a script is a single letter, which may have a capital delta before it. The script itself is a single
//! letter or digit, or anything in braces. Names of files and columns such as `delta_q_t` or `x_final` are left as they
//! are.

use std::fmt::Write as _;

/// The size of a script, relative to its base.
pub(super) const SCRIPT: f64 = 0.72;
/// How far a subscript and a superscript are moved down, relative to the size of their base.
const LOWERED: f64 = 0.22;
const RAISED: f64 = -0.36;

/// The height of a part of a text: on the line, below or above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    Line,
    Sub,
    Super,
}

impl Level {
    fn shift(self) -> f64 {
        match self {
            Self::Line => 0.0,
            Self::Sub => LOWERED,
            Self::Super => RAISED,
        }
    }
}

/// Splits a text into parts of the same level, none of them empty.
pub(super) fn parts(text: &str) -> Vec<(Level, &str)> {
    let mut parts = Vec::new();
    let (mut from, mut at) = (0, 0);
    while let Some(offset) = text[at..].find(['_', '^']) {
        let mark = at + offset;
        at = mark + 1;
        let Some((script, end)) = script(text, mark).filter(|_| has_base(&text[..mark], &text[mark..])) else {
            continue;
        };
        let level = if text[mark..].starts_with('_') { Level::Sub } else { Level::Super };
        parts.extend([(Level::Line, &text[from..mark]), (level, script)]);
        (from, at) = (end, end);
    }
    parts.push((Level::Line, &text[from..]));
    parts.retain(|(_, part)| !part.is_empty());
    parts
}

/// Whether a script may follow `before`: it ends with a single letter, or the script is the power of a number or a
/// bracket.
fn has_base(before: &str, mark: &str) -> bool {
    let mut back = before.chars().rev();
    let Some(base) = back.next() else { return false };
    let is_alone = back.next().is_none_or(|c| !(c.is_alphanumeric() || c == '_') || c == 'Δ');
    (base.is_alphabetic() && is_alone) || (mark.starts_with('^') && (base.is_ascii_digit() || base == ')'))
}

/// The script after the `_` or `^` at `mark`, and the position at which the text continues.
fn script(text: &str, mark: usize) -> Option<(&str, usize)> {
    let behind = &text[mark + 1..];
    if let Some(inner) = behind.strip_prefix('{') {
        let end = inner.find('}')?;
        return (end > 0 && !inner[..end].contains('{')).then_some((&inner[..end], mark + 2 + end + 1));
    }
    let mut ahead = behind.chars();
    let letter = ahead.next().filter(|c| c.is_alphanumeric())?;
    let goes_on = ahead.next().is_some_and(|c| c.is_alphanumeric() || c == '_');
    (!goes_on).then_some((&behind[..letter.len_utf8()], mark + 1 + letter.len_utf8()))
}

/// The document, with the scripts of all its texts as elements of their own.
pub(super) fn typeset(svg: &str) -> String {
    let mut set = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some((before, element)) = rest.split_once("<text ") {
        set.push_str(before);
        set.push_str("<text ");
        let Some((attributes, behind)) = element.split_once('>') else {
            return set + element;
        };
        set.push_str(attributes);
        set.push('>');
        let (content, after) = behind.split_once('<').unwrap_or((behind, ""));
        match font_size(attributes) {
            Some(size) => set_parts(&mut set, content, size),
            None => set.push_str(content),
        }
        set.push('<');
        rest = after;
    }
    set + rest
}

fn font_size(attributes: &str) -> Option<f64> {
    attributes.split("font-size=\"").nth(1)?.split('"').next()?.parse().ok()
}

/// Appends the parts of a text. Scripts are moved by `dy`, which every viewer knows, unlike `baseline-shift`. It
/// applies to the rest of the text as well, so that the next part has to undo it.
fn set_parts(set: &mut String, content: &str, size: f64) {
    // The backend puts a newline after the text.
    let text = content.trim_end_matches('\n');
    let mut shift = 0.0;
    for (level, part) in parts(text) {
        let by = level.shift() - shift;
        shift = level.shift();
        if by == 0.0 {
            set.push_str(part);
            continue;
        }
        let letters = if level == Level::Line { 1.0 } else { SCRIPT };
        let (dy, letters) = (by * size, letters * size);
        // Some viewers drop a space at the beginning if it is not marked as preserved.
        let space = if part.starts_with(' ') { " xml:space=\"preserve\"" } else { "" };
        let _ = write!(set, "<tspan dy=\"{dy:.1}\" font-size=\"{letters:.1}\"{space}>{part}</tspan>");
    }
    set.push_str(&content[text.len()..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        let part = |(level, part): (Level, &str)| match level {
            Level::Line => part.to_owned(),
            Level::Sub => format!("[{part}]"),
            Level::Super => format!("<{part}>"),
        };
        parts(text).into_iter().map(part).collect()
    }

    #[test]
    fn symbols_have_scripts_and_names_have_none() {
        assert_eq!(shown("γ_f − γ_i"), "γ[f] − γ[i]");
        assert_eq!(shown("|ΔQ_t| and ε_x(γ_f)"), "|ΔQ[t]| and ε[x](γ[f])");
        assert_eq!(shown("|ΔG^t|, λ_7/H_N, V_{eff}, 10^{−16}"), "|ΔG<t>|, λ[7]/H[N], V[eff], 10<−16>");
        for name in
            ["delta_q_t.svg", "my_case", "x_final", "run1_2", "t_", "_x", "a__b", "γ_{", "γ_{}", "^", "x^−2", "snake_c"]
        {
            assert_eq!(shown(name), name);
        }
    }

    #[test]
    fn the_line_goes_on_at_its_height() {
        let text = "<text dy=\"0.76em\" font-size=\"100\" fill=\"#222222\">\nγ_f − 1 &lt; x\n</text>";
        let set = typeset(text);
        assert!(set.contains("\nγ<tspan dy=\"22.0\" font-size=\"72.0\">f</tspan>"), "{set}");
        assert!(set.contains("font-size=\"100.0\" xml:space=\"preserve\"> − 1 &lt; x</tspan>\n</text>"), "{set}");
        let without = "<rect a=\"x_i\"/>\n<text fill=\"#000\">a</text>";
        assert_eq!(typeset(without), without);
    }
}
