//! The packages of the workspace and their dependencies, as `cargo metadata` lists them. Read once, never
//! changed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::Deserialize;

use crate::shell;

/// The output of `cargo metadata`, as far as this program uses it.
#[derive(Debug, Deserialize)]
pub(crate) struct Metadata {
    pub(crate) packages: Vec<Package>,
    pub(crate) workspace_members: BTreeSet<String>,
    pub(crate) target_directory: PathBuf,
    #[serde(default)]
    pub(crate) resolve: Option<Resolve>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Package {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) version: String,
    #[serde(default)]
    pub(crate) license: Option<String>,
    #[serde(default)]
    pub(crate) description: Option<String>,
    #[serde(default)]
    pub(crate) readme: Option<PathBuf>,
    /// The registries to which it may be published; `None` for all.
    #[serde(default)]
    pub(crate) publish: Option<Vec<String>>,
    pub(crate) manifest_path: PathBuf,
    #[serde(default)]
    pub(crate) repository: Option<String>,
    #[serde(default)]
    pub(crate) dependencies: Vec<Dependency>,
    #[serde(default)]
    pub(crate) features: BTreeMap<String, Vec<String>>,
}

/// One line of a `[dependencies]` table.
#[derive(Debug, Deserialize)]
pub(crate) struct Dependency {
    pub(crate) name: String,
    #[serde(default)]
    pub(crate) rename: Option<String>,
    pub(crate) req: String,
    #[serde(default)]
    pub(crate) kind: Option<Kind>,
    /// The folder of a package of this workspace; `None` for others.
    #[serde(default)]
    pub(crate) path: Option<PathBuf>,
}

/// The kind of a dependency; ordinary dependencies have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    Dev,
    Build,
}

/// The packages that the lock file selects, and their dependencies.
#[derive(Debug, Deserialize)]
pub(crate) struct Resolve {
    pub(crate) nodes: Vec<ResolvedPackage>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct ResolvedPackage {
    pub(crate) id: String,
    pub(crate) deps: Vec<Edge>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Edge {
    pub(crate) pkg: String,
    pub(crate) dep_kinds: Vec<EdgeKind>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct EdgeKind {
    pub(crate) kind: Option<Kind>,
}

impl Metadata {
    /// Reads the packages of the workspace alone. This is fast and needs no network.
    pub(crate) fn of_workspace(root: &Path) -> Result<Self> {
        Self::read(root, &["--no-deps"])
    }

    /// Reads all packages that a build for this machine's platform uses.
    pub(crate) fn with_dependencies(root: &Path) -> Result<Self> {
        let version = shell::read(std::process::Command::new("rustc").arg("-vV"))?;
        let host = version
            .lines()
            .find_map(|line| line.strip_prefix("host: "))
            .context("`rustc -vV` names no host")?;
        Self::read(root, &["--filter-platform", host])
    }

    fn read(root: &Path, options: &[&str]) -> Result<Self> {
        let mut command = shell::cargo();
        command
            .args(["metadata", "--quiet", "--format-version", "1"])
            .args(options)
            .current_dir(root);
        serde_json::from_str(&shell::read(&mut command)?)
            .context("the output of `cargo metadata` has an unknown form")
    }

    /// Returns the packages of this workspace, in cargo's order.
    pub(crate) fn members(&self) -> impl Iterator<Item = &Package> {
        self.packages
            .iter()
            .filter(|package| self.workspace_members.contains(&package.id))
    }

    /// Returns all packages by their identifiers.
    pub(crate) fn by_id(&self) -> BTreeMap<&str, &Package> {
        self.packages
            .iter()
            .map(|package| (package.id.as_str(), package))
            .collect()
    }
}

impl Package {
    /// Returns the package's folder relative to the root of the workspace, with `/` as separator.
    pub(crate) fn folder(&self, root: &Path) -> String {
        folder(root, self.manifest_path.parent().unwrap_or(&self.manifest_path))
    }
}

/// Returns a path relative to the root, with `/` as separator.
pub(crate) fn folder(root: &Path, path: &Path) -> String {
    path.strip_prefix(root)
        .unwrap_or(path)
        .to_string_lossy()
        .replace('\\', "/")
}
