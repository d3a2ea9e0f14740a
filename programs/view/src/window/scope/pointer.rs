//! Pointer input on the traces: it moves the time window and the cursors, opens switches, and shows the data
//! at a time.

use eframe::egui::{CursorIcon, Rect, Response, Ui};

use jde_timeline::HierarchyRow;

use super::Scope;
use super::axis::Scale;
use super::paint::ROW;
use super::traces::Traces;

impl Scope {
    /// Handles the pointer: the wheel zooms at it, a drag moves the window or a cursor, a double click
    /// follows the present.
    pub(super) fn steer(&mut self, ui: &Ui, traces: &Response, scale: &Scale, now: f64) {
        if let Some(at) = traces.hover_pos() {
            let (wheel, zoom) = ui.input_mut(|input| {
                let wheel = if input.modifiers.shift {
                    eframe::egui::Vec2::ZERO
                } else {
                    std::mem::take(&mut input.smooth_scroll_delta)
                };
                (wheel, input.zoom_delta())
            });
            let factor = (-f64::from(wheel.y) / 200.0).exp() / f64::from(zoom);
            if (factor - 1.0).abs() > 1e-9 {
                self.axis.zoom(factor, scale.time(at.x));
            }
            if wheel.x != 0.0 {
                self.axis.pan(-f64::from(wheel.x) * scale.per_point(), now);
            }
        }
        if traces.drag_started()
            && let Some(from) = ui.input(|input| input.pointer.press_origin())
        {
            traces.request_focus();
            self.cursors.take(scale, from.x);
        }
        if traces.dragged() {
            let to = traces.interact_pointer_pos().map(|at| scale.time(at.x));
            if !to.is_some_and(|to| self.cursors.drag(to)) && traces.drag_delta().x != 0.0 {
                self.axis
                    .pan(-f64::from(traces.drag_delta().x) * scale.per_point(), now);
            }
        }
        if traces.drag_stopped() {
            self.cursors.let_go();
        }
        if traces.double_clicked() {
            self.axis.follow();
        }
    }

    /// Handles clicks and hovering: a click opens the switch at the pointer and selects its row. Hovering
    /// shows the state and events at that time. Returns the time of a switch that was clicked.
    pub(super) fn point(
        &mut self,
        ui: &Ui,
        pointed: &Response,
        drawn: &Traces<'_>,
        list: &[HierarchyRow],
        rows: &Rect,
        top: f32,
    ) -> Option<f64> {
        let at = pointed
            .hover_pos()
            .or(pointed.interact_pointer_pos())
            .filter(|at| rows.contains(*at))?;
        let row = list.get(((at.y - top) / ROW).floor().max(0.0) as usize)?;
        let snapshot = drawn.seen.snapshot;
        let view = row.schema().map(|schema| &snapshot.schemas[schema]);
        let group = row.group().or_else(|| view?.group);
        let switch = group
            .and_then(|group| snapshot.groups.get(group))
            .and_then(|group| drawn.switch_at(&group.name, at.x));
        if pointed.clicked() {
            pointed.request_focus();
            if let Some(view) = view {
                self.selected = Some(view.name.clone());
            }
            if let Some(number) = switch {
                self.why.open(number);
            }
        }
        if pointed.hovered() && !pointed.dragged() {
            let mut lines = vec![format!("{:.3} s", drawn.scale.time(at.x))];
            lines.extend(view.into_iter().flat_map(|view| drawn.description_at(view, at.x)));
            if switch.is_some() {
                lines.push("Click to show the reason of this switch".to_owned());
                ui.ctx().set_cursor_icon(CursorIcon::PointingHand);
            }
            pointed.clone().on_hover_text_at_pointer(lines.join("\n"));
        }
        let clicked = switch.filter(|_| pointed.clicked())?;
        let decision = drawn.seen.timeline.log().decisions().find(clicked);
        decision.map(|decision| decision.time_s)
    }
}
