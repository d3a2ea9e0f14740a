//! The page for browsers, with real processes and sockets: who gets in, what a page may do, and when it ends.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use serde_json::{Value, json};
use tungstenite::client::ClientRequestBuilder;
use tungstenite::{Message, WebSocket};

use crate::attached::Sandbox;
use crate::support::{jde, jde_with_plugins, pair, root};

/// A run with a page. It is killed when dropped.
pub(crate) struct PageRun {
    process: Child,
    /// `http://127.0.0.1:7480`.
    pub(crate) origin: String,
    pub(crate) token: String,
    _output: Box<dyn BufRead>,
}

impl Drop for PageRun {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl PageRun {
    pub(crate) fn start(sandbox: &Sandbox, application: &str, options: &[&str]) -> Self {
        let mut command = jde_with_plugins(&["run", application, "--plain"]);
        command.args(options).stdout(Stdio::null()).stderr(Stdio::piped());
        Self::of(sandbox, command)
    }

    /// Starts what prints the address of a page, to what is piped.
    fn of(sandbox: &Sandbox, command: Command) -> Self {
        let mut command = sandbox.command(command);
        let mut process = command
            .stdin(Stdio::null())
            .spawn()
            .expect("the executable starts");
        let mut output: Box<dyn BufRead> = match process.stdout.take() {
            Some(output) => Box::new(BufReader::new(output)),
            None => Box::new(BufReader::new(process.stderr.take().expect("it is piped"))),
        };
        let address = loop {
            let mut line = String::new();
            assert!(
                output.read_line(&mut line).expect("text") > 0,
                "the run ended early"
            );
            if let Some((_, address)) = line.trim().split_once(": ").filter(|(what, address)| {
                (what.starts_with("page") || *what == "to look only") && address.contains("/#")
            }) {
                break address.to_owned();
            }
        };
        let (origin, token) = address.split_once("/#").expect("the token is behind a #");
        Self {
            process,
            origin: origin.to_owned(),
            token: token.to_owned(),
            _output: output,
        }
    }

    pub(crate) fn host(&self) -> &str {
        self.origin.split_once("://").expect("a scheme").1
    }

    /// Opens a socket from a page of this origin. Returns the status of a refusal.
    fn open(&self, origin: Option<&str>) -> Result<Visitor, u16> {
        let stream = TcpStream::connect(self.host()).expect("the page listens");
        self.open_on(stream, &format!("ws://{}/socket", self.host()), origin)
    }

    /// As [`Self::open`], on any stream.
    pub(crate) fn open_on<S: Read + Write>(
        &self,
        stream: S,
        address: &str,
        origin: Option<&str>,
    ) -> Result<Visitor<S>, u16> {
        let mut request = ClientRequestBuilder::new(address.parse().expect("an address"));
        if let Some(origin) = origin {
            request = request.with_header("Origin", origin);
        }
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Visitor { socket }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(tungstenite::HandshakeError::Failure(error)) => panic!("{error}"),
            Err(tungstenite::HandshakeError::Interrupted(_)) => panic!("the stream blocks"),
        }
    }

    /// Opens the page itself with a token.
    pub(crate) fn enter(&self, token: &str) -> (Visitor, Value) {
        let visitor = self.open(Some(&self.origin)).expect("the page's own socket");
        Self::enter_on(visitor, token)
    }

    /// Opens the page itself over a network that passes bytes on.
    pub(crate) fn enter_by(&self, network: &str) -> (Visitor, Value) {
        let stream = TcpStream::connect(network).expect("the network listens");
        let address = format!("ws://{}/socket", self.host());
        let visitor = self.open_on(stream, &address, Some(&self.origin));
        Self::enter_on(visitor.expect("the page's own socket"), &self.token)
    }

    fn enter_on(mut visitor: Visitor, token: &str) -> (Visitor, Value) {
        visitor.say(&json!({ "do": "enter", "token": token, "name": "ana" }));
        let welcome = visitor.next("welcome");
        (visitor, welcome)
    }

    /// Sends a request as text and returns the answer.
    pub(crate) fn ask(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.host()).expect("the page listens");
        stream
            .write_all(request.replace('\n', "\r\n").as_bytes())
            .expect("it is sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("text");
        answer
    }
}

/// A page in a browser.
pub(crate) struct Visitor<S = TcpStream> {
    socket: WebSocket<S>,
}

impl<S: Read + Write> Visitor<S> {
    pub(crate) fn say(&mut self, message: &Value) {
        self.socket
            .send(Message::text(message.to_string()))
            .expect("it is sent");
    }

