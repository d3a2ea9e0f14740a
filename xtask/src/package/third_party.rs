//! The notices of the libraries that are built in: name, version, licence, and the texts that their packages
//! contain.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Result, ensure};

use crate::metadata::Metadata;
use crate::tidy::licences::shipped;

/// How the names of files with notices begin.
const NAMES: &[&str] = &[
    "LICENSE",
    "LICENCE",
    "COPYING",
    "COPYRIGHT",
    "NOTICE",
    "UNLICENSE",
];

/// Returns the notices of all shipped libraries. Each text appears once, after the names of its libraries.
pub(super) fn notices(metadata: &Metadata) -> Result<String> {
    let packages = metadata.by_id();
    let shipped = shipped(metadata).into_iter();
    let mut libraries: Vec<_> = shipped.filter_map(|id| packages.get(id)).collect();
    libraries.sort_by_key(|package| (&package.name, &package.version));
    ensure!(!libraries.is_empty(), "no library is built in");
    let mut list = "jde contains these libraries. Their notices follow the list.\n\n".to_owned();
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for library in libraries {
        let found = texts_in(library.manifest_path.parent().unwrap_or(Path::new("")))?;
        // A crate of the project has notices if it holds what others made.
        if found.is_empty() && metadata.workspace_members.contains(&library.id) {
            continue;
        }
        let title = format!("{} {}", library.name, library.version);
        let licence = library.license.as_deref().unwrap_or("see below");
        let repository = library.repository.as_deref().unwrap_or_default();
        let _ = writeln!(list, "{title}: {licence} {repository}");
        for text in found {
            texts.entry(text).or_default().push(title.clone());
        }
    }
    for (text, titles) in texts {
        let _ = write!(
            list,
            "\n{}\n{}\n\n{}\n",
            "-".repeat(80),
            titles.join(", "),
            text.trim()
        );
    }
    Ok(list)
}

/// Reads the files with notices in the folder of a package.
fn texts_in(folder: &Path) -> Result<Vec<String>> {
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .to_uppercase();
        if path.is_file() && NAMES.iter().any(|begin| name.starts_with(begin)) {
            texts.push(String::from_utf8_lossy(&fs::read(&path)?).into_owned());
        }
    }
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codes_of_tags_bring_the_notice_of_their_library() {
        let notices = notices(&Metadata::with_dependencies(&crate::root()).unwrap()).unwrap();
        assert!(notices.contains("The Regents of The University of Michigan"));
        assert!(notices.contains("\njde-tags "), "the list names it");
        assert!(
            !notices.contains("\njde-schema "),
            "and no crate without such a notice"
        );
    }

    #[test]
    fn the_texts_of_a_package_are_found_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("LICENSE-MIT", "a"),
            ("Notice.txt", "b"),
            ("license.rs.bak", "c"),
            ("src.rs", "d"),
        ] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        fs::create_dir(folder.path().join("LICENSES")).unwrap();
        let mut texts = texts_in(folder.path()).unwrap();
        texts.sort();
        assert_eq!(texts, ["a", "b", "c"]);
    }
}
