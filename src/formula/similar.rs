//! Suggestions for misspelt words.

/// The word of `known` that is nearest to `word`, if it is near enough for `word` to be a typing mistake.
pub fn nearest<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let folded = word.to_lowercase();
    let distance = |name: &str| strsim::damerau_levenshtein(&folded, &name.to_lowercase());
    let near = |name: &str| (name.chars().count() / 3).max(1).min(name.chars().count() - 1);
    let candidates = known.into_iter().filter(|name| !name.is_empty());
    candidates.filter(|name| distance(name) <= near(name)).min_by_key(|name| distance(name))
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_slip_is_near_and_another_word_is_not() {
        let known = ["gamma_i", "gamma_f", "t_f", "n_gamma", "windows", "x"];
        for (word, meant) in
            [("n_gama", "n_gamma"), ("ngamma", "n_gamma"), ("window", "windows"), ("X", "x"), ("tf", "t_f")]
        {
            assert_eq!(nearest(word, known), Some(meant), "{word}");
        }
        for word in ["steps", "y", "", "colour"] {
            assert_eq!(nearest(word, known), None, "{word}");
        }
    }
}
