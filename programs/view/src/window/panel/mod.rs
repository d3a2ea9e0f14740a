//! The panel that a schema draws: its newest list, and the gestures on it, which are sent to the schema. It
//! shows only what the schema drew, and the age of that.

mod field;
mod image;
mod layout;
mod plot;
mod state;
mod table;

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, RichText, ScrollArea, Ui};
use jde_core::State;
use jde_link::Rate;
use jde_link::message::Action;
use jde_panel::{Gesture, Ink, List};
use jde_records::snapshot::HoldKind;
use jde_records::wire::state_name;

use super::Window;
use crate::session::{OrderOutcome, WindowSession};
use crate::style::{self, Style};
use layout::ListLayout;
use state::PanelState;

/// Rate at which lists are requested: smooth to the eye, and cheap for the schema.
const RATE: Rate = Rate::Hz(20);
/// Age from which the age of a list is shown.
const SHOWN_AGE: Duration = Duration::from_millis(1500);

/// Opacity of a panel whose schema receives no gestures.
const FADED_OPACITY: f32 = 0.55;

/// The window of a panel.
pub(crate) struct Panel {
    schema: String,
    kept: PanelState,
    /// The newest list, and when it arrived.
    newest: Option<(Arc<List>, Instant)>,
    /// The corners of the schema's robot, in its own frame.
    outline: Vec<[f64; 2]>,
    /// The outcome of the last gesture.
    outcome: OrderOutcome,
}

/// The content to show.
enum Content<'a> {
    /// Nothing has arrived yet.
    Waiting,
    /// The application is a recording without this panel.
    Unrecorded,
    /// There is no list that can be shown, for this reason.
    Refused(&'a str),
    /// The newest list.
    Shown(&'a Arc<List>),
}

impl Panel {
    /// Opens the panel of a schema with its saved state.
    pub(crate) fn open(schema: &str, kept: &serde_json::Value) -> Self {
        Self {
            schema: schema.to_owned(),
            kept: PanelState::read(kept),
            newest: None,
            outline: Vec::new(),
            outcome: OrderOutcome::default(),
        }
    }

    /// Shows the state of the schema, and why its panel is old or missing. Returns whether the panel accepts
    /// gestures.
    fn head(&self, ui: &mut Ui, session: &WindowSession, style: &Style) -> bool {
        let Some(view) = session.view(&self.schema) else {
            ui.label(faint(
                style,
                &format!("There is no schema {} in this application.", self.schema),
            ));
            return false;
        };
        let unloaded = view.is_held_to(HoldKind::Unloaded);
        ui.horizontal(|ui| {
            let (spot, _) = ui.allocate_exact_size(egui::Vec2::splat(10.0), egui::Sense::hover());
            ui.painter()
                .circle_filled(spot.center(), 4.5, style::state(view.state, style));
            let state = if unloaded {
                "unloaded".to_owned()
            } else {
                state_name(view.state)
            };
            ui.label(state).on_hover_text(
                session
                    .schema(&self.schema)
                    .map_or("", |schema| schema.doc.as_str()),
            );
            if let Some(ending) = session.ending().filter(|_| session.is_over()) {
                let text = format!("{}; this is the last panel", ending.word());
                ui.label(colored(style, style::severity(ending.severity()), &text));
            } else if unloaded {
                ui.label(faint(style, "it draws nothing until it is loaded again"));
            } else if view.state == State::Slept {
                ui.label(faint(style, "it is asleep"));
                let play = ui
                    .small_button("Play")
                    .on_hover_text("Wake it as its father would (R14)");
                if play.clicked() {
                    let schema = self.schema.clone();
                    session.act(Action::Play { schema });
                }
            }
            if let Some((_, received)) = &self.newest
                && received.elapsed() > SHOWN_AGE
                && !session.is_over()
            {
                let age = received.elapsed().as_secs_f64();
                ui.label(colored(style, Ink::Warn, &format!("drawn {age:.0} s ago")))
                    .on_hover_text(
                        "No newer panel has arrived. A schema whose panel does not change may send nothing",
                    );
                ui.ctx().request_repaint_after(Duration::from_secs(1));
            }
        });
        if let Some(Err(reason)) = self.outcome.get() {
            ui.label(colored(
                style,
                Ink::Bad,
                &format!("The gesture was refused: {reason}"),
            ));
        }
        !session.is_over() && !unloaded && !session.is_recording()
    }

    /// Draws the content. Returns the gestures on it.
    fn body(&mut self, ui: &mut Ui, style: &Style, content: &Content<'_>, alive: bool) -> Vec<Gesture> {
        match content {
            Content::Waiting => {
                ui.centered_and_justified(|ui| ui.label(faint(style, "waiting for the first picture")));
                Vec::new()
            }
            Content::Refused(reason) => {
                ui.add_space(8.0);
                ui.label(colored(style, Ink::Bad, "This panel cannot be shown:"));
                ui.label(*reason);
                Vec::new()
            }
            Content::Unrecorded => {
                ui.add_space(8.0);
                ui.label(faint(style, "This panel was not recorded. To record panels:"));
                ui.code("jde run APP --record FILE --panels");
                Vec::new()
            }
            Content::Shown(list) => {
                let mut gestures = Vec::new();
                let kept = &mut self.kept;
                kept.take(list);
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    if !alive {
                        ui.multiply_opacity(FADED_OPACITY);
                    }
                    gestures = ListLayout::new(style, kept, &self.outline, alive).show(ui, list);
                });
                gestures
            }
        }
    }
}

