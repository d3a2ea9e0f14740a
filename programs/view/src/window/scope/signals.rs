//! Traces of shared variables below the hierarchy: found by name, drawn on the same time axis, with their
//! values at the cursors.

use std::collections::BTreeMap;

use eframe::egui::{
    Align, Key, Layout, PopupCloseBehavior, Rect, RichText, Role, ScrollArea, TextEdit, Ui, UiBuilder, Vec2,
    WidgetInfo, pos2, vec2,
};
use eframe::egui::{Popup, Sense};
use jde_link::message::VariableInfo;
use jde_panel::Ink;

use super::axis::Scale;
use super::cursors::Cursors;
use super::field;
use super::input::Input;
use super::paint::{self, Icon};
use super::signal::Signal;
use crate::style::{self, Style};

/// Height of a signal's row, in points.
pub(super) const ROW_HEIGHT: f32 = 58.0;
/// Maximum number of names offered at once.
const MAX_OFFERED: usize = 100;

/// The traces.
#[derive(Debug, Default)]
pub(super) struct Signals {
    pub(super) list: Vec<Signal>,
    typed: String,
    trouble: Option<String>,
    /// The names of all numbers of all variables, computed when the menu is first opened.
    names: Vec<String>,
    colors: usize,
}

impl Signals {
    /// Adds a trace by its name, as in `pioneer.odometry.pose.pose.position.x`. Does nothing if it exists.
    ///
    /// # Errors
    /// Why there is no such number, with the nearest existing name.
    pub(super) fn add(&mut self, name: &str, variables: &[VariableInfo]) -> Result<(), String> {
        let name = name.trim();
        if self.list.iter().any(|signal| signal.name == name) {
            return Ok(());
        }
        let fits = |variable: &&VariableInfo| {
            name.strip_prefix(&variable.name)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        // The longest match, as one variable's name may be the prefix of another's.
        let variable = variables
            .iter()
            .filter(fits)
            .max_by_key(|variable| variable.name.len());
        let variable = variable.ok_or_else(|| {
            let start: Vec<_> = name.splitn(3, '.').take(2).collect();
            let nearest = jde_nearest::nearest(
                &start.join("."),
                variables.iter().map(|variable| variable.name.as_str()),
            );
            let nearest = nearest.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            format!("there is no variable `{name}`{nearest}")
        })?;
        let value_type = variable.value_type().map_err(|error| error.to_string())?;
        let path = name[variable.name.len()..].trim_start_matches('.');
        let mut place = field::find(&value_type, path)?;
        if place.unit.is_empty() {
            place.unit.clone_from(&variable.unit);
        }
        let signal = Signal::new(name.to_owned(), variable.name.clone(), Ok(place), self.colors);
        self.colors += 1;
        self.list.push(signal);
        Ok(())
    }

    /// Adds a trace that another window requested.
    pub(super) fn add_requested(&mut self, name: &str, variables: &[VariableInfo]) {
        self.trouble = self.add(name, variables).err();
    }

    /// Shows the button that adds a trace, with a menu of names.
    pub(super) fn pick(&mut self, ui: &mut Ui, variables: &[VariableInfo], style: &Style) {
        let button = ui
            .button("+ trace")
            .on_hover_text("Plot a number of any shared variable.");
        let menu = Popup::menu(&button).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
        menu.show(|ui| {
            ui.set_width(380.0);
            if self.names.is_empty() {
                self.names = names(variables);
            }
            let hint = "variable and field, as in pioneer.odometry…";
            let field = TextEdit::singleline(&mut self.typed)
                .hint_text(hint)
                .desired_width(f32::INFINITY);
            let response = ui.add(field).accessible_name("Name of the trace");
            if button.clicked() {
                response.request_focus();
            }
            let entered = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let search_words: Vec<_> = self.typed.split_whitespace().map(str::to_lowercase).collect();
            let fits = |name: &&String| {
                let name = name.to_lowercase();
                search_words.iter().all(|word| name.contains(word))
            };
            let offered: Vec<_> = self
                .names
                .iter()
                .filter(fits)
                .take(MAX_OFFERED)
                .cloned()
                .collect();
            let mut chosen = None;
            if entered {
                let exact =
                    self.names.contains(&self.typed) || offered.is_empty() || self.typed.contains('[');
                chosen = if exact {
                    Some(self.typed.clone())
                } else {
                    offered.first().cloned()
                };
            }
            if let Some(trouble) = &self.trouble {
                ui.label(RichText::new(trouble).color(style::color_of(Ink::Bad, style)));
            }
            let list = ScrollArea::vertical()
                .max_height(260.0)
                .auto_shrink([false, true]);
            list.show(ui, |ui| {
                for name in offered {
                    if ui.selectable_label(false, &name).clicked() {
                        chosen = Some(name);
                    }
                }
            });
            if let Some(chosen) = chosen {
                self.trouble = self.add(&chosen, variables).err();
                if self.trouble.is_none() {
                    self.typed.clear();
                    ui.close();
                }
            }
        });
    }

    /// Draws the traces one below the other, with their names left of the time axis.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        scale: &Scale,
        seen: &Input<'_>,
        cursors: &Cursors,
        style: &Style,
    ) {
        let mut removed = None;
        let inside = UiBuilder::new()
            .max_rect(rect)
            .layout(Layout::top_down(Align::Min));
        ui.scope_builder(inside, |ui| {
            ui.set_clip_rect(rect.intersect(ui.clip_rect()));
            ui.spacing_mut().item_spacing = Vec2::ZERO;
            let area = ScrollArea::vertical().id_salt("lanes").auto_shrink(false);
            area.show_rows(ui, ROW_HEIGHT, self.list.len(), |ui, range| {
                for place in range {
                    let (row, _) =
                        ui.allocate_exact_size(vec2(ui.available_width(), ROW_HEIGHT), Sense::hover());
                    if signal_row(ui, row, &self.list[place], scale, seen, cursors, style) {
                        removed = Some(place);
                    }
                }
            });
        });
        if let Some(removed) = removed {
            self.list.remove(removed);
        }
    }
}

