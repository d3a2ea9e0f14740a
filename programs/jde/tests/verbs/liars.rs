//! Applications of others that state nonsense, or whose texts would control a terminal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_board::{Board, Nanos};
use jde_core::{Health, State};
use jde_link::message::{Action, Refusal, Schemas};
use jde_link::{Events, Folders, Link, Settings, Subject, SubjectInfo};
use jde_records::event::{StateChange, What};
use jde_records::snapshot::{GroupView, Hold, HoldKind, SchemaView, Snapshot};
use jde_records::{CandidateRecord, DecidedBy, Decision, RunRecord};

use crate::attached::Sandbox;
use crate::support::{RunOutput, pair};
use crate::terminal::{ENTER, LEAVE, Terminal};

/// An application that answers what it likes.
struct Liar {
    board: Board,
    snapshot: Snapshot,
    /// What it answers once it is set.
    later: Option<(AtomicBool, Snapshot)>,
}

impl Subject for Liar {
    fn info(&self) -> SubjectInfo {
        SubjectInfo {
            application: "liar".to_owned(),
            file: TEXT.to_owned(),
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

    fn writer(&self, _: u32) -> String {
        String::new()
    }

    fn now(&self) -> Nanos {
        1
    }

    fn snapshot(&self) -> Snapshot {
        match &self.later {
            Some((is_later, snapshot)) if is_later.load(Ordering::Relaxed) => snapshot.clone(),
            Some(_) | None => self.snapshot.clone(),
        }
    }

    fn act(&self, _: &str, _: &Action) -> Result<(), Refusal> {
        Ok(())
    }
}

/// Schemas with these fathers.
fn snapshot(fathers: impl IntoIterator<Item = Option<usize>>) -> Snapshot {
    let schemas = fathers.into_iter().enumerate().map(|(place, father)| SchemaView {
        name: format!("s{place}"),
        type_name: "liar/s".to_owned(),
        father,
        ..SchemaView::default()
    });
    Snapshot {
        schemas: schemas.collect(),
        ..Snapshot::default()
    }
}

fn open(sandbox: &Sandbox, name: &str, liar: Arc<Liar>) -> Link {
    let settings = Settings {
        folder: Folders::at(sandbox.folder().join("jde")),
        ..Settings::local(name)
    };
    Link::open(&settings, liar, &Events::of_records()).expect("the link opens")
}

fn lie(sandbox: &Sandbox, name: &str, snapshot: Snapshot) -> Link {
    let liar = Liar {
        board: Board::new(),
        snapshot,
        later: None,
    };
    open(sandbox, name, Arc::new(liar))
}

#[test]
fn an_application_that_states_nonsense_is_named_and_the_others_are_shown() {
    let sandbox = Sandbox::new();
    let _pair = sandbox.start_acting(&pair());
    let mut bad_winner = snapshot([None]);
    bad_winner.groups.push(GroupView {
        name: "roots".to_owned(),
        winner: Some(5),
        ..GroupView::default()
    });
    let deep = snapshot((0..300_usize).map(|place| place.checked_sub(1)));
    let liars = [
        (
            "robot7",
            snapshot([None, None, Some(99)]),
            "schema 2 has father 99, and it has 3 schemas",
        ),
        ("robot8", bad_winner, "group 0 has winner 5, and it has 1 schemas"),
        (
            "robot9",
            snapshot([Some(1), Some(0)]),
            "schema 0 has more than 255 fathers above it",
        ),
        ("robot10", deep, "schema 256 has more than 255 fathers above it"),
    ];
    let links: Vec<_> = liars
        .iter()
        .map(|(name, snapshot, _)| lie(&sandbox, name, snapshot.clone()))
        .collect();
    let apps = sandbox.run(&["apps"]);
    assert_eq!(apps.status, Some(1), "{apps:?}");
    assert!(
        apps.out
            .lines()
            .any(|line| line.starts_with("pair ") && line.contains("listener")),
        "{apps:?}"
    );
    for (name, _, reason) in &liars {
        let sentence = format!("`{name}`: its answer makes no sense: {reason}");
        assert!(
            apps.out.contains(name) && apps.err.contains(&sentence),
            "{sentence}: {apps:?}"
        );
        let ps = sandbox.run(&["ps", name]);
        assert!(ps.status == Some(1) && ps.err.contains(&sentence), "{ps:?}");
        assert_eq!(ps.out, "", "{ps:?}");
    }
    let good = sandbox.run(&["ps", "pair"]);
    assert_eq!((good.status, &*good.err), (Some(0), ""), "{good:?}");
    drop(links);
}

#[test]
fn endpoints_that_do_not_answer_are_named_beside_the_answers_of_others() {
    let sandbox = Sandbox::new();
    let listening = loop {
        // Another test may take the port between the two.
        let port = std::net::TcpListener::bind("127.0.0.1:0")
            .unwrap()
            .local_addr()
            .unwrap()
            .port();
        let settings = Settings {
            folder: Folders::at(sandbox.folder().join("other")),
            listen: vec![format!("tcp/127.0.0.1:{port}")],
            insecure: true,
            ..Settings::local("robot7")
        };
        let liar = Liar {
            board: Board::new(),
            snapshot: snapshot([None]),
            later: None,
        };
        if let Ok(link) = Link::open(&settings, Arc::new(liar), &Events::of_records()) {
            break (link, settings.listen[0].clone());
        }
    };
    let (_link, alive) = listening;
    // Nobody listens on these ports: they need rights.
    let [dead, other] = ["tcp/127.0.0.1:1", "tcp/127.0.0.1:2"];
    let apps = sandbox.run(&["apps", "--at", dead, "--at", &alive, "--at", other]);
    assert_eq!(apps.status, Some(1), "{apps:?}");
    assert!(apps.out.contains("robot7"), "{apps:?}");
    for endpoint in [dead, other] {
        assert!(
            apps.out.contains(endpoint) && apps.err.contains(endpoint),
            "{apps:?}"
        );
    }
    let ps = sandbox.run(&["ps", "--at", dead, "--at", &alive]);
    assert!(
        ps.status == Some(1) && ps.out.contains("s0") && ps.err.contains(dead),
        "{ps:?}"
    );
    let all = sandbox.run(&["apps", "--at", dead, "--at", other]);
    assert!(
        all.status == Some(1) && all.err.contains(dead) && all.err.contains(other),
        "{all:?}"
    );
    let logged = sandbox.run(&["ps", "--at", &alive, "--log", "debug"]);
    assert!(
        logged.status == Some(0) && logged.err.contains("debug"),
        "{logged:?}"
    );
}

#[test]
fn top_shows_the_last_answer_that_made_sense_and_restores_the_terminal() {
    let sandbox = Sandbox::new();
    let liar = Arc::new(Liar {
        board: Board::new(),
        snapshot: snapshot([None, Some(0), Some(1)]),
        later: Some((AtomicBool::new(false), snapshot([Some(0)]))),
    });
    let _link = open(&sandbox, "robot7", Arc::clone(&liar));
    let mut terminal = Terminal::start(&sandbox, [30, 110], &format!("{} top", env!("CARGO_BIN_EXE_jde")));
    terminal.wait_for(|shown| shown.contains("s2"));
    liar.later.as_ref().unwrap().0.store(true, Ordering::Relaxed);
    // Between two words there may be a movement of the cursor.
    terminal.wait_for(|shown| shown.contains("sense:"));
    terminal.type_keys(b"q");
    let (status, shown) = terminal.finish();
    assert_eq!(status, Some(0), "{shown}");
    assert!(shown.find(ENTER) < shown.find(LEAVE), "{shown}");
}

/// A text of somebody who wants to forge lines and colours.
const TEXT: &str = "x\nFORGED\r\u{1b}[31mFORGED\u{202e}\u{2066}\u{9b}31mFORGED";

/// Fails if [`TEXT`] has forged a line, a colour or a direction somewhere.
fn assert_harmless(what: &str, text: &str) {
    assert!(text.contains("FORGED"), "{what} shows the text: {text}");
    let is_forged = |line: &str| line.trim_start().starts_with("FORGED");
    assert!(!text.lines().any(is_forged), "{what}: {text:?}");
    let controls = ['\r', '\u{202e}', '\u{2066}', '\u{9b}'];
    assert!(
        !text.contains(controls) && !text.contains("\u{1b}[31mFORGED"),
        "{what}: {text:?}"
    );
}

/// Everything that a verb prints, with colours.
fn printed(sandbox: &Sandbox, args: &[&str]) -> String {
    let mut all = args.to_vec();
    all.extend(["--color", "always"]);
    let RunOutput { out, err, .. } = sandbox.run(&all);
    out + &err
}

#[test]
fn texts_of_an_application_forge_neither_lines_nor_colours() {
    let sandbox = Sandbox::new();
    let mut said = snapshot([None, None]);
    // A name may have no control characters, and any others.
    said.schemas[0].name = "FORGED\u{202e}\u{2066}".to_owned();
    for schema in &mut said.schemas {
        schema.type_name = TEXT.to_owned();
        schema.health = Health::Faulted(TEXT.to_owned());
        schema.group = Some(0);
        schema.operator = Some(Hold {
            kind: HoldKind::Stopped,
            with_everything: false,
            leased: false,
            by: TEXT.to_owned(),
        });
    }
    said.groups.push(GroupView {
        name: "roots".to_owned(),
        members: vec![0, 1],
        winner: Some(0),
        policy: TEXT.to_owned(),
        ..GroupView::default()
    });
    let (settings, events) = (
        Settings {
            folder: Folders::at(sandbox.folder().join("jde")),
            ..Settings::local("robot7")
        },
        Events::of_records(),
    );
    let liar = Liar {
        board: Board::new(),
        snapshot: said,
        later: None,
    };
    let text = || TEXT.to_owned();
    let candidate = CandidateRecord {
        name: text(),
        state: State::Ready,
        ready: true,
        urgency: None,
    };
    events.push(RunRecord::Decision(Decision {
        number: 1,
        group: "roots".to_owned(),
        candidates: vec![candidate],
        choice: Some(text()),
        decider: DecidedBy::Policy(text()),
        reason: text(),
        cause: text(),
        changed: true,
        takeover_us: Some(1.0),
        ..Decision::default()
    }));
    let unknown = What::Unknown {
        kind: text(),
        schema: Some(text()),
        by: None,
        text: text(),
        data: None,
    };
    events.push(unknown.at(0).into());
    events.push(RunRecord::State(StateChange {
        time: 0,
        schema: text(),
        from: State::Slept,
        to: State::Ready,
    }));
    let _link = Link::open(&settings, Arc::new(liar), &events).expect("the link opens");
    for args in [
        &["apps"][..],
        &["ps"],
        &["events", "--once", "--all"],
        &["events", "--once", "--all", "--json"],
        &["why"],
        &["stop", TEXT],
        &["get", TEXT],
        &["ps", TEXT],
    ] {
        assert_harmless(
            &args.join(" ").escape_default().to_string(),
            &printed(&sandbox, args),
        );
    }
}

#[test]
fn texts_of_files_forge_neither_lines_nor_colours() {
    let sandbox = Sandbox::new();
    let quoted = serde_json::to_string(TEXT).unwrap().replace('\u{9b}', "\\u009b");
    let file = |name: &str, text: &str| {
        let path = sandbox.folder().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let files = [
        file(
            "raw.toml",
            &format!("name = \"a\"\n{} = 1\n", TEXT.replace('\n', " ")),
        ),
        file("key.toml", &format!("name = \"a\"\n{quoted} = 1\n")),
        file("doc.toml", &format!("name = {quoted}\ndoc = {quoted}\n")),
        file(&TEXT.replace('/', "_"), "name = 1\n"),
    ];
    for file in &files {
        for verb in ["check", "run", "experiment", "info", "report"] {
            let shown = printed(&sandbox, &[verb, file]);
            if shown.contains("FORGED") {
                assert_harmless(&format!("{verb} {}", file.escape_default()), &shown);
            }
        }
    }
    assert_harmless("check", &printed(&sandbox, &["check", &files[1]]));
    assert_harmless("check", &printed(&sandbox, &["check", &files[3]]));
}