    fn read(&mut self) -> Value {
        loop {
            // Answers to pings are no messages.
            if let Message::Text(text) = self.socket.read().expect("the socket is open") {
                return serde_json::from_str(&text).expect("JSON");
            }
        }
    }

    /// Reads up to the next message of a kind.
    pub(crate) fn next(&mut self, kind: &str) -> Value {
        loop {
            let message = self.read();
            if message["t"] == kind {
                return message;
            }
        }
    }

    /// Reads up to a state that fits.
    pub(crate) fn until(&mut self, fits: impl Fn(&Value) -> bool) -> Value {
        loop {
            let state = self.next("state");
            if fits(&state) {
                return state;
            }
        }
    }

    /// Reads up to the refusal of an order to drive, for this reason.
    pub(crate) fn refused(&mut self, reason: &str) {
        while !is_refusal(&self.next("drive"), reason) {}
    }

    pub(crate) fn order(&mut self, order: &str) -> Value {
        self.say(&json!({ "do": order, "id": 1 }));
        self.next("answer")
    }

    /// Holds the pad, as the page does, until a state fits.
    pub(crate) fn drive_until(&mut self, fits: impl Fn(&Value) -> bool) {
        loop {
            let message = self.read();
            if message["t"] == "tick" {
                self.say(&drive(message["n"].as_u64().expect("a number")));
            } else if message["t"] == "state" && fits(&message) {
                return;
            }
        }
    }
}

fn drive(tick: u64) -> Value {
    json!({ "do": "drive", "schema": "teleop", "ahead": 0.5, "left": 0.0, "speed": 0.2, "tick": tick })
}

fn is_refusal(answer: &Value, reason: &str) -> bool {
    answer["held"] == false && answer["text"].as_str().is_some_and(|text| text.contains(reason))
}

fn state_of(state: &Value, schema: &str) -> String {
    let rows = state["rows"].as_array().expect("a list").iter();
    let mut rows = rows.filter(|row| row["name"] == schema);
    rows.next().map_or_else(String::new, |row| {
        row["state"].as_str().expect("a name").to_owned()
    })
}

pub(crate) fn drives(state: &Value) -> bool {
    state_of(state, "teleop") == "WINNER"
}

pub(crate) fn safe_navigation() -> String {
    root().join("apps/safe-navigation.toml").display().to_string()
}

pub(crate) fn read_token(welcome: &Value) -> String {
    let share = welcome["share"].as_str().expect("an address");
    share.split_once("/#").expect("a token").1.to_owned()
}

#[test]
fn r14_a_page_with_its_token_shows_who_acts_and_stops_everything() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web"]);
    let (mut page, welcome) = run.enter(&run.token);
    assert_eq!(
        (&welcome["right"], &welcome["by"]),
        (&json!("operate"), &json!("ana@127.0.0.1"))
    );
    let state = page.until(|state| state["acting"][0]["name"].is_string());
    assert_ne!(state["acting"][0]["reason"], "", "{state}");
    let answer = page.order("stop-all");
    assert_eq!(answer["ok"], true, "{answer}");
    page.until(|state| state["stopped"]["by"] == "ana@127.0.0.1");
    assert_eq!(sandbox.motors_awake(), [""; 0]);
    assert_eq!(page.order("release-all")["ok"], true);
    page.until(|state| state["stopped"].is_null());
}

#[test]
fn a_page_that_looks_operates_nothing() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &safe_navigation(), &["--web"]);
    let (_, welcome) = run.enter(&run.token);
    let (mut page, welcome) = run.enter(&read_token(&welcome));
    assert_eq!(
        (&welcome["right"], &welcome["drive"]),
        (&json!("read"), &json!([]))
    );
    for order in ["stop-all", "release-all"] {
        assert_eq!(page.order(order)["ok"], false, "{order}");
    }
    let gesture =
        json!({ "widget": "field", "touch": { "clicked": { "at": [1.0, 1.0, 0.0], "button": "primary" } } });
    page.say(&json!({ "do": "touch", "id": 1, "schema": "example", "gesture": gesture }));
    assert_eq!(page.next("answer")["ok"], false);
    let tick = page.next("tick")["n"].as_u64().expect("a number");
    page.say(&drive(tick));
    assert_eq!(page.next("drive")["held"], false);
    let state = page.next("state");
    assert!(state["stopped"].is_null() && !drives(&state), "{state}");
}

