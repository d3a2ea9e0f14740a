//! The link of a run, open as long as the run. A run continues without a link, unless the application or the
//! user explicitly requested one.

use std::io::Read;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::thread;

use jde_app::Application;
use jde_host::{Handle, StartHook, StartHookError};
use jde_link::{Events, Folders, Link, Login, Settings, SubjectInfo, Tls};
use jde_link_host::Running;
use jde_loader::Plugins;
use jde_records::event::Observer;
use jde_session::run::{Extension, PreparedExtension, RecordingSummary, RunContext};
use parking_lot::Mutex;

use super::page::{PageOptions, RunPage};
use crate::failure::Failure;
use crate::windows;

/// The options of a run for its link.
#[derive(Clone, Default)]
pub(crate) struct LinkOptions {
    /// The name of the application for other applications and tools, if one was given.
    pub(crate) name: Option<String>,
    /// Whether to open a link; `None` leaves the choice to the application and the kind of run.
    pub(crate) enabled: Option<bool>,
    /// Whether to open windows on the run.
    pub(crate) view: bool,
    /// The page for browsers, if one is to be served.
    pub(crate) page: Option<PageOptions>,
    /// Whether time may stand still: then also a run in lockstep lasts until somebody has looked at it.
    pub(crate) stands_still: bool,
}

/// At least this many of the last bytes that the windows write to standard error are kept.
const MAX_ERROR_BYTES: usize = 4096;

/// An open link and its page, which ends after the link: its last picture shows how the run ended.
type OpenLink = (Link, Option<RunPage>);

/// The link of a run.
struct RunLink {
    settings: Settings,
    /// Whether the run must not start without the link.
    required: bool,
    view: bool,
    page: Option<PageOptions>,
    title: SubjectInfo,
    events: Events,
    link: Arc<Mutex<Option<OpenLink>>>,
}

impl RunLink {
    /// Prepares the link. Returns `None` if the run has none.
    ///
    /// # Errors
    /// The password cannot be read, the name is that of an imported application, or windows are requested and
    /// there is no screen.
    fn prepare(options: &LinkOptions, context: &RunContext<'_>) -> Result<Option<Self>, Failure> {
        let RunContext {
            application,
            lockstep,
            speed,
        } = *context;
        let link = &application.link;
        let is_usual = (!lockstep || options.stands_still) && !link.off;
        if !options.enabled.unwrap_or(is_usual) {
            return Ok(None);
        }
        if options.view {
            windows::check()?;
        }
        let settings = settings(options.name.clone(), application)?;
        let required = settings.require_name
            || settings.is_networked()
            || options.enabled == Some(true)
            || options.view
            || options.page.is_some();
        let mut title = SubjectInfo::new(application, speed);
        if lockstep {
            "lockstep".clone_into(&mut title.executor);
        }
        Ok(Some(Self {
            settings,
            required,
            view: options.view,
            page: options.page.clone(),
            title,
            events: Events::of(application),
            link: Arc::default(),
        }))
    }
}

impl Extension for LinkOptions {
    fn prepare(
        &self,
        context: &RunContext<'_>,
    ) -> Result<Option<Box<dyn PreparedExtension>>, StartHookError> {
        let link = RunLink::prepare(self, context)?;
        Ok(link.map(|link| Box::new(link) as _))
    }
}

impl PreparedExtension for RunLink {
    /// The observer passes the application's events to the link.
    fn observer(&self) -> Box<dyn Observer> {
        self.events.observer()
    }

