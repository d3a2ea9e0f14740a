//! A plane in metres with pan and zoom, which windows share: its visible part, a grid, shapes, and gestures.
//! It preserves the aspect ratio, and knows nothing of schemas.

mod clip;
mod draw2d;
mod gestures;
mod grid;
mod pan_zoom;
mod view;

use eframe::egui::{self, Id, Pos2, Rect, Response, Sense, Ui, Vec2, WidgetInfo, pos2, vec2};
use jde_panel::{Area, Touch, Wants};

use crate::style::Style;

pub(crate) use draw2d::{Draw2d, bounds, nose};
pub(crate) use gestures::Gestures;
pub(crate) use view::{Transform, View};

/// A plane to show, before it is drawn.
pub(crate) struct Canvas<'a> {
    name: &'a str,
    home: Area,
    size: Vec2,
    forward_up: bool,
    wants: Wants,
}

/// The result of showing a canvas for one frame.
pub(crate) struct CanvasResponse {
    /// egui's response for the whole canvas.
    pub(crate) response: Response,
    /// The requested gestures, in the order of [`Gestures::touches`].
    pub(crate) touches: Vec<Touch>,
}

impl<'a> Canvas<'a> {
    /// Creates a canvas that shows `home` until the user pans or zooms. `name` is its accessible name, and
    /// must be unique among its neighbours. It takes all available space.
    pub(crate) fn new(name: &'a str, home: Area) -> Self {
        Self {
            name,
            home,
            size: Vec2::INFINITY,
            forward_up: false,
            wants: Wants::default(),
        }
    }

    /// Limits the size, in points of the screen.
    pub(crate) fn size(self, size: Vec2) -> Self {
        Self { size, ..self }
    }

    /// Shows x upwards and y to the left.
    pub(crate) fn forward_up(self, forward_up: bool) -> Self {
        Self { forward_up, ..self }
    }

    /// Sets the gestures that are reported instead of moving the view.
    pub(crate) fn wants(self, wants: Wants) -> Self {
        Self { wants, ..self }
    }

    /// Shows the plane with the shapes that `draw` draws.
    pub(crate) fn show(
        self,
        ui: &mut Ui,
        style: &Style,
        view: &mut View,
        draw: impl FnOnce(&mut Draw2d<'_>),
    ) -> CanvasResponse {
        let size = self.size.min(ui.available_size()).max(Vec2::splat(32.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let name = self.name;
        response.widget_info(|| WidgetInfo::labeled(egui::Role::Canvas, true, name));
        let buttons = self.buttons(ui, response.id, rect, view);
        let transform_before = view.transform(rect, self.home, self.forward_up);
        let touches = view
            .gestures
            .touches(ui, &response, self.wants, |at| flat(&transform_before, at));
        pan_zoom::steer(ui, &response, rect, view, &self);
        let transform = view.transform(rect, self.home, self.forward_up);
        if buttons || !touches.is_empty() {
            ui.ctx().request_repaint();
        }
        if ui.is_rect_visible(rect) {
            let visuals = ui.visuals();
            let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(rect));
            painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
            grid::draw(&painter, &transform, style);
            draw(&mut Draw2d::new(painter.clone(), transform, style));
            if let Some(pointer) = response.hover_pos() {
                grid::pointer_position(&painter, &transform, pointer, style);
            }
            let border = if response.has_focus() {
                visuals.selection.stroke
            } else {
                visuals.widgets.noninteractive.bg_stroke
            };
            painter.rect_stroke(rect, 3.0, border, egui::StrokeKind::Inside);
            // The buttons lie above the shapes.
            paint_buttons(ui, response.id, rect);
        }
        CanvasResponse { response, touches }
    }

    /// The buttons that zoom and fit, for users without a wheel. Returns whether one was pressed.
    fn buttons(&self, ui: &Ui, id: Id, rect: Rect, view: &mut View) -> bool {
        let middle = rect.center();
        let mut pressed = false;
        for (place, button) in ZoomButton::ALL.into_iter().enumerate() {
            let name = format!("{} of {}", button.word(), self.name);
            let response = ui
                .interact(
                    button_rect(rect, place),
                    id.with(("button", place)),
                    Sense::click(),
                )
                .on_hover_text(button.hint());
            response.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, &name));
            if response.clicked() {
                pressed = true;
                match button {
                    ZoomButton::Closer => view.zoom(rect, self.home, self.forward_up, middle, 1.5),
                    ZoomButton::Farther => view.zoom(rect, self.home, self.forward_up, middle, 1.0 / 1.5),
                    ZoomButton::Fit => view.fit(),
                }
            }
        }
        pressed
    }
}

#[derive(Clone, Copy)]
enum ZoomButton {
    Closer,
    Farther,
    Fit,
}

impl ZoomButton {
    const ALL: [Self; 3] = [Self::Closer, Self::Farther, Self::Fit];

    fn word(self) -> &'static str {
        match self {
            Self::Closer => "closer view",
            Self::Farther => "farther view",
            Self::Fit => "whole view",
        }
    }

    fn hint(self) -> &'static str {
        match self {
            Self::Closer => "Closer (+, or the wheel at the pointer)",
            Self::Farther => "Farther (-, or the wheel at the pointer)",
            Self::Fit => "Show all of it (0)",
        }
    }

    /// Draws the button's sign. Not every font has these signs.
    fn paint(self, painter: &egui::Painter, button_rect: Rect, color: egui::Color32) {
        let (middle, radius) = (button_rect.center(), 4.0);
        let stroke = egui::Stroke::new(1.5, color);
        let line = |from: Vec2, to: Vec2| {
            painter.line_segment([middle + from * radius, middle + to * radius], stroke);
        };
        match self {
            Self::Closer => {
                line(vec2(-1.0, 0.0), vec2(1.0, 0.0));
                line(vec2(0.0, -1.0), vec2(0.0, 1.0));
            }
            Self::Farther => line(vec2(-1.0, 0.0), vec2(1.0, 0.0)),
            Self::Fit => {
                for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    line(vec2(x, y), vec2(x * 0.2, y));
                    line(vec2(x, y), vec2(x, y * 0.2));
                }
            }
        }
    }
}

fn button_rect(rect: Rect, place: usize) -> Rect {
    let side = 18.0;
    let left = rect.right() - (ZoomButton::ALL.len() - place) as f32 * (side + 2.0) - 2.0;
    Rect::from_min_size(pos2(left, rect.top() + 4.0), Vec2::splat(side))
}

/// A position on the plane as a panel's gestures report it, with z = 0.
fn flat(transform: &Transform, at: Pos2) -> [f64; 3] {
    let [x, y] = transform.plane(at);
    [x, y, 0.0]
}

fn paint_buttons(ui: &Ui, id: Id, rect: Rect) {
    for (place, button) in ZoomButton::ALL.into_iter().enumerate() {
        let button_rect = button_rect(rect, place);
        let response = ui.ctx().read_response(id.with(("button", place)));
        let highlighted = response.is_some_and(|response| response.hovered() || response.has_focus());
        let visuals = ui.visuals();
        let painter = ui.painter().with_clip_rect(ui.clip_rect().intersect(rect));
        let ground = if highlighted {
            visuals.widgets.hovered.weak_bg_fill
        } else {
            visuals.window_fill.gamma_multiply(0.7)
        };
        painter.rect_filled(button_rect, 3.0, ground);
        let color = if highlighted {
            visuals.text_color()
        } else {
            visuals.weak_text_color()
        };
        button.paint(&painter, button_rect, color);
    }
}
