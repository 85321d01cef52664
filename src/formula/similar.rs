//! Suggestions for misspelt words.

/// The word of `known` that is nearest to `word`, if it is near enough for `word` to be a typing mistake.
pub fn nearest<'k>(word: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let folded = word.to_lowercase();
    let distance = |name: &str| strsim::damerau_levenshtein(&folded, &name.to_lowercase());
    let near = |name: &str| (name.chars().count() / 3).max(1).min(name.chars().count() - 1);
    let candidates = known.into_iter().filter(|name| !name.is_empty());
    candidates.filter(|name| distance(name) <= near(name)).min_by_key(|name| distance(name))
}
