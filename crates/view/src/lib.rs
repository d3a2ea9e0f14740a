//! Windows on running applications: the hierarchy oscilloscope, sensors and motors, a 3D view, each schema's own panel. All of
//! it is a client of the link: it sees what a tool across the room sees, and closing it touches nothing.
//!
//! It refuses to control: what a person does here becomes an operator's request (R14), and who is asked decides.

mod app;
mod canvas;
mod graphics_card;
mod picture;
mod player;
mod screen;
mod session;
mod settings;
mod start;
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

/// What to show first.
#[derive(Clone, Debug)]
pub struct Opening {
    /// Where applications are looked for.
    pub reach: Reach,
    /// The application to begin with, by name; nothing: the only one that runs, or the start page.
    pub application: Option<String>,
    /// A recording to begin with.
    pub recording: Option<PathBuf>,
    /// How a recording is played: the program and its arguments before `--name NAME FILE`, in a process of its own, which ends at
    /// the end of its standard input.
    pub player: Vec<OsString>,
    /// Where recordings are looked for.
    pub recordings: Vec<PathBuf>,
}

/// Why no window can be shown.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no screen.
    #[error("there is no screen here: neither WAYLAND_DISPLAY nor DISPLAY is set")]
    NoScreen,
    /// Nothing here draws.
    #[error(
        "no graphics card here can draw windows: {0}; install its driver, or Mesa's, which does without one (apt install \
         mesa-vulkan-drivers)"
    )]
    NoCard(String),
    /// The card was lost, or refused what it cannot do without.
    #[error("the graphics card draws no more: {0}; open the windows again, they are as they were left")]
    Lost(String),
    /// The screen, or the window on it, went away.
    #[error("the screen is gone, or took the window away; open it again, it is as it was left ({0})")]
    Taken(String),
    /// The screen refused.
    #[error("cannot open a window: {0}")]
    Window(String),
}

/// Opens the window and stays until it is closed. To be called from the main thread.
///
/// # Errors
/// [`Error`]; whatever goes wrong later is shown in the window.
pub fn run(opening: Opening) -> Result<(), Error> {
    app::run(opening)
}

/// Whether there is a screen to open windows on, as far as the environment tells.
#[must_use]
pub fn has_screen() -> bool {
    let names = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"];
    names
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}
