//! The middle of the window: rows with facts at the left and traces at the right, and signals below, with one
//! time axis.

use eframe::egui::{
    Color32, CursorIcon, Rangef, Rect, Response, Role, ScrollArea, Sense, Stroke, Ui, UiBuilder, WidgetInfo,
    pos2, vec2,
};
use jde_panel::Ink;
use jde_timeline::{HierarchyRow, Item, OTHERS};

use super::axis::Scale;
use super::input::{Input, Request};
use super::paint::{self, ROW};
use super::rows;
use super::ruler;
use super::table::{self, Table};
use super::traces::Traces;
use super::{Scope, Trigger};
use crate::style::{self, Style};

/// Height of the titles and times, in points.
const HEAD_HEIGHT: f32 = 18.0;
/// Space below the last row, in points.
const MARGIN: f32 = 8.0;
/// Width of the scroll bar, in points.
const SCROLL_BAR_WIDTH: f32 = 10.0;

/// The regions of the window.
struct Regions {
    head: Rect,
    rows: Rect,
    signals: Rect,
    /// The horizontal range of the traces.
    x: Rangef,
}

impl Scope {
    pub(super) fn body(&mut self, ui: &mut Ui, seen: &Input<'_>, style: &Style, requests: &mut Vec<Request>) {
        let area = ui.available_rect_before_wrap();
        if area.width() < 120.0 || area.height() < 2.0 * ROW {
            return;
        }
        let parts = self.parts(ui, area);
        let (list, left_out) = rows::rows(
            seen.timeline.hierarchy(),
            seen.snapshot,
            &self.filter,
            &self.folded,
        );
        self.left_out = left_out;
        let signals = self.signals.height();
        self.needed = HEAD_HEIGHT + list.len() as f32 * ROW + signals + MARGIN;
        let id = ui.scope_id().with("traces");
        self.keys(ui, id, seen, &list, requests);
        let visible = Rect::from_x_y_ranges(parts.x, area.y_range());
        let traces = ui.interact(visible, id, Sense::click_and_drag());
        traces.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Traces"));
        let now = seen.now();
        self.steer(ui, &traces, &self.axis.scale(now, parts.x), now);
        let scale = self.axis.scale(now, parts.x);

        let body = Rect::from_x_y_ranges(parts.x, parts.rows.top()..=parts.signals.bottom());
        let times = Rect::from_x_y_ranges(parts.x, parts.head.y_range());
        ruler::draw(ui.painter(), times, body, &scale, self.axis.division(), style);
        let names = table::name_width(ui, seen, &list);
        let table = Table::new(area.left(), parts.x.min - 6.0, names);
        table.titles(ui, parts.head.with_max_x(parts.x.min - 6.0));
        self.rows(ui, seen, &list, &parts, &table, &traces, &scale, style, requests);
        self.signals
            .show(ui, parts.signals, &scale, seen, &self.cursors, style);
        gaps(ui.painter(), body, &scale, seen.gaps, style);
        let overlay = ui.painter().with_clip_rect(visible);
        trigger_line(&overlay, body, &scale, &self.trigger, style);
        self.cursors.draw(&overlay, times, body, &scale, style);
        let present = scale.x(now);
        if scale.holds(now) && (!self.axis.is_live() || now < seen.end_s) {
            overlay.vline(
                present,
                body.y_range(),
                Stroke::new(1.0, style::color_of(Ink::Faint, style)),
            );
        }
        self.focused = traces.has_focus();
        self.has_row = self.selected_view(seen, &list).is_some();
        if self.focused {
            let line = ui.visuals().selection.stroke;
            ui.painter().rect_stroke(
                visible.shrink(0.5),
                0.0,
                Stroke::new(1.0, line.color),
                eframe::egui::StrokeKind::Inside,
            );
        }
        if list.is_empty() {
            let text = if seen.snapshot.schemas.is_empty() {
                "This application has no schemas."
            } else {
                "No schema matches the filter."
            };
            paint::write(
                ui.painter(),
                parts.rows.shrink(12.0),
                text,
                paint::font(),
                ui.visuals().weak_text_color(),
            );
        }
    }

