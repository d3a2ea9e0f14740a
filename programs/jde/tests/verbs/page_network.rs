//! The page over networks that are encrypted, slow, lossy or frozen, and with a class that looks at once.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use rustls::pki_types::ServerName;
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use serde_json::json;

use crate::attached::Sandbox;
use crate::page::{PageRun, Visitor, drives, safe_navigation};
use crate::support::{jde_with_plugins, output_of, root};

/// Pages that look at once.
const CLASS: usize = 30;

/// A network between a page and the robot: it delays by 100 ms, and of each twenty pieces it loses one, which comes when it
/// is sent again. It can freeze.
struct Network {
    address: String,
    is_frozen: Arc<AtomicBool>,
}

impl Network {
    fn to(host: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address").to_string();
        let (host, is_frozen) = (host.to_owned(), Arc::new(AtomicBool::new(false)));
        let frozen = Arc::clone(&is_frozen);
        thread::spawn(move || {
            for page in listener.incoming().map_while(Result::ok) {
                let robot = TcpStream::connect(&host).expect("the page listens");
                let clone = |stream: &TcpStream| stream.try_clone().expect("a descriptor");
                pass_on(clone(&page), clone(&robot), Arc::clone(&frozen));
                pass_on(robot, page, Arc::clone(&frozen));
            }
        });
        Self { address, is_frozen }
    }
}

/// Passes bytes on, later.
fn pass_on(mut from: TcpStream, mut to: TcpStream, is_frozen: Arc<AtomicBool>) {
    let (pieces, arrived) = channel::<(Instant, Vec<u8>)>();
    thread::spawn(move || {
        let mut piece = [0; 1400];
        for number in 1_u64.. {
            let length = from.read(&mut piece).unwrap_or(0);
            let lost = if number.is_multiple_of(20) { 200 } else { 0 };
            let due = Instant::now() + Duration::from_millis(100 + lost);
            if length == 0 || pieces.send((due, piece[..length].to_vec())).is_err() {
                return;
            }
        }
    });
    thread::spawn(move || {
        // Nobody sends on it: to wait is to wait for the time.
        let (_never, time) = channel::<()>();
        for (due, piece) in arrived {
            wait_until(&time, due);
            while is_frozen.load(Ordering::Relaxed) {
                wait_until(&time, Instant::now() + Duration::from_millis(10));
            }
            if to.write_all(&piece).is_err() {
                return;
            }
        }
        let _ = to.shutdown(Shutdown::Both);
    });
}

fn wait_until(time: &Receiver<()>, due: Instant) {
    let _ = time.recv_timeout(due.saturating_duration_since(Instant::now()));
}

#[test]
fn r14_over_a_slow_and_lossy_network_the_stop_is_acknowledged_and_a_frozen_one_lets_the_pad_go() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &safe_navigation(), &["--web"]);
    let network = Network::to(run.host());
    let (mut here, _) = run.enter(&run.token);
    let (mut there, _) = run.enter_by(&network.address);
    there.drive_until(drives);
    here.until(drives);
    network.is_frozen.store(true, Ordering::Relaxed);
    here.until(|state| !drives(state) && state["driving"] == json!([]));
    // What was under way is too old to drive by when it arrives.
    network.is_frozen.store(false, Ordering::Relaxed);
    there.say(
        &json!({ "do": "drive", "schema": "teleop", "ahead": 1.0, "left": 0.0, "speed": 0.3, "tick": 1 }),
    );
    there.refused("too slow");
    assert_eq!(there.order("stop-all")["ok"], true);
    there.until(|state| !state["stopped"].is_null());
}

#[test]
fn a_class_looks_at_once_and_one_of_it_stops_the_robot() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &safe_navigation(), &["--web"]);
    let mut pages: Vec<Visitor> = (0..CLASS).map(|_| run.enter(&run.token).0).collect();
    let topics = json!([{ "what": "floor" }, { "what": "values", "of": "pioneer" }, { "what": "panel", "of": "goon" }]);
    thread::scope(|scope| {
        for page in &mut pages {
            let topics = &topics;
            scope.spawn(move || {
                page.say(&json!({ "do": "look", "at": topics }));
                let mut seen = [0; 3];
                while seen.contains(&0) || seen[0] < 5 {
                    let looks = page.next("looks");
                    for news in looks["news"].as_array().expect("a list") {
                        let places = ["floor", "values", "panel"];
                        let what = places.iter().position(|what| news["topic"]["what"] == *what);
                        seen[what.expect("it is known")] += 1;
                        assert!(news["parts"][0]["error"].is_null(), "{news}");
                    }
                    page.say(&json!({ "do": "taken" }));
                }
            });
        }
    });
    assert_eq!(pages[CLASS / 2].order("stop-all")["ok"], true);
    for page in &mut pages {
        page.until(|state| !state["stopped"].is_null());
    }
}

