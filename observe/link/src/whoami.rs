//! The names of this machine and user, for display only: they authenticate nothing.

use std::path::PathBuf;

/// The name of this machine.
pub(crate) fn host() -> String {
    let names = rustix::system::uname();
    names.nodename().to_string_lossy().into_owned()
}

/// The home of this user from the system's user database.
pub(crate) fn home() -> Option<PathBuf> {
    let known = nix::unistd::User::from_uid(nix::unistd::Uid::current());
    known.ok().flatten().map(|user| user.dir)
}

/// The name of this user: from the environment, else from the system's user database, else the numeric id.
pub(crate) fn user() -> String {
    let variable = |key: &str| std::env::var(key).ok();
    resolve_user(
        [variable("USER"), variable("LOGNAME")],
        rustix::process::getuid().as_raw(),
    )
}

fn resolve_user(names: [Option<String>; 2], number: u32) -> String {
    let mut names = names.into_iter().flatten().filter(|name| !name.is_empty());
    names.next().unwrap_or_else(|| {
        let known = nix::unistd::User::from_uid(nix::unistd::Uid::from_raw(number));
        known
            .ok()
            .flatten()
            .map_or_else(|| number.to_string(), |user| user.name)
    })
}

/// The operator's name as displayed: `ana@laptop`.
#[must_use]
pub fn operator() -> String {
    format!("{}@{}", user(), host())
}

#[cfg(test)]
mod tests {
    use super::resolve_user;

    #[test]
    fn a_user_missing_in_the_environment_is_looked_up_in_the_user_database() {
        let name = |name: &str| Some(name.to_owned());
        assert_eq!(resolve_user([name("ana"), name("eva")], 0), "ana");
        assert_eq!(resolve_user([name(""), name("eva")], 0), "eva");
        assert_eq!(resolve_user([name(""), None], 0), "root", "not 0");
        assert_eq!(resolve_user([None, None], 4_000_000_123), "4000000123");
    }
}
