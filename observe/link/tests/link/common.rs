//! An application without schemas, and a separate runtime folder for each test.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use jde_app::RemoteVariable as Import;
use jde_board::{Access, Board, Declaration, Nanos, Variable, Writer};
use jde_link::message::{Action, Refusal, Schemas};
use jde_link::{
    Client, Events, Folders, Link, OnDrawn, PanelViewer, Reach, Remote, Sample, Settings, Subject,
    SubjectInfo,
};
use jde_records::snapshot::Snapshot;
use jde_types::Value as _;
use parking_lot::Mutex;
use zenoh::Wait;

use crate::panels::TestPanel;

/// Longest wait for an expected event.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(30);

/// An application without schemas.
pub(crate) struct TestSubject {
    pub(crate) board: Board,
    pub(crate) clock: AtomicU64,
    pub(crate) actions: Mutex<Vec<(String, Action)>>,
    pub(crate) snapshots: AtomicU64,
    /// How often the link accessed its board.
    pub(crate) board_accesses: AtomicU64,
    pub(crate) panel: Arc<TestPanel>,
    /// Locking it delays gestures.
    pub(crate) gesture_lock: Mutex<()>,
    /// Locking it delays the return of snapshots.
    pub(crate) snapshot_lock: Mutex<()>,
    imports: Vec<Import>,
    /// The start, if its time advances in real time.
    start: Option<Instant>,
}

impl TestSubject {
    pub(crate) fn new() -> Arc<Self> {
        Self::with_imports(Vec::new())
    }

    /// An application that imports from others. Its time advances in real time.
    pub(crate) fn with_imports(imports: Vec<Import>) -> Arc<Self> {
        let subject = Self {
            start: (!imports.is_empty()).then(Instant::now),
            board: Board::new(),
            clock: AtomicU64::new(5_000_000_000),
            gesture_lock: Mutex::default(),
            snapshot_lock: Mutex::default(),
            actions: Mutex::default(),
            snapshots: AtomicU64::new(0),
            board_accesses: AtomicU64::new(0),
            panel: Arc::default(),
            imports,
        };
        for import in &subject.imports {
            let (owner, name) = import.parts();
            let value_type = jde_abi::describe::Type::clone(&import.value_type);
            subject.export(owner, name, value_type);
        }
        subject.export("pioneer", "bearing", f64::describe());
        subject.export("pioneer", "path", jde_types::Path::describe());
        let gain = Declaration {
            access: Access::Modulation,
            initial: Some(0.5_f64.to_ne_bytes().to_vec()),
            ..declaration("goon", "gain", f64::describe())
        };
        subject.board.declare(gain).unwrap();
        Arc::new(subject)
    }

    pub(crate) fn export(
        &self,
        owner: &str,
        name: &str,
        value_type: jde_abi::describe::Type,
    ) -> Arc<Variable> {
        self.board.declare(declaration(owner, name, value_type)).unwrap()
    }

    pub(crate) fn writer(&self, variable: &str) -> Writer {
        self.board.get(variable).unwrap().writer(0, "pioneer").unwrap()
    }

    pub(crate) fn actions(&self) -> Vec<(String, Action)> {
        self.actions.lock().clone()
    }
}

pub(crate) fn write(writer: &mut Writer, number: f64, time: Nanos) {
    writer.loan().copy_from_slice(&number.to_ne_bytes());
    writer.publish(time, time).unwrap();
}

pub(crate) fn declaration(owner: &str, name: &str, value_type: jde_abi::describe::Type) -> Declaration {
    Declaration {
        owner: owner.to_owned(),
        name: name.to_owned(),
        doc: "A test.".to_owned(),
        unit: String::new(),
        value_type: Arc::new(value_type),
        access: Access::Export {
            validity: jde_board::LASTING,
        },
        limits: jde_abi::describe::Limits::default(),
        initial: None,
        writers: 1,
        readers: 1,
    }
}

impl Subject for TestSubject {
    fn info(&self) -> SubjectInfo {
        SubjectInfo {
            application: "test".to_owned(),
            file: "test.toml".to_owned(),
            executor: "threads".to_owned(),
            speed: 1.0,
        }
    }

    fn schemas(&self) -> Schemas {
        self.panel.schemas()
    }

    fn view_panel(&self, _: &str, rate: f64, on_drawn: OnDrawn) -> Result<Box<dyn PanelViewer>, Refusal> {
        Ok(TestPanel::view(&self.panel, rate, on_drawn))
    }

