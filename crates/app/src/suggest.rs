//! Finds the known name that a misspelt one probably means. Suggests only similar names, and never acts on a
//! suggestion.

use super::fault::Fault;
use super::report::{quote, quote_all};

/// The most names that are listed if none is similar.
pub(super) const MAX_LISTED: usize = 12;
/// Longer texts are not misspelt names.
const MAX_LENGTH: usize = 80;

/// Returns the most similar known name; at most a third of its letters may differ.
pub(super) fn nearest<'n>(name: &str, known: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    known
        .into_iter()
        .filter(|candidate| *candidate != name && candidate.len() <= MAX_LENGTH)
        .filter_map(|candidate| {
            let letters = candidate.chars().count().max(name.chars().count());
            let distance = strsim::damerau_levenshtein(name, candidate);
            (distance < letters && distance <= (letters / 3).max(1)).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

impl Fault {
    /// Suggests the most similar known name; if there is none and the names are few, all of them.
    pub(super) fn suggest<'n>(&mut self, name: &str, what: &str, known: impl IntoIterator<Item = &'n str>) {
        if self.counted {
            return;
        }
        let known: Vec<_> = known.into_iter().collect();
        if let Some(near) = nearest(name, known.iter().copied()) {
            self.advise(format!("did you mean {}?", quote(near)));
        } else if (1..=MAX_LISTED).contains(&known.len()) {
            self.advise(format!("{what}: {}", quote_all(known)));
        }
    }
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
