//! The keys: they select, request an action, or leave.
//!
//! It does not check whether an action makes sense. The application does, and its answer is shown.

use jde_core::Nanos;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::view_state::{ActionResult, Mode, TIME_BASES, ViewState};
use super::{ExitReason, ObservedApplication, ScreenAction, text};

/// The longest text that can be typed for a period. No period is longer.
const MAX_INPUT_LENGTH: usize = 16;

impl ViewState {
    /// Handles a key. Returns why the view is left, if the key leaves it.
    pub(super) fn handle_key(&mut self, app: &dyn ObservedApplication, key: KeyEvent) -> Option<ExitReason> {
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return (key.code == KeyCode::Char('c')).then(|| self.exit_reason());
        }
        match self.mode.clone() {
            Mode::Watch => self.watch_key(app, key.code),
            Mode::Help => {
                self.mode = Mode::Watch;
                None
            }
            Mode::Period { schema, typed } => {
                self.input_key(app, key.code, schema, typed);
                None
            }
        }
    }

    fn watch_key(&mut self, app: &dyn ObservedApplication, code: KeyCode) -> Option<ExitReason> {
        self.status = None;
        match code {
            KeyCode::Char('q') | KeyCode::Esc => return Some(self.exit_reason()),
            KeyCode::Enter if self.ending.is_some() => return Some(self.exit_reason()),
            KeyCode::Up | KeyCode::Char('k') => self.select(-1),
            KeyCode::Down | KeyCode::Char('j') => self.select(1),
            KeyCode::Home => self.select(isize::MIN),
            KeyCode::End => self.select(isize::MAX),
            KeyCode::Char('[') => self.time_base = self.time_base.saturating_sub(1),
            KeyCode::Char(']') => self.time_base = (self.time_base + 1).min(TIME_BASES.len() - 1),
            KeyCode::Char('?') => self.mode = Mode::Help,
            // The key that is found fastest stops everything, and never does the opposite: `g` does.
            KeyCode::Char(' ') => self.act(app, ScreenAction::StopAll),
            KeyCode::Char('g') => self.act(app, ScreenAction::ReleaseAll),
            KeyCode::Char('c') if self.snapshot.standstill.is_some() => self.act(app, ScreenAction::Continue),
            KeyCode::Char('n') if self.snapshot.standstill.is_some() => self.act(app, ScreenAction::Step),
            KeyCode::Char(letter) => self.operate(app, letter),
            _ => {}
        }
        None
    }

    fn operate(&mut self, app: &dyn ObservedApplication, letter: char) {
        let schema = self.selected;
        let Some(view) = self.selection() else { return };
        let period = view.period;
        // No key undoes what it did: pressed twice, it does the same again.
        match letter {
            'p' => self.act(app, ScreenAction::Play(schema)),
            's' => self.act(app, ScreenAction::Stop(schema)),
            'f' => self.act(app, ScreenAction::Force(schema)),
            'r' => self.act(app, ScreenAction::Release(schema)),
            '+' | '=' => self.act(
                app,
                ScreenAction::Period(schema, round_to_micros(period as f64 * 1.1)),
            ),
            '-' => self.act(
                app,
                ScreenAction::Period(schema, round_to_micros(period as f64 / 1.1)),
            ),
            't' => {
                self.mode = Mode::Period {
                    schema,
                    typed: String::new(),
                }
            }
            _ => {}
        }
    }

    fn input_key(&mut self, app: &dyn ObservedApplication, code: KeyCode, schema: usize, mut typed: String) {
        match code {
            KeyCode::Esc => {
                self.status = None;
                self.mode = Mode::Watch;
                return;
            }
            KeyCode::Enter => match text::period(&typed) {
                Ok(period) => {
                    self.mode = Mode::Watch;
                    self.act(app, ScreenAction::Period(schema, period));
                    return;
                }
                Err(reason) => self.status = Some(ActionResult::Refused(reason)),
            },
            KeyCode::Backspace => {
                typed.pop();
            }
            KeyCode::Char(letter) if typed.chars().count() < MAX_INPUT_LENGTH => typed.push(letter),
            _ => {}
        }
        self.mode = Mode::Period { schema, typed };
    }

    fn act(&mut self, app: &dyn ObservedApplication, action: ScreenAction) {
        let name = |schema| self.name(schema);
        let done = match action {
            ScreenAction::Play(schema) => format!("{} is kept awake", name(schema)),
            ScreenAction::Stop(schema) => format!("{} is stopped", name(schema)),
            ScreenAction::Force(schema) => format!("{} is forced to win", name(schema)),
            ScreenAction::Release(schema) => format!("{} is released", name(schema)),
            ScreenAction::Period(schema, period) => {
                format!("{} now runs every {}", name(schema), text::format_setting(period))
            }
            ScreenAction::StopAll => "everything is stopped; g releases it".to_owned(),
            ScreenAction::ReleaseAll => "released from the stop of everything".to_owned(),
            ScreenAction::Continue => "time passes again".to_owned(),
            ScreenAction::Step => "a step".to_owned(),
        };
        self.status = Some(match app.act(action) {
            Ok(()) => ActionResult::Done(done),
            Err(reason) => ActionResult::Refused(reason),
        });
    }

    fn exit_reason(&self) -> ExitReason {
        if self.ending.is_some() {
            ExitReason::Ended
        } else {
            ExitReason::Quit
        }
    }
}

/// Rounds to whole microseconds, at least 1, so that a step up and a step down lead back to the same period.
fn round_to_micros(nanos: f64) -> Nanos {
    ((nanos / 1e3).round() as Nanos).max(1) * 1_000
}
