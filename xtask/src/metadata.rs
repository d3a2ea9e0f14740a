//! What cargo knows of the workspace: its packages and their arrows. Read once, never changed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use serde::Deserialize;

use crate::shell;

/// The answer of `cargo metadata`, as far as it is used here.
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
    pub(crate) manifest_path: PathBuf,
    #[serde(default)]
    pub(crate) dependencies: Vec<Dependency>,
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
    /// The folder, for a package of this workspace.
    #[serde(default)]
    pub(crate) path: Option<PathBuf>,
}

/// What a dependency is for; ordinary ones have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    Dev,
    Build,
}

/// The packages that the lock file chose, and who needs whom.
#[derive(Debug, Deserialize)]
pub(crate) struct Resolve {
    pub(crate) nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Node {
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
    /// Packages of the workspace alone: quick, and needs no network.
    pub(crate) fn of_workspace(root: &Path) -> Result<Self> {
        Self::read(root, &["--no-deps"])
    }

    /// Everything that this machine's kind of platform would build.
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
            .context("`cargo metadata` answers in an unknown form")
    }

    /// The packages of this workspace, in cargo's order.
    pub(crate) fn members(&self) -> impl Iterator<Item = &Package> {
        self.packages
            .iter()
            .filter(|package| self.workspace_members.contains(&package.id))
    }

    /// The packages by their identifiers.
    pub(crate) fn by_id(&self) -> BTreeMap<&str, &Package> {
        self.packages
            .iter()
            .map(|package| (package.id.as_str(), package))
            .collect()
    }
}

impl Package {
    /// The folder of the package, relative to the root of the workspace, with `/` between its parts.
    pub(crate) fn folder(&self, root: &Path) -> String {
        folder(root, self.manifest_path.parent().unwrap_or(&self.manifest_path))
    }
}

/// A path relative to the root, with `/` between its parts.
pub(crate) fn folder(root: &Path, path: &Path) -> String {
    path.strip_prefix(root)
        .unwrap_or(path)
        .to_string_lossy()
        .replace('\\', "/")
}