    /// The hook opens the link. If the link fails, the run continues with a warning, or does not start if the
    /// link is required.
    fn before_start(&self, plugins: &Arc<Plugins>) -> StartHook {
        let plugins = Arc::clone(plugins);
        let (settings, title, required) = (self.settings.clone(), self.title.clone(), self.required);
        let (events, link, view) = (self.events.clone(), Arc::clone(&self.link), self.view);
        let page = self.page.clone();
        Box::new(move |handle: &Handle| {
            let subject = Arc::new(Running::new(handle.clone(), title).reloading(plugins));
            match Link::open(&settings, subject, &events) {
                Ok(open) => {
                    let name = &open.about().name;
                    if *name != settings.name {
                        tracing::warn!(
                            "another `{}` runs on this machine, so this one has the name `{name}` for tools; --name sets another name",
                            settings.name
                        );
                    }
                    if view {
                        open_windows(&open.about().name)?;
                    }
                    let page = page.as_ref().map(|page| RunPage::start(page, open.about()));
                    *link.lock() = Some((open, page.transpose()?));
                    Ok(())
                }
                Err(error) if required => Err(Box::new(Failure::Link(error))),
                Err(error) => {
                    tracing::warn!("no tool can connect to this run: {error}");
                    Ok(())
                }
            }
        })
    }

    /// Closes the link.
    fn finish(&self) -> Option<RecordingSummary> {
        let link = self.link.lock().take();
        drop(link);
        None
    }
}

/// Opens windows on the application in a separate process, which may end, hang or be killed at any time.
fn open_windows(name: &str) -> Result<(), Failure> {
    let failure = |error| Failure::broken(format!("the windows cannot be opened: {error}"));
    let windows = Command::new(std::env::current_exe().map_err(failure)?)
        .args(["view", "--app", name])
        // The application runs on this machine, wherever other tools connect.
        .env_remove("JDE_AT")
        .env_remove("JDE_KEY")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        // An interrupt from the keyboard does not reach the windows, so they can show how the application
        // ended.
        .process_group(0)
        .spawn()
        .map_err(failure)?;
    // A detached thread waits for the process, so that no zombie remains.
    let name = name.to_owned();
    thread::Builder::new()
        .name("windows".to_owned())
        .spawn(move || wait_for_windows(windows, &name))
        .map_err(failure)?;
    Ok(())
}

/// Waits for the windows, and logs an error if they could not be shown.
fn wait_for_windows(mut windows: Child, name: &str) {
    let mut output = Vec::new();
    if let Some(said) = windows.stderr.take() {
        // Reads to the end, so that the windows never wait for a reader. Of long output the beginning is
        // dropped.
        for byte in std::io::BufReader::new(said).bytes().map_while(Result::ok) {
            if output.len() == 2 * MAX_ERROR_BYTES {
                output.drain(..MAX_ERROR_BYTES);
            }
            output.push(byte);
        }
    }
    let ended = windows.wait();
    if !ended.is_ok_and(|status| status.success()) {
        let output = String::from_utf8_lossy(&output);
        let last = output.trim().lines().next_back().unwrap_or_default();
        tracing::warn!("the windows ended with an error; `jde view {name}` shows the reason ({last})");
    }
}

fn settings(name: Option<String>, application: &Application) -> Result<Settings, Failure> {
    let link = &application.link;
    if let Some(name) = &name
        && application.remotes.iter().any(|import| import.peer == *name)
    {
        return Err(Failure::usage(
            format!(
                "it imports from another application called `{name}`, so it cannot have that name itself"
            ),
            "give --name another one",
        ));
    }
    let login = match &link.login {
        Some(login) => {
            let read = Login::read(&login.user, &login.password_file);
            Some(read.map_err(Failure::Link)?)
        }
        None => None,
    };
    let tls = link.tls.as_ref().map(|tls| Tls {
        identity: tls
            .identity
            .as_ref()
            .map(|identity| (text(&identity.certificate), text(&identity.key))),
        authority: tls.authority.as_deref().map(text),
        clients: tls.clients,
    });
    Ok(Settings {
        // A chosen name is kept or refused, never changed.
        require_name: name.is_some() || link.name != jde_app::Link::local(&application.name).name,
        name: name.unwrap_or_else(|| link.name.clone()),
        listen: link.listen.clone(),
        connect: link.connect.clone(),
        discover: link.discover,
        access: link.access,
        login,
        tls,
        insecure: link.insecure,
        folder: Folders::of_user(),
    })
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}
