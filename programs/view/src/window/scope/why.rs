//! The reasons of switches: the list of switches, and the description of the opened record (R15).

use eframe::egui::{Grid, Rect, RichText, Role, ScrollArea, Sense, Ui, Vec2, WidgetInfo, vec2};
use jde_core::Case;
use jde_panel::Ink;
use jde_records::Decision;
use jde_records::snapshot::GroupView;
use jde_timeline::{RecordLog, Timeline};

use super::input::Input;
use super::paint;
use crate::style::{self, Style, time};

/// Least width of a switch in the list for its case, in points.
const MIN_WIDTH_WITH_CASE: f32 = 280.0;

/// The list of switches and the opened record.
#[derive(Debug, Default)]
pub(super) struct SwitchDetails {
    /// The number of the opened selection. `None` shows the newest.
    opened: Option<u64>,
    /// Whether selections without a switch are listed too.
    all: bool,
    /// Scroll the list to the opened record.
    scroll: bool,
}

impl SwitchDetails {
    /// Opens the record of a selection, by its number.
    pub(super) fn open(&mut self, number: u64) {
        (self.opened, self.scroll) = (Some(number), true);
    }

    /// Opens the record of a time in s, if there is one.
    pub(super) fn open_at(&mut self, log: &RecordLog, at: f64) {
        // The times may differ by the conversion from ns.
        let place = log
            .decisions()
            .partition_point(|decision| decision.time_s < at - 1e-6);
        if let Some(decision) = log.decisions().get(place)
            && decision.time_s <= at + 1e-6
        {
            self.open(decision.number);
        }
    }

    /// The number of the selection that the user opened.
    pub(super) fn opened(&self) -> Option<u64> {
        self.opened
    }

    /// Opens the next or previous switch. Returns its number.
    pub(super) fn turn(&mut self, log: &RecordLog, forward: bool) -> Option<u64> {
        let switches = log.switches();
        let newest = *switches.back()?;
        let place = switches.partition_point(|number| *number < self.opened.unwrap_or(newest));
        let exact = switches.get(place) == self.opened.as_ref().or(Some(&newest));
        let next = match (forward, exact) {
            (true, true) => place + 1,
            (true, false) => place,
            (false, _) => place.checked_sub(1)?,
        };
        let number = *switches.get(next)?;
        self.open(number);
        Some(number)
    }

    /// Draws the list and the record. Returns a time in s that the axis must show.
    pub(super) fn show(&mut self, ui: &mut Ui, seen: &Input<'_>, style: &Style) -> Option<f64> {
        let mut reveal = None;
        let log = seen.timeline.log();
        ui.horizontal(|ui| {
            ui.strong("Why");
            for (text, forward, tip) in [
                ("Previous", false, "The previous switch (left arrow)."),
                ("Next", true, "The next switch (right arrow)."),
            ] {
                if ui.button(text).on_hover_text(tip).clicked()
                    && let Some(number) = self.turn(log, forward)
                {
                    reveal = log.decisions().find(number).map(|decision| decision.time_s);
                }
            }
            let newest = ui.selectable_label(self.opened.is_none(), "Newest");
            if newest.on_hover_text("Shows each new switch.").clicked() {
                self.opened = None;
            }
            ui.checkbox(&mut self.all, "selections without a switch")
                .on_hover_text(
                    "A group selects after each iteration of its winner. Most selections do not change the winner.",
                );
            if seen.timeline.missed() > 0 {
                let text = match seen.timeline.missed() {
                    1 => "1 line was lost".to_owned(),
                    missed => format!("{missed} lines were lost"),
                };
                ui.label(RichText::new(text).color(style::color_of(Ink::Warn, style)))
                    .on_hover_text("The network or this machine was too slow.");
            }
        });
        let rect = ui.available_rect_before_wrap();
        let left = rect.with_max_x(rect.left() + (rect.width() * 0.42).clamp(180.0, 420.0));
        let right = rect.with_min_x(left.right() + 10.0);
        ui.scope_builder(eframe::egui::UiBuilder::new().max_rect(left), |ui| {
            if let Some(time) = self.list(ui, seen, style) {
                reveal = Some(time);
            }
        });
        ui.scope_builder(eframe::egui::UiBuilder::new().max_rect(right), |ui| {
            ScrollArea::vertical()
                .id_salt("record")
                .auto_shrink(false)
                .show(ui, |ui| {
                    let number = self.shown(seen);
                    match number.map(|number| (number, log.decisions().find(number))) {
                        None => {
                            ui.weak(
                                "No group has changed its winner yet. The reason of each change is shown here.",
                            );
                        }
                        Some((_, Some(decision))) => record(ui, decision, seen, style),
                        Some((number, None)) => {
                            ui.weak(format!("The record of selection {number} is no longer kept."));
                        }
                    }
                });
        });
        reveal
    }

