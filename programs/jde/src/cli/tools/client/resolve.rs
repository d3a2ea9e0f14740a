//! Finds the application of a name. `robot2:pioneer.odometry` is a variable that the chosen application
//! imports from `robot2`, if there is one. Otherwise it is a variable of the application `robot2` itself.

use jde_link::{Error, Remote};
use jde_log::Selection;

use super::{Context, Target};
use crate::failure::Failure;
use crate::quantity;
use crate::remote::name::{self, split_application};

/// The advice for names of several applications.
const ONE_BY_ONE: &str = "use the verb once for each application";

impl Context {
    /// Returns the application of a variable, a field or a pattern, with its name in that application.
    pub(super) fn resolve<'n>(
        &self,
        target: &Target,
        requested: &'n str,
    ) -> Result<(Remote, &'n str), Failure> {
        let (Some(named), rest) = split_application(requested) else {
            return Ok((self.remote(target, None)?, requested));
        };
        // If several applications run and none is chosen, the prefix can only be an application's name.
        let default = self.remote(target, None).ok();
        let known = default.as_ref().and_then(|default| default.variables(false).ok());
        let known = known.unwrap_or_default();
        let names = || known.iter().map(|variable| variable.name.as_str());
        if let Some(default) = &default
            && is_known(requested, names())
        {
            return Ok((default.clone(), requested));
        }
        // A recording is asked alone: the later look-up refuses a prefix that it does not have.
        if target.is_recording {
            return Ok((self.remote(target, None)?, requested));
        }
        let imports = format!("{named}:");
        match (self.remote(target, Some(named)), default) {
            // The variable's name is misspelt: the later look-up in this application suggests the nearest
            // one.
            (Err(Failure::Link(Error::UnknownApplication { .. })), Some(default))
                if names().any(|name| name.starts_with(&imports)) =>
            {
                Ok((default, requested))
            }
            (remote, _) => Ok((remote?, rest)),
        }
    }

    /// As [`Self::resolve`] for several names, which must all belong to one application. Without names, the
    /// chosen application.
    pub(super) fn resolve_all(
        &self,
        target: &Target,
        requested: &[String],
    ) -> Result<(Remote, Vec<String>), Failure> {
        let Some((first, others)) = requested.split_first() else {
            return Ok((self.remote(target, None)?, Vec::new()));
        };
        let (remote, name) = self.resolve(target, first)?;
        let mut names = vec![name.to_owned()];
        for other in others {
            let (another, name) = self.resolve(target, other)?;
            if another.about().id != remote.about().id {
                return Err(Failure::usage(
                    format!(
                        "`{first}` belongs to {}, and `{other}` to {}; this verb is for one application",
                        remote.about().name,
                        another.about().name
                    ),
                    ONE_BY_ONE,
                ));
            }
            names.push(name.to_owned());
        }
        Ok((remote, names))
    }

    /// Returns the application that an argument names. `--app` must not name another one.
    pub(super) fn remote_by_name(&self, target: &Target, named: Option<&str>) -> Result<Remote, Failure> {
        if let Some(named) = named
            && target.is_recording
        {
            return Err(Failure::usage(
                format!("`{named}` names an application, and --in a recording"),
                "leave one of them out",
            ));
        }
        if let (Some(named), Some(app)) = (named, target.typed_app())
            && named != app
        {
            return Err(Failure::usage(
                format!("`{named}` and --app {app} name two applications"),
                ONE_BY_ONE,
            ));
        }
        self.remote(target, named)
    }
}

/// Returns the application that the words of a question name, if any, and the words without it.
pub(super) fn split_one_application(words: &[String]) -> Result<(Option<&str>, Vec<String>), Failure> {
    let mut named = None;
    let mut rest = Vec::with_capacity(words.len());
    for word in words.iter().flat_map(|words| words.split_whitespace()) {
        if quantity::is_time_of_day(word.trim_end_matches('?')) {
            rest.push(word.to_owned());
            continue;
        }
        let (application, word) = split_application(word);
        if let (Some(first), Some(second)) = (named, application)
            && first != second
        {
            return Err(Failure::usage(
                format!("`{first}` and `{second}` are two applications; this verb is for one"),
                ONE_BY_ONE,
            ));
        }
        named = application.or(named);
        rest.push(word.to_owned());
    }
    Ok((named, rest))
}

/// Whether a name, a field or a pattern matches an existing variable.
fn is_known<'v>(requested: &str, names: impl Iterator<Item = &'v str> + Clone) -> bool {
    let all: Vec<_> = names.clone().map(str::to_owned).collect();
    name::split_variable(requested, names).is_ok() || Selection::new(vec![requested.to_owned()], &all).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_imported_variable_is_known_by_its_full_name() {
        let names = ["goon.fast", "robot2:pioneer.odometry"];
        let is_known = |requested| super::is_known(requested, names.into_iter());
        assert!(is_known("robot2:pioneer.odometry"));
        assert!(is_known("robot2:pioneer.odometry.pose.pose.position.x"));
        assert!(is_known("robot2:*") && is_known("*.odometry"));
        assert!(!is_known("robot2:goon.fast") && !is_known("robot2:pioneer.laser") && !is_known("robot3:*"));
    }

    #[test]
    fn a_question_is_about_one_application() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let requested = words("why did robot2:vff win");
        let (named, rest) = split_one_application(&requested).unwrap();
        assert_eq!((named, rest), (Some("robot2"), words("why did vff win")));
        let message = split_one_application(&words("a:vff b:goon"))
            .unwrap_err()
            .to_string();
        assert_eq!(message, "`a` and `b` are two applications; this verb is for one");
    }
}
