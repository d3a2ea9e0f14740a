//! Renews the C headers under `include/`, or compares them. Their content is defined by `jde-headers`.

use std::path::Path;

use anyhow::{Context as _, Result, bail};

/// Writes the headers that differ, and prints their paths.
pub(crate) fn renew(root: &Path) -> Result<()> {
    for path in jde_headers::renew(root).context("cannot write the headers under include/")? {
        println!("renewed {}", path.strip_prefix(root).unwrap_or(&path).display());
    }
    Ok(())
}

/// Compares without writing. The error names the headers that differ.
pub(crate) fn check(root: &Path) -> Result<()> {
    let include = root.join("include");
    let differs = |(name, text): (&'static str, String)| {
        let same = std::fs::read_to_string(include.join(name)).is_ok_and(|old| old == text);
        (!same).then_some(name)
    };
    let stale: Vec<&str> = jde_headers::all().into_iter().filter_map(differs).collect();
    if !stale.is_empty() {
        bail!(
            "stale under include/: {}; `{}` renews them",
            stale.join(", "),
            jde_headers::RENEW
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_stale_until_they_are_renewed() {
        let root = tempfile::tempdir().unwrap();
        let error = check(root.path()).unwrap_err().to_string();
        assert_eq!(
            error,
            "stale under include/: jde.h, jde_types.h; `cargo xtask headers` renews them"
        );
        renew(root.path()).unwrap();
        check(root.path()).unwrap();
        std::fs::write(root.path().join("include/jde.h"), "other").unwrap();
        assert!(
            check(root.path())
                .unwrap_err()
                .to_string()
                .starts_with("stale under include/: jde.h;")
        );
    }
}
