//! Suggests the name that was probably meant.

/// Longer texts are not misspelt names.
const MAX_LENGTH: usize = 80;

/// The most letters times letters that are compared, for a few thousand names: a tenth of a second.
const MAX_WORK: usize = 400_000;

/// Returns the candidate nearest to `name`, if it is near enough to suggest.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    let length = name.chars().count();
    let mut work = 0;
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name && candidate.len() <= MAX_LENGTH)
        .map(|candidate| (candidate.chars().count(), candidate))
        // At most a third of the letters may differ: `lasr` means `laser`, `goal` does not mean `pose`.
        .map(|(other, candidate)| (other, (length.max(other) / 3).max(1), candidate))
        .filter(|(other, most, _)| length.abs_diff(*other) <= *most)
        .take_while(|(other, ..)| {
            work += length * other;
            work <= MAX_WORK
        })
        .filter_map(|(other, most, candidate)| {
            let distance = strsim::damerau_levenshtein(name, candidate);
            (distance < length.max(other) && distance <= most).then_some((distance, candidate))
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
    fn the_search_in_a_very_long_list_is_given_up() {
        let mut asked = 0;
        let names = std::iter::repeat_with(|| {
            asked += 1;
            "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
        });
        assert_eq!(nearest(&"b".repeat(40), names.take(100_000)), None);
        assert!(asked < 1000, "{asked}");
    }

    #[test]
    fn a_name_is_not_suggested_for_itself() {
        assert_eq!(nearest("stop", ["stop", "stops"]), Some("stops"));
    }
}
