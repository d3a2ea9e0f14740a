//! A module with files of its own is `name/mod.rs`, never `name.rs` beside `name/`.

use super::tree::{Tree, Violation};

pub(super) fn check(tree: &Tree) -> Vec<Violation> {
    let beside = |path: &str| {
        let folder = format!("{}/", path.strip_suffix(".rs")?);
        let has_files = tree.files.iter().any(|file| file.path.starts_with(&folder));
        has_files.then(|| format!("{folder}mod.rs"))
    };
    let files = tree.with_extension(&["rs"]);
    files
        .filter_map(|file| {
            let place = beside(&file.path)?;
            let message = "a module's own file lies beside its folder";
            Some(Violation::new(
                file.path.as_str(),
                1,
                message,
                format!("move it to {place}"),
            ))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::super::tree::File;
    use super::*;

    fn found(paths: &[&str]) -> Vec<String> {
        let files = paths.iter().map(|path| File::new(*path, "")).collect();
        let root = PathBuf::new();
        let found = check(&Tree { root, files });
        found.into_iter().map(|violation| violation.path).collect()
    }

    #[test]
    fn one_of_the_two_styles_passes() {
        assert!(found(&["a/mod.rs", "a/b.rs", "ab.rs"]).is_empty());
        assert_eq!(found(&["a.rs", "a/b.rs"]), ["a.rs"]);
    }
}
