//! The crates with which authors elsewhere write plugins: what crates.io demands of them, and a trial of their publication.

use std::path::Path;

use anyhow::{Result, ensure};

use crate::metadata::{Kind, Metadata, Package};
use crate::paint::Paint;
use crate::shell;

/// Checks what crates.io demands: descriptions, licences, READMEs, and versions of the crates that a crate needs.
pub(super) fn check(root: &Path, crates: &[&Package]) -> Result<()> {
    let mut missing = Vec::new();
    for package in crates {
        let name = &package.name;
        let facts = [
            ("description", package.description.is_some()),
            ("licence", package.license.is_some()),
            ("readme", package.readme.is_some()),
            (
                "leave to be published",
                package
                    .publish
                    .as_ref()
                    .is_none_or(|registries| !registries.is_empty()),
            ),
        ];
        missing.extend(
            facts
                .iter()
                .filter(|(_, is_there)| !is_there)
                .map(|(fact, _)| format!("{name} has no {fact}")),
        );
        let needed = package
            .dependencies
            .iter()
            .filter(|needed| needed.kind != Some(Kind::Dev));
        let unversioned = needed.filter(|needed| needed.path.is_some() && needed.req == "*");
        missing.extend(unversioned.map(|needed| format!("{name} names no version of {}", needed.name)));
    }
    ensure!(
        missing.is_empty(),
        "crates in {} lack something: {}",
        root.display(),
        missing.join(", ")
    );
    Ok(())
}

/// Returns the command that publishes the crates, each after those that it needs.
pub(super) fn publication(crates: &[&Package]) -> String {
    let packages: String = crates
        .iter()
        .map(|package| format!(" --package {}", package.name))
        .collect();
    format!("cargo publish{packages}")
}

/// Packs each crate, and builds it from what a registry would give, without an upload.
pub(super) fn try_publication(
    root: &Path,
    metadata: &Metadata,
    crates: &[&Package],
    paint: Paint,
) -> Result<()> {
    let mut cargo = shell::cargo();
    cargo.args(["publish", "--dry-run", "--allow-dirty"]);
    for package in crates {
        cargo.args(["--package", &package.name]);
    }
    cargo
        .arg("--target-dir")
        .arg(metadata.target_directory.join("publication"));
    shell::run(cargo.current_dir(root), paint)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package::sdk;

    #[test]
    fn the_crates_of_the_sdk_have_what_a_registry_demands() {
        let root = crate::root();
        let metadata = Metadata::of_workspace(&root).unwrap();
        let crates = sdk::crates(&metadata).unwrap();
        check(&root, &crates).unwrap();
        let names: Vec<&str> = crates.iter().map(|package| package.name.as_str()).collect();
        let place = |name| names.iter().position(|found| *found == name);
        assert!(
            place("jde-abi") < place("jde-schema") && place("jde-schema") < place("jde-device"),
            "{names:?}"
        );
    }
}
