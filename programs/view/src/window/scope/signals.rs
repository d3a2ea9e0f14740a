//! Traces of shared variables below the hierarchy: found by name, drawn on the same time axis, with their
//! values at the cursors.

use std::collections::BTreeMap;
use std::path::PathBuf;

use eframe::egui::{
    Align, Key, Label, Layout, Painter, PopupCloseBehavior, Rect, RichText, Role, ScrollArea, TextEdit, Ui,
    UiBuilder, Vec2, WidgetInfo, pos2, vec2,
};
use eframe::egui::{Popup, Sense};
use jde_link::message::VariableInfo;
use jde_panel::Ink;

use super::axis::Scale;
use super::chart::{self, Chart, LINE};
use super::cursors::Cursors;
use super::field;
use super::input::Input;
use super::paint::{self, Icon};
use super::signal::Signal;
use crate::style::{self, Style};

/// Maximum number of names offered at once.
const MAX_OFFERED: usize = 100;

/// The traces.
#[derive(Debug, Default)]
pub(super) struct Signals {
    pub(super) list: Vec<Chart>,
    typed: String,
    trouble: Option<String>,
    /// The names of all numbers of all variables, computed when the menu is first opened.
    names: Vec<String>,
    colors: usize,
    /// Where the values were saved, or why they were not.
    saved: Option<String>,
}

impl Signals {
    /// Adds a chart by its text, as in `pioneer.odometry.pose.pose.position.x`. Does nothing if it exists.
    ///
    /// # Errors
    /// Why there is no such number, with the nearest existing name.
    pub(super) fn add(&mut self, name: &str, variables: &[VariableInfo]) -> Result<(), String> {
        let name = name.trim();
        if self.list.iter().any(|chart| chart.name == name) {
            return Ok(());
        }
        let chart = Chart::parse(name, variables, self.colors)?;
        self.colors += chart.signals.len();
        self.list.push(chart);
        Ok(())
    }

    /// The height that all charts need, in points.
    pub(super) fn height(&self) -> f32 {
        self.list.iter().map(Chart::height).sum()
    }

    /// Writes the values of the visible time to a new file in the present folder.
    fn save(&mut self, scale: &Scale) {
        let mut files = (1_u32..).map(|number| PathBuf::from(format!("traces-{number}.csv")));
        let file = files.find(|file| !file.exists()).unwrap_or_default();
        self.saved = Some(match std::fs::write(&file, chart::csv(&self.list, scale)) {
            Ok(()) => format!("saved in {}", file.display()),
            Err(error) => format!("{} cannot be written: {error}", file.display()),
        });
    }

    /// Adds a trace that another window requested.
    pub(super) fn add_requested(&mut self, name: &str, variables: &[VariableInfo]) {
        self.trouble = self.add(name, variables).err();
    }

