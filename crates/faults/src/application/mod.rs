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

/// The root of the workspace, with the demonstration's application and its world.
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
    /// The application of a case.
    ///
    /// # Errors
    /// The demonstration is missing, or has changed.
    pub fn of(root: &Root, seed: u64, case: Case) -> Result<Self> {
        let mut chance = Rng::new(seed, &format!("stage {case}"));
        match case.scenario {
            Scenario::Demo => demo::build(root, &mut chance),
            Scenario::Hundred => Ok(hundred::build(root, &mut chance)),
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

    /// The schemas that can have a fault.
    #[must_use]
    pub fn victims(&self, whom: TargetKind, apart: bool) -> Vec<&String> {
        let fit = |player: &&FaultySchema| player.kind == whom && (player.isolated || !apart);
        self.schemas
            .iter()
            .filter(fit)
            .map(|player| &player.name)
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
    for (folder, because) in SearchPath::usual(None).folders() {
        path.push(folder, because);
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
        format!("there is no plugin `{name}`; `cargo build --release --workspace` makes it")
    })?;
    Ok(found.path)
}
