//! Real applications in this process, and sessions on them. Their plugins are built if needed. No helper
//! waits for a fixed time: a harness takes steps until a condition holds.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use eframe::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::{By, NodeT, Queryable};
use jde_app::Application;
use jde_host::{Handle, Options, Running};
use jde_link::{Client, Events, Folders, Link, Reach, Settings, SubjectInfo};
use jde_loader::{Plugins, SearchPath};

use crate::session::WindowSession;

pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// The plugins of the applications that come with jde.
const PLUGINS: [&str; 10] = [
    "sim", "carmen", "example", "goon", "vff", "stop", "family", "pair", "ball", "teleop",
];

/// Maximum number of steps of a harness until a condition holds: minutes, on any machine.
const STEPS: usize = 400_000;

/// A running application with a link.
pub(crate) struct Robot {
    // Dropped in this order: the link closes before the application ends.
    _link: Link,
    running: Running,
    folder: Folders,
    files: tempfile::TempDir,
}

impl Robot {
    /// Starts an application of `apps`, by the name of its file without extension.
    pub(crate) fn of(name: &str) -> Self {
        let plugins = plugins();
        let file = Path::new(ROOT).join("apps").join(format!("{name}.toml"));
        let application = jde_app::load(&file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
        Self::start(application, &plugins, None)
    }

    /// Starts an application from text, with plugins that the test links in.
    pub(crate) fn linked(text: &str, plugins: Plugins) -> Self {
        Self::linked_at(&Path::new(ROOT).join("apps/test.toml"), text, plugins)
    }

    /// As [`Self::linked`], with the text in this file.
    pub(crate) fn linked_at(file: &Path, text: &str, plugins: Plugins) -> Self {
        let application =
            jde_app::parse(text, file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
        Self::start(application, &plugins, None)
    }

    /// As [`Self::linked`]; the windows see it as a recording that plays.
    pub(crate) fn recorded(text: &str, plugins: Plugins) -> Self {
        let file = Path::new(ROOT).join("apps/test.toml");
        let application =
            jde_app::parse(text, &file, &[], &plugins).unwrap_or_else(|faults| panic!("{faults}"));
        Self::start(application, &plugins, Some("replay"))
    }

    fn start(application: Application, plugins: &Plugins, executor: Option<&str>) -> Self {
        let files = tempfile::tempdir().expect("the folder is created");
        let folder = Folders::at(files.path().join("jde"));
        let events = Events::of(&application);
        let mut title = SubjectInfo::new(&application, 1.0);
        if let Some(executor) = executor {
            executor.clone_into(&mut title.executor);
        }
        let options = Options {
            observers: vec![events.observer()],
            ..Options::default()
        };
        let name = application.name.clone();
        let running = Running::start(application, plugins, options).expect("the application starts");
        let settings = Settings {
            folder: folder.clone(),
            ..Settings::local(&name)
        };
        let subject = Arc::new(jde_link_host::Running::new(running.handle(), title));
        Self {
            _link: Link::open(&settings, subject, &events).expect("the link opens"),
            running,
            folder,
            files,
        }
    }

    /// Opens another link to the application with other settings, as a separate run.
    pub(crate) fn serve(&self, settings: &Settings) -> Link {
        self.serve_with(settings, &Events::of_records())
    }

    /// As [`Self::serve`], with events of its own.
    pub(crate) fn serve_with(&self, settings: &Settings, events: &Events) -> Link {
        let title = SubjectInfo {
            application: settings.name.clone(),
            file: "robot.toml".to_owned(),
            executor: "threads".to_owned(),
            speed: 1.0,
        };
        let subject = Arc::new(jde_link_host::Running::new(self.running.handle(), title));
        Link::open(settings, subject, events).expect("the link opens")
    }

    /// Direct access to the application, without the link.
    pub(crate) fn handle(&self) -> Handle {
        self.running.handle()
    }

    /// Where tools find the application.
    pub(crate) fn reach(&self) -> Reach {
        Reach::Local(self.folder.clone())
    }

    /// The folder in which the application is announced.
    pub(crate) fn announcement_folder(&self) -> PathBuf {
        self.files.path().join("jde")
    }

    /// Opens a session on the application, as a window does.
    pub(crate) fn session(&self) -> WindowSession {
        let remote = Client::connect(&self.reach())
            .and_then(|client| client.application(None))
            .expect("the application is found");
        WindowSession::open(remote, egui::Context::default()).expect("the application replies")
    }
}

/// Takes steps until a condition holds. Panics after [`STEPS`] steps.
pub(crate) fn until<State>(
    harness: &mut Harness<'_, State>,
    mut condition: impl FnMut(&mut Harness<'_, State>) -> bool,
) {
    for _ in 0..STEPS {
        if condition(harness) {
            return;
        }
        harness.step();
        // Gives the application's threads time on a machine with few cores. The loop does not depend on it.
        std::thread::yield_now();
    }
    let shown = harness.query_all(By::new());
    let shown: Vec<String> = shown
        .filter_map(|node| {
            let node = node.accesskit_node();
            node.label().or_else(|| node.value())
        })
        .collect();
    panic!("the condition did not hold within {STEPS} steps; the window shows {shown:?}");
}

/// The plugins of [`PLUGINS`], built by the first call.
pub(crate) fn plugins() -> Plugins {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| jde_test_plugins::folder(&PLUGINS));
    let mut path = SearchPath::default();
    path.push(folder, "built for this test");
    Plugins::new(path)
}
