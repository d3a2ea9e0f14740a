//! The view as its users see it: drawn into a buffer, driven by keys, over an application with fixed data.

mod keys;
pub(crate) mod snapshots;

use std::cell::{Cell, RefCell};
use std::time::Duration;

use jde_core::{Nanos, State};
use jde_records::event::Outcome;
use jde_records::snapshot::{Hold, HoldKind, Snapshot};
use jde_timeline::Ending;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use ratatui::style::{Color, Modifier};

use super::theme::Theme;
use super::view_state::ViewState;
use super::{ExitReason, ObservedApplication, RobotView, ScreenAction, draw};
use snapshots::{held, navigation, snapshot};

const MS: Nanos = 1_000_000;

struct Fixed {
    snapshot: RefCell<Snapshot>,
    ending: RefCell<Option<Ending>>,
    silent: Cell<Duration>,
    refuses: Option<&'static str>,
    acts: RefCell<Vec<ScreenAction>>,
}

impl Fixed {
    fn new() -> Self {
        Self {
            snapshot: RefCell::new(navigation()),
            ending: RefCell::new(None),
            silent: Cell::default(),
            refuses: None,
            acts: RefCell::default(),
        }
    }

    fn screen(&self) -> ViewState {
        ViewState::new("safe-navigation", Theme { color: true }, self)
    }
}

impl ObservedApplication for Fixed {
    fn snapshot(&self) -> Snapshot {
        self.snapshot.borrow().clone()
    }

    fn robot(&self) -> Option<RobotView> {
        Some(RobotView {
            pose: (1.0, 2.0, std::f64::consts::FRAC_PI_2),
            target: Some((4.0, 6.0)),
            reached: 2,
            total: 5,
        })
    }

    fn act(&self, action: ScreenAction) -> Result<(), String> {
        self.acts.borrow_mut().push(action);
        self.refuses.map_or(Ok(()), |reason| Err(reason.to_owned()))
    }

    fn ending(&self) -> Option<Ending> {
        self.ending.borrow().clone()
    }

    fn silent(&self) -> Duration {
        self.silent.get()
    }

    fn log_lines(&self) -> Vec<String> {
        (1..=40).map(|n| format!("log line {n}")).collect()
    }
}

fn drawn(screen: &mut ViewState, width: u16, height: u16) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| draw::draw(frame, screen)).unwrap();
    terminal
}

fn lines(screen: &mut ViewState, width: u16, height: u16) -> Vec<String> {
    let terminal = drawn(screen, width, height);
    let cells: Vec<&str> = terminal
        .backend()
        .buffer()
        .content()
        .iter()
        .map(|cell| cell.symbol())
        .collect();
    cells
        .chunks(usize::from(width))
        .map(|row| row.concat().trim_end().to_owned())
        .collect()
}

fn line(lines: &[String], word: &str) -> String {
    lines
        .iter()
        .find(|line| line.contains(word))
        .unwrap_or_else(|| panic!("no “{word}” in {lines:#?}"))
        .clone()
}

fn press(screen: &mut ViewState, app: &Fixed, keys: &[KeyCode]) -> Option<ExitReason> {
    keys.iter().fold(None, |_, key| {
        screen.handle_key(app, KeyEvent::new(*key, KeyModifiers::NONE))
    })
}

fn typed(text: &str) -> Vec<KeyCode> {
    text.chars().map(KeyCode::Char).collect()
}

#[test]
fn control_characters_are_shown_as_code_points() {
    let app = Fixed::new();
    app.snapshot.borrow_mut().schemas[3].name = "vff\u{202e}x".to_owned();
    let lines = lines(&mut app.screen(), 80, 24).join("\n");
    assert_eq!(lines.matches("vff\\u{202e}x").count(), 3, "{lines}");
}

#[test]
fn the_classic_terminal_shows_the_whole_example() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("jjj"));
    let lines = lines(&mut screen, 80, 24);
    assert!(lines[0].starts_with(" safe-navigation") && lines[0].ends_with("running  12.4 s"));
    assert_eq!(
        line(&lines, "robot"),
        "robot 1.00, 2.00 m  90°  →  4.00, 6.00 m, 5.00 m away  ·  2 of 5 reached"
    );
    assert!(line(&lines, "roots").contains("▸ example  priority  1 switch"));
    assert!(
        line(&lines, "  example/base").contains("▸ vff  father  12 switches  worst 3.10 ms of 80 ms"),
        "{lines:#?}"
    );
    let vff = line(&lines, "├ vff");
    for word in ["F WINNER", " ok ", "75 ms", "75.0 ms", "12%", "█"] {
        assert!(vff.contains(word), "{word} in {vff}");
    }
    assert!(line(&lines, "└ stop").contains("faulted"));
    assert!(line(&lines, "├ goon").contains("READY") && line(&lines, "├ goon").contains('▄'));
    let below = lines.join("\n");
    for word in [
        "── vff · safe-navigation/vff, motor ─",
        "WINNER with authority · ok · forced by ana@laptop",
        "1234 iterations · 2 overruns · 3 refused · 0 faults",
        "12.345 s  example/base  goon → vff  in 3.10 ms  father: obstacle ahead",
        "log line 40",
        "q quit  ? help",
    ] {
        assert!(below.contains(word), "{word} in {below}");
    }
}