/// Draws a trace. Returns whether it is to be removed.
fn signal_row(
    ui: &Ui,
    row: Rect,
    signal: &Signal,
    scale: &Scale,
    seen: &Input<'_>,
    cursors: &Cursors,
    style: &Style,
) -> bool {
    let painter = ui.painter().with_clip_rect(row.intersect(ui.clip_rect()));
    let line = ui.visuals().widgets.noninteractive.bg_stroke;
    painter.hline(row.x_range(), row.top(), line);
    let plot = Rect::from_x_y_ranges(scale.x, row.y_range()).shrink2(vec2(0.0, 3.0));
    let left = Rect::from_min_max(row.left_top(), pos2(scale.x.min - 6.0, row.bottom()));
    let swatch = Rect::from_min_size(left.left_top() + vec2(6.0, 8.0), vec2(4.0, ROW_HEIGHT - 16.0));
    painter.rect_filled(swatch, 2.0, paint::signal_color(signal.color, style));
    let remove = Rect::from_min_size(pos2(left.right() - 20.0, left.top() + 2.0), Vec2::splat(20.0));
    let name_area = Rect::from_min_max(
        pos2(swatch.right() + 6.0, left.top() + 4.0),
        pos2(remove.left(), left.bottom()),
    );
    let rows = |nth: f32| {
        let top = name_area.top() + nth * 17.0;
        Rect::from_min_max(pos2(name_area.left(), top), pos2(name_area.right(), top + 16.0))
    };
    let now_text = signal
        .present(seen.now())
        .map_or_else(|| "–".to_owned(), |value| signal.show(value, style));
    let name = ui.interact(
        rows(0.0),
        ui.scope_id().with(("lane", &signal.name)),
        Sense::hover(),
    );
    name.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("trace {}: {now_text}", signal.name)));
    paint::write_name(
        &painter,
        rows(0.0),
        &signal.name,
        paint::font(),
        ui.visuals().text_color(),
    );
    paint::write(
        &painter,
        rows(1.0),
        &now_text,
        paint::digits(),
        paint::signal_color(signal.color, style),
    );
    if let Some([a, b]) = cursors.at {
        let show =
            |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| signal.show(value, style));
        let (a, b) = (signal.at(a), signal.at(b));
        let difference = a.zip(b).map(|(a, b)| b - a);
        let values_text = format!("A {}  B {}  B − A {}", show(a), show(b), show(difference));
        paint::write(
            &painter,
            rows(2.0),
            &values_text,
            paint::small(),
            style::color_of(Ink::Seen, style),
        );
    }
    if name.hovered() {
        name.on_hover_text(&signal.name);
    }
    signal.draw(
        &painter.with_clip_rect(plot.intersect(ui.clip_rect())),
        plot,
        scale,
        seen.end_s,
        style,
    );
    let label = format!("Remove trace {}", signal.name);
    let id = ui.scope_id().with(("remove", &signal.name));
    paint::button(
        ui,
        remove,
        id,
        Icon::Remove,
        (&label, "Remove this trace."),
        (true, false),
    )
    .clicked()
}

/// The names of all numbers of all variables.
fn names(variables: &[VariableInfo]) -> Vec<String> {
    let mut known = BTreeMap::new();
    let mut names = Vec::new();
    for variable in variables {
        let paths = known.entry(&variable.type_name).or_insert_with(|| {
            variable
                .value_type()
                .map_or_else(|_| Vec::new(), |value_type| field::list(&value_type))
        });
        for path in paths {
            names.push(if path.is_empty() {
                variable.name.clone()
            } else {
                format!("{}.{path}", variable.name)
            });
        }
    }
    names
}
