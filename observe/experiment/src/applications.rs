//! The application of an experiment as each of its drives sets it. Plugins are loaded once for each variant,
//! since no library is ever unmapped.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use jde_app::{Application, Faults, Override};
use jde_host::MockCatalogue;
use jde_isolation::{Inspector, Program};
use jde_loader::{Plugins, SearchPath};

use crate::experiment::Variant;

/// Loads the application of an experiment.
pub struct Applications {
    file: PathBuf,
    /// The text of the file when it was first read: all drives are of one text, even if the file is edited meanwhile.
    text: Option<String>,
    inspector: Option<Program>,
    /// The executable beside which plugins are searched for too.
    executable: Option<PathBuf>,
    /// The schemas that are replaced by mocks.
    mocked: Vec<String>,
    plugins: BTreeMap<Vec<(String, PathBuf)>, Arc<Plugins>>,
    /// The last application that was loaded, and what it was loaded with.
    last: Option<(Vec<Override>, Variant, Application)>,
}

impl Applications {
    /// Loads the application in `file`. With an inspector, plugins and what the modulations name are
    /// inspected in its process first.
    #[must_use]
    pub fn new(file: PathBuf, inspector: Option<Program>) -> Self {
        Self {
            file,
            text: None,
            inspector,
            executable: None,
            mocked: Vec::new(),
            plugins: BTreeMap::new(),
            last: None,
        }
    }

    /// Searches for plugins beside this executable too, as the executable does itself.
    #[must_use]
    pub fn with_executable(self, executable: Option<PathBuf>) -> Self {
        Self { executable, ..self }
    }

    /// States which schemas are replaced by mocks: they inspect nothing.
    #[must_use]
    pub fn with_mocks(self, mocked: Vec<String>) -> Self {
        Self { mocked, ..self }
    }

    /// Returns the plugins of a variant.
    pub fn plugins(&mut self, variant: &Variant) -> Arc<Plugins> {
        let plugins = self.plugins.entry(variant.plugins.clone()).or_insert_with(|| {
            let mut path = SearchPath::usual(Some(&self.file));
            if let Some(executable) = &self.executable {
                path.push_executable(executable);
            }
            let mut plugins = Plugins::new(path);
            if let Some(program) = &self.inspector {
                plugins = plugins.with_inspector(Inspector::new(program.clone()));
            }
            let replaced = variant.plugins.iter();
            Arc::new(replaced.fold(plugins, |plugins, (name, file)| plugins.with_file(name, file)))
        });
        Arc::clone(plugins)
    }

    /// Returns the application with these values. The same values as in the last call are not read again.
    ///
    /// # Errors
    /// All faults of the application and of the values.
    pub fn load(&mut self, overrides: &[Override], variant: &Variant) -> Result<Application, Faults> {
        if let Some((last_overrides, last_variant, application)) = &self.last
            && last_overrides == overrides
            && last_variant == variant
        {
            return Ok(application.clone());
        }
        let plugins = self.plugins(variant);
        let text = match self.text.take() {
            Some(text) => text,
            None => jde_app::read_text(&self.file)?,
        };
        let catalogue = MockCatalogue::new(&*plugins, self.mocked.iter().cloned());
        let loaded = jde_app::load_text(&text, &self.file, overrides, &catalogue);
        self.text = Some(text);
        plugins.stop_inspector();
        let application = loaded?;
        self.last = Some((overrides.to_vec(), variant.clone(), application.clone()));
        Ok(application)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edit_between_two_drives_changes_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("app.toml");
        std::fs::write(&file, "first = 1\n").expect("it is written");
        let mut applications = Applications::new(file.clone(), None);
        let mut faults = |overrides: &[Override]| {
            let loaded = applications.load(overrides, &Variant::default());
            loaded.expect_err("no application").to_string()
        };
        assert!(faults(&[]).contains("first"));
        std::fs::write(&file, "second = 1\n").expect("it is written");
        let again = faults(&[]);
        assert!(again.contains("first") && !again.contains("second"), "{again}");
    }
}
