//! Taps: what is over within a frame, as on a trackpad or on a busy machine, is no drag for a widget that senses those alone.

use eframe::egui::{Pos2, Response, Ui};

/// Where a widget was pressed and let go of within this frame, if it was.
pub(crate) fn tap(ui: &Ui, response: &Response) -> Option<Pos2> {
    let at = ui.input(|input| {
        let pointer = &input.pointer;
        (pointer.primary_pressed() && pointer.primary_released())
            .then(|| pointer.interact_pos())
            .flatten()
    })?;
    (response.enabled() && response.contains_pointer()).then_some(at)
}
