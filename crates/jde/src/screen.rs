//! The terminal while a view has it: raw, on its alternate screen, and given back on every way out.
//!
//! It refuses to draw.

use std::io::{self, IsTerminal, Stdout, Write};
use std::panic::{self, AssertUnwindSafe};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{
    Clear, ClearType, EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};

/// Panics of other threads that are kept to be told at the end: the first ones hold the cause.
const PANICS_KEPT: usize = 20;

/// Whether the terminal is ours. Given back twice, it would put its cursor over what was printed in between.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Gives `view` the terminal and takes it back afterwards; a panic of `view` goes on once the terminal is as before.
///
/// Meanwhile panics of other threads are kept, not printed over the picture, and told on standard error at the end.
pub(crate) fn with_screen<T>(
    view: impl FnOnce(&mut Terminal<CrosstermBackend<Stdout>>) -> io::Result<T>,
) -> io::Result<T> {
    if !io::stdin().is_terminal() || !io::stdout().is_terminal() {
        return Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "this view needs a terminal for its input and output: run it without a pipe",
        ));
    }
    let before = Arc::new(panic::take_hook());
    let kept = Arc::new(Mutex::new(Vec::new()));
    let (view_thread, told, keep) = (thread::current().id(), Arc::clone(&before), Arc::clone(&kept));
    panic::set_hook(Box::new(move |info| {
        if thread::current().id() == view_thread {
            give_back();
            told(info);
            return;
        }
        let mut kept = keep.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() < PANICS_KEPT {
            kept.push(format!(
                "thread '{}' {info}",
                thread::current().name().unwrap_or("?")
            ));
        }
    }));

    let result = panic::catch_unwind(AssertUnwindSafe(|| {
        take().and_then(|mut terminal| view(&mut terminal))
    }));

    give_back();
    panic::set_hook(Box::new(move |info| before(info)));
    for told in kept.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let _ = writeln!(io::stderr(), "{told}");
    }
    result.unwrap_or_else(|panic| panic::resume_unwind(panic))
}

fn take() -> io::Result<Terminal<CrosstermBackend<Stdout>>> {
    TAKEN.store(true, Ordering::Relaxed);
    enable_raw_mode()?;
    // Not by `Terminal::clear`, which asks where the cursor is: the console of a robot may never answer.
    execute!(io::stdout(), EnterAlternateScreen, Clear(ClearType::All))?;
    Terminal::new(CrosstermBackend::new(io::stdout()))
}

/// A terminal that is gone cannot be told so: errors mean nothing here.
fn give_back() {
    if TAKEN.swap(false, Ordering::Relaxed) {
        let _ = disable_raw_mode();
        let _ = execute!(io::stdout(), LeaveAlternateScreen, Show);
    }
}
