//! The name that a person may have meant. It never corrects a name by itself.

/// Returns the known name that is most similar to a wrong one, if any is similar enough.
#[must_use]
pub fn nearest<'a>(wrong: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // A suggestion below this similarity misleads more often than it helps.
    const MIN_SIMILARITY: f64 = 0.75;
    known
        .map(|name| (strsim::jaro_winkler(wrong, name), name))
        .filter(|(likeness, _)| *likeness >= MIN_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}