    /// Shows the button that adds a trace, with a menu of names.
    pub(super) fn pick(&mut self, ui: &mut Ui, variables: &[VariableInfo], scale: &Scale, style: &Style) {
        let button = ui
            .button("+ trace")
            .on_hover_text("Plot a number of any shared variable, several in one chart, or an expression.");
        if !self.list.is_empty() {
            let save = ui.button("CSV");
            let hint = "Save the values of the visible time, as comma-separated values.";
            if save
                .on_hover_text(hint)
                .accessible_name("Save the traces as CSV")
                .clicked()
            {
                self.save(scale);
            }
        }
        if let Some(saved) = &self.saved {
            ui.add(Label::new(RichText::new(saved).weak()).extend());
        }
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
                let exact = self.names.contains(&self.typed)
                    || offered.is_empty()
                    || self.typed.contains(['[', ',', '(']);
                chosen = if exact {
                    Some(self.typed.clone())
                } else {
                    offered.first().cloned()
                };
            }
            ui.weak("a.b.c, a.b.d shares a chart; a.b.y against a.b.x; abs(a.b.c - a.b.d) * 2.0");
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
            area.show(ui, |ui| {
                for (place, chart) in self.list.iter().enumerate() {
                    let size = vec2(ui.available_width(), chart.height());
                    let (row, _) = ui.allocate_exact_size(size, Sense::hover());
                    if ui.is_rect_visible(row) && chart_row(ui, row, chart, scale, seen, cursors, style) {
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

/// Draws a chart. Returns whether it is to be removed.
fn chart_row(
    ui: &Ui,
    row: Rect,
    chart: &Chart,
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
    let remove = Rect::from_min_size(pos2(left.right() - 20.0, left.top() + 2.0), Vec2::splat(20.0));
    let is_single = chart.signals.len() == 1;
    for (place, signal) in chart.signals.iter().enumerate() {
        let top = left.top() + 4.0 + place as f32 * LINE;
        let bottom = if is_single {
            left.bottom() - 4.0
        } else {
            top + LINE - 3.0
        };
        let own = Rect::from_min_max(pos2(left.left() + 6.0, top), pos2(remove.left(), bottom));
        signal_texts(ui, &painter, own, signal, is_single, seen.now(), cursors, style);
    }
    chart.draw(
        &painter.with_clip_rect(plot.intersect(ui.clip_rect())),
        plot,
        scale,
        seen.end_s,
        style,
    );
    let label = format!("Remove trace {}", chart.name);
    let id = ui.scope_id().with(("remove", &chart.name));
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

/// Writes the name of a signal and its values: below each other if it is alone, and else in one line.
#[expect(
    clippy::too_many_arguments,
    reason = "the function shows all facts of a signal"
)]
fn signal_texts(
    ui: &Ui,
    painter: &Painter,
    area: Rect,
    signal: &Signal,
    is_single: bool,
    now: f64,
    cursors: &Cursors,
    style: &Style,
) {
    let color = paint::signal_color(signal.color, style);
    let swatch = Rect::from_min_size(area.left_top() + vec2(0.0, 2.0), vec2(4.0, area.height() - 4.0));
    painter.rect_filled(swatch, 2.0, color);
    let show = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| signal.show(value, style));
    let now_text = show(signal.present(now));
    let at_cursors = cursors.at.map(|[a, b]| {
        let (a, b) = (signal.at(a), signal.at(b));
        let difference = a.zip(b).map(|(a, b)| b - a);
        format!("A {}  B {}  B − A {}", show(a), show(b), show(difference))
    });
    let name_area = area.with_min_x(swatch.right() + 6.0);
    let row = |nth: f32| {
        let top = name_area.top() + nth * LINE;
        Rect::from_min_max(pos2(name_area.left(), top), pos2(name_area.right(), top + 16.0))
    };
    let name = ui.interact(
        row(0.0),
        ui.scope_id().with(("lane", &signal.name)),
        Sense::hover(),
    );
    name.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("trace {}: {now_text}", signal.name)));
    let seen_color = style::color_of(Ink::Seen, style);
    let plain = ui.visuals().text_color();
    if is_single {
        paint::write_name(painter, row(0.0), &signal.name, paint::font(), plain);
        paint::write(painter, row(1.0), &now_text, paint::digits(), color);
        if let Some(text) = &at_cursors {
            paint::write(painter, row(2.0), text, paint::small(), seen_color);
        }
    } else {
        let split = row(0.0).left() + 0.62 * row(0.0).width();
        paint::write_name(
            painter,
            row(0.0).with_max_x(split),
            &signal.name,
            paint::font(),
            plain,
        );
        paint::write(
            painter,
            row(0.0).with_min_x(split + 6.0),
            &now_text,
            paint::digits(),
            color,
        );
    }
    if name.hovered() {
        name.on_hover_text(
            [Some(signal.name.clone()), at_cursors]
                .into_iter()
                .flatten()
                .collect::<Vec<_>>()
                .join("\n"),
        );
    }
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
