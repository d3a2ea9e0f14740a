//! Renews the generated files, or compares them. Their content is defined by `jde-headers`.

use std::path::Path;

use anyhow::{Context as _, Result, bail};

/// Writes the files that differ, and prints their paths.
pub(crate) fn renew(root: &Path) -> Result<()> {
    for path in jde_headers::renew(root).context("cannot write the generated files")? {
        println!("renewed {path}");
    }
    Ok(())
}

/// Compares without writing. The error names the files that differ.
pub(crate) fn check(root: &Path) -> Result<()> {
    let stale = jde_headers::stale(root);
    if !stale.is_empty() {
        bail!(
            "stale: {}; `{}` renews them",
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
            "stale: include/jde.h, include/jde_types.h; `cargo xtask headers` renews them"
        );
        renew(root.path()).unwrap();
        check(root.path()).unwrap();
        std::fs::write(root.path().join("include/jde.h"), "other").unwrap();
        assert!(
            check(root.path())
                .unwrap_err()
                .to_string()
                .starts_with("stale: include/jde.h;")
        );
    }
}