    fn board(&self) -> &Board {
        self.board_accesses.fetch_add(1, Ordering::Relaxed);
        &self.board
    }

    fn writer(&self, number: u32) -> String {
        match number {
            0 => "pioneer".to_owned(),
            _ => String::new(),
        }
    }

    fn now(&self) -> Nanos {
        match self.start {
            Some(start) => start.elapsed().as_nanos() as Nanos,
            None => self.clock.load(Ordering::Relaxed),
        }
    }

    fn imports(&self) -> &[Import] {
        &self.imports
    }

    fn snapshot(&self) -> Snapshot {
        let snapshot = Snapshot {
            time: self.now(),
            schemas: Vec::new(),
            groups: Vec::new(),
            ..Snapshot::default()
        };
        self.snapshots.fetch_add(1, Ordering::Relaxed);
        drop(self.snapshot_lock.lock());
        snapshot
    }

    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal> {
        if action.schema() == "unknown" {
            return Err(Refusal {
                error: "there is no schema `unknown`".to_owned(),
                nearest: Some("goon".to_owned()),
            });
        }
        if matches!(action, Action::Touch { .. }) {
            drop(self.gesture_lock.lock());
        }
        self.actions.lock().push((by.to_owned(), action.clone()));
        Ok(())
    }
}

/// The import of a number from a peer, valid for `stale`.
pub(crate) fn import(peer: &str, variable: &str, stale: Duration) -> Import {
    Import {
        peer: peer.to_owned(),
        variable: variable.to_owned(),
        local: format!("{peer}:{variable}"),
        value_type: Arc::new(f64::describe()),
        unit: String::new(),
        stale_ns: stale.as_nanos() as Nanos,
    }
}

/// A runtime folder for one test, and the applications and clients in it.
pub(crate) struct TestRuntime {
    pub(crate) folder: Folders,
    _files: tempfile::TempDir,
}

impl TestRuntime {
    pub(crate) fn new() -> Self {
        let files = tempfile::tempdir().unwrap();
        Self {
            folder: Folders::at(files.path().join("jde")),
            _files: files,
        }
    }

    pub(crate) fn settings(&self, name: &str) -> Settings {
        Settings {
            folder: self.folder.clone(),
            ..Settings::local(name)
        }
    }

    pub(crate) fn open(&self, name: &str, subject: &Arc<TestSubject>) -> Link {
        Link::open(&self.settings(name), subject.clone(), &Events::of_records()).unwrap()
    }

    pub(crate) fn client(&self) -> Client {
        Client::connect(&Reach::Local(self.folder.clone())).unwrap()
    }

    pub(crate) fn remote(&self) -> Remote {
        self.client().application(None).unwrap()
    }
}

/// Receives the values of a variable.
pub(crate) fn watch(
    remote: &Remote,
    variable: &str,
    rate: jde_link::Rate,
) -> (jde_link::Subscription, Receiver<Sample>) {
    let (sender, samples) = channel();
    let subscription = remote
        .watch(variable, rate, move |sample| drop(sender.send(sample)))
        .unwrap();
    (subscription, samples)
}

/// Polls a condition until it is true.
pub(crate) fn until(expected: &str, mut condition: impl FnMut() -> bool) {
    let start = std::time::Instant::now();
    while !condition() {
        assert!(start.elapsed() < TIMEOUT, "timed out: {expected}");
        // Leave the processor to the awaited thread.
        std::thread::park_timeout(Duration::from_millis(2));
    }
}

pub(crate) fn number(sample: &Sample) -> Option<f64> {
    let bytes = sample.bytes.as_ref()?;
    Some(f64::from_ne_bytes((**bytes).try_into().unwrap()))
}

/// A Zenoh session that does not implement the link's protocol.
pub(crate) fn raw_session(endpoint: &str) -> zenoh::Session {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"client\"".to_owned()),
        ("connect/endpoints", format!("[\"{endpoint}\"]")),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    zenoh::open(config).wait().unwrap()
}

/// The private socket of the only application.
pub(crate) fn socket(folder: &Folders) -> PathBuf {
    std::fs::read_dir(folder.path())
        .unwrap()
        .flatten()
        .map(|file| file.path())
        .find(|path| path.extension().is_some_and(|end| end == "sock"))
        .unwrap()
}
