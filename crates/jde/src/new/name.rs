//! Names that are valid for a folder, a package, a schema and a Rust type.

/// The longest name, in bytes. It is part of every line of the oscilloscope.
const MAX_LENGTH: usize = 32;
/// Names that no Rust package may have, and those of existing plugins.
const RESERVED: &str = "abstract alloc as async await become box break build carmen const continue core crate deps do dyn else \
    enum example examples extern false family final fn for gen goon if impl in incremental jde-schema jde-types let loop \
    macro match mod move mut override pair priv proc-macro pub ref return self sim static std stop struct super test trait \
    true try type typeof unsafe unsized use vff virtual where while yield";

/// A name in both forms.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Name {
    /// "follow-wall".
    pub(super) kebab: String,
    /// "FollowWall".
    pub(super) camel: String,
}

impl Name {
    /// Checks a name. `is_taken` returns whether the template uses a word for something else.
    ///
    /// # Errors
    /// The reason why the name is invalid.
    pub(super) fn new(text: &str, is_taken: impl Fn(&str) -> bool) -> Result<Self, String> {
        let parts: Vec<&str> = text.split('-').collect();
        let is_valid = |part: &&str| {
            !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit())
        };
        let starts_with_letter = text.starts_with(|c: char| c.is_ascii_lowercase());
        if !starts_with_letter || !parts.iter().all(is_valid) {
            return Err(format!("`{}` cannot be a name", text.escape_debug()));
        }
        if text.len() > MAX_LENGTH {
            return Err(format!(
                "`{text}` is too long for a name; {MAX_LENGTH} letters is the most"
            ));
        }
        let camel: String = parts
            .iter()
            .map(|part| part[..1].to_ascii_uppercase() + &part[1..])
            .collect();
        if RESERVED.split(' ').any(|word| word == text) || is_taken(text) || is_taken(&camel) {
            return Err(format!("the name `{text}` is taken"));
        }
        Ok(Self {
            kebab: text.to_owned(),
            camel,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Name;

    #[test]
    fn a_name_is_written_with_hyphens_and_as_a_type() {
        let name = Name::new("follow-wall-2", |_| false).unwrap();
        assert_eq!(
            (name.kebab.as_str(), name.camel.as_str()),
            ("follow-wall-2", "FollowWall2")
        );
    }

    #[test]
    fn invalid_names_of_packages_and_types_are_refused() {
        for text in [
            "",
            "-",
            "a--b",
            "-a",
            "a-",
            "2a",
            "Follow",
            "follow_wall",
            "../up",
            "a b",
            "ä",
            "fn",
            "stop",
        ] {
            assert!(Name::new(text, |_| false).is_err(), "{text}");
        }
        assert!(Name::new(&"a".repeat(33), |_| false).is_err());
    }

    #[test]
    fn a_name_that_the_template_needs_is_refused() {
        assert!(Name::new("twist", |word| word == "Twist").is_err());
    }
}
