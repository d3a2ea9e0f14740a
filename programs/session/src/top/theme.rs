//! The colours and their meanings; no colours if NO_COLOR is set (no-color.org).
//!
//! It uses only the sixteen colours of the terminal's theme, and a colour is never the only sign of anything.

use std::env;

use jde_core::{Health, State};
use jde_timeline::{Severity, health_severity};
use ratatui::style::{Color, Modifier, Style};

use super::strip::StripState;

/// Maps meanings to styles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Theme {
    /// Whether colours may be used.
    pub(super) color: bool,
}

impl Theme {
    pub(super) fn from_environment() -> Self {
        Self {
            color: env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()),
        }
    }

    pub(super) fn state(self, state: State) -> Style {
        match state {
            State::Winner => self.fg(Color::Green).add_modifier(Modifier::BOLD),
            State::Ready => self.fg(Color::Yellow),
            State::Checking => self.fg(Color::Cyan),
            State::Slept => self.faint(),
        }
    }

    pub(super) fn health(self, health: &Health) -> Style {
        match health_severity(health) {
            Severity::Good => self.faint(),
            Severity::Warning => self.fg(Color::Yellow),
            Severity::Bad => self.bad(),
        }
    }

    pub(super) fn strip_state(self, trace: StripState) -> Style {
        match trace {
            StripState::Slept => self.faint(),
            StripState::Checking => self.fg(Color::Cyan),
            StripState::Ready => self.fg(Color::Yellow),
            StripState::Winner => self.fg(Color::Green),
            StripState::Faulted => self.bad(),
        }
    }

    pub(super) fn bad(self) -> Style {
        self.fg(Color::Red).add_modifier(Modifier::BOLD)
    }

    pub(super) fn operator(self) -> Style {
        self.fg(Color::Magenta).add_modifier(Modifier::REVERSED)
    }

    pub(super) fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    pub(super) fn faint(self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }

    pub(super) fn selected(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    fn fg(self, color: Color) -> Style {
        if self.color {
            Style::new().fg(color)
        } else {
            Style::new()
        }
    }
}
