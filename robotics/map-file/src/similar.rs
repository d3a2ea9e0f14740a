//! The name that a person may have meant. It never corrects a name by itself.

/// Returns the known name that is most similar to a wrong one, if any is similar enough.
#[must_use]
pub fn nearest<'a>(wrong: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // Longer texts are not misspelt names.
    const MAX_LENGTH: usize = 80;
    // A suggestion below this similarity misleads more often than it helps.
    const MIN_SIMILARITY: f64 = 0.75;
    if wrong.len() > MAX_LENGTH {
        return None;
    }
    known
        .filter(|name| name.len() <= MAX_LENGTH)
        .map(|name| (strsim::jaro_winkler(wrong, name), name))
        .filter(|(likeness, _)| *likeness >= MIN_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