#[test]
fn a_fault_is_shown_with_its_reason() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("jjjj"));
    assert!(
        lines(&mut screen, 80, 24)
            .join("\n")
            .contains("faulted: panicked: index out of bounds")
    );
}

#[test]
fn a_wide_terminal_shows_every_column_and_sets_panels_side_by_side() {
    let app = Fixed::new();
    let lines = lines(&mut app.screen(), 180, 40);
    let header = line(&lines, "schema");
    for column in ["iterations", "overruns", "refused", "longest", "faults", "last "] {
        assert!(header.contains(column), "{column} in {header}");
    }
    assert!(line(&lines, "── switches").contains("── log"));
}

#[test]
fn no_size_panics_with_or_without_help() {
    let app = Fixed::new();
    let mut screen = app.screen();
    for help in [false, true] {
        if help {
            press(&mut screen, &app, &typed("?"));
        }
        for width in [0, 1, 2, 5, 11, 20, 40, 79, 80, 119, 120, 121, 250] {
            for height in [0, 1, 2, 3, 4, 5, 8, 10, 13, 14, 15, 24, 60] {
                drawn(&mut screen, width, height);
            }
        }
    }
}

#[test]
fn a_small_terminal_still_shows_names_and_states() {
    let app = Fixed::new();
    let lines = lines(&mut app.screen(), 40, 10);
    assert!(line(&lines, "teleop").contains("CHECKING"));
    assert!(line(&lines, "q quit").contains("? help"));
}

#[test]
fn an_empty_application_is_drawn_and_takes_keys() {
    let app = Fixed::new();
    *app.snapshot.borrow_mut() = snapshot(0, vec![], vec![]);
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("jkpfr+-t"));
    drawn(&mut screen, 80, 24);
    assert!(app.acts.borrow().is_empty());
}

#[test]
fn the_list_scrolls_to_the_selection() {
    let app = Fixed::new();
    let mut screen = app.screen();
    assert!(!lines(&mut screen, 80, 9).join("\n").contains("pioneer"));
    press(&mut screen, &app, &[KeyCode::End]);
    assert!(lines(&mut screen, 80, 9).join("\n").contains("pioneer"));
    press(&mut screen, &app, &[KeyCode::Home]);
    assert!(line(&lines(&mut screen, 80, 9), "roots").contains("example"));
}

#[test]
fn states_have_their_colours_unless_no_color_asks_for_none() {
    let app = Fixed::new();
    for (color, green) in [(true, Color::Green), (false, Color::Reset)] {
        let mut screen = ViewState::new("x", Theme { color }, &app);
        let terminal = drawn(&mut screen, 80, 24);
        let cells = terminal.backend().buffer().content();
        let winner = cells.iter().find(|cell| cell.symbol() == "█").unwrap();
        assert_eq!(winner.fg, green);
        assert_eq!(cells.iter().any(|cell| cell.fg == Color::Cyan), color);
        assert!(
            cells
                .iter()
                .any(|cell| cell.modifier.contains(Modifier::REVERSED))
        );
    }
}

#[test]
fn the_strip_shows_the_history() {
    let app = Fixed::new();
    let mut screen = app.screen();
    app.snapshot.borrow_mut().time += 1000 * MS;
    app.snapshot.borrow_mut().schemas[3].state = State::Checking;
    screen.observe(&app);
    app.snapshot.borrow_mut().time += 700 * MS;
    screen.observe(&app);
    let vff = line(&lines(&mut screen, 80, 24), "├ vff");
    assert!(
        vff.ends_with(" █████▁▁▁"),
        "a cell for a quarter of a second: {vff}"
    );
    press(&mut screen, &app, &typed("]]"));
    let vff = line(&lines(&mut screen, 80, 24), "├ vff");
    assert!(vff.ends_with(" ██▁"), "a cell for a second: {vff}");
}
