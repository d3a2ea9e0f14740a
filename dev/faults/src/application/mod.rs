//! The applications of the campaign, generated from a seed and never written to a file.

mod demo;
mod hundred;

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow};
use jde_app::Application;
use jde_loader::{Plugins, SearchPath};

use crate::case::{Case, Scenario};
use crate::plan::TargetKind;
use crate::rng::Rng;

/// The root of the workspace, which contains the application of the demonstration and its world.
#[derive(Clone, Debug)]
pub struct Root(pub PathBuf);

/// An application, and its schemas that can misbehave.
#[derive(Debug)]
pub struct TestApplication {
    text: String,
    path: PathBuf,
    schemas: Vec<FaultySchema>,
}

/// A schema that misbehaves on command.
#[derive(Debug)]
struct FaultySchema {
    name: String,
    kind: TargetKind,
    isolated: bool,
}

impl Root {
    /// The workspace in which this program was built.
    #[must_use]
    pub fn usual() -> Self {
        Self(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
    }
}

impl TestApplication {
    /// Returns the application of a case.
    ///
    /// # Errors
    /// The demonstration is missing, or has changed.
    pub fn of(root: &Root, seed: u64, case: Case) -> Result<Self> {
        let mut rng = Rng::new(seed, &format!("stage {case}"));
        match case.scenario {
            Scenario::Demo => demo::build(root, &mut rng),
            Scenario::Hundred => Ok(hundred::build(root, &mut rng)),
        }
    }

    /// Parses and checks the application.
    ///
    /// # Errors
    /// The faults of the application.
    pub fn application(&self, plugins: &Plugins, seed: u64) -> Result<Application> {
        let parsed = jde_app::parse(&self.text, &self.path, &[], plugins);
        let mut application = parsed.map_err(|faults| anyhow!("{faults}"))?;
        application.seed = seed;
        Ok(application)
    }

    /// Returns the schemas of this kind that can have a fault.
    #[must_use]
    pub fn victims(&self, kind: TargetKind, isolated_only: bool) -> Vec<&String> {
        let suitable = |schema: &&FaultySchema| schema.kind == kind && (schema.isolated || !isolated_only);
        self.schemas
            .iter()
            .filter(suitable)
            .map(|schema| &schema.name)
            .collect()
    }

    /// The text of the application.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// The plugins in these folders and the usual ones.
#[must_use]
pub fn plugins(more: &[PathBuf]) -> Plugins {
    let mut path = SearchPath::default();
    for folder in more {
        path.push(folder, "named on the command line");
    }
    for (folder, origin) in SearchPath::usual(None).folders() {
        path.push(folder, origin);
    }
    Plugins::new(path)
}

/// The file of a plugin.
///
/// # Errors
/// There is no such plugin.
pub fn file_of(plugins: &Plugins, name: &str) -> Result<PathBuf> {
    let found = plugins.search_path().find(name);
    let found = found.with_context(|| {
        format!("there is no plugin `{name}`; `cargo build --release --workspace` builds it")
    })?;
    Ok(found.path)
}
