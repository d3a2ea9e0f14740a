//! The page of a run, in a process of its own, which ends with the run. No byte of a browser reaches the robot's process.

use std::io::{self, BufRead as _, BufReader, Read as _};
use std::os::unix::process::CommandExt as _;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;

use jde_link::message::About;
use jde_session::log::Log;
use jde_web::{Addresses, Settings};

use crate::failure::Failure;

/// The longest text of the page's process that is kept, bytes.
const MAX_TEXT: u64 = 64 << 10;

/// What the user wants of a page.
#[derive(Clone)]
pub(crate) struct PageOptions {
    pub(crate) settings: Settings,
    /// Where its address is shown.
    pub(crate) log: Log,
}

/// The page of a run. Its process ends when this is dropped, and shows how the run ended before.
pub(super) struct RunPage {
    _alive: Option<ChildStdin>,
}

impl RunPage {
    /// Starts the page of an application, and shows its address.
    ///
    /// # Errors
    /// The page cannot be served, and the reason.
    pub(super) fn start(options: &PageOptions, about: &About) -> Result<Self, Failure> {
        let failure = |error: io::Error| Failure::broken(format!("the page cannot be served: {error}"));
        let mut command = Command::new(std::env::current_exe().map_err(failure)?);
        let settings = serde_json::to_string(&options.settings).map_err(|error| failure(error.into()))?;
        let name = format!("{}@{}", about.name, about.id);
        command.args(["web", "--beside-run", &settings, "--app", &name]);
        let mut page = command
            // The application runs on this machine, wherever other tools connect.
            .env_remove("JDE_AT")
            .env_remove("JDE_KEY")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // An interrupt from the keyboard does not reach it, so that it can show how the application ended.
            .process_group(0)
            .spawn()
            .map_err(failure)?;
        let alive = page.stdin.take();
        let mut line = String::new();
        if let Some(output) = page.stdout.take() {
            BufReader::new(output.take(MAX_TEXT))
                .read_line(&mut line)
                .map_err(failure)?;
        }
        let Ok(addresses) = serde_json::from_str::<Addresses>(&line) else {
            // Its end is what `reason` waits for.
            drop(alive);
            return Err(Failure::broken(reason(page)));
        };
        let right = if addresses.operate.is_some() {
            ""
        } else {
            " (to look only)"
        };
        let address = addresses.operate.as_ref().unwrap_or(&addresses.read);
        options.log.pin(format!("page{right}: {address}"));
        options.log.pin(format!("foxglove: {}", addresses.foxglove));
        // A detached thread reads what it says, so that it never waits for a reader, and that no zombie remains.
        thread::Builder::new()
            .name("page".to_owned())
            .spawn(move || watch(page))
            .map_err(failure)?;
        Ok(Self { _alive: alive })
    }
}

/// Logs what the page says, and its end if that is before the run's.
fn watch(mut page: Child) {
    if let Some(errors) = page.stderr.take() {
        for line in BufReader::new(errors).lines().map_while(Result::ok) {
            tracing::warn!("the page: {line}");
        }
    }
    if !page.wait().is_ok_and(|status| status.success()) {
        tracing::warn!("the page ended; the robot goes on without it, and jde web serves another one");
    }
}

/// Returns what the page's process said before it ended.
fn reason(mut page: Child) -> String {
    let mut text = String::new();
    if let Some(errors) = page.stderr.take() {
        // Whatever is not text says nothing.
        let _ = errors.take(MAX_TEXT).read_to_string(&mut text);
    }
    let _ = page.wait();
    let said = text.trim();
    let said = said.strip_prefix("error: ").unwrap_or(said);
    if said.is_empty() {
        "the page's process ended without a reason".to_owned()
    } else {
        said.to_owned()
    }
}
