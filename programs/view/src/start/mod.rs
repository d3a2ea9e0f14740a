//! The start page: running applications, local or where the user pointed, and recordings. A click opens one.

mod discovery;
mod present;

use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use eframe::egui;
use egui_extras::{Column, TableBuilder};
use jde_link::Reach;
use jde_link::message::{About, Network};

use crate::Opening;
use discovery::Discovered;
pub(crate) use discovery::Discovery;

/// Height of a row, in points: that of a button which stops a robot.
const ROW_HEIGHT: f32 = 32.0;

/// The user's choice.
pub(crate) enum Selection {
    /// A running application.
    Application(Box<About>),
    /// A recording.
    Recording(PathBuf),
    /// A stop of everything in a running application.
    Stop(Box<About>),
    /// The applications at an address, such as `tls/robot2:7447`.
    Address(String),
}

/// The start page.
pub(crate) struct StartPage {
    /// Why the last choice could not be opened.
    pub(crate) trouble: Option<String>,
    /// Nothing has been chosen yet: if exactly one application runs, it is opened.
    pub(crate) eager: bool,
    discovery: Discovery,
    typed: String,
    address: String,
}

impl StartPage {
    /// Starts to search, once a second until the page is dropped.
    pub(crate) fn new(ctx: &egui::Context, opening: &Opening) -> Self {
        Self {
            trouble: None,
            eager: false,
            discovery: Discovery::new(ctx, &opening.reach, &opening.recordings),
            typed: String::new(),
            address: match &opening.reach {
                Reach::Local(_) => String::new(),
                Reach::Network { endpoints, .. } => endpoints.join(" "),
            },
        }
    }

    /// The names of the applications that run, recordings aside.
    pub(crate) fn running(&self) -> Vec<String> {
        let seen = self.discovery.seen();
        let running = seen.running.iter().filter(|about| about.executor != "replay");
        running.map(|about| about.name.clone()).collect()
    }

    /// Draws the page below its bar. Returns the user's choice.
    pub(crate) fn show(&mut self, ui: &mut egui::Ui) -> Option<Selection> {
        let mut chosen = None;
        egui::CentralPanel::default().show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| {
                if let Some(trouble) = &self.trouble {
                    ui.colored_label(ui.visuals().error_fg_color, trouble);
                    ui.add_space(8.0);
                }
                let seen = self.discovery.seen();
                if seen.searched
                    && std::mem::take(&mut self.eager)
                    && let [only] = seen.running.as_slice()
                {
                    chosen = Some(Selection::Application(Box::new(only.clone())));
                }
                if !seen.running.is_empty() || !seen.recordings.is_empty() {
                    // The page shows ages, which change each second.
                    ui.ctx().request_repaint_after(Duration::from_secs(1));
                }
                ui.heading("Running applications");
                if let Some(trouble) = &seen.trouble {
                    ui.colored_label(ui.visuals().error_fg_color, trouble);
                }
                ui.push_id("running", |ui| chosen = chosen.take().or(running(ui, &seen)));
                ui.add_space(8.0);
                let address = typed(
                    ui,
                    "Another machine:",
                    "tls/robot2:7447",
                    "Connect",
                    &mut self.address,
                );
                chosen = chosen.take().or(address.map(Selection::Address));
                ui.add_space(16.0);
                ui.heading("Recordings");
                ui.push_id("recordings", |ui| {
                    chosen = chosen.take().or(recordings(ui, &seen))
                });
                drop(seen);
                ui.add_space(8.0);
                let file = typed(ui, "Another recording:", "drive.mcap", "Open", &mut self.typed);
                let file = file.filter(|file| !file.is_empty());
                chosen = chosen
                    .take()
                    .or(file.map(|file| Selection::Recording(PathBuf::from(file))));
            });
        });
        let dropped = ui.input(|input| {
            input
                .raw
                .dropped_files
                .iter()
                .map(|file| file.path().to_owned())
                .next()
        });
        chosen.or(dropped.map(Selection::Recording))
    }
}

/// A field with its name and a button. Returns its text when the button or Enter is pressed.
fn typed(ui: &mut egui::Ui, name: &str, hint: &str, button: &str, text: &mut String) -> Option<String> {
    ui.horizontal(|ui| {
        let label = ui.label(name);
        let field = egui::TextEdit::singleline(text)
            .hint_text(hint)
            .desired_width(320.0);
        let field = ui.add(field).labelled_by(label.id);
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        (ui.button(button).clicked() || entered).then(|| text.trim().to_owned())
    })
    .inner
}

