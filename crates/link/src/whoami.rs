//! Who we are, in words that others see. Decides nothing by it: names are not proof.

/// The name of this machine.
pub(crate) fn host() -> String {
    let names = rustix::system::uname();
    names.nodename().to_string_lossy().into_owned()
}

/// The name of this user, or the number where there is none.
pub(crate) fn user() -> String {
    let name = |key: &str| std::env::var(key).ok().filter(|name| !name.is_empty());
    name("USER")
        .or_else(|| name("LOGNAME"))
        .unwrap_or_else(|| rustix::process::getuid().as_raw().to_string())
}

/// Who acts, as operators are shown: `ana@laptop`.
#[must_use]
pub fn operator() -> String {
    format!("{}@{}", user(), host())
}