impl Window for Panel {
    fn show(&mut self, ui: &mut Ui, session: &WindowSession, style: &Style) {
        let alive = self.head(ui, session, style);
        if session.view(&self.schema).is_none() {
            return;
        }
        self.outline = jde_timeline::outline(session.body(&self.schema).as_ref());
        let refused = match session.panel(&self.schema, RATE) {
            None => None,
            Some(Ok(list)) => {
                let new = self
                    .newest
                    .as_ref()
                    .is_none_or(|(old, _)| !Arc::ptr_eq(old, &list));
                if new {
                    self.newest = Some((list, Instant::now()));
                }
                None
            }
            Some(Err(reason)) => Some(reason),
        };
        let newest = self.newest.as_ref().map(|(list, _)| Arc::clone(list));
        let unrecorded =
            session.is_recording() && !session.schema(&self.schema).is_some_and(|schema| schema.panel);
        let content = match (&refused, &newest) {
            (Some(_), _) if unrecorded => Content::Unrecorded,
            (Some(reason), _) => Content::Refused(reason),
            (None, Some(list)) => Content::Shown(list),
            (None, None) => Content::Waiting,
        };
        for gesture in self.body(ui, style, &content, alive) {
            self.outcome = session.touch(&self.schema, gesture);
        }
    }

    fn keep(&self) -> serde_json::Value {
        self.kept.write()
    }
}

fn faint(style: &Style, text: &str) -> RichText {
    colored(style, Ink::Faint, text)
}

fn colored(style: &Style, color: Ink, text: &str) -> RichText {
    RichText::new(text).color(style::color_of(color, style))
}

#[cfg(test)]
pub(crate) mod bench {
    //! A panel's list without a session, for tests: it takes a list and collects gestures.

    use super::*;

    /// A list and the state of its window.
    #[derive(Default)]
    pub(crate) struct Bench {
        kept: PanelState,
        outline: Vec<[f64; 2]>,
        /// The list to show.
        pub(crate) list: Arc<List>,
        /// The gestures so far.
        pub(crate) gestures: Vec<Gesture>,
    }

    impl Bench {
        /// Creates a bench that shows a list.
        pub(crate) fn of(list: List) -> Self {
            Self {
                list: Arc::new(list),
                outline: jde_timeline::outline(None),
                ..Self::default()
            }
        }

        /// Draws one frame.
        pub(crate) fn show(&mut self, ui: &mut Ui, style: &Style) {
            let list = Arc::clone(&self.list);
            self.kept.take(&list);
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                let layout = ListLayout::new(style, &mut self.kept, &self.outline, true);
                self.gestures.extend(layout.show(ui, &list));
            });
        }
    }
}
