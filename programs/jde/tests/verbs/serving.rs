//! `jde sim`, and its robots when the process or the network of their client fails.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};

use jde_watchdog::Watchdog;

use crate::cable::Cable;
use crate::support::{jde, jde_with_plugins, json, output_of, root, signal};

/// A `jde sim` that serves a world. It is killed when dropped.
struct Server {
    process: Child,
    output: BufReader<ChildStdout>,
    address: String,
    _watchdog: Watchdog,
}

impl Server {
    fn start(world: &str, options: &[&str]) -> Self {
        let watchdog = Watchdog::for_test();
        let mut command = jde(&["sim", world, "--p2os", "127.0.0.1:0"]);
        let mut process = command
            .args(options)
            .current_dir(root())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the executable starts");
        let mut output = BufReader::new(process.stdout.take().expect("stdout is piped"));
        let line = until(&mut output, |line| line.contains("tcp:"));
        let (_, address) = line.split_once("tcp:").expect("an address");
        Self {
            process,
            output,
            address: format!("tcp:{}", address.trim()),
            _watchdog: watchdog,
        }
    }

    /// Waits for a line that contains `part`.
    fn until(&mut self, part: &str) -> String {
        until(&mut self.output, |line| line.contains(part))
    }

    /// Ends the server with SIGINT, and returns the rest of its output.
    fn end(mut self) -> String {
        signal("INT", &self.process);
        let mut rest = String::new();
        self.output
            .read_to_string(&mut rest)
            .expect("the output is UTF-8");
        assert_eq!(self.process.wait().expect("the process ends").code(), Some(0));
        rest
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns the first line that fulfils a condition.
fn until(output: &mut impl BufRead, condition: impl Fn(&str) -> bool) -> String {
    loop {
        let mut line = String::new();
        assert_ne!(
            output.read_line(&mut line).expect("the output is UTF-8"),
            0,
            "the output ended early"
        );
        if condition(&line) {
            return line;
        }
    }
}

/// Writes the application of the demonstration with a driver that connects to a robot over TCP.
fn safe_navigation(folder: &Path, address: &str) -> String {
    let text =
        std::fs::read_to_string(root().join("apps/safe-navigation.toml")).expect("the application exists");
    let simulated = "type  = \"sim/robot\"\nworld = \"../worlds/office.toml\"\n";
    assert!(text.contains(simulated));
    let real = format!("type  = \"p2os/pioneer\"\nport  = \"{address}\"\nstart = [3.55, 1.6, \"90deg\"]\n");
    let file = folder.join("safe-navigation.toml");
    std::fs::write(&file, text.replace(simulated, &real)).expect("a file");
    file.display().to_string()
}

/// Starts an application that drives the server's robot.
fn start_client(folder: &Path, server: &mut Server) -> (Child, BufReader<ChildStdout>) {
    let app = safe_navigation(folder, &server.address);
    let mut driver = jde_with_plugins(&["run", &app, "--plain"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    server.until("a client is connected");
    let mut output = BufReader::new(driver.stdout.take().expect("the output is piped"));
    // Until the first scan arrives, stop may win.
    until(&mut output, |line| line.contains("-> goon"));
    (driver, output)
}

#[test]
fn a_server_that_ignores_sigint_prints_how_to_end_it() {
    let _watchdog = Watchdog::for_test();
    let sim = jde(&["sim", "worlds/office.toml", "--p2os", "127.0.0.1:0"]);
    let mut script = Command::new("sh");
    // `trap` ignores SIGINT, as a shell does for a process started with `&`. That process would not be a
    // child of this test.
    script
        .args(["-c", "trap '' INT; exec \"$0\" \"$@\""])
        .arg(sim.get_program());
    script.args(sim.get_args()).current_dir(root());
    for (name, value) in sim.get_envs() {
        value.map(|value| script.env(name, value));
    }
    let mut process = script.stdout(Stdio::piped()).spawn().expect("a shell starts");
    let mut output = BufReader::new(process.stdout.take().expect("the output is piped"));
    let first = until(&mut output, |line| line.contains("its robots wait"));
    let kill = format!("`kill {}` ends it", process.id());
    assert!(first.contains(&kill), "{first}");
    until(&mut output, |line| line.contains("tcp:"));
    signal("INT", &process);
    signal("TERM", &process);
    let mut rest = String::new();
    output.read_to_string(&mut rest).expect("the output is UTF-8");
    assert_eq!(
        process.wait().expect("the process ends").code(),
        Some(0),
        "{rest}"
    );
}

#[test]
fn the_demonstration_drives_a_robot_over_tcp() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let (driver, mut output) = start_client(folder.path(), &mut server);
    until(&mut output, |line| line.contains("target 1 of 8 reached"));
    signal("INT", &driver);
    let mut driver = driver;
    driver.wait().expect("the process ends");
    server.until("the client ended its session");
    let rest = server.end();
    assert!(rest.contains("0 contacts"), "{rest}");
}

#[test]
fn a_robot_stops_when_its_client_is_stopped_or_killed() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let (driver, _output) = start_client(folder.path(), &mut server);
    signal("STOP", &driver);
    server.until("no packet for 2.0 s, the motors stop");
    signal("CONT", &driver);
    signal("KILL", &driver);
    server.until("the client disconnected");
    let mut driver = driver;
    driver.wait().expect("the process ends");
    let rest = server.end();
    assert!(rest.contains("0 contacts"), "{rest}");
}

#[test]
fn r7_a_robot_stops_and_its_driver_withdraws_exports_when_the_network_fails() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let cable = Cable::to(&server.address);
    let app = safe_navigation(folder.path(), &cable.address);
    let mut driver = jde_with_plugins(&["run", &app, "--plain"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    server.until("a client is connected");
    let mut output = BufReader::new(driver.stdout.take().expect("the output is piped"));
    until(&mut output, |line| line.contains("-> goon"));
    cable.cut();
    server.until("no packet for 2.0 s, the motors stop");
    // The driver's exports are withdrawn, so goon is not ready, and stop is.
    until(&mut output, |line| line.contains("-> stop"));
    signal("KILL", &driver);
    driver.wait().expect("the process ends");
    let rest = server.end();
    assert!(rest.contains("0 contacts"), "{rest}");
}

#[test]
fn an_application_logs_a_lost_robot_and_drives_it_again_after_it_returns() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start("worlds/office.toml", &[]);
    let address = server.address.replace("tcp:", "");
    let app = safe_navigation(folder.path(), &server.address);
    let mut driver = jde_with_plugins(&["run", &app, "--plain", "--log", "pioneer=info"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    let mut log: BufReader<ChildStderr> = BufReader::new(driver.stderr.take().expect("the output is piped"));
    let mut output = BufReader::new(driver.stdout.take().expect("the output is piped"));
    server.until("a client is connected");
    until(&mut output, |line| line.contains("-> goon"));
    signal("KILL", &server.process);
    drop(server);
    until(&mut log, |line| line.contains("pioneer"));
    // Without a scan goon is not ready, and stop is.
    until(&mut output, |line| line.contains("-> stop"));
    let mut again = jde(&["sim", "worlds/office.toml", "--p2os", &address])
        .current_dir(root())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the executable starts");
    until(&mut output, |line| line.contains("-> goon"));
    signal("INT", &driver);
    driver.wait().expect("the process ends");
    signal("INT", &again);
    let mut rest = String::new();
    let mut output = again.stdout.take().expect("the output is piped");
    output.read_to_string(&mut rest).expect("the output is UTF-8");
    assert!(rest.contains("a client is connected"), "{rest}");
    again.wait().expect("the process ends");
}

#[test]
fn the_summary_of_a_server_is_printed_as_text_and_as_json() {
    let run = output_of(
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
    assert!(run.err.contains("left: 0.0 m driven, 0 contacts"), "{}", run.err);
    assert!(run.err.matches("tcp:127.0.0.1:").count() == 2, "{}", run.err);
}

#[test]
fn a_server_warns_when_it_listens_on_the_network() {
    let open = output_of(
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
    assert!(open.out.contains("the protocol has no password"), "{}", open.out);
    let local = output_of(
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
    assert!(!local.out.contains("password"), "{}", local.out);
}

#[test]
fn invalid_arguments_of_sim_have_exit_status_2_and_a_hint() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").port().to_string();
    let cases: [(&[&str], &str); 6] = [
        (&["offic", "--p2os"], "did you mean `office`?"),
        (&["office", "--p2os", &port], "another program uses this address"),
        (&["office", "--p2os", "here"], "is not an address"),
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
        let run = output_of(jde(&[&["sim"], args].concat()).current_dir(root()));
        assert_eq!(run.status, Some(2), "{args:?}: {}", run.err);
        assert!(run.err.contains(part), "{args:?}: {}", run.err);
    }
}

#[test]
fn a_device_cannot_be_driven_in_lockstep_or_faster_than_real_time_or_halted() {
    let folder = tempfile::tempdir().unwrap();
    let app = safe_navigation(folder.path(), "tcp:127.0.0.1:1");
    for option in [&["--lockstep"][..], &["--speed", "2x"], &["--break", "conflict"]] {
        let run = output_of(&mut jde_with_plugins(
            &[&["run", &*app, "--plain"], option].concat(),
        ));
        assert_eq!(run.status, Some(1), "{}", run.err);
        let output = run.out + &run.err;
        assert!(
            output.contains("run without --lockstep, --speed and --break"),
            "{output}"
        );
    }
}