    /// The number of the selection that is described: the opened one, or the last switch until the present.
    fn shown(&self, seen: &Input<'_>) -> Option<u64> {
        let log = seen.timeline.log();
        let newest = || {
            // A record may be newer than the newest snapshot.
            if !seen.is_recording {
                return log.switches().back().copied();
            }
            let is_past = |number: &u64| {
                let decision = log.decisions().find(*number);
                decision.is_some_and(|decision| decision.time_s <= seen.now())
            };
            let past = log.switches().partition_point(is_past);
            log.switches().get(past.checked_sub(1)?).copied()
        };
        self.opened.or_else(newest)
    }

    fn list(&mut self, ui: &mut Ui, seen: &Input<'_>, style: &Style) -> Option<f64> {
        let (timeline, log) = (seen.timeline, seen.timeline.log());
        let (count, switches) = if self.all {
            (log.decisions().len(), None)
        } else {
            (log.switches().len(), Some(log.switches()))
        };
        let get = |row: usize| {
            // Newest first.
            let place = count - 1 - row;
            match switches {
                Some(switches) => log.decisions().find(switches[place]),
                None => log.decisions().get(place),
            }
        };
        let shown = self.shown(seen);
        let mut reveal = None;
        let height = 18.0;
        ui.spacing_mut().item_spacing = Vec2::ZERO;
        let mut area = ScrollArea::vertical().id_salt("switches").auto_shrink(false);
        if std::mem::take(&mut self.scroll)
            && let Some(number) = shown
        {
            let place = match switches {
                Some(switches) => switches.partition_point(|candidate| *candidate < number),
                None => log
                    .decisions()
                    .partition_point(|candidate| candidate.number < number),
            };
            let from_top = (count.saturating_sub(place + 1)) as f32 * height;
            area = area.vertical_scroll_offset((from_top - ui.available_height() / 2.0).max(0.0));
        }
        area.show_rows(ui, height, count, |ui, range| {
            for row in range {
                let (rect, response) =
                    ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::click());
                let Some(decision) = get(row) else { continue };
                let is_opened = shown == Some(decision.number);
                line(ui, rect, timeline, decision, is_opened, style);
                response.widget_info(|| WidgetInfo::labeled(Role::Button, true, summary(decision)));
                if response.clicked() {
                    self.opened = Some(decision.number);
                    reveal = Some(decision.time_s);
                }
            }
        });
        reveal
    }
}

/// A selection in one line: `4.000 s  example/base: goon › vff`.
fn summary(decision: &Decision) -> String {
    let choice = if decision.changed {
        format!("{} › {}", decision.before_name(), decision.choice_name())
    } else {
        format!("{} stays", decision.choice_name())
    };
    format!("{:.3} s  {}: {choice}", decision.time_s, decision.group)
}

fn line(ui: &Ui, rect: Rect, timeline: &Timeline, decision: &Decision, opened: bool, style: &Style) {
    if opened {
        let ground = ui.visuals().selection.bg_fill.gamma_multiply(0.35);
        ui.painter().rect_filled(rect, 2.0, ground);
    }
    let color = if decision.changed {
        ui.visuals().text_color()
    } else {
        ui.visuals().weak_text_color()
    };
    let inside = rect.shrink2(vec2(4.0, 0.0));
    // In a narrow list, the schemas are more important than the case, which the record has.
    if inside.width() < MIN_WIDTH_WITH_CASE {
        paint::write(ui.painter(), inside, &summary(decision), paint::font(), color);
        return;
    }
    let case = Rect::from_min_max(inside.right_top() - vec2(58.0, 0.0), inside.right_bottom());
    let text = inside.with_max_x(case.left());
    paint::write(ui.painter(), text, &summary(decision), paint::font(), color);
    paint::write(
        ui.painter(),
        case,
        timeline.case_word(decision),
        paint::small(),
        case_color(timeline, decision, style),
    );
}

/// Several that are ready are as usual as one. Nobody to drive is worth a look, unless the robot has arrived.
fn case_color(timeline: &Timeline, decision: &Decision, style: &Style) -> eframe::egui::Color32 {
    let color = match decision.case {
        Case::Alone | Case::Collision => Ink::Faint,
        Case::Absence if timeline.is_arrival(decision) => Ink::Good,
        Case::Absence => Ink::Warn,
        Case::Forced => Ink::Goal,
    };
    style::color_of(color, style)
}

