//! Applications and clients in processes of their own, which can be killed and stopped.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use jde_link::{Client, Error, Folders, Rate, Reach};
use jde_watchdog::Watchdog;
use rustix::process::{Pid, Signal, kill_process};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use crate::common::{Home, SOON, Stage, import, number, socket, stranger, until, watch, write};

/// Environment variables with the role of a child process and its folder.
const ROLE: &str = "JDE_LINK_TEST_ROLE";
const PLACE: &str = "JDE_LINK_TEST_PLACE";

/// This test program in another role; killed when dropped.
pub(crate) struct Actor {
    child: Child,
    out: BufReader<ChildStdout>,
    _watchdog: Watchdog,
}

impl Actor {
    pub(crate) fn start(role: &str, home: &Home) -> Self {
        Self::run(
            Command::new(std::env::current_exe().unwrap()),
            role,
            home.folder.path(),
        )
    }

    /// Starts an actor in a network namespace.
    pub(crate) fn on(machine: &str, role: &str, folder: &Path) -> Self {
        let mut command = Command::new("ip");
        command
            .args(["netns", "exec", machine])
            .arg(std::env::current_exe().unwrap());
        Self::run(command, role, folder)
    }

    fn run(mut command: Command, role: &str, folder: &Path) -> Self {
        let mut child = command
            .args(["--exact", "processes::plays_its_role", "--nocapture"])
            .env(ROLE, role)
            .env(PLACE, folder)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let mut actor = Self {
            child,
            out,
            _watchdog: Watchdog::for_test(),
        };
        actor.hears("ready");
        actor
    }

    /// Waits for a line with a word, and returns the line.
    pub(crate) fn hears(&mut self, word: &str) -> String {
        let mut line = String::new();
        while !line.contains(word) {
            line.clear();
            assert!(
                self.out.read_line(&mut line).unwrap() > 0,
                "it ended before it said {word}"
            );
        }
        line
    }

    /// Waits for a line with a word, and returns the number after it.
    pub(crate) fn number(&mut self, word: &str) -> u64 {
        let line = self.hears(word);
        let (_, number) = line.split_once(word).unwrap();
        number.trim().parse().unwrap()
    }

    fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(self.child.id().cast_signed()).unwrap();
        kill_process(pid, signal).unwrap();
    }
}

