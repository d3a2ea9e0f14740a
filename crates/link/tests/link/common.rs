//! A subject with variables only, and a separate folder for each test.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
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
use zenoh::Wait;

use crate::panels::Easel;

/// Longest wait for an expected event.
pub(crate) const SOON: Duration = Duration::from_secs(30);

/// An application without schemas.
pub(crate) struct Stage {
    pub(crate) board: Board,
    pub(crate) clock: AtomicU64,
    pub(crate) acted: Mutex<Vec<(String, Action)>>,
    pub(crate) snapshots: AtomicU64,
    /// The number of accesses to its board.
    pub(crate) looked: AtomicU64,
    pub(crate) easel: Arc<Easel>,
    /// Holding it delays gestures.
    pub(crate) hold: Mutex<()>,
    /// Holding it delays snapshots that were taken.
    pub(crate) hold_snapshots: Mutex<()>,
    imports: Vec<Import>,
    /// Set if its time advances in real time.
    start: Option<Instant>,
}

impl Stage {
    pub(crate) fn new() -> Arc<Self> {
        Self::importing(Vec::new())
    }

    /// A stage that imports from others, and whose time advances.
    pub(crate) fn importing(imports: Vec<Import>) -> Arc<Self> {
        let stage = Self {
            start: (!imports.is_empty()).then(Instant::now),
            board: Board::new(),
            clock: AtomicU64::new(5_000_000_000),
            hold: Mutex::default(),
            hold_snapshots: Mutex::default(),
            acted: Mutex::default(),
            snapshots: AtomicU64::new(0),
            looked: AtomicU64::new(0),
            easel: Arc::default(),
            imports,
        };
        for import in &stage.imports {
            let (owner, name) = import.parts();
            let value_type = jde_abi::describe::Type::clone(&import.value_type);
            stage.export(owner, name, value_type);
        }
        stage.export("pioneer", "bearing", f64::describe());
        stage.export("pioneer", "path", jde_types::Path::describe());
        let gain = Declaration {
            access: Access::Modulation,
            initial: Some(0.5_f64.to_ne_bytes().to_vec()),
            ..declaration("goon", "gain", f64::describe())
        };
        stage.board.declare(gain).unwrap();
        Arc::new(stage)
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

    pub(crate) fn acts(&self) -> Vec<(String, Action)> {
        self.acted.lock().unwrap().clone()
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
        access: Access::Export,
        limits: jde_abi::describe::Limits::default(),
        initial: None,
        writers: 1,
        readers: 1,
    }
}

impl Subject for Stage {
    fn info(&self) -> SubjectInfo {
        SubjectInfo {
            application: "stage".to_owned(),
            file: "stage.toml".to_owned(),
            executor: "threads".to_owned(),
            speed: 1.0,
        }
    }

    fn schemas(&self) -> Schemas {
        self.easel.schemas()
    }

    fn view_panel(&self, _: &str, rate: f64, news: OnDrawn) -> Result<Box<dyn PanelViewer>, Refusal> {
        Ok(Easel::look(&self.easel, rate, news))
    }

    fn board(&self) -> &Board {
        self.looked.fetch_add(1, Ordering::Relaxed);
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
        };
        self.snapshots.fetch_add(1, Ordering::Relaxed);
        drop(self.hold_snapshots.lock().unwrap());
        snapshot
    }

    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal> {
        if action.schema() == "nobody" {
            return Err(Refusal {
                error: "there is no schema `nobody`".to_owned(),
                nearest: Some("goon".to_owned()),
            });
        }
        if matches!(action, Action::Touch { .. }) {
            drop(self.hold.lock().unwrap());
        }
        self.acted.lock().unwrap().push((by.to_owned(), action.clone()));
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

/// A folder for one test.
pub(crate) struct Home {
    pub(crate) folder: Folders,
    _files: tempfile::TempDir,
}

impl Home {
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

    pub(crate) fn open(&self, name: &str, stage: &Arc<Stage>) -> Link {
        Link::open(&self.settings(name), stage.clone(), &Events::of_records()).unwrap()
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
    let (tell, told) = channel();
    let watching = remote
        .watch(variable, rate, move |sample| drop(tell.send(sample)))
        .unwrap();
    (watching, told)
}

/// Polls a condition until it is true.
pub(crate) fn until(what: &str, mut so: impl FnMut() -> bool) {
    let start = std::time::Instant::now();
    while !so() {
        assert!(start.elapsed() < SOON, "{what}");
        // The awaited thread may need the processor.
        std::thread::park_timeout(Duration::from_millis(2));
    }
}

pub(crate) fn number(sample: &Sample) -> Option<f64> {
    let bytes = sample.bytes.as_ref()?;
    Some(f64::from_ne_bytes(bytes.as_slice().try_into().unwrap()))
}

/// A client without the protocol.
pub(crate) fn stranger(endpoint: &str) -> zenoh::Session {
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
