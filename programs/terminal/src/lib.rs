//! The output of this program: by default coloured on a terminal, plain in a pipe. All output passes through
//! this module, which `cargo xtask tidy` checks.
//!
//! Lines are queued for one thread per stream, so that a blocked terminal, pipe or disk delays no other
//! thread. A terminal is one stream, also if it shows both standard output and standard error. This module
//! determines for the whole process how long threads wait for a reader. It opens the streams before a verb
//! begins, so that no later line can fail because the process has no descriptor or thread left.

pub mod escape;
mod guard;
mod hang_up;
pub mod interrupt;
mod printer;
mod progress_line;
pub mod queue;
mod raw;
mod screen;
mod style;

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::MetadataExt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use anstream::{AutoStream, ColorChoice};

use crate::escape::EscapingWriter;
use printer::{BlockingPolicy, Stream};

pub use guard::{GUARD, serve_guard};
pub use hang_up::on_hang_up;
pub use printer::Printer;
pub use progress_line::ProgressLine;
pub use raw::{install_panic_hook, write_raw};
pub use screen::with_screen;
pub use style::{BAD, FAINT, GOOD, Style, TITLE, WARN, own_styles, style_mark};

/// A stream of text for people, which drops colours where they are not shown.
pub type TextWriter = Box<dyn Write + Send>;

/// How long this process waits for the readers of its output.
static POLICY: BlockingPolicy = BlockingPolicy::new();
static OUT: OnceLock<Arc<Stream>> = OnceLock::new();
static ERR: OnceLock<Arc<Stream>> = OnceLock::new();
/// Whether standard output is reserved for one writer.
static RESERVED: AtomicBool = AtomicBool::new(false);

/// When to use colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Color {
    /// On a terminal, unless NO_COLOR is set.
    #[default]
    Auto,
    /// Also in a pipe.
    Always,
    /// Nowhere.
    Never,
}

/// Opens standard output and standard error for printing, past the standard library's locks: a thread that waits for a
/// reader must not hold one.
///
/// # Errors
/// The process has no descriptor or no thread left.
pub fn open() -> io::Result<()> {
    let out = start_stream("stdout", io::stdout().as_fd())?;
    // Two threads that write to one terminal would mix and reorder their lines.
    let err = match is_one_terminal() {
        true => Arc::clone(&out),
        false => start_stream("stderr", io::stderr().as_fd())?,
    };
    // A second call changes nothing.
    let _ = (OUT.set(out), ERR.set(err));
    Ok(())
}

/// Sets the use of colours for the whole process.
pub fn set_color(color: Color) {
    match color {
        Color::Auto => ColorChoice::Auto,
        Color::Always => ColorChoice::Always,
        Color::Never => ColorChoice::Never,
    }
    .write_global();
}

/// Reserves standard output for the returned printer, whose reader is a program. Everything else that is printed there
/// from then on, by this program, its plugins, libraries and child processes, goes to standard error. The descriptor is
/// of the same stream, to watch whether somebody reads it.
///
/// # Errors
/// The process has no descriptor or no thread left.
pub fn reserve_out() -> io::Result<(Printer, OwnedFd)> {
    let reserved = io::stdout().as_fd().try_clone_to_owned()?;
    rustix::stdio::dup2_stdout(rustix::stdio::stderr())?;
    RESERVED.store(true, Ordering::Relaxed);
    let watched = reserved.try_clone()?;
    Ok((lines_to(reserved.into())?, watched))
}

/// Returns standard output.
pub fn out() -> TextWriter {
    if RESERVED.load(Ordering::Relaxed) {
        return err();
    }
    let plain = AutoStream::choice(&io::stdout()) == ColorChoice::Never;
    Box::new(EscapingWriter::new(Printer::new(OUT.get().cloned(), plain)))
}

/// Returns the output for text: standard error if standard output is for JSON.
pub fn text_out(json: bool) -> TextWriter {
    if json { err() } else { out() }
}

