//! An application of nothing but variables, for the link to serve; and a folder of its own for each test.

#![allow(dead_code, unreachable_pub, reason = "each test uses its part")]

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use jde_board::{Access, Board, Declaration, Nanos, Variable, Writer};
use jde_host::snapshot::Snapshot;
use jde_link::message::{Action, Range, Refusal, Schemas};
use jde_link::{Client, Events, Folder, Link, Reach, Remote, Sample, Settings, Subject, Title};
use jde_types::Value as _;

/// How long a test waits for what must come.
pub const SOON: Duration = Duration::from_secs(30);

/// An application without schemas.
pub struct Stage {
    pub board: Board,
    pub clock: AtomicU64,
    pub acted: Mutex<Vec<(String, Action)>>,
    pub snapshots: AtomicU64,
}

impl Stage {
    pub fn new() -> Arc<Self> {
        let stage = Self {
            board: Board::new(),
            clock: AtomicU64::new(5_000_000_000),
            acted: Mutex::default(),
            snapshots: AtomicU64::new(0),
        };
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

    pub fn export(&self, owner: &str, name: &str, value_type: jde_abi::describe::Type) -> Arc<Variable> {
        self.board.declare(declaration(owner, name, value_type)).unwrap()
    }

    pub fn writer(&self, variable: &str) -> Writer {
        self.board.get(variable).unwrap().writer(0, "pioneer").unwrap()
    }

    pub fn acts(&self) -> Vec<(String, Action)> {
        self.acted.lock().unwrap().clone()
    }
}

pub fn write(writer: &mut Writer, number: f64, time: Nanos) {
    writer.loan().copy_from_slice(&number.to_ne_bytes());
    writer.publish(time, time).unwrap();
}

pub fn declaration(owner: &str, name: &str, value_type: jde_abi::describe::Type) -> Declaration {
    Declaration {
        owner: owner.to_owned(),
        name: name.to_owned(),
        doc: "A test.".to_owned(),
        unit: String::new(),
        value_type: Arc::new(value_type),
        access: Access::Export,
        initial: None,
        writers: 1,
        readers: 1,
    }
}

impl Subject for Stage {
    fn title(&self) -> Title {
        Title {
            application: "stage".to_owned(),
            file: "stage.toml".to_owned(),
            executor: "threads".to_owned(),
            speed: 1.0,
        }
    }

    fn schemas(&self) -> Schemas {
        Schemas::default()
    }

    fn board(&self) -> &Board {
        &self.board
    }

    fn limits(&self, _: &Variable) -> (Range, bool) {
        (Range::default(), false)
    }

    fn writer(&self, number: u32) -> String {
        match number {
            0 => "pioneer".to_owned(),
            _ => String::new(),
        }
    }

    fn now(&self) -> Nanos {
        self.clock.load(Ordering::Relaxed)
    }

    fn snapshot(&self) -> Snapshot {
        self.snapshots.fetch_add(1, Ordering::Relaxed);
        Snapshot {
            time: self.now(),
            schemas: Vec::new(),
            groups: Vec::new(),
        }
    }

    fn act(&self, by: &str, action: &Action) -> Result<(), Refusal> {
        if action.schema() == "nobody" {
            return Err(Refusal {
                error: "there is no schema `nobody`".to_owned(),
                nearest: Some("goon".to_owned()),
            });
        }
        self.acted.lock().unwrap().push((by.to_owned(), action.clone()));
        Ok(())
    }
}

/// A folder for one test.
pub struct Home {
    pub folder: Folder,
    _files: tempfile::TempDir,
}

impl Home {
    pub fn new() -> Self {
        let files = tempfile::tempdir().unwrap();
        Self {
            folder: Folder::at(files.path().join("jde")),
            _files: files,
        }
    }

    pub fn settings(&self, name: &str) -> Settings {
        Settings {
            folder: self.folder.clone(),
            ..Settings::local(name)
        }
    }

    pub fn open(&self, name: &str, stage: &Arc<Stage>) -> Link {
        Link::open(&self.settings(name), stage.clone(), &Events::told()).unwrap()
    }

    pub fn client(&self) -> Client {
        Client::connect(&Reach::Local(self.folder.clone())).unwrap()
    }

    pub fn remote(&self) -> Remote {
        self.client().application(None).unwrap()
    }
}

/// Values of a variable as they come.
pub fn watch(
    remote: &Remote,
    variable: &str,
    rate: jde_link::Rate,
) -> (jde_link::Watching, Receiver<Sample>) {
    let (tell, told) = channel();
    let watching = remote
        .watch(variable, rate, move |sample| drop(tell.send(sample)))
        .unwrap();
    (watching, told)
}

/// Looks again and again until it is so.
pub fn until(what: &str, mut so: impl FnMut() -> bool) {
    let start = std::time::Instant::now();
    while !so() {
        assert!(start.elapsed() < SOON, "{what}");
        std::thread::yield_now();
    }
}

pub fn number(sample: &Sample) -> Option<f64> {
    let bytes = sample.bytes.as_ref()?;
    Some(f64::from_ne_bytes(bytes.as_slice().try_into().unwrap()))
}
