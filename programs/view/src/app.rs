//! The main window: the start page, or the windows on one application. It owns no robot: it may be closed at
//! any time.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use eframe::egui;
use jde_link::{Client, Folders, Reach, complete_endpoint};

use crate::graphics_card::{self, DeviceLoss};
use crate::keys::KeyList;
use crate::player::Player;
use crate::recorder::Recorder;
use crate::screen;
use crate::session::WindowSession;
use crate::settings::{SettingsStore, WindowSettings};
use crate::start::{Selection, StartPage};
use crate::stop::{self, StopTarget, Stops};
use crate::style::Style;
use crate::ui_renderer;
use crate::window::space::{self, Quality};
use crate::workspace::{Navigation, Workspace, appearance_menu};
use crate::{Error, Opening};

/// The name of the settings file.
const SETTINGS: &str = "settings";

pub(crate) fn run(opening: Opening) -> Result<(), Error> {
    if !crate::has_screen() {
        return Err(Error::NoScreen);
    }
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("jde")
            .with_title("jde")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([480.0, 320.0]),
        ..eframe::NativeOptions::default()
    };
    let lost = DeviceLoss::default();
    let watched = lost.clone();
    let build: eframe::AppCreator<'_> = Box::new(move |context| {
        if let Some(card) = &context.wgpu_render_state {
            let effort = Quality::of(card);
            space::offer(&context.egui_ctx, card, effort);
            watched.watch(&context.egui_ctx, card);
            ui_renderer::take_over(&context.egui_ctx, card, effort);
        }
        let mut app = App::new(&context.egui_ctx, opening, SettingsStore::of_user());
        app.lost = watched;
        Ok(Box::new(app))
    });
    let ended = screen::hold(|| eframe::run_native("jde", options, build));
    match (lost.reason(), ended) {
        (Some(reason), _) => Err(Error::Lost(reason.to_owned())),
        (None, Err(reason)) => Err(Error::Taken(reason)),
        (None, Ok(ended)) => ended.map_err(|error| graphics_card::refused(&error)),
    }
}

/// The main window's content.
pub(crate) struct App {
    opening: Opening,
    settings: WindowSettings,
    /// The settings as last written.
    saved: WindowSettings,
    store: SettingsStore,
    page: Page,
    /// The windows that the user left for the start page. They go on receiving.
    left: Option<Box<Workspace>>,
    stops: Stops,
    keys: KeyList,
    lost: DeviceLoss,
}

enum Page {
    /// Running applications and recordings.
    Start(StartPage),
    /// Searches for an application and connects to it.
    Connecting {
        name: String,
        /// The application; `None` for a recording.
        application: Option<String>,
        opened: Receiver<Opened>,
        _cancel: Cancel,
    },
    /// The windows on one application.
    Open(Box<Workspace>),
}

/// Cancels the search for an application when dropped.
#[derive(Default)]
struct Cancel(Arc<AtomicBool>);

impl Drop for Cancel {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The result of opening an application.
type Opened = Result<(WindowSession, Option<Player>), String>;

impl App {
    pub(crate) fn new(ctx: &egui::Context, opening: Opening, store: SettingsStore) -> Self {
        let settings: WindowSettings = store.take(SETTINGS).unwrap_or_default();
        settings.begin(ctx);
        let mut app = Self {
            page: Page::Start(StartPage::new(ctx, &opening)),
            opening,
            saved: settings.clone(),
            settings,
            store,
            left: None,
            stops: Stops::default(),
            keys: KeyList::default(),
            lost: DeviceLoss::default(),
        };
        if let Some(file) = app.opening.recording.clone() {
            app.play(ctx, file);
        } else if let Some(name) = app.opening.application.clone() {
            app.connect(ctx, name);
        } else if let Page::Start(start) = &mut app.page {
            start.eager = true;
        }
        app
    }