/// Returns standard output without escaping or dropping colours: for pictures, and for a view that uses the
/// terminal.
pub fn raw_out() -> Printer {
    if RESERVED.load(Ordering::Relaxed) {
        return err_printer();
    }
    Printer::new(OUT.get().cloned(), false)
}

/// Returns standard error.
pub fn err() -> TextWriter {
    Box::new(EscapingWriter::new(err_printer()))
}

/// Returns standard error for a thread that never waits for the reader: lines that find no room are dropped and counted.
pub fn err_without_waiting() -> TextWriter {
    Box::new(EscapingWriter::new(err_printer().without_waiting()))
}

fn err_printer() -> Printer {
    let plain = AutoStream::choice(&io::stderr()) == ColorChoice::Never;
    Printer::new(ERR.get().cloned(), plain)
}

/// Returns a writer of lines to a file or pipe that a program reads. Dropped lines are counted, and not
/// reported among the lines.
///
/// # Errors
/// The system refuses a thread.
pub fn lines_to(file: File) -> io::Result<Printer> {
    Ok(Printer::new(
        Some(Stream::start("lines", file, &POLICY, false)?),
        false,
    ))
}

/// Whether standard input and standard output are terminals.
pub fn is_interactive() -> bool {
    io::stdin().is_terminal() && io::stdout().is_terminal()
}

/// Whether standard output is a terminal.
pub fn out_is_terminal() -> bool {
    io::stdout().is_terminal()
}

/// Returns how many columns the terminal of standard output has; `None` if it is not a terminal.
pub fn width() -> Option<usize> {
    let (columns, _) = out_is_terminal().then(ratatui::crossterm::terminal::size)?.ok()?;
    Some(columns.into())
}

/// Whether standard error is a terminal.
pub fn err_is_terminal() -> bool {
    io::stderr().is_terminal()
}

/// Makes printing never wait, until the returned guard is dropped. After that it waits only for readers that
/// keep reading.
pub fn never_block() -> NonBlockingGuard {
    POLICY.never_block();
    NonBlockingGuard(())
}

/// Printing never waits while this guard lives.
pub struct NonBlockingGuard(());

impl Drop for NonBlockingGuard {
    fn drop(&mut self) {
        POLICY.block_briefly();
    }
}

/// Marks the process as ending: printing then waits only for readers that keep reading. Where printing never
/// waits, nothing changes.
pub fn finish_soon() {
    POLICY.finish_soon();
}

/// Makes printing wait for readers again: for a shell, which runs one verb after another.
pub fn resume_blocking() {
    POLICY.block();
}

/// Waits until everything is written, for as long as the process has patience.
///
/// # Errors
/// Standard output could not be written. Errors of standard error are ignored, because there is nowhere to
/// report them.
pub fn drain() -> io::Result<()> {
    let out = OUT.get().map_or(Ok(()), |out| out.drain());
    let _ = ERR.get().map(|err| err.drain());
    out
}

/// Returns how many lines of standard output and of standard error were not read in time; on one terminal,
/// all are of standard output.
pub fn lost() -> [u64; 2] {
    let [out, err] = [&OUT, &ERR].map(OnceLock::get);
    let err = err.filter(|err| out.is_none_or(|out| !Arc::ptr_eq(out, err)));
    [out, err].map(|stream| stream.map_or(0, |stream| stream.lost()))
}

/// Whether standard output and standard error are the same terminal.
fn is_one_terminal() -> bool {
    let device = |stream: BorrowedFd<'_>| {
        let file = File::from(stream.try_clone_to_owned().ok()?);
        Some(file.metadata().ok()?.rdev())
    };
    out_is_terminal() && err_is_terminal() && device(io::stdout().as_fd()) == device(io::stderr().as_fd())
}

fn start_stream(name: &str, stream: BorrowedFd<'_>) -> io::Result<Arc<Stream>> {
    Stream::start(name, stream.try_clone_to_owned()?.into(), &POLICY, true)
}