    /// Divides the space, and handles drags of the border between facts and traces.
    fn parts(&mut self, ui: &Ui, area: Rect) -> Regions {
        let border = area.left() + area.width() * self.share;
        let handle = Rect::from_x_y_ranges(Rangef::new(border - 6.0, border - 1.0), area.y_range());
        let response = ui
            .interact(handle, ui.scope_id().with("border"), Sense::drag())
            .on_hover_cursor(CursorIcon::ResizeHorizontal);
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            self.share = ((at.x - area.left() + 3.0) / area.width()).clamp(0.2, 0.8);
        }
        let line = if response.hovered() || response.dragged() {
            ui.visuals().widgets.hovered.fg_stroke
        } else {
            ui.visuals().widgets.noninteractive.bg_stroke
        };
        ui.painter().vline(handle.center().x, area.y_range(), line);
        let border = area.left() + area.width() * self.share;
        let desired = self.signals.height();
        let signals = desired.min((area.height() - HEAD_HEIGHT) * 0.5);
        let split = area.bottom() - signals;
        Regions {
            head: area.with_max_y(area.top() + HEAD_HEIGHT),
            rows: Rect::from_min_max(
                pos2(area.left(), area.top() + HEAD_HEIGHT),
                pos2(area.right(), split),
            ),
            signals: area.with_min_y(split),
            x: Rangef::new(border, area.right() - SCROLL_BAR_WIDTH),
        }
    }

    #[expect(
        clippy::too_many_arguments,
        reason = "the function draws both halves of a row"
    )]
    fn rows(
        &mut self,
        ui: &mut Ui,
        seen: &Input<'_>,
        list: &[HierarchyRow],
        parts: &Regions,
        table: &Table,
        pointer: &Response,
        scale: &Scale,
        style: &Style,
        requests: &mut Vec<Request>,
    ) {
        let selected = |row: &HierarchyRow| selected_row(&self.selected, seen, row);
        let mut area = ScrollArea::vertical().id_salt("rows").auto_shrink(false);
        if std::mem::take(&mut self.reveal)
            && let Some(place) = list.iter().position(selected)
        {
            let (top, height) = (place as f32 * ROW, parts.rows.height());
            area = area.vertical_scroll_offset(self.scrolled.clamp((top + ROW - height).max(0.0), top));
        }
        // The row of each schema; schemas in folded parts have none.
        let mut places = vec![None; seen.snapshot.schemas.len()];
        for (place, row) in list.iter().enumerate() {
            if let Some(schema) = row.schema() {
                places[schema] = Some(place);
            }
        }
        let inside = UiBuilder::new().max_rect(parts.rows);
        let output = ui.scope_builder(inside, |ui| {
            ui.set_clip_rect(parts.rows.intersect(ui.clip_rect()));
            ui.spacing_mut().item_spacing = vec2(ui.spacing().item_spacing.x, 0.0);
            area.show_viewport(ui, |ui, visible| {
                ui.set_height(list.len() as f32 * ROW);
                let top = ui.max_rect().top();
                let rect_of = |place: usize| {
                    let y = top + place as f32 * ROW;
                    Rect::from_x_y_ranges(parts.rows.x_range(), y..=y + ROW)
                };
                let first = (visible.min.y / ROW).floor().max(0.0) as usize;
                let last = ((visible.max.y / ROW).ceil().max(0.0) as usize).min(list.len());
                let pixel = 1.0 / ui.pixels_per_point();
                let mut drawn = Traces::new(seen, *scale, style, pixel);
                let overlay = ui.painter().with_clip_rect(
                    Rect::from_x_y_ranges(parts.x, parts.rows.y_range()).intersect(ui.clip_rect()),
                );
                for (place, row) in list.iter().enumerate().take(last).skip(first) {
                    let rect = rect_of(place);
                    table::ground(
                        ui,
                        rect,
                        selected_row(&self.selected, seen, row),
                        table::is_hovered(pointer, rect),
                    );
                    let trace = Rect::from_x_y_ranges(parts.x, rect.y_range());
                    let depth = row.depth;
                    match row.item {
                        Item::Group(group) => {
                            let view = &seen.snapshot.groups[group];
                            table.group(ui, rect, seen, view, depth, style);
                            drawn.group(&overlay, trace, view);
                        }
                        Item::Schema(schema, below) => {
                            let view = &seen.snapshot.schemas[schema];
                            let done = table.schema(
                                ui,
                                rect,
                                seen,
                                schema,
                                (depth, below),
                                &mut self.editing,
                                style,
                                requests,
                            );
                            if done.folded && !self.folded.remove(&view.name) {
                                self.folded.insert(view.name.clone());
                            }
                            if done.selected {
                                self.selected = Some(view.name.clone());
                                pointer.request_focus();
                            }
                            drawn.schema(&overlay, trace, view);
                        }
                        Item::Others => {
                            let line = rect.with_min_x(rect.left() + 6.0).with_max_x(table.right);
                            let faint = ui.visuals().weak_text_color();
                            paint::write(ui.painter(), line, OTHERS, paint::small(), faint);
                        }
                    }
                }
                let middle = |schema: usize| {
                    places
                        .get(schema)
                        .copied()
                        .flatten()
                        .map(|place| rect_of(place).center().y)
                };
                for view in &seen.snapshot.groups {
                    let visible = rect_of(first).top()..=rect_of(last).bottom();
                    if view
                        .members
                        .iter()
                        .filter_map(|&member| middle(member))
                        .any(|y| visible.contains(&y))
                    {
                        drawn.switches(&overlay, view, &middle, self.why.opened());
                    }
                }
                let clicked = self.point(ui, pointer, &drawn, list, &parts.rows, top);
                if let Some(time) = clicked.filter(|_| seen.is_recording) {
                    requests.push(Request::Seek(time));
                }
            })
        });
        self.scrolled = output.inner.state.clamped_offset().y;
    }
}