#[test]
fn a_page_of_a_link_that_only_reads_says_so_and_offers_nothing_else() {
    let sandbox = Sandbox::new();
    let socket = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("tcp/{}", socket.local_addr().expect("an address"));
    drop(socket);
    let text = std::fs::read_to_string(safe_navigation()).expect("the application exists");
    let link = format!("[link]\nlisten = [\"{address}\"]\ninsecure = true\naccess = \"read\"\n");
    let text = text.replace("\"../", &format!("\"{}/", root().display()));
    let file = sandbox.folder().join("open.toml");
    std::fs::write(&file, format!("{text}\n{link}")).expect("the folder is writable");
    let _robot = sandbox.start(&file.display().to_string(), &[]);
    let mut command = jde(&["web", "--at", &address]);
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let run = PageRun::of(&sandbox, command);
    let (mut page, welcome) = run.enter(&run.token);
    assert_eq!(
        (&welcome["right"], &welcome["drive"]),
        (&json!("read"), &json!([]))
    );
    let why = welcome["looks_only"].as_str().expect("a reason");
    assert!(why.contains("clients from the network only read"), "{why}");
    assert_eq!(page.order("stop-all")["ok"], false);
    page.until(|state| state["acting"][0]["name"].is_string() && state["stopped"].is_null());
}

#[test]
fn all_pages_see_the_values_of_a_schema_and_the_newest_only_once_taken() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &safe_navigation(), &["--web"]);
    let (first, welcome) = run.enter(&run.token);
    let (second, _) = run.enter(&read_token(&welcome));
    let topic = json!({ "what": "values", "of": "pioneer" });
    for mut page in [first, second] {
        page.say(&json!({ "do": "look", "at": [topic] }));
        let mut odometry = 0;
        while odometry < 3 {
            let looks = page.next("looks");
            let news = &looks["news"][0];
            assert_eq!(news["topic"], topic, "{looks}");
            let parts = news["parts"].as_array().expect("a list").iter();
            odometry += parts
                .filter(|part| part["name"] == "odometry" && part["numbers"][0][1].is_number())
                .count();
            // What is not taken keeps back the next one.
            page.until(|_| true);
            page.say(&json!({ "do": "taken" }));
        }
        page.say(&json!({ "do": "look", "at": [{ "what": "values", "of": "nobody" }] }));
        page.say(&json!({ "do": "taken" }));
        let mut looks = page.next("looks");
        while looks["news"][0]["topic"] == topic {
            page.say(&json!({ "do": "taken" }));
            looks = page.next("looks");
        }
        assert_eq!(
            looks["news"][0]["parts"][0]["error"], "there is no schema `nobody`",
            "{looks}"
        );
    }
}

#[test]
fn other_sites_other_names_and_wrong_tokens_are_refused() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web"]);
    for origin in [
        None,
        Some("null"),
        Some("http://evil.example"),
        Some("http://127.0.0.1"),
    ] {
        assert_eq!(run.open(origin).err(), Some(403), "{origin:?}");
    }
    let host = run.host();
    let own = run.ask(&format!("GET / HTTP/1.1\nHost: {host}\n\n"));
    assert!(
        own.starts_with("HTTP/1.1 200") && own.contains("default-src 'none'"),
        "{own:.300}"
    );
    assert!(!own.contains("Set-Cookie") && !own.contains(&run.token));
    let rebound = run.ask(&format!(
        "GET / HTTP/1.1\nHost: rebound.example{}\n\n",
        &host[9..]
    ));
    assert!(
        rebound.starts_with("HTTP/1.1 403") && rebound.contains("hosts"),
        "{rebound}"
    );
    let posted = run.ask(&format!("POST / HTTP/1.1\nHost: {host}\nContent-Length: 0\n\n"));
    assert!(posted.starts_with("HTTP/1.1 405"), "{posted}");
    for first in [
        json!({ "do": "enter", "token": "abcdefghijkmnpqrstuvwxyz" }),
        json!({ "do": "stop-all", "id": 1 }),
        json!(null),
    ] {
        let mut page = run.open(Some(&run.origin)).expect("the page's own socket");
        page.say(&first);
        let refused = page.read();
        assert!(
            refused["t"] == "refused" && refused["is_token"] == true,
            "{refused}"
        );
        assert!(
            page.socket.read().is_ok_and(|message| message.is_close()),
            "{first}"
        );
    }
    assert!(!sandbox.motors_awake().is_empty(), "nothing was stopped");
}

