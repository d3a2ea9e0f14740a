//! The button and the key that stop everything, and the orders that are under way (R14). The button is on every page
//! except a recording's, at the same place, whatever the state of the connection, and repeating it is harmless. Going
//! on is elsewhere, and asks once.

mod request;

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, Color32, RichText};
use jde_link::Reach;

pub(crate) use request::{StopRequest, StopTarget};

/// After this time without an answer, the one that owes it is named.
const ANSWER_EXPECTED: Duration = Duration::from_secs(1);
/// How often the times that are shown change.
const SHOWN_TIME_INTERVAL: Duration = Duration::from_millis(500);

/// Draws the button. Returns whether everything is to be stopped.
pub(crate) fn button(ui: &mut egui::Ui, target: &StopTarget) -> bool {
    let text = RichText::new("Stop everything").strong().color(Color32::WHITE);
    let button = ui.add(egui::Button::new(text).fill(Color32::from_rgb(176, 32, 32)));
    let whom = match target {
        StopTarget::One(_) => "this application",
        StopTarget::All => "every application in reach",
    };
    button
        .on_hover_text(format!(
            "Ctrl+Space. Puts every root of {whom} and all schemas below it to sleep; the actuators brake. All schemas keep their memory."
        ))
        .clicked()
}

/// A button that asks once. Its place then has the way back, so that a second click undoes the first. Returns whether the
/// person confirmed.
pub(crate) fn confirmed(ui: &mut egui::Ui, asks: &mut bool, text: &str, question: &str) -> bool {
    if !*asks {
        *asks = ui.button(text).clicked();
        return false;
    }
    if ui.button("Keep it stopped").clicked() {
        *asks = false;
    }
    let confirmed = ui.button(question).clicked();
    *asks &= !confirmed;
    confirmed
}

/// The orders of these windows. Leaving a page ends none of them.
#[derive(Default)]
pub(crate) struct Stops {
    requests: Vec<Arc<StopRequest>>,
    asks: bool,
}

impl Stops {
    /// Begins an order to these applications. It replaces an earlier one to the same target, which has waited since then.
    pub(crate) fn begin(
        &mut self,
        target: StopTarget,
        reach: &Reach,
        names: Vec<String>,
    ) -> Arc<StopRequest> {
        let mut since = Instant::now();
        self.requests.retain(|request| {
            if request.is_pending() && request.target == target {
                since = request.since;
                request.withdraw();
            }
            request.is_pending()
        });
        let request = StopRequest::new(target, reach.clone(), since, names);
        self.requests.push(Arc::clone(&request));
        request
    }

    /// Whether an order to this target is under way.
    pub(crate) fn is_pending(&self, target: &StopTarget) -> bool {
        let mut requests = self.requests.iter();
        requests.any(|request| request.target == *target && request.is_pending())
    }

    /// Draws what is under way, and also what is done if the page does not show it itself.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui, with_done: bool) {
        // Those that were withdrawn are over.
        self.requests
            .retain(|request| request.is_pending() || request.answers().acknowledged.is_some());
        let is_shown = |request: &&Arc<StopRequest>| with_done || request.is_pending();
        let shown: Vec<_> = self.requests.iter().filter(is_shown).cloned().collect();
        let pending = shown.iter().any(|request| request.is_pending());
        self.asks &= pending;
        if shown.is_empty() {
            return;
        }
        ui.ctx().request_repaint_after(SHOWN_TIME_INTERVAL);
        egui::Panel::top("stops").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                if pending
                    && confirmed(
                        ui,
                        &mut self.asks,
                        "Stop asking ...",
                        "Stop asking, although a robot may still move",
                    )
                {
                    shown.iter().for_each(|request| request.withdraw());
                }
                for request in &shown {
                    let color = if request.is_pending() {
                        ui.visuals().error_fg_color
                    } else {
                        ui.visuals().warn_fg_color
                    };
                    let label = ui.label(RichText::new(text(request)).color(color).strong());
                    let missing = request.answers().missing.into_iter();
                    let reasons: Vec<_> = missing
                        .filter_map(|(name, reason)| Some(format!("{name}: {}", reason?)))
                        .collect();
                    if !reasons.is_empty() {
                        label.on_hover_text(reasons.join("\n"));
                    }
                }
            });
        });
    }
}

/// How an order stands.
fn text(request: &StopRequest) -> String {
    let answers = request.answers();
    let stopped = answers.stopped.join(", ");
    if let Some(acknowledged) = answers.acknowledged {
        let ago = acknowledged.elapsed().as_secs();
        return match stopped.as_str() {
            "" => "Nothing to stop: no application runs".to_owned(),
            stopped => format!("Stopped by {} {ago} s ago: {stopped}", jde_link::operator()),
        };
    }
    let waited = request.since.elapsed();
    let missing: Vec<_> = answers.missing.into_keys().collect();
    match missing.as_slice() {
        [] => format!("Stopping for {} s", waited.as_secs()),
        missing if waited < ANSWER_EXPECTED => format!("Stopping {}", missing.join(", ")),
        missing => format!(
            "Stopping: not acknowledged by {} for {} s",
            missing.join(", "),
            waited.as_secs()
        ),
    }
}
