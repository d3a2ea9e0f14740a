//! The origin of a recording.

use std::collections::BTreeMap;
use std::time::{SystemTime, UNIX_EPOCH};

use jde_app::Application;

use jde_log::RecordedHierarchy;

/// The largest application file, bytes.
const MAX_FILE: u64 = 2 << 20;

/// The origin of a recording. The recording contains it as metadata, and the application's file as an
/// attachment.
#[derive(Clone, Debug)]
pub struct Origin {
    /// Name of the application.
    pub application: String,
    /// The seed of its random generators.
    pub seed: u64,
    /// The wall-clock time at which the application's clock was 0.
    pub started: SystemTime,
    /// The folder of the application's file, if it has one.
    pub folder: Option<String>,
    /// The name and the text of the application's file, if it has one that can be read.
    pub file: Option<(String, Vec<u8>)>,
    /// The application's schemas and groups, if they are known.
    pub hierarchy: Option<RecordedHierarchy>,
}

impl Origin {
    /// Returns the origin for an application that starts now. `lockstep` states whether it runs in virtual
    /// time.
    #[must_use]
    pub fn of(application: &Application, lockstep: bool) -> Self {
        let name = application.path.file_name();
        let name = name.map(|name| name.to_string_lossy().into_owned());
        Self {
            application: application.name.clone(),
            seed: application.seed,
            started: SystemTime::now(),
            folder: application
                .path
                .parent()
                .map(|folder| folder.display().to_string())
                .filter(|folder| !folder.is_empty()),
            file: name.zip(jde_files::read(&application.path, MAX_FILE).ok()),
            hierarchy: Some(RecordedHierarchy::of(application, lockstep)),
        }
    }

    /// Returns the time at which the application's clock was 0, in ns since 1970. 0 for earlier times.
    pub(crate) fn start(&self) -> u64 {
        let since = self.started.duration_since(UNIX_EPOCH).unwrap_or_default();
        u64::try_from(since.as_nanos()).unwrap_or(0)
    }

    pub(crate) fn metadata(&self) -> BTreeMap<String, String> {
        let folder = self.folder.clone().map(|folder| ("folder".to_owned(), folder));
        let entries = BTreeMap::from([
            ("application".to_owned(), self.application.clone()),
            ("jde".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("seed".to_owned(), self.seed.to_string()),
            ("start_ns".to_owned(), self.start().to_string()),
        ]);
        let hierarchy = self.hierarchy.as_ref().map(RecordedHierarchy::metadata_entry);
        entries.into_iter().chain(folder).chain(hierarchy).collect()
    }
}