#[test]
fn a_browser_that_does_not_read_delays_nobody_and_then_gets_the_newest_state() {
    let sandbox = Sandbox::new();
    let application = root().join("apps/navigate.toml").display().to_string();
    let run = PageRun::start(&sandbox, &application, &["--web"]);
    let (mut slow, welcome) = run.enter(&run.token);
    let panels = welcome["panels"].as_array().expect("a list").iter().take(3);
    let panels = panels.map(|schema| json!({ "what": "panel", "of": schema }));
    let topics: Vec<_> = panels.chain([json!({ "what": "floor" })]).collect();
    slow.say(&json!({ "do": "look", "at": topics }));
    let time = |state: &serde_json::Value| state["time_s"].as_f64().expect("a time");
    let first = time(&slow.next("state"));
    let (mut other, _) = run.enter(&run.token);
    let (mut states, mut now) = (0, first);
    while now < first + 9.0 {
        let state = other.next("state");
        (states, now) = (states + 1, time(&state));
        // It claims to have taken what it has not read.
        slow.say(&json!({ "do": "taken" }));
    }
    let mut late = 1;
    while time(&slow.next("state")) < now {
        late += 1;
    }
    assert!(late < states, "{late} states after {states}");
    assert_eq!(slow.order("stop-all")["ok"], true);
    other.until(|state| !state["stopped"].is_null());
}

#[test]
fn with_a_certificate_the_page_is_encrypted_and_nothing_else_is_served() {
    let sandbox = Sandbox::new();
    let write = |name: &str, text: String| std::fs::write(sandbox.folder().join(name), text).expect("a file");
    let made = rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).expect("a certificate");
    write("robot.pem", made.cert.pem());
    write("robot.key", made.signing_key.serialize_pem());
    write(
        "page.toml",
        "listen = \"127.0.0.1:0\"\ntls = { certificate = \"robot.pem\", key = \"robot.key\" }\n".to_owned(),
    );
    let option = format!("--web={}", sandbox.folder().join("page.toml").display());
    let run = PageRun::start(&sandbox, &safe_navigation(), &[&option]);
    let mut roots = RootCertStore::empty();
    roots.add(made.cert.der().clone()).expect("a certificate");
    let config = ClientConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
        .with_safe_default_protocol_versions()
        .expect("versions")
        .with_root_certificates(roots)
        .with_no_client_auth();
    let config = Arc::new(config);
    let greet = || {
        let name = ServerName::try_from("localhost").expect("a name");
        let client = ClientConnection::new(Arc::clone(&config), name).expect("a client");
        StreamOwned::new(client, TcpStream::connect(run.host()).expect("the page listens"))
    };
    assert!(run.origin.starts_with("https://"), "{}", run.origin);
    let host = run.host();
    let mut stream = greet();
    let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n");
    stream.write_all(request.as_bytes()).expect("it is sent");
    let mut page = String::new();
    stream
        .read_to_string(&mut page)
        .expect("the stream has a proper end");
    let policy = format!("connect-src 'self' wss://{host};");
    assert!(
        page.starts_with("HTTP/1.1 200") && page.contains(&policy),
        "{page:.300}"
    );
    let mut visitor = run
        .open_on(greet(), &format!("wss://{host}/socket"), Some(&run.origin))
        .expect("the page's own");
    visitor.say(&json!({ "do": "enter", "token": run.token }));
    assert_eq!(visitor.next("welcome")["right"], "operate");
    assert_eq!(visitor.order("stop-all")["ok"], true);
    // Without TLS there is no page, and no answer that a network could read.
    let mut plain = TcpStream::connect(host).expect("the page listens");
    plain.write_all(request.as_bytes()).expect("it is sent");
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(!answer.starts_with(b"HTTP"), "{answer:?}");
}

#[test]
fn an_application_states_its_page_and_the_command_line_overrides_it() {
    let sandbox = Sandbox::new();
    let text = std::fs::read_to_string(safe_navigation()).expect("the application exists");
    let text = text.replace("\"../", &format!("\"{}/", root().display()));
    let file = sandbox.folder().join("paged.toml");
    std::fs::write(
        &file,
        format!("{text}\n[web]\nlisten = \"127.0.0.1:0\"\naccess = \"read\"\n"),
    )
    .expect("a file");
    let application = file.display().to_string();
    let right = |options: &[&str]| {
        let run = PageRun::start(&sandbox, &application, options);
        let (_, welcome) = run.enter(&run.token);
        welcome["right"].clone()
    };
    assert_eq!((right(&[]), right(&["--web"])), (json!("read"), json!("read")));
    let own = sandbox.folder().join("page.toml");
    std::fs::write(&own, "listen = \"127.0.0.1:0\"\n").expect("a file");
    assert_eq!(right(&[&format!("--web={}", own.display())]), "operate");
    let command = jde_with_plugins(&["run", &application, "--plain", "--no-web", "--for", "1s"]);
    let output = output_of(&mut sandbox.command(command));
    assert!(!output.err.contains("page"), "{output:?}");
    std::fs::write(&file, format!("{text}\n[web]\nlisten = \"0.0.0.0:7480\"\n")).expect("a file");
    let output = output_of(&mut jde_with_plugins(&["check", &application]));
    let is_shown = output.err.contains("without TLS") && output.err.contains("listen = \"0.0.0.0:7480\"");
    assert!(
        output.status != Some(0) && is_shown && output.err.contains('^'),
        "{output:?}"
    );
}
