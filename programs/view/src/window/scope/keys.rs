//! The keys of the oscilloscope: those of the terminal oscilloscope, and the arrows between switches. They
//! act only while the traces have the focus, so that typing and driving elsewhere is not affected. Space also
//! acts while nothing has the focus.

use eframe::egui::{EventFilter, Id, Key, Modifiers, Ui};
use jde_link::message::Action;
use jde_records::snapshot::SchemaView;
use jde_timeline::HierarchyRow;

use super::Scope;
use super::input::{Input, Request};

/// The keys that the traces keep for themselves while they have the focus.
const FILTER: EventFilter = EventFilter {
    tab: false,
    horizontal_arrows: true,
    vertical_arrows: true,
    escape: false,
};

impl Scope {
    pub(super) fn keys(
        &mut self,
        ui: &Ui,
        traces: Id,
        seen: &Input<'_>,
        rows: &[HierarchyRow],
        requests: &mut Vec<Request>,
    ) {
        let focused = ui.memory(|memory| memory.focused());
        if focused.is_none_or(|focused| focused == traces) && take(ui, Key::Space) {
            self.run_or_pause(seen);
        }
        if focused != Some(traces) {
            return;
        }
        ui.memory_mut(|memory| memory.set_focus_lock_filter(traces, FILTER));
        for (key, forward) in [(Key::ArrowLeft, false), (Key::ArrowRight, true)] {
            if take(ui, key)
                && let Some(number) = self.why.turn(seen.timeline.log(), forward)
                && let Some(decision) = seen.timeline.log().decisions().find(number)
            {
                self.go_to(decision.time_s, seen, requests);
            }
        }
        for (key, step) in [
            (Key::ArrowUp, -1),
            (Key::ArrowDown, 1),
            (Key::PageUp, -20),
            (Key::PageDown, 20),
        ] {
            if take(ui, key) {
                self.select(seen, rows, step);
            }
        }
        // A key must not act on what the user does not see.
        let Some(view) = self.selected_view(seen, rows) else {
            return;
        };
        let schema = view.name.clone();
        if take(ui, Key::T) {
            self.editing.begin(&schema, view.period as f64 / 1e9);
        }
        if take(ui, Key::P) && seen.accepts_requests {
            requests.push(Request::Act(Action::Play { schema }));
        } else if take(ui, Key::S) && seen.accepts_requests {
            requests.push(Request::Act(Action::Stop { schema }));
        } else if take(ui, Key::F) && seen.accepts_requests {
            requests.push(Request::Act(Action::Force { schema }));
        } else if take(ui, Key::R) && seen.accepts_requests {
            requests.push(Request::Act(Action::Release { schema }));
        }
    }

    /// Returns the selected schema, unless its row is filtered out or folded.
    pub(super) fn selected_view<'s>(
        &self,
        seen: &Input<'s>,
        rows: &[HierarchyRow],
    ) -> Option<&'s SchemaView> {
        let schemas: &'s [SchemaView] = &seen.snapshot.schemas;
        let mut shown = rows.iter().filter_map(|row| schemas.get(row.schema()?));
        shown.find(|view| self.selected.as_ref() == Some(&view.name))
    }

    /// Moves the selection by a number of schemas, limited to the ends of the list.
    fn select(&mut self, seen: &Input<'_>, rows: &[HierarchyRow], step: isize) {
        let order: Vec<_> = rows
            .iter()
            .filter_map(|row| seen.snapshot.schemas.get(row.schema()?))
            .collect();
        let place = order
            .iter()
            .position(|view| Some(&view.name) == self.selected.as_ref());
        let next = match place {
            Some(place) => place.saturating_add_signed(step).min(order.len() - 1),
            None => 0,
        };
        if let Some(view) = order.get(next) {
            self.selected = Some(view.name.clone());
            self.reveal = true;
        }
    }
}

fn take(ui: &Ui, key: Key) -> bool {
    ui.input_mut(|input| input.consume_key(Modifiers::NONE, key))
}
