//! Finds the application of a name. `robot2:pioneer.odometry` is a variable that the chosen application
//! imports from `robot2`, if there is one. Otherwise it is a variable of the application `robot2` itself.

use jde_link::{Error, Remote};
use jde_log::Selection;

use super::{Context, Target};
use crate::failure::Failure;
use crate::remote::name::{self, split_application};

/// The advice for names of several applications.
const ONE_BY_ONE: &str = "ask one after the other";

impl Context {
    /// Returns the application of a variable, a field or a pattern, with its name there.
    pub(super) fn resolve<'n>(&self, target: &Target, asked: &'n str) -> Result<(Remote, &'n str), Failure> {
        let (Some(named), rest) = split_application(asked) else {
            return Ok((self.remote(target, None)?, asked));
        };
        // If several applications run and none is chosen, the prefix can only be an application's name.
        let usual = self.remote(target, None).ok();
        let known = usual.as_ref().and_then(|usual| usual.variables(false).ok());
        let known = known.unwrap_or_default();
        let names = || known.iter().map(|variable| variable.name.as_str());
        if let Some(usual) = &usual
            && is_known(asked, names())
        {
            return Ok((usual.clone(), asked));
        }
        let imports = format!("{named}:");
        match (self.remote(target, Some(named)), usual) {
            // The variable's name is misspelt: the later look-up in this application suggests the nearest
            // one.
            (Err(Failure::Link(Error::UnknownApplication { .. })), Some(usual))
                if names().any(|name| name.starts_with(&imports)) =>
            {
                Ok((usual, asked))
            }
            (remote, _) => Ok((remote?, rest)),
        }
    }

    /// As [`Self::of`] for several names, which must all be of one application. Without names, the chosen
    /// application.
    pub(super) fn resolve_all(
        &self,
        target: &Target,
        asked: &[String],
    ) -> Result<(Remote, Vec<String>), Failure> {
        let Some((first, others)) = asked.split_first() else {
            return Ok((self.remote(target, None)?, Vec::new()));
        };
        let (remote, name) = self.resolve(target, first)?;
        let mut names = vec![name.to_owned()];
        for other in others {
            let (another, name) = self.resolve(target, other)?;
            if another.about().id != remote.about().id {
                return Err(Failure::usage(
                    format!(
                        "`{first}` is of {}, `{other}` of {}, and this is for one application",
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

/// Returns the application that the words name, if any, and the words without it.
pub(super) fn split_one_application(words: &[String]) -> Result<(Option<&str>, Vec<String>), Failure> {
    let mut named = None;
    let mut rest = Vec::with_capacity(words.len());
    for word in words {
        let (application, word) = split_application(word);
        if let (Some(one), Some(other)) = (named, application)
            && one != other
        {
            return Err(Failure::usage(
                format!("`{one}` and `{other}` are two applications, and this is for one"),
                ONE_BY_ONE,
            ));
        }
        named = application.or(named);
        rest.push(word.to_owned());
    }
    Ok((named, rest))
}

/// Whether a name, a field or a pattern matches an existing variable.
fn is_known<'v>(asked: &str, names: impl Iterator<Item = &'v str> + Clone) -> bool {
    let all: Vec<_> = names.clone().map(str::to_owned).collect();
    name::split_variable(asked, names).is_ok() || Selection::new(vec![asked.to_owned()], &all).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_that_is_imported_is_there_by_its_whole_name() {
        let names = ["goon.fast", "robot2:pioneer.odometry"];
        let there = |asked| is_known(asked, names.into_iter());
        assert!(there("robot2:pioneer.odometry"));
        assert!(there("robot2:pioneer.odometry.pose.pose.position.x"));
        assert!(there("robot2:*") && there("*.odometry"));
        assert!(!there("robot2:goon.fast") && !there("robot2:pioneer.laser") && !there("robot3:*"));
    }

    #[test]
    fn words_are_of_one_application() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        let asked = words("why did robot2:vff win");
        let (named, rest) = split_one_application(&asked).unwrap();
        assert_eq!((named, rest), (Some("robot2"), words("why did vff win")));
        let message = split_one_application(&words("a:vff b:goon"))
            .unwrap_err()
            .to_string();
        assert_eq!(message, "`a` and `b` are two applications, and this is for one");
    }
}
