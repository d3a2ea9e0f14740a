//! Which variables are recorded: names in which `*` matches any text, such as `pioneer.*` and `*.laser`.

use jde_abi::describe::Role;
use jde_app::Application;
use jde_nearest::nearest;

/// A selection of variables. The default selects all of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    patterns: Vec<String>,
}

/// A pattern that matches no variable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no variable is called `{pattern}`{}", .nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
pub struct UnknownPattern {
    /// The pattern.
    pub pattern: String,
    /// The most similar name, if one is similar.
    pub nearest: Option<String>,
}

/// Returns the full names of all variables of a running application.
#[must_use]
pub fn variables(application: &Application) -> Vec<String> {
    let mut names = Vec::new();
    for instance in &application.instances {
        let own = instance.schema.ports.iter().filter(|port| match port.role {
            Role::Export { .. } | Role::Modulation { .. } | Role::Command { .. } => true,
            Role::Import | Role::Actuator | Role::ChildModulation { .. } => false,
        });
        names.extend(own.map(|port| format!("{}.{}", instance.name, port.name)));
        names.push(format!("{}.period", instance.name));
    }
    names.extend(application.remotes.iter().map(|remote| remote.local.clone()));
    names
}

impl Selection {
    /// Selects the variables among `names` that match at least one of the patterns. Without patterns, all are
    /// selected.
    ///
    /// # Errors
    /// The first pattern that matches none.
    pub fn new(patterns: Vec<String>, names: &[String]) -> Result<Self, UnknownPattern> {
        for pattern in &patterns {
            if !names.iter().any(|name| is_match(pattern, name)) {
                return Err(UnknownPattern {
                    pattern: pattern.clone(),
                    nearest: nearest(pattern, names.iter().map(String::as_str)).map(str::to_owned),
                });
            }
        }
        Ok(Self { patterns })
    }

    /// Returns whether the variable with that full name is selected.
    #[must_use]
    pub fn contains(&self, name: &str) -> bool {
        self.patterns.is_empty() || self.patterns.iter().any(|pattern| is_match(pattern, name))
    }
}

/// Returns whether a name matches. Each piece between stars is matched as early as possible, which leaves the
/// most text for the pieces after it.
fn is_match(pattern: &str, name: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else {
        return pattern == name;
    };
    let Some(mut name) = name.strip_prefix(first) else {
        return false;
    };
    let mut pieces: Vec<&str> = rest.split('*').collect();
    let last = pieces.pop().unwrap_or_default();
    for piece in pieces {
        let Some(found) = name.find(piece) else {
            return false;
        };
        name = &name[found + piece.len()..];
    }
    name.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_matches_any_text() {
        assert!(is_match("pioneer.*", "pioneer.laser"));
        assert!(is_match("*.laser", "pioneer.laser"));
        assert!(is_match("*", "pioneer.laser"));
        assert!(is_match("p*n*.*r", "pioneer.laser"));
        assert!(is_match("pioneer.laser", "pioneer.laser"));
        assert!(!is_match("pioneer", "pioneer.laser"));
        assert!(!is_match("*.lase", "pioneer.laser"));
        assert!(!is_match("a*a", "a"), "no letter is matched twice");
        assert!(!is_match("laser.*", "pioneer.laser"));
    }

    #[test]
    fn a_pattern_without_a_match_is_reported_with_the_nearest_name() {
        let names = ["pioneer.laser".to_owned(), "pioneer.sonar".to_owned()];
        let unknown = Selection::new(vec!["pioneer.lasr".to_owned()], &names).unwrap_err();
        assert_eq!(
            unknown.to_string(),
            "no variable is called `pioneer.lasr`; did you mean `pioneer.laser`?"
        );
        let unknown = Selection::new(vec!["*.camera".to_owned()], &names).unwrap_err();
        assert_eq!(unknown.to_string(), "no variable is called `*.camera`");
        let selection = Selection::new(vec!["*.sonar".to_owned()], &names).unwrap();
        assert!(selection.contains("pioneer.sonar") && !selection.contains("pioneer.laser"));
        assert!(Selection::default().contains("anything"));
    }
}
