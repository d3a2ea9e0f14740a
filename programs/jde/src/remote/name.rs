//! Parses names on a command line: `[APPLICATION:]SCHEMA.VARIABLE[.FIELD]`, `[APPLICATION:]SCHEMA`.

use std::collections::BTreeSet;

use jde_nearest::nearest;

use crate::failure::Failure;

/// Splits a name into its application, if it has one, and the rest.
pub(crate) fn split_application(name: &str) -> (Option<&str>, &str) {
    match name.split_once(':') {
        Some((application, rest)) if !application.is_empty() => (Some(application), rest),
        Some(_) | None => (None, name),
    }
}

/// Splits a name into one of the known variables and the path of a field, which may be empty.
///
/// # Errors
/// There is no such variable. The error contains the nearest name.
pub(crate) fn split_variable<'v, 'n>(
    name: &'n str,
    known: impl Iterator<Item = &'v str> + Clone,
) -> Result<(&'v str, &'n str), Failure> {
    let is_prefix = |variable: &&str| {
        name.strip_prefix(*variable)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    // The longest match is meant if the name of one variable begins with another's.
    if let Some(variable) = known
        .clone()
        .filter(is_prefix)
        .max_by_key(|variable| variable.len())
    {
        let rest = &name[variable.len()..];
        return Ok((variable, rest.strip_prefix('.').unwrap_or(rest)));
    }
    let mut parts = name.splitn(3, '.');
    let variable_name = match (parts.next(), parts.next()) {
        (Some(owner), Some(variable)) => format!("{owner}.{variable}"),
        _ => name.to_owned(),
    };
    if !variable_name.contains('.') {
        let prefix = format!("{variable_name}.");
        let its_variables: Vec<_> = known
            .clone()
            .filter(|variable| variable.starts_with(&prefix))
            .collect();
        if !its_variables.is_empty() {
            return Err(Failure::usage(
                format!("`{variable_name}` is a schema, not a variable"),
                format!("its variables: {}", its_variables.join(", ")),
            ));
        }
    }
    Err(unknown_variable("variable", &variable_name, known))
}

/// Returns wrong use because there is no such variable. The advice is the nearest one, or those of the same schema, or the
/// schemas.
pub(crate) fn unknown_variable<'v>(
    what: &str,
    name: &str,
    known: impl Iterator<Item = &'v str> + Clone,
) -> Failure {
    let owner_of = |name: &'v str| name.split_once('.').map_or(name, |(owner, _)| owner);
    let (owner, _) = name.split_once('.').unwrap_or((name, ""));
    if nearest(name, known.clone()).is_some() {
        return Failure::unknown(what, name, known);
    }
    let of_owner: Vec<_> = known.clone().filter(|name| owner_of(name) == owner).collect();
    if of_owner.is_empty() {
        let owners: BTreeSet<_> = known.map(owner_of).collect();
        return Failure::unknown("schema", owner, owners.iter().copied());
    }
    Failure::usage(
        format!("there is no {what} `{name}`"),
        format!("`{owner}` has {}", of_owner.join(", ")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [&str; 3] = ["pioneer.laser", "pioneer.odometry", "goon.fast"];

    fn find(name: &str) -> Result<(&str, &str), String> {
        split_variable(name, KNOWN.into_iter()).map_err(|failure| match failure {
            Failure::Run(crate::failure::RunFailure::Usage { message, help }) => format!("{message}; {help}"),
            other => other.to_string(),
        })
    }

    #[test]
    fn a_name_may_include_its_application() {
        assert_eq!(split_application("robot2:goon"), (Some("robot2"), "goon"));
        assert_eq!(split_application("goon.fast"), (None, "goon.fast"));
        assert_eq!(split_application(":goon"), (None, ":goon"));
    }

    #[test]
    fn a_field_follows_its_variable() {
        assert_eq!(find("pioneer.laser"), Ok(("pioneer.laser", "")));
        assert_eq!(
            find("pioneer.odometry.pose.pose.position.x"),
            Ok(("pioneer.odometry", "pose.pose.position.x"))
        );
        assert_eq!(
            find("pioneer.laser.ranges[3]"),
            Ok(("pioneer.laser", "ranges[3]"))
        );
    }

    #[test]
    fn a_misspelt_name_is_refused_with_the_nearest() {
        assert_eq!(
            find("pioneer.lasr.ranges"),
            Err("there is no variable `pioneer.lasr`; did you mean `pioneer.laser`?".to_owned())
        );
        assert_eq!(
            find("pioneer.nonsense"),
            Err(
                "there is no variable `pioneer.nonsense`; `pioneer` has pioneer.laser, pioneer.odometry"
                    .to_owned()
            )
        );
        assert_eq!(
            find("robot.position"),
            Err("there is no schema `robot`; there are: goon, pioneer".to_owned())
        );
        assert_eq!(
            find("pioneer"),
            Err(
                "`pioneer` is a schema, not a variable; its variables: pioneer.laser, pioneer.odometry"
                    .to_owned()
            )
        );
    }
}
