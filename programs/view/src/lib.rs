//! Windows on running applications: the hierarchy oscilloscope, sensors and motors, a 3D view, and the panel
//! of each schema. Every window is a client of the link: it sees what a remote tool sees, and closing it
//! changes nothing in the application.
//!
//! It refuses to control: each input of the user becomes an operator's request (R14), and the application
//! decides whether to accept it.

mod app;
mod canvas;
mod graphics_card;
mod keys;
mod moments;
mod picture;
mod player;
mod recorded;
mod recorder;
mod screen;
mod session;
mod settings;
mod start;
mod stop;
mod style;
mod tap;
#[cfg(test)]
mod tests;
mod ui_renderer;
mod window;
mod workspace;

use std::ffi::OsString;
use std::path::PathBuf;

use jde_link::Reach;

/// What [`run`] opens first.
#[derive(Clone, Debug)]
pub struct Opening {
    /// Where to search for applications.
    pub reach: Reach,
    /// The name of the application to open. `None` opens the only running one, or the start page.
    pub application: Option<String>,
    /// The recording to open. It takes precedence over `application`.
    pub recording: Option<PathBuf>,
    /// The time from which the recording is shown, ns since the application's start. It is paused there.
    pub from: Option<u64>,
    /// How to play a recording: the program and its arguments before `--name NAME FILE`. It runs as a
    /// separate process, which must end at the end of its standard input.
    pub player: Vec<OsString>,
    /// How to record an application: the program and its arguments before `--app NAME FILE`. It runs as a separate
    /// process, which must complete the file at the end of its standard input. Empty for no recordings.
    pub recorder: Vec<OsString>,
    /// Folders to search for recordings. New ones are written to the first.
    pub recordings: Vec<PathBuf>,
}

/// Why windows cannot be shown, or why they closed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no display.
    #[error("there is no screen: neither WAYLAND_DISPLAY nor DISPLAY is set")]
    NoScreen,
    /// No graphics adapter can draw windows.
    #[error(
        "no graphics card can draw windows: {0}; install its driver, or Mesa's software renderer (apt install \
         mesa-vulkan-drivers)"
    )]
    NoCard(String),
    /// The graphics device was lost, or reported an error.
    #[error("the graphics card failed: {0}; open the windows again, their layout is saved")]
    Lost(String),
    /// The display, or the window on it, disappeared.
    #[error("the screen or its window disappeared; open the window again, its layout is saved ({0})")]
    Taken(String),
    /// The display refused to open a window.
    #[error("cannot open a window: {0}")]
    Window(String),
}

/// Opens the window and blocks until it is closed. Must be called from the main thread.
///
/// # Errors
/// [`Error`]. Problems of applications and recordings are shown in the window instead.
pub fn run(opening: Opening) -> Result<(), Error> {
    app::run(opening)
}

/// Whether the environment names a display: `WAYLAND_DISPLAY`, `WAYLAND_SOCKET` or `DISPLAY` is set.
#[must_use]
pub fn has_screen() -> bool {
    let names = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"];
    names
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}