fn running(ui: &mut egui::Ui, seen: &Discovered) -> Option<Selection> {
    if seen.running.is_empty() {
        if seen.searched {
            ui.label("There is no running application that you may open. In a terminal:");
            ui.code("jde demo");
            ui.code("jde run apps/safe-navigation.toml");
            ui.label("The application is then listed on this page.");
        } else {
            ui.spinner();
        }
        return None;
    }
    let mut chosen = None;
    table(
        ui,
        &[
            "Name",
            "Who acts",
            "Mission",
            "Battery",
            "",
            "Where",
            "Since",
            "Clients from the network",
        ],
        seen.running.len(),
        |row, column, ui| {
            let about = &seen.running[row];
            let present = seen.present.get(&about.id);
            match column {
                0 => {
                    let hint = format!("Opens its windows.\n{}, {}", about.application, about.file);
                    if ui.link(&about.name).on_hover_text(hint).clicked() {
                        chosen = Some(Selection::Application(Box::new(about.clone())));
                    }
                }
                1 if about.executor == "replay" => drop(ui.weak("a recording")),
                1 => drop(ui.label(present.map_or("...", |present| present.acting.as_str()))),
                2 => drop(ui.label(present.map_or("", |present| present.mission.as_str()))),
                3 => drop(ui.label(present.map_or("", |present| present.battery.as_str()))),
                4 if about.executor == "replay" => {}
                4 => {
                    let button = ui
                        .add(egui::Button::new("Stop").min_size(egui::vec2(56.0, ROW_HEIGHT)))
                        .on_hover_text("Stops all of this application; the actuators brake.");
                    let name = format!("stop {}", about.name);
                    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                    if button.clicked() {
                        chosen = Some(Selection::Stop(Box::new(about.clone())));
                    }
                }
                5 => drop(ui.label(format!("{}@{}", about.user, about.host))),
                6 => drop(ui.label(ago(UNIX_EPOCH + Duration::from_nanos(about.started_ns)))),
                _ => drop(ui.label(match about.network {
                    Network::Closed => "have no access",
                    Network::Read => "may observe",
                    Network::Operate => "may observe and operate",
                })),
            }
        },
    );
    chosen
}

fn recordings(ui: &mut egui::Ui, seen: &Discovered) -> Option<Selection> {
    if seen.recordings.is_empty() {
        if seen.searched {
            ui.label("There are no recordings. Record a drive with");
            ui.code("jde run apps/safe-navigation.toml --record drive.mcap");
            ui.label("A file can also be dropped on this window.");
        }
        return None;
    }
    let mut chosen = None;
    table(
        ui,
        &["File", "Size", "Written"],
        seen.recordings.len(),
        |row, column, ui| {
            let file = &seen.recordings[row];
            match column {
                0 => {
                    let name = file.path.file_name().unwrap_or_default().to_string_lossy();
                    let link = ui.link(name).on_hover_text(file.path.display().to_string());
                    if link.clicked() {
                        chosen = Some(Selection::Recording(file.path.clone()));
                    }
                }
                1 => drop(ui.label(size(file.bytes))),
                _ => drop(ui.label(ago(file.written))),
            }
        },
    );
    chosen
}

fn table(ui: &mut egui::Ui, head: &[&str], rows: usize, mut cell: impl FnMut(usize, usize, &mut egui::Ui)) {
    ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
    let mut table = TableBuilder::new(ui)
        .striped(true)
        .vscroll(false)
        .cell_layout(egui::Layout::left_to_right(egui::Align::Center));
    for _ in head {
        table = table.column(Column::auto().at_least(90.0));
    }
    table
        .header(20.0, |mut header| {
            for title in head {
                header.col(|ui| drop(ui.weak(*title)));
            }
        })
        .body(|body| {
            body.rows(ROW_HEIGHT, rows, |mut row| {
                let place = row.index();
                for column in 0..head.len() {
                    row.col(|ui| cell(place, column, ui));
                }
            });
        });
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1_000 => format!("{bytes} B"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

fn ago(then: SystemTime) -> String {
    let seconds = SystemTime::now()
        .duration_since(then)
        .unwrap_or_default()
        .as_secs();
    match seconds {
        0..60 => format!("{seconds} s ago"),
        60..3_600 => format!("{} min ago", seconds / 60),
        3_600..86_400 => format!("{} h ago", seconds / 3_600),
        _ => format!("{} days ago", seconds / 86_400),
    }
}