/// Describes a record.
fn record(ui: &mut Ui, decision: &Decision, seen: &Input<'_>, style: &Style) {
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.horizontal_wrapped(|ui| {
        ui.label(RichText::new(summary(decision)).strong());
        let case = format!("{}: {}", seen.timeline.case_word(decision), decision.case_text());
        ui.label(RichText::new(case).color(case_color(seen.timeline, decision, style)));
    });
    let facts = |ui: &mut Ui| {
        ui.label(format!("Because: {}", decision.reason));
        ui.label(format!("Decided by: {}", decision.decider_text()));
        ui.label(format!("Cause: {}", decision.cause));
        takeover(ui, decision, seen, style);
    };
    // Side by side if there is space, which avoids scrolling.
    if ui.available_width() > 620.0 {
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| candidates(ui, decision, style));
            ui.add_space(16.0);
            ui.vertical(facts);
        });
    } else {
        candidates(ui, decision, style);
        facts(ui);
    }
}

fn candidates(ui: &mut Ui, decision: &Decision, style: &Style) {
    if decision.candidates.is_empty() {
        ui.weak("No candidate was awake.");
        return;
    }
    let grid = Grid::new("candidates")
        .num_columns(5)
        .spacing(vec2(14.0, 1.0))
        .striped(true)
        .min_row_height(17.0);
    grid.show(ui, |ui| {
        for title in ["candidate", "precondition", "urgency", "was", ""] {
            ui.weak(title);
        }
        ui.end_row();
        for candidate in &decision.candidates {
            let chosen = decision.choice.as_ref() == Some(&candidate.name);
            let name = RichText::new(&candidate.name);
            ui.label(if chosen { name.strong() } else { name });
            let refusal = decision.refusal_of(&candidate.name);
            let (precondition, color) = match (candidate.ready, &refusal) {
                (true, _) => ("holds", Ink::Good),
                (false, Some(_)) => ("refused by a guard", Ink::Bad),
                (false, None) => ("does not hold", Ink::Faint),
            };
            let label = ui.label(RichText::new(precondition).color(style::color_of(color, style)));
            if let Some(refusal) = refusal {
                label.on_hover_text(refusal);
            }
            let urgency = candidate
                .urgency
                .map_or_else(|| "no number".to_owned(), |urgency| format!("{urgency:.3}"));
            ui.label(urgency);
            ui.label(candidate.state.name());
            let result = if chosen { "wins" } else { "" };
            ui.label(RichText::new(result).color(style::color_of(Ink::Good, style)));
            ui.end_row();
        }
    });
}

/// Shows how long the takeover took, with the limit of the group's contract (R17).
fn takeover(ui: &mut Ui, decision: &Decision, seen: &Input<'_>, style: &Style) {
    let allowed = seen
        .snapshot
        .groups
        .iter()
        .find(|group| group.name == decision.group)
        .map(|GroupView { allowed, .. }| *allowed as f64 / 1e9)
        // Of a group without a contract, and of recordings without their hierarchy, there is none.
        .filter(|allowed| *allowed > 0.0);
    let took = decision.takeover_us.map(|took| took / 1e6);
    let of = allowed.map_or_else(String::new, |allowed| {
        format!(" of {} allowed", time::span(allowed))
    });
    let (text, color) = match (took, decision.changed) {
        (Some(took), _) if allowed.is_some_and(|allowed| took > allowed) => (
            format!("Took over in {}{of}: too late", time::span(took)),
            Ink::Bad,
        ),
        (Some(took), _) => (format!("Took over in {}{of}", time::span(took)), Ink::Plain),
        (None, true) if decision.choice.is_none() => ("No schema took over".to_owned(), Ink::Faint),
        (None, true) => (
            "Not carried out: another choice replaced it".to_owned(),
            Ink::Faint,
        ),
        (None, false) => ("Nothing changed".to_owned(), Ink::Faint),
    };
    ui.label(RichText::new(text).color(style::color_of(color, style)));
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    #[test]
    fn previous_and_next_step_through_the_switches_and_stop_at_the_ends() {
        let fixed = fixture::navigation();
        let log = fixed.timeline.log();
        let mut details = SwitchDetails::default();
        let backward: Vec<_> = (0..5).map(|_| details.turn(log, false)).collect();
        assert_eq!(backward, [Some(3), Some(2), Some(1), None, None]);
        let forward_numbers: Vec<_> = (0..4).map(|_| details.turn(log, true)).collect();
        assert_eq!(forward_numbers, [Some(2), Some(3), Some(4), None]);
        assert_eq!(details.opened(), Some(4));
    }
}
