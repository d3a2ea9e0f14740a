//! The window's frame: the start page, or the windows on one application. It owns no robot: it may be closed at any time.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

use eframe::egui;
use jde_link::Client;
use jde_link::message::About;

use crate::layout::{Desk, Settings};
use crate::look::Look;
use crate::session::Session;
use crate::start::{Chosen, Start};
use crate::{Error, Opening};

pub(crate) fn run(opening: Opening) -> Result<(), Error> {
    let screen = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"]
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()));
    if !screen {
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
    let build: eframe::AppCreator<'_> = Box::new(move |context| {
        if let Some(card) = &context.wgpu_render_state {
            crate::window::space::offer(&context.egui_ctx, card);
        }
        Ok(Box::new(App::new(&context.egui_ctx, opening)))
    });
    eframe::run_native("jde", options, build).map_err(|error| Error::Window(error.to_string()))
}

/// What the window shows.
pub(crate) struct App {
    opening: Opening,
    settings: Settings,
    page: Page,
}

enum Page {
    /// What runs, and what was recorded.
    Start(Start),
    /// Looks for an application and connects.
    Connecting {
        name: String,
        session: Receiver<Result<Session, String>>,
    },
    /// The windows on one application.
    Open(Box<Desk>),
}

impl App {
    pub(crate) fn new(ctx: &egui::Context, opening: Opening) -> Self {
        let settings = Settings::load();
        settings.apply(ctx);
        let mut app = Self {
            page: Page::Start(Start::new(&opening)),
            opening,
            settings,
        };
        if let Some(name) = app.opening.application.clone() {
            app.connect(ctx, name);
        }
        app
    }

    /// One frame.
    pub(crate) fn frame(&mut self, ui: &mut egui::Ui) {
        let look = Look::of(ui.ctx(), self.settings.units);
        let mut next = None;
        match &mut self.page {
            Page::Start(start) => next = start.show(ui, &mut self.settings).map(Next::Open),
            Page::Connecting { name, session } => match session.try_recv() {
                Ok(Ok(session)) => next = Some(Next::Desk(Box::new(session))),
                Ok(Err(reason)) => next = Some(Next::Start(Some(reason))),
                Err(TryRecvError::Disconnected) => next = Some(Next::Start(None)),
                Err(TryRecvError::Empty) => {
                    ui.centered_and_justified(|ui| {
                        ui.horizontal(|ui| {
                            ui.spinner();
                            ui.label(format!("Looking for {name}"));
                            if ui.button("Cancel").clicked() {
                                next = Some(Next::Start(None));
                            }
                        })
                    });
                }
            },
            Page::Open(desk) => {
                if desk.show(ui, &look, &mut self.settings) {
                    next = Some(Next::Start(None));
                }
            }
        }
        match next {
            None => {}
            Some(Next::Open(Chosen::Application(about))) => self.connect(ui.ctx(), named(&about)),
            Some(Next::Open(Chosen::Recording(file))) => self.play(ui.ctx(), file),
            Some(Next::Desk(session)) => self.page = Page::Open(Box::new(Desk::open(*session))),
            Some(Next::Start(reason)) => {
                let mut start = Start::new(&self.opening);
                start.trouble = reason;
                self.page = Page::Start(start);
            }
        }
    }

    fn connect(&mut self, ctx: &egui::Context, name: String) {
        let (done, session) = channel();
        let (reach, repaint, asked) = (self.opening.reach.clone(), ctx.clone(), name.clone());
        let look = move || {
            let opened = Client::connect(&reach)
                .and_then(|client| client.application(Some(&asked)))
                .and_then(|remote| Session::open(remote, repaint.clone()));
            let _ = done.send(opened.map_err(|error| error.to_string()));
            repaint.request_repaint();
        };
        if let Err(error) = thread::Builder::new().name("view-connect".to_owned()).spawn(look) {
            tracing::error!("no thread to connect: {error}");
        }
        self.page = Page::Connecting { name, session };
    }

    fn play(&mut self, _ctx: &egui::Context, _file: PathBuf) {}
}

/// What comes after the present page.
enum Next {
    Open(Chosen),
    Desk(Box<Session>),
    Start(Option<String>),
}

/// What finds this application and no other.
fn named(about: &About) -> String {
    format!("{}@{}", about.name, about.id)
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }
}
