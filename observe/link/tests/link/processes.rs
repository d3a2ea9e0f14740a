//! Applications and clients in child processes, which the tests kill and stop.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use jde_link::{Client, Error, Folders, Rate, Reach};
use jde_watchdog::Watchdog;
use rustix::process::{Pid, Signal, kill_process};
use zenoh::Wait;
use zenoh::qos::CongestionControl;

use crate::common::{
    TIMEOUT, TestRuntime, TestSubject, import, number, raw_session, socket, until, watch, write,
};

/// Environment variables with the role of a child process and its folder.
const ROLE: &str = "JDE_LINK_TEST_ROLE";
const FOLDER: &str = "JDE_LINK_TEST_FOLDER";

/// This test program in another role; killed when dropped.
pub(crate) struct ChildProcess {
    process: Child,
    output: BufReader<ChildStdout>,
    _watchdog: Watchdog,
}

impl ChildProcess {
    pub(crate) fn start(role: &str, runtime: &TestRuntime) -> Self {
        Self::run(
            Command::new(std::env::current_exe().unwrap()),
            role,
            runtime.folder.path(),
        )
    }

    /// Starts a child process in a network namespace.
    pub(crate) fn in_namespace(namespace: &str, role: &str, folder: &Path) -> Self {
        let mut command = Command::new("ip");
        command
            .args(["netns", "exec", namespace])
            .arg(std::env::current_exe().unwrap());
        Self::run(command, role, folder)
    }

    fn run(mut command: Command, role: &str, folder: &Path) -> Self {
        let mut process = command
            .args(["--exact", "processes::runs_its_role", "--nocapture"])
            .env(ROLE, role)
            .env(FOLDER, folder)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let output = BufReader::new(process.stdout.take().unwrap());
        let mut child = Self {
            process,
            output,
            _watchdog: Watchdog::for_test(),
        };
        child.wait_for_line("ready");
        child
    }

    /// Waits for a line with a word, and returns the line.
    pub(crate) fn wait_for_line(&mut self, word: &str) -> String {
        let mut line = String::new();
        while !line.contains(word) {
            line.clear();
            assert!(
                self.output.read_line(&mut line).unwrap() > 0,
                "the process ended before it printed {word}"
            );
        }
        line
    }

    /// Waits for a line with a word, and returns the number after it.
    pub(crate) fn number(&mut self, word: &str) -> u64 {
        let line = self.wait_for_line(word);
        let (_, number) = line.split_once(word).unwrap();
        number.trim().parse().unwrap()
    }

    fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(self.process.id().cast_signed()).unwrap();
        kill_process(pid, signal).unwrap();
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The entry point of the child processes; tests nothing itself.
#[test]
fn runs_its_role() {
    let Ok(role) = std::env::var(ROLE) else { return };
    let folder = Folders::at(std::env::var_os(FOLDER).unwrap());
    match role.as_str() {
        "application" => {
            let subject = TestSubject::new();
            write(&mut subject.writer("pioneer.bearing"), 1.5, 1);
            let settings = jde_link::Settings {
                folder,
                ..jde_link::Settings::local("robot")
            };
            let _link = jde_link::Link::open(&settings, subject, &jde_link::Events::of_records()).unwrap();
            println!("ready");
            loop {
                std::thread::park();
            }
        }
        "client" => {
            let client = Client::connect(&Reach::Local(folder)).unwrap();
            let remote = client.application(None).unwrap();
            let (_subscription, received) = watch(&remote, "pioneer.bearing", Rate::Full);
            received.recv().unwrap();
            println!("ready");
            loop {
                std::thread::park();
            }
        }
        // Watches a panel.
        "viewer" => {
            let client = Client::connect(&Reach::Local(folder)).unwrap();
            let remote = client.application(None).unwrap();
            let _subscription = remote.watch_panel("goon", Rate::Hz(5), |_| {}).unwrap();
            println!("ready");
            loop {
                std::thread::park();
            }
        }
        // Queries a value 3000 times a second.
        "queries" => {
            let socket = socket(&folder);
            let raw_session = raw_session(&format!("unixsock-stream/{}", socket.display()));
            let id = socket.file_stem().unwrap().to_string_lossy();
            let key = format!("jde/1/robot/{id}/var/pioneer/bearing");
            println!("ready");
            loop {
                for _ in 0..3 {
                    let _ = raw_session.get(&key).callback(|_| {}).wait();
                }
                std::thread::park_timeout(Duration::from_millis(1));
            }
        }
        // Queries everything endlessly and reads nothing.
        "flood" => {
            let socket = socket(&folder);
            let raw_session = raw_session(&format!("unixsock-stream/{}", socket.display()));
            let id = socket.file_stem().unwrap().to_string_lossy();
            println!("ready");
            loop {
                for (key, payload) in [
                    ("operate", r#"{"by":"x","action":"play","schema":"goon"}"#),
                    ("variables?status", ""),
                    ("**", ""),
                    ("hierarchy", ""),
                ] {
                    let get = raw_session
                        .get(format!("jde/1/robot/{id}/{key}"))
                        .payload(payload);
                    let _ = get
                        .congestion_control(CongestionControl::Drop)
                        .callback(|_| {})
                        .wait();
                }
                let put = raw_session.put("jde/1/robot/x/hierarchy", vec![0; 1000]);
                let _ = put.congestion_control(CongestionControl::Drop).wait();
            }
        }
        // The two machines of `cut`: one publishes an increasing number, the other imports it. They connect
        // by address or by multicast.
        "robot" | "robot by multicast" => {
            let subject = TestSubject::new();
            let mut writer = subject.writer("pioneer.bearing");
            let mut settings = networked(folder, "robot2", &["tcp/10.77.0.2:7447"], &[]);
            settings.discover = role == "robot by multicast";
            let _link = jde_link::Link::open(&settings, subject, &jde_link::Events::of_records()).unwrap();
            println!("ready");
            for value in 1_u32.. {
                write(&mut writer, value.into(), 5_000_000_000);
                std::thread::park_timeout(Duration::from_millis(20));
            }
        }
        "base" | "base by multicast" => {
            let stale = Duration::from_millis(500);
            let subject = TestSubject::with_imports(vec![import("robot2", "pioneer.bearing", stale)]);
            let proxy = subject.board.get("robot2:pioneer.bearing").unwrap();
            let mut settings = networked(folder, "base", &[], &[]);
            settings.discover = role == "base by multicast";
            if !settings.discover {
                settings.connect = vec!["tcp/10.77.0.2:7447".to_owned()];
            }
            let _link = jde_link::Link::open(&settings, subject, &jde_link::Events::of_records()).unwrap();
            println!("ready");
            let mut printed = 0;
            loop {
                let newest = proxy.wait_newer(printed, Duration::from_millis(50));
                let mut reader = proxy.reader("base");
                match reader.latch(0) {
                    Some(latched) if newest != printed => {
                        println!("value {}", f64::from_ne_bytes(latched.bytes.try_into().unwrap()));
                    }
                    Some(_) => {}
                    None => println!("none"),
                }
                printed = newest;
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
fn a_killed_application_is_gone_and_its_files_are_removed() {
    let runtime = TestRuntime::new();
    let child = ChildProcess::start("application", &runtime);
    let remote = runtime.remote();
    assert_eq!(number(&remote.get("pioneer.bearing").unwrap()), Some(1.5));
    assert_eq!(remote.about().pid, child.process.id());
    drop(child);
    assert!(remote.wait_gone(TIMEOUT));
    assert!(matches!(
        remote.get("pioneer.bearing"),
        Err(Error::Disconnected(_))
    ));
    assert!(runtime.client().applications().unwrap().is_empty());
    let remaining = std::fs::read_dir(runtime.folder.path()).unwrap().flatten();
    let remaining: Vec<_> = remaining.map(|file| file.file_name()).collect();
    assert_eq!(remaining, ["lock"]);
    // Its name is free again.
    assert_eq!(runtime.open("robot", &TestSubject::new()).about().name, "robot");
}

#[test]
fn a_stopped_application_is_listed_and_does_not_reply() {
    let runtime = TestRuntime::new();
    let child = ChildProcess::start("application", &runtime);
    let client = runtime.client();
    child.signal(Signal::STOP);
    assert_eq!(client.applications().unwrap().len(), 1);
    let error = client.application(None).err().unwrap();
    assert!(
        matches!(&error, Error::Timeout { application, .. } if application == "robot"),
        "{error}"
    );
    child.signal(Signal::CONT);
    let mut remote = None;
    until("the application replies again", || {
        remote = client.application(None).ok();
        remote.is_some()
    });
    assert_eq!(
        number(&remote.unwrap().get("pioneer.bearing").unwrap()),
        Some(1.5)
    );
}

#[test]
fn killed_and_stopped_clients_are_removed_and_delay_no_other() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let mut writer = subject.writer("pioneer.bearing");
    write(&mut writer, 0.0, 1);
    let readers = || {
        subject
            .board
            .get("pioneer.bearing")
            .unwrap()
            .status(0)
            .readers
            .len()
    };
    for signal in [Signal::KILL, Signal::STOP] {
        let child = ChildProcess::start("client", &runtime);
        assert_eq!(readers(), 1);
        child.signal(signal);
        let remote = runtime.remote();
        let (subscription, received) = watch(&remote, "pioneer.bearing", Rate::Full);
        received.recv_timeout(TIMEOUT).unwrap();
        for value in 1..=500 {
            write(&mut writer, f64::from(value), 1);
            while number(&received.recv_timeout(TIMEOUT).unwrap()) != Some(f64::from(value)) {}
        }
        drop(subscription);
        until("the link closes its reader", || readers() == 0);
    }
}
