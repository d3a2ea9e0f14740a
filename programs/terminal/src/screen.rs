//! The terminal while a view uses it: in raw mode on its alternate screen, and restored on every way out.
//!
//! It never waits: a picture is not drawn while the terminal has not taken the previous one. A terminal that
//! is gone is an error.

use std::io::{self, Write};
use std::mem::ManuallyDrop;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::event::{self, Event, KeyEvent, KeyEventKind};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{
    Clear, ClearType, EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::{Frame, Terminal};

use super::guard::TerminalGuard;
use super::hang_up::wait_for_key;
use super::{Printer, drain, err, is_interactive, raw_out};

/// Panics of other threads that are kept and printed at the end. The first ones show the cause.
const MAX_PANICS: usize = 20;

/// How long the library may wait for a key. Without any time it does not read at all.
const POLL_TIMEOUT: Duration = Duration::from_millis(1);

/// Whether this process has taken the terminal. Restoring it twice would put the cursor over text printed in
/// between.
static ACQUIRED: AtomicBool = AtomicBool::new(false);

/// Restores the terminal if this process cannot.
static WATCHED: Mutex<Option<TerminalGuard>> = Mutex::new(None);

/// The terminal of a view.
pub struct TerminalScreen {
    /// Never dropped: its drop panics when the terminal is gone. [`release`] restores the terminal instead.
    terminal: ManuallyDrop<Terminal<CrosstermBackend<Printer>>>,
    out: Printer,
}

impl TerminalScreen {
    /// Draws a picture, unless the terminal has not yet taken the previous one.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn draw(&mut self, draw: impl FnOnce(&mut Frame<'_>)) -> io::Result<()> {
        if self.out.is_idle() {
            self.terminal.draw(draw)?;
        }
        Ok(())
    }

    /// Returns the next key pressed before `until`, or `None`.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn read_key(&mut self, until: Instant) -> io::Result<Option<KeyEvent>> {
        let mut timeout = Duration::ZERO;
        loop {
            wait_for_key(timeout)?;
            while event::poll(POLL_TIMEOUT)? {
                if let Event::Key(key) = event::read()?
                    && key.kind != KeyEventKind::Release
                {
                    return Ok(Some(key));
                }
            }
            timeout = until.saturating_duration_since(Instant::now());
            if timeout.is_zero() {
                return Ok(None);
            }
        }
    }
}

/// Runs `view` with the terminal, and restores the terminal afterwards. A panic of `view` continues once the
/// terminal is restored.
///
/// Panics of other threads are not printed over the picture: they are kept, and printed on standard error at
/// the end.
pub fn with_screen<T>(view: impl FnOnce(&mut TerminalScreen) -> io::Result<T>) -> io::Result<T> {
    if !is_interactive() {
        return Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this view needs a terminal for its input and output: run it without a pipe",
        ));
    }
    let previous_hook = Arc::new(panic::take_hook());
    let messages = Arc::new(Mutex::new(Vec::new()));
    let view_thread = thread::current().id();
    let (hook, hook_messages) = (Arc::clone(&previous_hook), Arc::clone(&messages));
    panic::set_hook(Box::new(move |info| {
        if thread::current().id() == view_thread {
            release();
            hook(info);
            return;
        }
        let message = format!("thread '{}' {info}", thread::current().name().unwrap_or("?"));
        // A panic waits for nobody.
        if let Some(mut messages) = hook_messages.try_lock()
            && messages.len() < MAX_PANICS
        {
            messages.push(message);
        }
    }));

    let result = panic::catch_unwind(AssertUnwindSafe(|| {
        acquire().and_then(|mut screen| view(&mut screen))
    }));

    release();
    panic::set_hook(Box::new(move |info| previous_hook(info)));
    for message in messages.lock().drain(..) {
        let _ = writeln!(err(), "{message}");
    }
    result.unwrap_or_else(|panic| panic::resume_unwind(panic))
}

fn acquire() -> io::Result<TerminalScreen> {
    // Everything printed before must appear first.
    drain()?;
    *WATCHED.lock() = TerminalGuard::start();
    ACQUIRED.store(true, Ordering::Relaxed);
    enable_raw_mode()?;
    let mut out = raw_out();
    // `Terminal::clear` would query the cursor's position, which the console of a robot may never report.
    execute!(out, EnterAlternateScreen, Clear(ClearType::All))?;
    let terminal = Terminal::new(CrosstermBackend::new(raw_out()))?;
    Ok(TerminalScreen {
        terminal: ManuallyDrop::new(terminal),
        out,
    })
}

/// Restores the terminal. Errors are ignored: the terminal may be gone.
fn release() {
    if ACQUIRED.swap(false, Ordering::Relaxed) {
        let _ = disable_raw_mode();
        let _ = execute!(raw_out(), LeaveAlternateScreen, Show);
        drop(WATCHED.lock().take());
    }
}
