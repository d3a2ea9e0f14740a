//! The crates with which authors write plugins in Rust: those that the projects of `jde new` use, and what these need.

use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result};

use crate::metadata::{Kind, Metadata, Package};
use crate::project_files;

/// The crates on which the projects of `jde new` depend.
const SDK: &[&str] = &["jde-device", "jde-schema", "jde-types"];

/// Returns the crates, each after those that it needs.
pub(crate) fn crates(metadata: &Metadata) -> Result<Vec<&Package>> {
    let mut found = Vec::new();
    for name in SDK {
        add(metadata, name, &mut found)?;
    }
    Ok(found)
}

fn add<'m>(metadata: &'m Metadata, name: &str, found: &mut Vec<&'m Package>) -> Result<()> {
    if found.iter().any(|package| package.name == name) {
        return Ok(());
    }
    let package = metadata.members().find(|package| package.name == name);
    let package = package.with_context(|| format!("there is no package {name}"))?;
    let needed = package.dependencies.iter();
    for needed in needed.filter(|needed| needed.path.is_some() && needed.kind != Some(Kind::Dev)) {
        add(metadata, &needed.name, found)?;
    }
    found.push(package);
    Ok(())
}

/// Copies the crates into a folder. Their manifests refer to that of the workspace, so its common part comes with them.
pub(super) fn write(root: &Path, metadata: &Metadata, data: &Path) -> Result<()> {
    let mut crates: Vec<String> = crates(metadata)?
        .iter()
        .map(|package| package.folder(root))
        .collect();
    crates.sort();
    let crates: Vec<&str> = crates.iter().map(String::as_str).collect();
    project_files::copy(root, &crates, data)?;
    let text = fs::read_to_string(root.join("Cargo.toml"))?;
    fs::write(data.join("Cargo.toml"), manifest(&text, &crates))?;
    Ok(())
}

/// Returns the manifest of a workspace of these crates alone: the tables below `workspace` that they inherit.
fn manifest(text: &str, crates: &[&str]) -> String {
    let tables = text.split("\n[").filter(|table| table.starts_with("workspace."));
    let inherited: String = tables.map(|table| format!("\n[{}\n", table.trim_end())).collect();
    format!("[workspace]\nresolver = \"3\"\nmembers = {crates:?}\n{inherited}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_manifest_of_the_sdk_keeps_what_its_crates_inherit() {
        let text = "[workspace]\nmembers = [\"a\"]\n\n[patch.crates-io]\nb = 1\n\n\
                    [workspace.package]\nversion = \"1.2.3\"\n# c\n\n[workspace.lints.rust]\nd = \"deny\"\n";
        assert_eq!(
            manifest(text, &["plugin/schema", "rules/core"]),
            "[workspace]\nresolver = \"3\"\nmembers = [\"plugin/schema\", \"rules/core\"]\n\n\
             [workspace.package]\nversion = \"1.2.3\"\n# c\n\n[workspace.lints.rust]\nd = \"deny\"\n"
        );
    }
}
