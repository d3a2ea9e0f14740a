//! Records the application `safe-navigation` for the tests of replay.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use jde_app::Application;
use jde_host::{Handle, Lockstep, Options, Running, StartHook};
use jde_loader::{Plugins, SearchPath};
use jde_log::{Recording, Selection, record};
use jde_recorder::{Origin, Recorder};
use jde_records::RunRecord;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
pub(crate) const SECOND: u64 = 1_000_000_000;

/// An action of an operator.
pub(crate) type Action = fn(&Handle);

/// A recording of safe-navigation.
pub(crate) struct RecordedDrive {
    _folder: tempfile::TempDir,
    file: PathBuf,
    plugins: Plugins,
}

impl RecordedDrive {
    pub(crate) fn lockstep(name: &str, limit: u64, only: &[&str]) -> Self {
        Self::new(name, limit, None, only, &[])
    }

    pub(crate) fn real_time(name: &str, limit: u64, speed: f64, only: &[&str]) -> Self {
        Self::new(name, limit, Some(speed), only, &[])
    }

    /// Records in lockstep, with actions of operators at times in ns.
    pub(crate) fn operated(name: &str, limit: u64, actions: &[(u64, Action)]) -> Self {
        Self::new(name, limit, None, &[], actions)
    }

    fn new(name: &str, limit: u64, speed: Option<f64>, only: &[&str], actions: &[(u64, Action)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        let plugins = navigation_plugins();
        let drive = Self {
            _folder: folder,
            file,
            plugins,
        };
        let application = drive.application(&[]);
        let recorder = drive.recorder(&application, speed.is_none());
        let only = only.iter().map(|pattern| (*pattern).to_owned()).collect();
        let selection = Selection::new(only, &jde_log::variables(&application)).unwrap();
        let options = Options {
            observers: vec![recorder.observer()],
            start_hook: Some(watch(&recorder, selection)),
            limit: Some(limit),
            speed: speed.unwrap_or(1.0),
            on_turn: Some(jde_recorder::turns(&recorder, &application, speed.is_none())),
            ..Options::default()
        };
        if speed.is_some() {
            Running::start(application, &drive.plugins, options)
                .unwrap()
                .wait();
        } else {
            let mut lockstep = Lockstep::start(application, &drive.plugins, options).unwrap();
            let handle = lockstep.handle();
            for (time, action) in actions {
                lockstep.run_until(*time);
                action(&handle);
            }
            lockstep.run();
        }
        let status = recorder.finish();
        assert_eq!(status.lost, 0, "{status:?}");
        drive
    }

    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    pub(crate) fn plugins(&self) -> &Plugins {
        &self.plugins
    }

    pub(crate) fn application(&self, sets: &[&str]) -> Application {
        let sets: Vec<_> = sets.iter().map(|set| set.parse().unwrap()).collect();
        let file = Path::new(ROOT).join("apps/safe-navigation.toml");
        jde_app::load(&file, &sets, &self.plugins).unwrap_or_else(|faults| panic!("{faults}"))
    }

    /// Returns the number of recorded selections.
    pub(crate) fn decisions(&self) -> u64 {
        let recording = Recording::open(&self.file).unwrap();
        let messages = recording.messages().unwrap();
        messages
            .filter(|message| message.as_ref().unwrap().channel.topic == "/jde/decisions")
            .count() as u64
    }

    /// Returns the texts of the recorded events of one kind.
    pub(crate) fn events(&self, kind: &str) -> Vec<String> {
        let recording = Recording::open(&self.file).unwrap();
        let messages = recording.messages().unwrap().map(Result::unwrap);
        let texts = messages.filter_map(|message| match record::read(&message) {
            Some(RunRecord::Other(event)) if event.what.kind() == kind => Some(event.text()),
            _ => None,
        });
        texts.collect()
    }

    fn recorder(&self, application: &Application, lossless: bool) -> Arc<Recorder> {
        let options = jde_recorder::RecorderOptions {
            origin: Origin::of(application, true),
            application: Some(application),
            overwrite: false,
            lossless,
            on_trouble: Box::new(|error| panic!("{error}")),
        };
        Arc::new(Recorder::create(&self.file, options).unwrap())
    }
}

/// Loads the plugins of safe-navigation from their files.
pub(crate) fn navigation_plugins() -> Plugins {
    plugins(&["sim", "example", "goon", "vff", "stop", "teleop"])
}

fn watch(recorder: &Arc<Recorder>, selection: Selection) -> StartHook {
    let recorder = Arc::clone(recorder);
    Box::new(move |handle| {
        for variable in handle.board().list() {
            if selection.contains(&variable.describe().full_name()) {
                let handle = handle.clone();
                recorder.watch(&variable, Arc::new(move || handle.now()));
            }
        }
        Ok(())
    })
}

/// Returns the plugins `names`. The first call builds them.
fn plugins(names: &[&str]) -> Plugins {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| jde_test_plugins::folder(names));
    let mut path = SearchPath::default();
    path.push(folder, "built for this test");
    Plugins::new(path)
}
