//! The kinds of windows on an application, each in its own folder, and their common interface.

pub(crate) mod events;
pub(crate) mod panel;
pub(crate) mod robot;
pub(crate) mod scope;
pub(crate) mod space;
mod trail;
pub(crate) mod values;

use eframe::egui;
use serde::{Deserialize, Serialize};

use crate::session::WindowSession;
use crate::style::Style;

/// A window on an application. It keeps the user's choices in it, and draws each frame from the session.
pub(crate) trait Window {
    /// Draws the window, and passes the user's requests to the session.
    fn show(&mut self, ui: &mut egui::Ui, session: &WindowSession, style: &Style);

    /// Takes what the session received, whether or not the window is shown. Called in each frame.
    fn follow(&mut self, session: &WindowSession) {
        let _ = session;
    }

    /// The state to save for the next start, as JSON. Null saves nothing.
    fn keep(&self) -> serde_json::Value {
        serde_json::Value::Null
    }
}

/// The kind of a window, as saved with the layout.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum WindowKind {
    /// The hierarchy over time.
    Oscilloscope,
    /// Sensors and motors.
    Robot,
    /// The 3D view.
    Space,
    /// Variables and modulations.
    Values,
    /// What happened.
    Events,
    /// The panel of a schema, by its name.
    Panel(String),
}

impl WindowKind {
    /// The title on its tab.
    pub(crate) fn title(&self) -> String {
        match self {
            Self::Oscilloscope => "Oscilloscope".to_owned(),
            Self::Robot => "Sensors and motors".to_owned(),
            Self::Space => "3D".to_owned(),
            Self::Values => "Variables".to_owned(),
            Self::Events => "Events".to_owned(),
            Self::Panel(schema) => schema.clone(),
        }
    }

    /// Creates a window of this kind from the state that an earlier one saved.
    pub(crate) fn open(&self, kept: &serde_json::Value) -> Box<dyn Window> {
        match self {
            Self::Oscilloscope => Box::new(scope::Scope::open(kept)),
            Self::Robot => Box::new(robot::RobotWindow::open(kept)),
            Self::Space => Box::new(space::Space::open(kept)),
            Self::Values => Box::new(values::Values::open(kept)),
            Self::Events => Box::new(events::EventsWindow::open(kept)),
            Self::Panel(schema) => Box::new(panel::Panel::open(schema, kept)),
        }
    }
}
