//! Imports that have no value now, which may be why a precondition does not hold. Prints nothing.

use serde::Serialize;

/// An import that has no value now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MissingValue {
    /// The schema.
    pub(crate) schema: String,
    /// Its import.
    pub(crate) import: String,
    /// The variable that it reads.
    pub(crate) variable: String,
    /// How old the newest value is, s; `None` if there was never one.
    pub(crate) age_s: Option<f64>,
}

impl MissingValue {
    /// Returns it in words.
    pub(crate) fn text(&self) -> String {
        let Self {
            schema,
            import,
            variable,
            age_s,
        } = self;
        match age_s {
            None => format!("{schema} has no {import}: {variable} was never written"),
            Some(age) => format!("{schema} has no {import} now: {variable} was last written {age:.1} s ago"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_never_written_differs_from_what_has_ended() {
        let mut missing = MissingValue {
            schema: "goon".to_owned(),
            import: "laser".to_owned(),
            variable: "pioneer.laser".to_owned(),
            age_s: None,
        };
        assert_eq!(
            missing.text(),
            "goon has no laser: pioneer.laser was never written"
        );
        missing.age_s = Some(3.21);
        assert_eq!(
            missing.text(),
            "goon has no laser now: pioneer.laser was last written 3.2 s ago"
        );
    }
}