fn selected_row(selected: &Option<String>, seen: &Input<'_>, row: &HierarchyRow) -> bool {
    let schema = row.schema().map(|schema| &seen.snapshot.schemas[schema].name);
    schema.is_some() && schema == selected.as_ref()
}

/// Draws the time at which the trigger last fired.
fn trigger_line(
    painter: &eframe::egui::Painter,
    body: Rect,
    scale: &Scale,
    trigger: &Trigger,
    style: &Style,
) {
    let Some((at, text)) = trigger.last().filter(|(at, _)| scale.holds(*at)) else {
        return;
    };
    let color = style::color_of(Ink::Warn, style);
    let x = scale.x(*at);
    let mut y = body.top();
    while y < body.bottom() {
        painter.vline(x, Rangef::new(y, y + 4.0), Stroke::new(1.3, color));
        y += 8.0;
    }
    let label_area = Rect::from_min_max(pos2(x + 4.0, body.top()), pos2(body.right(), body.top() + 14.0));
    paint::write(painter, label_area, &format!("T {text}"), paint::small(), color);
}

/// Marks where nothing was recorded.
fn gaps(painter: &eframe::egui::Painter, body: Rect, scale: &Scale, gaps: &[(f64, f64)], style: &Style) {
    for (from, until) in gaps
        .iter()
        .filter(|(from, until)| *until >= scale.from && *from <= scale.to)
    {
        let x = Rangef::new(scale.x(*from).max(scale.x.min), scale.x(*until).min(scale.x.max));
        let gap = Rect::from_x_y_ranges(x, body.y_range());
        let ground = if style.dark {
            Color32::BLACK
        } else {
            Color32::WHITE
        };
        painter.rect_filled(gap, 0.0, ground);
        paint::write(
            painter,
            gap.shrink(3.0),
            "not recorded",
            paint::small(),
            style::color_of(Ink::Faint, style),
        );
    }
}
