//! Suggests the name that was probably meant, for all messages about an unknown one. It never corrects a name by itself.

use std::cell::Cell;

/// Longer texts are not misspelt names.
const MAX_LENGTH: usize = 80;

/// The most letters times letters that are compared, for a few thousand names: a tenth of a second.
const MAX_WORK: usize = 400_000;

/// The shortest name that may be the beginning of the intended one, letters.
const MIN_BEGINNING: usize = 3;

/// Returns the candidate nearest to `name`, if it is near enough to suggest: one that differs in few letters, else the
/// shortest that begins with it.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    let (length, work) = (name.chars().count(), Cell::new(0));
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name && candidate.len() <= MAX_LENGTH)
        .take_while(|_| work.get() <= MAX_WORK)
        .filter_map(|candidate| {
            let other = candidate.chars().count();
            // At most a third of the letters may differ: `lasr` means `laser`, `goal` does not mean `pose`.
            let most = (length.max(other) / 3).max(1);
            if length.abs_diff(other) <= most {
                work.update(|work| work + length * other);
                let distance = strsim::damerau_levenshtein(name, candidate);
                if distance < length.max(other) && distance <= most {
                    return Some(((false, distance), candidate));
                }
            }
            // Often a unit is missing at the end: `heading` means `heading_deg`.
            let begins = length >= MIN_BEGINNING && candidate.starts_with(name);
            begins.then_some(((true, other), candidate))
        })
        .min_by_key(|(rank, _)| *rank)
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
    fn a_name_without_its_end_finds_the_shortest_that_begins_with_it() {
        let known = ["heading_degrees", "heading_deg", "hero"];
        assert_eq!(nearest("heading", known), Some("heading_deg"));
        assert_eq!(nearest("he", known), None);
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
