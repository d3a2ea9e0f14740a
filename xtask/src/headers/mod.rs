//! The files that are generated from the Rust source, so that the two cannot differ: the headers of the ABI,
//! of the library for programs and of the standard types, those types in Python, and the table of policies in the documentation.
//!
//! `jde.h` is written from the source of `jde_abi::raw`, which uses only constants and C structures with
//! comments. A general generator would keep Rust's links in the comments and could not compute the magic
//! number. It would also turn an opaque structure into one without members, which C does not permit.

mod abi;
mod library;
mod names;
mod policies;
mod python;
mod types;

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};

/// The page with the table of policies.
const PAGE: &str = "docs/applications.md";

/// Returns the files of the project at `root` that differ from the source: their paths from there, and the text
/// that they should have.
fn stale(root: &Path) -> Vec<(&'static str, String)> {
    let mut files = vec![
        ("include/jde.h", abi::header()),
        ("include/jde_run.h", library::header()),
        ("include/jde_types.h", types::header()),
        ("include/jde/types.hpp", types::cplusplus()),
        ("programs/python/python/jde/types.py", python::module()),
    ];
    let page = fs::read_to_string(root.join(PAGE));
    files.extend(page.ok().map(|page| (PAGE, policies::renew(&page))));
    files.retain(|(path, text)| fs::read_to_string(root.join(path)).ok().as_ref() != Some(text));
    files
}

/// Writes the files that differ, and prints their paths.
pub(crate) fn renew(root: &Path) -> Result<()> {
    for (name, text) in stale(root) {
        let path = root.join(name);
        fs::create_dir_all(path.parent().unwrap_or(root))
            .and_then(|()| fs::write(path, text))
            .with_context(|| format!("cannot write {name}"))?;
        println!("renewed {name}");
    }
    Ok(())
}

/// Compares without writing. The error names the files that differ.
pub(crate) fn check(root: &Path) -> Result<()> {
    let stale: Vec<_> = stale(root).into_iter().map(|(path, _)| path).collect();
    if !stale.is_empty() {
        bail!("stale: {}; `cargo xtask headers` renews them", stale.join(", "));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generated_files_are_up_to_date() {
        check(&crate::root()).unwrap();
    }

    #[test]
    fn headers_are_stale_until_they_are_renewed() {
        let root = tempfile::tempdir().unwrap();
        let error = check(root.path()).unwrap_err().to_string();
        assert_eq!(
            error,
            "stale: include/jde.h, include/jde_run.h, include/jde_types.h, include/jde/types.hpp, programs/python/python/jde/types.py; `cargo xtask headers` renews them"
        );
        renew(root.path()).unwrap();
        check(root.path()).unwrap();
        fs::write(root.path().join("include/jde.h"), "other").unwrap();
        assert!(
            check(root.path())
                .unwrap_err()
                .to_string()
                .starts_with("stale: include/jde.h;")
        );
    }
}
