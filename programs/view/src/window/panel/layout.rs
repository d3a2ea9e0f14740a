//! Draws a list: its widgets one below the other. Those that stretch share the remaining height.

use eframe::egui::{self, Align, CollapsingHeader, Layout, RichText, Ui, vec2};
use jde_panel::{Area, Gesture, Ink, Item, List, Shape, Touch, Wants, Words};

use super::state::PanelState;
use super::{field, image, plot, table};
use crate::canvas::{self, Canvas};
use crate::style::{self, Style};

/// Minimum height of a widget that stretches, in points.
const MIN_STRETCHED_HEIGHT: f32 = 170.0;

/// A list that is being drawn.
pub(super) struct ListLayout<'a> {
    pub(super) style: &'a Style,
    pub(super) kept: &'a mut PanelState,
    /// The corners of the robot that shapes show, in its own frame.
    outline: &'a [[f64; 2]],
    gestures: Vec<Gesture>,
    /// Height of a widget that stretches, in points.
    height: f32,
    /// The schema receives gestures.
    alive: bool,
    /// The current widget is in a row.
    pub(super) beside: bool,
}

impl<'a> ListLayout<'a> {
    pub(super) fn new(
        style: &'a Style,
        kept: &'a mut PanelState,
        outline: &'a [[f64; 2]],
        alive: bool,
    ) -> Self {
        Self {
            style,
            kept,
            outline,
            gestures: Vec::new(),
            height: MIN_STRETCHED_HEIGHT,
            alive,
            beside: false,
        }
    }

    /// Draws the list. Returns the gestures on it.
    pub(super) fn show(mut self, ui: &mut Ui, list: &List) -> Vec<Gesture> {
        let available = ui.available_height();
        let large = list.items.iter().filter(|item| stretches(item)).count();
        if large > 0 {
            self.height = ((available - self.kept.small) / large as f32)
                .floor()
                .max(MIN_STRETCHED_HEIGHT);
        }
        let mut fixed = 0.0;
        for (place, item) in list.items.iter().enumerate() {
            let top = ui.cursor().top();
            ui.push_id(place, |ui| self.item(ui, item));
            fixed += if stretches(item) {
                ui.spacing().item_spacing.y
            } else {
                ui.cursor().top() - top
            };
        }
        if (fixed - self.kept.small).abs() > 0.5 {
            self.kept.small = fixed;
            // The height of the fixed widgets is known only now, so the frame is drawn again.
            ui.ctx().request_discard("the height of a panel's widgets");
        }
        self.gestures
    }

    fn items(&mut self, ui: &mut Ui, items: &[Item]) {
        for (place, item) in items.iter().enumerate() {
            ui.push_id(place, |ui| self.item(ui, item));
        }
    }

    fn item(&mut self, ui: &mut Ui, item: &Item) {
        if !self.alive && needs_schema(item) {
            ui.disable();
        }
        match item {
            Item::Text { text, words } => drop(ui.label(self.styled(text, *words))),
            Item::Value { label, value, unit } => field::value(self, ui, label, *value, unit),
            Item::Button { id, label, enabled } => {
                if ui.add_enabled(*enabled, egui::Button::new(label)).clicked() {
                    self.record_gesture(id, Touch::Pressed);
                }
            }
            Item::Toggle { id, label, on } => field::toggle(self, ui, id, label, *on),
            Item::Slider {
                id,
                label,
                value,
                least,
                greatest,
                unit,
            } => {
                let range = field::Range {
                    least: *least,
                    greatest: *greatest,
                    unit,
                };
                field::slider(self, ui, id, label, *value, &range);
            }
            Item::Choice {
                id,
                label,
                options,
                chosen,
            } => field::choice(self, ui, id, label, options, *chosen),
            Item::Image { .. } => image::show(self, ui, item),
            Item::Plot {
                id,
                label,
                across,
                up,
                traces,
            } => plot::show(self.style, ui, self.height, id, label, [across, up], traces),
            Item::Table { id, columns, rows } => {
                let sorted = self.kept.sorted.entry(id.clone()).or_default();
                sorted.sort(self.kept.serial, rows);
                table::show(ui, self.height, id, columns, rows, sorted);
            }
            Item::Row { items } => {
                let outer = std::mem::replace(&mut self.beside, true);
                self.row(ui, items);
                self.beside = outer;
            }
            Item::Group {
                id,
                label,
                open,
                items,
            } => {
                CollapsingHeader::new(RichText::new(label).strong())
                    .id_salt(id)
                    .default_open(*open)
                    .show(ui, |ui| self.items(ui, items));
            }
            Item::Canvas {
                id,
                area,
                forward_up,
                shapes,
                wants,
            } => self.canvas(ui, id, *area, *forward_up, shapes, *wants),
            Item::Scene { frame, solids, .. } => {
                let text = format!(
                    "{} shapes in space, in the frame {frame}: see the 3D window.",
                    solids.len()
                );
                ui.label(
                    RichText::new(text)
                        .color(style::color_of(Ink::Faint, self.style))
                        .italics(),
                );
            }
        }
    }

