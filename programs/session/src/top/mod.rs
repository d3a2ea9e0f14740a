//! The oscilloscope in a terminal: the live hierarchy, the winners with the reasons of their selection, and a
//! few keys for the operator.
//!
//! It reads a running application through [`ObservedApplication`] alone, so that an application of this
//! process and one across a network look the same. It contains no control: it does not decide, keep time for
//! an application or open connections.

mod draw;
mod keys;
mod strip;
#[cfg(test)]
pub mod tests;
pub mod text;
mod theme;
mod tree;
mod view_state;

use std::io;
use std::time::{Duration, Instant};

use jde_core::Nanos;
use jde_records::event::Outcome;
use jde_records::snapshot::Snapshot;
use jde_terminal as terminal;
use jde_timeline::Ending;

use view_state::ViewState;

pub use tree::branches;

/// Time between two redraws: 20 per second look continuous and cost a few per cent of one core.
const REDRAW_INTERVAL: Duration = Duration::from_millis(50);

/// A running application as the oscilloscope sees it. No call waits. All calls come from the thread of
/// [`run`].
pub trait ObservedApplication {
    /// Returns the present state of every schema and group.
    fn snapshot(&self) -> Snapshot;

    /// Returns the pose and target of the robot, if the application exports them.
    fn robot(&self) -> Option<RobotView>;

    /// Carries out an action of the operator.
    ///
    /// # Errors
    /// The reason of a refusal, as text for the status line.
    fn act(&self, action: ScreenAction) -> Result<(), String>;

    /// Returns how the application ended; `None` while it runs.
    fn ending(&self) -> Option<Ending>;

    /// Returns how long the application has said nothing.
    fn silent(&self) -> Duration;

    /// Returns the latest lines of the log, oldest first.
    fn log_lines(&self) -> Vec<String>;
}

/// An operator's action. Schemas are identified by their place in the snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScreenAction {
    /// Keep a schema awake.
    Play(usize),
    /// Keep a schema asleep.
    Stop(usize),
    /// Make a motor schema the winner of its group.
    Force(usize),
    /// Release a schema: the hierarchy decides about it again.
    Release(usize),
    /// Set the period of a schema, ns.
    Period(usize, Nanos),
    /// Stop everything at once.
    StopAll,
    /// End the stop of everything.
    ReleaseAll,
    /// Let time pass that stands still.
    Continue,
    /// Let a little time pass that stands still.
    Step,
}

/// The pose and the target of a robot, in metres and radians in the frame of its odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotView {
    /// x, y and heading.
    pub pose: (f64, f64, f64),
    /// The present target.
    pub target: Option<(f64, f64)>,
    /// Targets reached so far.
    pub reached: u32,
    /// Targets of the mission; 0 without a mission or for one without end.
    pub total: u32,
}

/// Why the view was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitReason {
    /// The operator left while the application was running.
    Quit,
    /// The application has ended.
    Ended,
}

/// Shows a running application in the terminal until the operator leaves or the application was asked to
/// stop.
///
/// An application that ends by itself stays on the screen until the operator leaves, so that its last moments
/// can be read. The terminal is restored on every way out, a panic included. A panic of another thread is
/// printed after that. Call it from the main thread. No other code may print to the terminal meanwhile.
///
/// # Errors
/// Standard input or output is not a terminal, or the terminal is gone.
pub fn run(app: &dyn ObservedApplication, title: &str) -> io::Result<ExitReason> {
    terminal::with_screen(|terminal| {
        let mut screen = ViewState::new(title, theme::Theme::from_environment(), app);
        loop {
            if screen.ending == Some(Ending::Known(Outcome::Stopped)) {
                return Ok(ExitReason::Ended);
            }
            terminal.draw(|frame| draw::draw(frame, &mut screen))?;
            let redraw = Instant::now() + REDRAW_INTERVAL;
            if let Some(key) = terminal.read_key(redraw)?
                && let Some(left) = screen.handle_key(app, key)
            {
                return Ok(left);
            }
            screen.observe(app);
        }
    })
}
