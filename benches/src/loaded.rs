//! Loads the plugin of the benches from its file as any plugin, and applications of it. Builds nothing:
//! `cargo xtask bench` does.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, ensure};
use jde_app::{Application, parse};
use jde_loader::{Plugins, SearchPath};

use crate::scope::Scope;

/// The name of the plugin, which is also in its file.
const NAME: &str = "bench-000";

/// Returns the path of the plugin's file.
pub(crate) fn file(scope: &Scope) -> PathBuf {
    scope.built.join("libbench_000.so")
}

/// Returns a catalogue of the plugins in a folder.
pub(crate) fn plugins(folder: &Path) -> Plugins {
    let mut path = SearchPath::default();
    path.push(folder, "of the benches");
    Plugins::new(path)
}

/// Reads an application from its text.
pub(crate) fn application(text: &str, plugins: &Plugins) -> Result<Application> {
    parse(text, Path::new("bench.toml"), &[], plugins).map_err(|faults| anyhow!("{faults}"))
}

/// Writes `count` plugins into a folder. They differ only in their names.
pub(crate) fn copies(scope: &Scope, count: usize, folder: &Path) -> Result<Vec<PathBuf>> {
    let original = fs::read(file(scope)).context("the plugin of the benches is not built")?;
    (0..count)
        .map(|number| {
            let name = format!("bench-{number:03}");
            let to = folder.join(format!("lib{}.so", name.replace('-', "_")));
            fs::write(&to, renamed(&original, &name)?)?;
            Ok(to)
        })
        .collect()
}

/// Returns the library with another name of the same length in its table.
fn renamed(library: &[u8], name: &str) -> Result<Vec<u8>> {
    let old = format!("{NAME}\0");
    let positions: Vec<usize> = (0..library.len() - old.len())
        .filter(|position| library[*position..].starts_with(old.as_bytes()))
        .collect();
    ensure!(
        positions.len() == 1 && name.len() == NAME.len(),
        "the plugin's name is in {} positions",
        positions.len()
    );
    let mut library = library.to_vec();
    library[positions[0]..positions[0] + name.len()].copy_from_slice(name.as_bytes());
    Ok(library)
}
