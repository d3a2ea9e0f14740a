//! The left half of a group's row: its policy, winner, switches, and its worst takeover with the limit of its
//! contract.

use eframe::egui::{Rect, Role, Sense, Ui, WidgetInfo, pos2};
use jde_panel::Ink;
use jde_records::snapshot::GroupView;

use super::input::Input;
use super::paint;
use super::table::{INDENT, Table};
use crate::style::{self, Style, time};

impl Table {
    /// Draws a group: its policy, winner, switches, and its worst takeover with the limit of its contract.
    pub(super) fn group(
        &self,
        ui: &Ui,
        rect: Rect,
        seen: &Input<'_>,
        group: &GroupView,
        depth: usize,
        style: &Style,
    ) {
        let winner = group
            .winner
            .and_then(|winner| seen.snapshot.schemas.get(winner))
            .map_or("nobody", |winner| &winner.name);
        let takeover = takeover(group);
        let late = takeover.is_some() && group.worst > group.allowed;
        let facts = facts(group, winner, takeover.as_deref());
        let left = self.left + 6.0 + depth as f32 * INDENT;
        let area = Rect::from_min_max(pos2(left, rect.top()), pos2(self.right - 4.0, rect.bottom()));
        let response = ui.interact(area, ui.scope_id().with(("group", &group.name)), Sense::hover());
        response.widget_info(|| {
            let text = format!("group {}: {facts}", group.name);
            WidgetInfo::labeled(Role::Label, true, text)
        });
        let accent = style::color_of(Ink::Accent, style);
        let end = paint::write_name(ui.painter(), area, &group.name, paint::font(), accent);
        let rest = area.with_min_x((end + 8.0).min(area.right()));
        let color = if late {
            style::color_of(Ink::Bad, style)
        } else {
            ui.visuals().weak_text_color()
        };
        paint::write(ui.painter(), rest, &facts, paint::small(), color);
        if response.hovered() {
            let members = group
                .members
                .iter()
                .filter_map(|&member| seen.snapshot.schemas.get(member))
                .map(|member| member.name.as_str())
                .collect::<Vec<_>>()
                .join(", ");
            let mut tip = format!("{}\nMembers, of which one wins: {members}", group.name);
            if !group.policy.is_empty() {
                tip += &format!("\nPolicy: {}", group.policy);
            }
            tip += &format!("\nWinner: {winner}\nSwitches: {}", group.switches);
            if let Some(takeover) = takeover {
                tip += &format!("\nWorst takeover: {takeover} allowed by its contract (R17)");
            }
            response.on_hover_text(tip);
        }
    }
}

/// Describes a group in one line. In a recording, the policy and the contract may be unknown.
fn facts(group: &GroupView, winner: &str, takeover: Option<&str>) -> String {
    let switches = match group.switches {
        1 => "1 switch".to_owned(),
        switches => format!("{switches} switches"),
    };
    let policy = (!group.policy.is_empty()).then(|| group.policy.clone());
    let winner = format!("{winner} wins");
    let takeover = takeover.map(|takeover| format!("worst takeover {takeover}"));
    let parts: Vec<_> = [policy, Some(winner), Some(switches), takeover]
        .into_iter()
        .flatten()
        .collect();
    parts.join(" · ")
}

/// The worst takeover and the contract's limit, as text. `None` without a contract.
fn takeover(group: &GroupView) -> Option<String> {
    let span = |nanos: u64| time::span(nanos as f64 / 1e9);
    (group.allowed > 0).then(|| format!("{} of {}", span(group.worst), span(group.allowed)))
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    #[test]
    fn the_description_of_a_group_omits_unknown_facts() {
        let mut group = fixture::group("roots", None, &[0]);
        let described = |group: &GroupView| facts(group, "goon", takeover(group).as_deref());
        assert_eq!(
            described(&group),
            "priority · goon wins · 3 switches · worst takeover 1.24 ms of 85.0 ms"
        );
        (group.policy, group.allowed, group.switches) = (String::new(), 0, 1);
        assert_eq!(described(&group), "goon wins · 1 switch");
    }
}