    /// Draws one frame.
    pub(crate) fn frame(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        if self.lost.reason().is_some() {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        let style = Style::of(&ctx, self.settings.units);
        if let Page::Open(workspace) = &mut self.page {
            workspace.begin_frame();
        }
        if let Some(left) = &mut self.left {
            left.begin_frame();
        }
        let target = self.page.stop_target();
        let mut next = self.bar(ui, target.as_ref());
        let shows_stops = matches!(self.page, Page::Open(_));
        self.stops.show(ui, !shows_stops);
        let stopping = target.is_some_and(|target| self.stops.is_pending(&target));
        match &mut self.page {
            Page::Start(start) => next = start.show(ui).map(Next::Chosen),
            Page::Connecting { name, opened, .. } => match opened.try_recv() {
                Ok(Ok(opened)) => next = Some(Next::Workspace(Box::new(opened))),
                Ok(Err(reason)) => next = Some(Next::Start(Some(reason))),
                Err(TryRecvError::Disconnected) => {
                    next = Some(Next::Start(Some(format!("{name} was not opened"))));
                }
                Err(TryRecvError::Empty) => {
                    if connecting(ui, name) {
                        next = Some(Next::Start(None));
                    }
                }
            },
            Page::Open(workspace) => workspace.show(ui, &style, stopping),
        }
        self.keys.show(&ctx);
        if self.settings != self.saved {
            self.saved = self.settings.clone();
            self.store.keep(SETTINGS, &self.saved);
        }
        match next {
            None => {}
            Some(Next::Chosen(Selection::Stop(about))) => {
                self.stop(&ctx, StopTarget::One(format!("{}@{}", about.name, about.id)));
            }
            Some(Next::Chosen(Selection::Address(address))) => self.reach(&ctx, &address),
            Some(Next::Chosen(selection)) => {
                let is_chosen = |left: &mut Box<Workspace>| match &selection {
                    Selection::Application(about) => left.session().about().id == about.id,
                    Selection::Recording(file) => left.recording() == Some(file),
                    Selection::Stop(_) | Selection::Address(_) => false,
                };
                match (self.left.take_if(is_chosen), selection) {
                    (Some(left), _) => self.show(&ctx, left),
                    (None, Selection::Application(about)) => {
                        self.connect(&ctx, format!("{}@{}", about.name, about.id));
                    }
                    (None, Selection::Recording(file)) => self.play(&ctx, file),
                    (None, Selection::Stop(_) | Selection::Address(_)) => {}
                }
            }
            Some(Next::Workspace(opened)) => {
                let (session, player) = *opened;
                let (store, reach) = (self.store.clone(), self.opening.reach.clone());
                self.left = None;
                let folder = self.opening.recordings.first().cloned().unwrap_or_default();
                let recorder = Recorder::new(self.opening.recorder.clone(), folder);
                let workspace = Workspace::open(session, store, player, recorder, reach);
                self.show(&ctx, Box::new(workspace));
            }
            Some(Next::Start(reason)) => {
                let mut start = StartPage::new(&ctx, &self.opening);
                start.trouble = reason;
                if let Page::Open(left) = std::mem::replace(&mut self.page, Page::Start(start)) {
                    self.left = Some(left);
                }
                ctx.send_viewport_cmd(egui::ViewportCommand::Title("jde".to_owned()));
            }
        }
    }

    /// Shows the windows on an application or a recording.
    fn show(&mut self, ctx: &egui::Context, mut workspace: Box<Workspace>) {
        let title = match workspace.recording() {
            Some(file) => file.display().to_string(),
            None => workspace.session().about().name.clone(),
        };
        self.page = Page::Open(workspace);
        ctx.send_viewport_cmd(egui::ViewportCommand::Title(format!("{title} - jde")));
    }

    /// Draws the bar of the page, with the button that stops everything at its end. Returns where the user navigates to, if
    /// so.
    fn bar(&mut self, ui: &mut egui::Ui, target: Option<&StopTarget>) -> Option<Next> {
        // Before all widgets, so that the key works in text fields too, and is not pressed on a button that has the focus.
        let stops = |input: &mut egui::InputState| input.consume_key(egui::Modifiers::CTRL, egui::Key::Space);
        let mut stop = target.is_some() && ui.input_mut(stops);
        let mut next = None;
        egui::Panel::top("bar").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| {
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    stop |= target.is_some_and(|target| stop::button(ui, target));
                    self.keys.button(ui);
                    ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                        // In a narrow window the rest of the bar is cut off, and not the button.
                        ui.set_clip_rect(ui.clip_rect().intersect(ui.max_rect()));
                        next = self.page.bar(ui, &mut self.settings);
                    });
                });
            });
        });
        if let Some(target) = target.filter(|_| stop) {
            self.stop(ui.ctx(), target.clone());
        }
        next
    }

    /// Stops everything that the page concerns, and goes on asking until that is acknowledged.
    fn stop(&mut self, ctx: &egui::Context, target: StopTarget) {
        let names = match &mut self.page {
            Page::Start(start) => match &target {
                StopTarget::All => start.running(),
                StopTarget::One(name) => vec![name.split('@').next().unwrap_or_default().to_owned()],
            },
            Page::Connecting { name, .. } => vec![name.clone()],
            Page::Open(workspace) => vec![workspace.session().about().name.clone()],
        };
        let request = self.stops.begin(target, &self.opening.reach, names);
        if let Page::Open(workspace) = &mut self.page {
            return workspace.session().stop_everything(request);
        }
        let (asked, repaint) = (Arc::clone(&request), ctx.clone());
        let worker = move || asked.ask_in_reach(&|| repaint.request_repaint());
        if let Err(error) = thread::Builder::new()
            .name("view-stop-all".to_owned())
            .spawn(worker)
        {
            request.fail(format!(
                "not asked, because there is no thread: {error}; press again"
            ));
        }
    }

    /// Looks for applications at addresses from now on, with the credentials given at the start; without one, for those of
    /// this machine.
    fn reach(&mut self, ctx: &egui::Context, addresses: &str) {
        let endpoints: Vec<_> = addresses.split_whitespace().map(complete_endpoint).collect();
        let (login, tls) = match &self.opening.reach {
            Reach::Network { login, tls, .. } => (login.clone(), tls.clone()),
            Reach::Local(_) => (None, None),
        };
        self.opening.reach = match endpoints.is_empty() {
            true => Reach::Local(Folders::of_user()),
            false => Reach::Network {
                endpoints,
                login,
                tls,
            },
        };
        self.page = Page::Start(StartPage::new(ctx, &self.opening));
    }

    fn connect(&mut self, ctx: &egui::Context, name: String) {
        let (reach, repaint, requested) = (self.opening.reach.clone(), ctx.clone(), name.clone());
        self.start_opening(
            ctx,
            name.split('@').next().unwrap_or_default().to_owned(),
            Some(name),
            move |_| {
                let session = Client::connect(&reach)
                    .and_then(|client| client.application(Some(&requested)))
                    .and_then(|remote| WindowSession::open(remote, repaint.clone()))
                    .map_err(|error| error.to_string())?;
                let is_here = matches!(reach, Reach::Local(_)) && session.is_recording();
                let file = PathBuf::from(&session.about().file);
                let session = match is_here && file.is_absolute() {
                    true => session.with_file(file, repaint),
                    false => session,
                };
                Ok((session, None))
            },
        );
    }

    fn play(&mut self, ctx: &egui::Context, file: PathBuf) {
        let (mut program, repaint) = (self.opening.player.clone(), ctx.clone());
        if let Some(from) = self.opening.from.take() {
            let from = format!("--from={}s", from as f64 / 1e9);
            program.extend([from, "--paused".to_owned()].map(OsString::from));
        }
        self.start_opening(ctx, file.display().to_string(), None, move |cancelled| {
            let (player, remote) = Player::start(&program, &file, cancelled)?;
            let session = WindowSession::open(remote, repaint.clone()).map_err(|error| error.to_string())?;
            Ok((session.with_file(file, repaint), Some(player)))
        });
    }

    fn start_opening(
        &mut self,
        ctx: &egui::Context,
        name: String,
        application: Option<String>,
        find: impl FnOnce(&AtomicBool) -> Opened + Send + 'static,
    ) {
        let (done, opened) = channel();
        let (repaint, cancel) = (ctx.clone(), Cancel::default());
        let cancelled = Arc::clone(&cancel.0);
        let worker = move || {
            // The receiver may be gone: the user cancelled.
            let _ = done.send(find(&cancelled));
            repaint.request_repaint();
        };
        // Without a thread, `done` is dropped, and the page shows that nothing was opened.
        if let Err(error) = thread::Builder::new()
            .name("view-connect".to_owned())
            .spawn(worker)
        {
            tracing::error!("no thread to connect: {error}");
        }
        self.page = Page::Connecting {
            name,
            application,
            opened,
            _cancel: cancel,
        };
    }
}

