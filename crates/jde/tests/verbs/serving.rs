//! `jde sim` as a user sees it, and robots whose driving process is stopped, killed or gone.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};

use jde_watchdog::Watchdog;

use crate::cable::Cable;
use crate::support::{jde, jde_with_plugins, json, root, said};

/// A served world. The server ends when this is dropped.
struct Server {
    process: Child,
    words: BufReader<ChildStdout>,
    address: String,
    _watchdog: Watchdog,
}

impl Server {
    fn start(world: &str, more: &[&str]) -> Self {
        let watchdog = Watchdog::for_test();
        let mut command = jde(&["sim", world, "--p2os", "127.0.0.1:0"]);
        let mut process = command
            .args(more)
            .current_dir(root())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the executable starts");
        let mut words = BufReader::new(process.stdout.take().expect("it has an output"));
        let line = until(&mut words, |line| line.contains("tcp:"));
        let (_, address) = line.split_once("tcp:").expect("an address");
        Self {
            process,
            words,
            address: format!("tcp:{}", address.trim()),
            _watchdog: watchdog,
        }
    }

    /// Waits for a line that contains `part`.
    fn until(&mut self, part: &str) -> String {
        until(&mut self.words, |line| line.contains(part))
    }

    /// Ends the server as Ctrl-C does, and returns the rest of its output.
    fn end(mut self) -> String {
        signal("INT", &self.process);
        let mut rest = String::new();
        self.words.read_to_string(&mut rest).expect("it says UTF-8");
        assert_eq!(self.process.wait().expect("it ends").code(), Some(0));
        rest
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns the first line that is as wanted.
fn until(words: &mut impl BufRead, wanted: impl Fn(&str) -> bool) -> String {
    loop {
        let mut line = String::new();
        assert_ne!(
            words.read_line(&mut line).expect("it says UTF-8"),
            0,
            "it ended before"
        );
        if wanted(&line) {
            return line;
        }
    }
}

fn signal(name: &str, process: &Child) {
    let mut kill = Command::new("kill");
    kill.args([&format!("-{name}"), &process.id().to_string()]);
    assert!(kill.status().expect("there is a kill").success());
}

/// Writes the application of the demonstration for a robot behind TCP. Only the lines of its driver differ.
fn safe_navigation(folder: &Path, address: &str) -> String {
    let text = std::fs::read_to_string(root().join("apps/safe-navigation.toml")).expect("it is there");
    let simulated = "type  = \"sim/pioneer\"\nworld = \"../worlds/office.toml\"\n";
    assert!(text.contains(simulated));
    let real = format!("type  = \"p2os/pioneer\"\nport  = \"{address}\"\nstart = [3.55, 1.6, \"90deg\"]\n");
    let file = folder.join("safe-navigation.toml");
    std::fs::write(&file, text.replace(simulated, &real)).expect("a file");
    file.display().to_string()
}

/// Starts an application that drives the server's robot.
fn driven(folder: &Path, server: &mut Server) -> (Child, BufReader<ChildStdout>) {
    let app = safe_navigation(folder, &server.address);
    let mut driver = jde_with_plugins(&["run", &app, "--plain"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    server.until("a client is connected");
    let mut words = BufReader::new(driver.stdout.take().expect("it has an output"));
    until(&mut words, |line| line.contains("nobody -> goon"));
    (driver, words)
}

#[test]
fn what_a_script_starts_in_the_background_says_how_it_ends() {
    let _watchdog = Watchdog::for_test();
    let sim = jde(&["sim", "worlds/office.toml", "--p2os", "127.0.0.1:0"]);
    let mut script = Command::new("sh");
    // A process started with `&` would not be a child of this test. `trap` ignores the signal that the shell
    // would ignore for it.
    script
        .args(["-c", "trap '' INT; exec \"$0\" \"$@\""])
        .arg(sim.get_program());
    script.args(sim.get_args()).current_dir(root());
    for (name, value) in sim.get_envs() {
        value.map(|value| script.env(name, value));
    }
    let mut process = script.stdout(Stdio::piped()).spawn().expect("a shell starts");
    let mut words = BufReader::new(process.stdout.take().expect("it has an output"));
    let first = until(&mut words, |line| line.contains("its robots wait"));
    let kill = format!("`kill {}` ends it", process.id());
    assert!(first.contains(&kill), "{first}");
    until(&mut words, |line| line.contains("tcp:"));
    signal("INT", &process);
    signal("TERM", &process);
    let mut rest = String::new();
    words.read_to_string(&mut rest).expect("it says UTF-8");
    assert_eq!(process.wait().expect("it ends").code(), Some(0), "{rest}");
}

#[test]
fn the_demonstration_drives_a_robot_behind_tcp_by_its_drivers_lines_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let (driver, mut words) = driven(folder.path(), &mut server);
    until(&mut words, |line| line.contains("target 1 of 8 reached"));
    signal("INT", &driver);
    let mut driver = driver;
    driver.wait().expect("it ends");
    server.until("the client ended its session");
    let rest = server.end();
    assert!(rest.contains("0 collisions"), "{rest}");
}

#[test]
fn a_process_that_is_stopped_or_killed_leaves_a_robot_that_stands() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let (driver, _words) = driven(folder.path(), &mut server);
    signal("STOP", &driver);
    server.until("no packet for 2.0 s, the motors stop");
    signal("CONT", &driver);
    signal("KILL", &driver);
    server.until("the client disconnected");
    let mut driver = driver;
    driver.wait().expect("it ends");
    let rest = server.end();
    assert!(rest.contains("0 collisions"), "{rest}");
}

#[test]
fn r7_a_network_that_is_cut_leaves_a_robot_that_stands_and_a_driver_that_knows() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let cable = Cable::to(&server.address);
    let app = safe_navigation(folder.path(), &cable.address);
    let mut driver = jde_with_plugins(&["run", &app, "--plain"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    server.until("a client is connected");
    let mut words = BufReader::new(driver.stdout.take().expect("it has an output"));
    until(&mut words, |line| line.contains("nobody -> goon"));
    cable.cut();
    server.until("no packet for 2.0 s, the motors stop");
    // The driver's exports are withdrawn, so no schema is ready, and nobody wins (R9).
    until(&mut words, |line| line.contains("goon -> nobody"));
    signal("KILL", &driver);
    driver.wait().expect("it ends");
    let rest = server.end();
    assert!(rest.contains("0 collisions"), "{rest}");
}

#[test]
fn an_application_tells_of_a_robot_that_goes_and_drives_it_when_it_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let address = server.address.replace("tcp:", "");
    let app = safe_navigation(folder.path(), &server.address);
    let mut driver = jde_with_plugins(&["run", &app, "--plain", "--log", "pioneer=info"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut log: BufReader<ChildStderr> = BufReader::new(driver.stderr.take().expect("it has an output"));
    let mut words = BufReader::new(driver.stdout.take().expect("it has an output"));
    server.until("a client is connected");
    until(&mut words, |line| line.contains("nobody -> goon"));
    signal("KILL", &server.process);
    drop(server);
    until(&mut log, |line| line.contains("pioneer"));
    // Without a scan no schema is ready, and nobody wins (R9).
    until(&mut words, |line| line.contains("goon -> nobody"));
    let mut again = jde(&["sim", "worlds/office.toml", "--p2os", &address])
        .current_dir(root())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    until(&mut words, |line| line.contains("nobody -> goon"));
    signal("INT", &driver);
    driver.wait().expect("it ends");
    signal("INT", &again);
    let mut rest = String::new();
    let mut words = again.stdout.take().expect("it has an output");
    words.read_to_string(&mut rest).expect("it says UTF-8");
    assert!(rest.contains("a client is connected"), "{rest}");
    again.wait().expect("it ends");
}

#[test]
fn what_became_of_the_robots_is_told_in_words_and_in_json() {
    let run = said(
        jde(&[
            "sim",
            "worlds/two-robots.toml",
            "--p2os",
            "127.0.0.1:0",
            "--for",
            "200ms",
            "--json",
        ])
        .current_dir(root()),
    );
    assert_eq!(run.status, Some(0), "{}", run.err);
    let summary = json(&run.out);
    assert_eq!(summary["world"], "two-robots");
    let robots = summary["robots"].as_array().expect("robots");
    assert_eq!(robots.len(), 2);
    assert_eq!(robots[0]["collisions"], 0);
    assert!(
        run.err.contains("left: 0.0 m driven, 0 collisions"),
        "{}",
        run.err
    );
    assert!(run.err.matches("tcp:127.0.0.1:").count() == 2, "{}", run.err);
}

#[test]
fn whoever_serves_the_network_is_told_so() {
    let open = said(
        jde(&[
            "sim",
            "worlds/office.toml",
            "--p2os",
            "0.0.0.0:0",
            "--for",
            "100ms",
        ])
        .current_dir(root()),
    );
    assert!(
        open.out.contains("the protocol knows no password"),
        "{}",
        open.out
    );
    let shut = said(
        jde(&[
            "sim",
            "worlds/office.toml",
            "--p2os",
            "127.0.0.1:0",
            "--for",
            "100ms",
        ])
        .current_dir(root()),
    );
    assert!(!shut.out.contains("password"), "{}", shut.out);
}

#[test]
fn what_cannot_be_served_is_wrong_use_and_says_what_to_do() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").port().to_string();
    let cases: [(&[&str], &str); 6] = [
        (&["offic", "--p2os"], "did you mean `office`?"),
        (&["office", "--p2os", &port], "another program serves there"),
        (&["office", "--p2os", "here"], "is no address"),
        (&["office"], "--p2os"),
        (
            &["office", "--pty", "--model", "pionner=amigo"],
            "has no robot `pionner`",
        ),
        (
            &["office", "--pty", "--model", "pioneer=p4dx"],
            "there is no model `p4dx`",
        ),
    ];
    for (args, part) in cases {
        let run = said(jde(&[&["sim"], args].concat()).current_dir(root()));
        assert_eq!(run.status, Some(2), "{args:?}: {}", run.err);
        assert!(run.err.contains(part), "{args:?}: {}", run.err);
    }
}

#[test]
fn a_device_is_not_driven_in_lockstep() {
    let folder = tempfile::tempdir().unwrap();
    let app = safe_navigation(folder.path(), "tcp:127.0.0.1:1");
    for hurry in [&["--lockstep"][..], &["--speed", "2x"]] {
        let run = said(&mut jde_with_plugins(
            &[&["run", &*app, "--plain"], hurry].concat(),
        ));
        assert_eq!(run.status, Some(1), "{}", run.err);
        let words = run.out + &run.err;
        assert!(words.contains("run without --lockstep and --speed"), "{words}");
    }
}
