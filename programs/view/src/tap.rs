//! Taps: a press and release within one frame, as on a trackpad or a slow machine. A widget that senses only
//! drags does not report these.

use eframe::egui::{Pos2, Response, Ui};

/// Where a widget was pressed and released within this frame.
pub(crate) fn tap(ui: &Ui, response: &Response) -> Option<Pos2> {
    let at = ui.input(|input| {
        let pointer = &input.pointer;
        (pointer.primary_pressed() && pointer.primary_released())
            .then(|| pointer.interact_pos())
            .flatten()
    })?;
    (response.enabled() && response.contains_pointer()).then_some(at)
}