impl Page {
    /// What a stop of everything concerns on this page; `None` on a recording's.
    fn stop_target(&mut self) -> Option<StopTarget> {
        match self {
            Self::Start(_) => Some(StopTarget::All),
            Self::Connecting { application, .. } => application.clone().map(StopTarget::One),
            Self::Open(workspace) => workspace.session().stop_target(),
        }
    }

    /// Draws its part of the bar. Returns where the user navigates to, if so.
    fn bar(&mut self, ui: &mut egui::Ui, settings: &mut WindowSettings) -> Option<Next> {
        match self {
            Self::Start(_) | Self::Connecting { .. } => {
                ui.strong("jde");
                ui.menu_button("Appearance", |ui| appearance_menu(ui, settings));
                None
            }
            Self::Open(workspace) => workspace.bar(ui, settings).map(|navigation| match navigation {
                Navigation::Away => Next::Start(None),
                Navigation::For(about) => Next::Chosen(Selection::Application(about)),
            }),
        }
    }
}

/// Draws the progress page. Returns whether the user cancelled.
fn connecting(ui: &mut egui::Ui, name: &str) -> bool {
    egui::CentralPanel::default()
        .show(ui, |ui| {
            ui.vertical_centered(|ui| {
                ui.add_space(ui.available_height() / 3.0);
                ui.spinner();
                ui.label(format!("Opening {name}"));
                ui.button("Cancel").clicked()
            })
            .inner
        })
        .inner
}

/// The page that replaces the current one.
enum Next {
    Chosen(Selection),
    Workspace(Box<(WindowSession, Option<Player>)>),
    Start(Option<String>),
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }

    /// The background of the window.
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        visuals.panel_fill.to_normalized_gamma_f32()
    }
}
