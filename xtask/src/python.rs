//! Python environments of the steps that run programs in Python: each step has one of its own in the target
//! folder, so that the packages of two steps cannot disagree. Nothing is installed elsewhere.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::paint::Paint;
use crate::shell;

/// What a step needs of Python.
pub(crate) struct Environment {
    /// The name of the environment's folder in the target folder.
    pub(crate) folder: &'static str,
    /// The packages of PyPI, with their exact versions.
    pub(crate) packages: &'static [&'static str],
    /// The modules whose import shows that the packages are installed.
    pub(crate) imports: &'static [&'static str],
}

impl Environment {
    /// Returns the environment's interpreter. The environment is created in the target folder if needed.
    pub(crate) fn interpreter(&self, target: &Path, paint: Paint) -> Result<PathBuf> {
        let folder = target.join(self.folder);
        let python = folder.join("bin/python");
        let imports = format!("import {}", self.imports.join(", "));
        if !shell::succeeds(Command::new(&python).args(["-c", &imports])) {
            shell::run(
                Command::new("python3")
                    .args(["-m", "venv", "--clear"])
                    .arg(&folder),
                paint,
            )?;
            shell::run(
                Command::new(&python)
                    .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
                    .args(self.packages),
                paint,
            )?;
        }
        Ok(python)
    }
}