impl Drop for Actor {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Plays the roles of the child processes; tests nothing itself.
#[test]
fn plays_its_role() {
    let Ok(role) = std::env::var(ROLE) else { return };
    let folder = Folders::at(std::env::var_os(PLACE).unwrap());
    match role.as_str() {
        "application" => {
            let stage = Stage::new();
            write(&mut stage.writer("pioneer.bearing"), 1.5, 1);
            let settings = jde_link::Settings {
                folder,
                ..jde_link::Settings::local("robot")
            };
            let _link = jde_link::Link::open(&settings, stage, &jde_link::Events::of_records()).unwrap();
            println!("ready");
            loop {
                std::thread::park();
            }
        }
        "client" => {
            let client = Client::connect(&Reach::Local(folder)).unwrap();
            let remote = client.application(None).unwrap();
            let (_watching, told) = watch(&remote, "pioneer.bearing", Rate::Full);
            told.recv().unwrap();
            println!("ready");
            loop {
                std::thread::park();
            }
        }
        // Watches a panel.
        "viewer" => {
            let client = Client::connect(&Reach::Local(folder)).unwrap();
            let remote = client.application(None).unwrap();
            let _watching = remote.watch_panel("goon", Rate::Hz(5), |_| {}).unwrap();
            println!("ready");
            loop {
                std::thread::park();
            }
        }
        // Queries a value 3000 times a second.
        "asks" => {
            let socket = socket(&folder);
            let stranger = stranger(&format!("unixsock-stream/{}", socket.display()));
            let id = socket.file_stem().unwrap().to_string_lossy();
            let key = format!("jde/1/robot/{id}/var/pioneer/bearing");
            println!("ready");
            loop {
                for _ in 0..3 {
                    let _ = stranger.get(&key).callback(|_| {}).wait();
                }
                std::thread::park_timeout(Duration::from_millis(1));
            }
        }
        // Queries everything endlessly and reads nothing.
        "flood" => {
            let socket = socket(&folder);
            let stranger = stranger(&format!("unixsock-stream/{}", socket.display()));
            let id = socket.file_stem().unwrap().to_string_lossy();
            println!("ready");
            loop {
                for (key, payload) in [
                    ("operate", r#"{"by":"x","action":"play","schema":"goon"}"#),
                    ("variables?status", ""),
                    ("**", ""),
                    ("hierarchy", ""),
                ] {
                    let get = stranger.get(format!("jde/1/robot/{id}/{key}")).payload(payload);
                    let _ = get
                        .congestion_control(CongestionControl::Drop)
                        .callback(|_| {})
                        .wait();
                }
                let put = stranger.put("jde/1/robot/x/hierarchy", vec![0; 1000]);
                let _ = put.congestion_control(CongestionControl::Drop).wait();
            }
        }
        // The two machines of `cut`: an increasing number, and its importer. They connect by address or by
        // multicast.
        "robot" | "robot to meet" => {
            let stage = Stage::new();
            let mut writer = stage.writer("pioneer.bearing");
            let mut settings = networked(folder, "robot2", &["tcp/10.77.0.2:7447"], &[]);
            settings.discover = role == "robot to meet";
            let _link = jde_link::Link::open(&settings, stage, &jde_link::Events::of_records()).unwrap();
            println!("ready");
            for value in 1_u32.. {
                write(&mut writer, value.into(), 5_000_000_000);
                std::thread::park_timeout(Duration::from_millis(20));
            }
        }
        "base" | "base to meet" => {
            let stale = Duration::from_millis(500);
            let stage = Stage::importing(vec![import("robot2", "pioneer.bearing", stale)]);
            let proxy = stage.board.get("robot2:pioneer.bearing").unwrap();
            let mut settings = networked(folder, "base", &[], &[]);
            settings.discover = role == "base to meet";
            if !settings.discover {
                settings.connect = vec!["tcp/10.77.0.2:7447".to_owned()];
            }
            let _link = jde_link::Link::open(&settings, stage, &jde_link::Events::of_records()).unwrap();
            println!("ready");
            let mut said = 0;
            loop {
                let newest = proxy.wait_newer(said, Duration::from_millis(50));
                let mut reader = proxy.reader("base");
                match reader.latch() {
                    Some(latched) if newest != said => {
                        println!("shows {}", f64::from_ne_bytes(latched.bytes.try_into().unwrap()));
                    }
                    Some(_) => {}
                    None => println!("nothing"),
                }
                said = newest;
            }
        }
        other => panic!("there is no role {other}"),
    }
}

fn networked(folder: Folders, name: &str, listen: &[&str], connect: &[&str]) -> jde_link::Settings {
    let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
    jde_link::Settings {
        folder,
        listen: texts(listen),
        connect: texts(connect),
        insecure: true,
        ..jde_link::Settings::local(name)
    }
}

#[test]
fn an_application_that_is_killed_is_gone_and_leaves_nothing() {
    let home = Home::new();
    let actor = Actor::start("application", &home);
    let remote = home.remote();
    assert_eq!(number(&remote.get("pioneer.bearing").unwrap()), Some(1.5));
    assert_eq!(remote.about().pid, actor.child.id());
    drop(actor);
    assert!(remote.wait_gone(SOON));
    assert!(matches!(
        remote.get("pioneer.bearing"),
        Err(Error::Disconnected(_))
    ));
    assert!(home.client().applications().unwrap().is_empty());
    let left = std::fs::read_dir(home.folder.path()).unwrap().flatten();
    let left: Vec<_> = left.map(|file| file.file_name()).collect();
    assert_eq!(left, ["lock"]);
    // Its name is free again.
    assert_eq!(home.open("robot", &Stage::new()).about().name, "robot");
}

#[test]
fn an_application_that_is_stopped_is_there_and_does_not_answer() {
    let home = Home::new();
    let actor = Actor::start("application", &home);
    let client = home.client();
    actor.signal(Signal::STOP);
    assert_eq!(client.applications().unwrap().len(), 1);
    let error = client.application(None).err().unwrap();
    assert!(
        matches!(&error, Error::Timeout { application, .. } if application == "robot"),
        "{error}"
    );
    actor.signal(Signal::CONT);
    let mut remote = None;
    until("it answers again", || {
        remote = client.application(None).ok();
        remote.is_some()
    });
    assert_eq!(
        number(&remote.unwrap().get("pioneer.bearing").unwrap()),
        Some(1.5)
    );
}

#[test]
fn clients_that_are_killed_or_stopped_are_forgotten_and_hold_up_nobody() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let mut writer = stage.writer("pioneer.bearing");
    write(&mut writer, 0.0, 1);
    let readers = || {
        stage
            .board
            .get("pioneer.bearing")
            .unwrap()
            .status(0)
            .readers
            .len()
    };
    for signal in [Signal::KILL, Signal::STOP] {
        let actor = Actor::start("client", &home);
        assert_eq!(readers(), 1);
        actor.signal(signal);
        let remote = home.remote();
        let (watching, told) = watch(&remote, "pioneer.bearing", Rate::Full);
        told.recv_timeout(SOON).unwrap();
        for value in 1..=500 {
            write(&mut writer, f64::from(value), 1);
            while number(&told.recv_timeout(SOON).unwrap()) != Some(f64::from(value)) {}
        }
        drop(watching);
        until("nothing is sent for it any more", || readers() == 0);
    }
}
