//! The list of all keys, which the key `?` shows and hides.

use eframe::egui::{self, Event, Grid, Ui};

/// The keys, each with what it does, by where they act.
const KEYS: [(&str, &[(&str, &str)]); 6] = [
    (
        "Everywhere",
        &[
            ("Ctrl+Space", "stop everything"),
            ("?", "show or hide this list"),
            ("Tab", "the focus goes on; Shift+Tab: back"),
        ],
    ),
    (
        "A recording, while nothing has the focus",
        &[("Space", "play or pause")],
    ),
    (
        "Oscilloscope, while its traces have the focus",
        &[
            ("Space", "pause the picture, or show the present again"),
            ("Left, Right", "the reason of the previous or the next switch"),
            ("Up, Down, PgUp, PgDn", "select a schema"),
            ("P S F R", "play, stop, force or release the selected schema"),
            ("T", "type its period: 75ms, 0.5s, 20Hz"),
        ],
    ),
    (
        "Drive pad, while it has the focus",
        &[
            ("Arrows, W A S D", "drive while held"),
            ("Space", "hold the robot still"),
        ],
    ),
    (
        "Plane and panels, while one has the focus",
        &[("Arrows", "move"), ("+ -", "zoom"), ("0, Home", "show all")],
    ),
    (
        "3D, while it has the focus",
        &[
            ("Arrows", "turn; with Shift: move"),
            ("+ -", "zoom"),
            ("F T R", "follow the robot, from the top, reset"),
        ],
    ),
];

/// Whether the list is shown.
#[derive(Default)]
pub(crate) struct KeyList {
    shown: bool,
}

impl KeyList {
    /// Draws the button in the bar.
    pub(crate) fn button(&mut self, ui: &mut Ui) {
        let button = ui.selectable_label(self.shown, "?").on_hover_text("All keys (?)");
        self.shown ^= button.accessible_name("Keys").clicked();
    }

    /// Draws the list if it is shown. The key counts unless a text is typed.
    pub(crate) fn show(&mut self, ctx: &egui::Context) {
        let is_key = |event: &Event| matches!(event, Event::Text(text) if text == "?");
        self.shown ^= !ctx.text_edit_focused() && ctx.input(|input| input.events.iter().any(is_key));
        let list = egui::Window::new("Keys").open(&mut self.shown).resizable(false);
        list.show(ctx, |ui| {
            for (place, keys) in KEYS {
                ui.strong(place);
                Grid::new(place)
                    .num_columns(2)
                    .spacing([16.0, 2.0])
                    .show(ui, |ui| {
                        for (key, meaning) in keys {
                            ui.monospace(*key);
                            ui.label(*meaning);
                            ui.end_row();
                        }
                    });
                ui.add_space(4.0);
            }
        });
    }
}