    /// Draws widgets in a row. If one stretches, all have the same width.
    fn row(&mut self, ui: &mut Ui, items: &[Item]) {
        if !items.iter().any(stretches) {
            ui.horizontal_wrapped(|ui| self.items(ui, items));
            return;
        }
        let (count, gap) = (items.len() as f32, ui.spacing().item_spacing.x);
        let width = ((ui.available_width() - gap * (count - 1.0)) / count).floor();
        ui.horizontal_top(|ui| {
            for (place, item) in items.iter().enumerate() {
                let size = vec2(width, self.height);
                ui.push_id(place, |ui| {
                    ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), |ui| {
                        ui.set_width(width);
                        self.item(ui, item);
                    });
                });
            }
        });
    }

    fn canvas(
        &mut self,
        ui: &mut Ui,
        id: &str,
        area: Option<Area>,
        forward_up: bool,
        shapes: &[Shape],
        wants: Wants,
    ) {
        let empty = Area {
            least: [-1.0, -1.0],
            greatest: [1.0, 1.0],
        };
        let home = area.unwrap_or_else(|| {
            let drawn = canvas::bounds(shapes).unwrap_or(empty);
            self.kept.home(id, drawn)
        });
        let mut view = self.kept.view(id);
        let outline = self.outline;
        let shown = Canvas::new(id, home)
            .size(vec2(f32::INFINITY, self.height))
            .forward_up(forward_up)
            .wants(wants)
            .show(ui, self.style, &mut view, |draw| {
                shapes.iter().for_each(|shape| draw.shape(shape, outline));
            });
        self.kept.look_at(id, view);
        if !self.alive {
            return;
        }
        for touch in shown.touches {
            self.record_gesture(id, touch);
        }
        if let Some(hint) = hint(wants) {
            shown.response.on_hover_text_at_pointer(hint);
        }
    }

    /// Records a gesture on a widget.
    pub(super) fn record_gesture(&mut self, id: &str, touch: Touch) {
        self.gestures.push(Gesture {
            widget: id.to_owned(),
            touch,
        });
    }

    /// Height of a widget that stretches, in points.
    pub(super) fn height(&self) -> f32 {
        self.height
    }

    fn styled(&self, text: &str, words: Words) -> RichText {
        let color_of = |color| style::color_of(color, self.style);
        let text = RichText::new(text);
        match words {
            Words::Plain => text,
            Words::Heading => text.heading(),
            Words::Faint => text.color(color_of(Ink::Faint)),
            Words::Good => text.color(color_of(Ink::Good)),
            Words::Warning => text.color(color_of(Ink::Warn)),
            Words::Error => text.color(color_of(Ink::Bad)).strong(),
            Words::Code => text.code(),
        }
    }
}

/// Whether a widget takes a share of the remaining height.
fn stretches(item: &Item) -> bool {
    match item {
        Item::Row { items } => items.iter().any(stretches),
        item => matches!(
            item,
            Item::Canvas { .. } | Item::Plot { .. } | Item::Table { .. } | Item::Image { .. }
        ),
    }
}

/// Whether a widget is useless without a schema that receives gestures. Planes and tables can still be
/// viewed.
fn needs_schema(item: &Item) -> bool {
    matches!(
        item,
        Item::Button { .. }
            | Item::Toggle { .. }
            | Item::Slider { .. }
            | Item::Choice { .. }
            | Item::Image { .. }
    )
}

/// A text about the gestures that a plane or image accepts, as these show no buttons.
pub(super) fn hint(wants: Wants) -> Option<String> {
    let mut inputs = Vec::new();
    if wants.clicks {
        inputs.push("click");
    }
    if wants.drags {
        inputs.push("drag (Shift moves the view)");
    }
    if wants.keys {
        inputs.push("keys, once clicked");
    }
    (!inputs.is_empty()).then(|| format!("This schema accepts: {}.", inputs.join(", ")))
}
