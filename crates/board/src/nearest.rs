//! Suggests the name that was probably meant.

/// Longer texts are not misspelt names.
const MAX_LENGTH: usize = 80;

/// Returns the candidate nearest to `name`, if it is near enough to suggest.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name && candidate.len() <= MAX_LENGTH)
        .filter_map(|candidate| {
            // At most a third of the letters may differ: `lasr` means `laser`, `goal` does not mean `pose`.
            let letters = candidate.chars().count().max(name.chars().count());
            let distance = strsim::damerau_levenshtein(name, candidate);
            (distance < letters && distance <= (letters / 3).max(1)).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_misspelt_name_finds_the_intended_one() {
        let known = ["period", "patience", "policy"];
        assert_eq!(nearest("perod", known), Some("period"));
        assert_eq!(nearest("polciy", known), Some("policy"));
    }

    #[test]
    fn a_name_unlike_all_known_names_finds_none() {
        assert_eq!(nearest("wheels", ["period", "patience"]), None);
        assert_eq!(nearest("x", ["y", "yz"]), None);
        assert_eq!(nearest(&"period".repeat(100), ["period"]), None);
    }

    #[test]
    fn a_name_is_not_suggested_for_itself() {
        assert_eq!(nearest("stop", ["stop", "stops"]), Some("stops"));
    }
}