#[test]
fn r14_a_page_drives_for_as_long_as_it_says_so_itself() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &safe_navigation(), &["--web"]);
    let (mut page, welcome) = run.enter(&run.token);
    assert_eq!(welcome["drive"][0]["schema"], "teleop");
    page.drive_until(drives);
    // It reads and is silent, as a page behind a message of the browser, which still answers pings.
    page.socket
        .send(Message::Ping(Vec::new().into()))
        .expect("it is sent");
    page.until(|state| !drives(state));
    // An order that was under way for long is not carried out.
    page.say(&drive(0));
    page.refused("too slow");
    page.drive_until(drives);
    // Another page takes nothing over.
    let (mut other, _) = run.enter(&run.token);
    page.drive_until(drives);
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| page.drive_until(|_| done.load(Ordering::Relaxed)));
        loop {
            let message = other.read();
            match message["t"].as_str() {
                Some("tick") => other.say(&drive(message["n"].as_u64().expect("a number"))),
                // On a busy machine the first page may be late once, and is let go.
                Some("drive") if message["held"] == true => other.say(&json!({ "do": "let-go" })),
                Some("drive") if is_refusal(&message, "drives now") => break,
                Some(_) | None => {}
            }
        }
        done.store(true, Ordering::Relaxed);
    });
    // The page vanishes.
    page.drive_until(drives);
    page.socket
        .get_ref()
        .shutdown(Shutdown::Both)
        .expect("it is open");
    other.until(|state| !drives(state) && state["driving"] == json!([]));
}

#[test]
fn pages_that_do_not_read_or_talk_nonsense_delay_nobody() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web"]);
    let mut unread: Vec<Visitor> = (0..30).map(|_| run.enter(&run.token).0).collect();
    let (mut page, _) = run.enter(&run.token);
    for nonsense in ["null", "[]", "7", "{\"do\": \"unload\"}"] {
        page.socket.send(Message::text(nonsense)).expect("it is sent");
        page.next("refused");
    }
    let first = page.next("state")["time_s"].as_f64().expect("a time");
    page.until(|state| state["time_s"].as_f64().is_some_and(|now| now > first + 1.0));
    // What does not read still stops the robot.
    unread[7].say(&json!({ "do": "stop-all", "id": 1 }));
    page.until(|state| state["stopped"]["by"] == "ana@127.0.0.1");
    // Too long for a page: its socket ends, and no other.
    unread[8].say(&json!({ "do": "x".repeat(5000) }));
    page.next("state");
}

#[test]
fn r14_those_who_only_look_leave_places_to_those_who_may_stop() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web"]);
    let (_, welcome) = run.enter(&run.token);
    let token = read_token(&welcome);
    let _looking: Vec<Visitor> = (0..48).map(|_| run.enter(&token).0).collect();
    let mut late = run.open(Some(&run.origin)).expect("the page's own socket");
    late.say(&json!({ "do": "enter", "token": token }));
    let refused = late.read();
    // Its token is right, so the page keeps it and tries again.
    assert!(
        refused["t"] == "refused" && refused["is_token"] == false,
        "{refused}"
    );
    let (mut page, _) = run.enter(&run.token);
    assert_eq!(page.order("stop-all")["ok"], true);
}

#[test]
fn the_last_state_says_how_the_run_ended() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web", "--for", "8s"]);
    let (mut page, _) = run.enter(&run.token);
    let state = page.until(|state| !state["ending"].is_null());
    assert_eq!(state["ending"]["word"], "ended", "{state}");
    while page.socket.read().is_ok() {}
}

#[test]
fn a_page_that_cannot_be_served_is_a_fault_before_the_start() {
    let sandbox = Sandbox::new();
    let file = sandbox.folder().join("page.toml");
    let refused = |text: &str, words: &str| {
        std::fs::write(&file, text).expect("a file");
        let option = format!("--web={}", file.display());
        let command = jde_with_plugins(&["run", &pair(), "--plain", "--for", "1s", &option]);
        let output = crate::support::output_of(&mut sandbox.command(command));
        assert!(
            output.status != Some(0) && output.err.contains(words),
            "{output:?}"
        );
    };
    refused("listen = \"0.0.0.0:0\"", "without TLS");
    refused("lisen = \"0.0.0.0:0\"", "lisen");
    refused(
        "tls = { certificate = \"none.pem\", key = \"none.key\" }",
        "none.pem",
    );
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("an address");
    refused(&format!("listen = \"{address}\""), "cannot listen on");
}
