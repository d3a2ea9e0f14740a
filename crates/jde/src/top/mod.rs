//! The oscilloscope in a terminal: the live hierarchy, who wins and why, and an operator's few keys.
//!
//! It sees a running application through [`Application`] alone, so that one in this process and one across a network look
//! the same. Nothing of control lives here: it refuses to decide, to keep time for anybody and to open a connection.

mod draw;
mod history;
mod keys;
mod paint;
mod screen;
mod switches;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod text;
mod tree;

use std::io;
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_host::event::Outcome;
use jde_host::snapshot::Snapshot;

use crate::terminal;
use screen::Screen;
pub(crate) use tree::{Row, rows};

/// Time between two redraws: 20 a second look continuous and cost a few per cent of one core.
const REDRAW: Duration = Duration::from_millis(50);

/// A running application as the oscilloscope sees it. Every call returns at once; all come from the thread of [`run`].
pub(crate) trait Application {
    /// Gives what every schema and group is doing now.
    fn snapshot(&self) -> Snapshot;

    /// Gives where the robot is, if anything of the application knows.
    fn robot(&self) -> Option<RobotView>;

    /// Does what the operator asks.
    ///
    /// Errors: why it was refused, in words for the status line.
    fn act(&self, action: Action) -> Result<(), String>;

    /// Gives how the application ended, once it has.
    fn outcome(&self) -> Option<Outcome>;

    /// Gives the latest lines of the log, oldest first.
    fn log_lines(&self) -> Vec<String>;
}

/// What an operator asks with a key. Schemas are named by their place in the snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// Keeps a schema awake.
    Play(usize),
    /// Keeps a schema asleep.
    Stop(usize),
    /// Makes a motor schema the winner of its group.
    Force(usize),
    /// Lets go of a schema: the hierarchy decides about it again.
    Release(usize),
    /// Gives a schema a new period, ns.
    Period(usize, Nanos),
    /// Stops everything at once.
    StopAll,
    /// Lets everything go on that was stopped at once.
    ReleaseAll,
}

/// Where a robot is and where it goes, in metres and radians in the frame of its odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RobotView {
    /// x, y and heading.
    pub(crate) pose: (f64, f64, f64),
    /// The place it is going to.
    pub(crate) target: Option<(f64, f64)>,
    /// Targets reached so far.
    pub(crate) reached: u32,
    /// Targets of the mission; 0 if it has none.
    pub(crate) total: u32,
}

/// Why the view was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Left {
    /// The operator left while the application runs.
    Quit,
    /// The application has ended.
    Ended,
}

/// Shows a running application in the terminal until the operator leaves or the application was asked to stop.
///
/// An application that ends by itself stays on the screen until a key is pressed, so that its last moments can be read.
/// The terminal is as before on every way out, a panic included; a panic of another thread is told after it.
/// Call it from the main thread, with the terminal to itself: nothing else may print meanwhile.
///
/// Errors: standard input or output is not a terminal, or it went away.
pub(crate) fn run(app: &dyn Application, title: &str) -> io::Result<Left> {
    terminal::with_screen(|terminal| {
        let mut screen = Screen::new(title, paint::Paint::from_environment(), app);
        loop {
            if screen.outcome == Some(Outcome::Stopped) {
                return Ok(Left::Ended);
            }
            terminal.draw(|frame| draw::draw(frame, &mut screen))?;
            let redraw = Instant::now() + REDRAW;
            if let Some(key) = terminal.key(redraw)?
                && let Some(left) = screen.key(app, key)
            {
                return Ok(left);
            }
            screen.observe(app);
        }
    })
}
