//! What this program says, and where: colours on a terminal only, plain text in a pipe. Everything it prints goes through here.
//!
//! Nobody prints past it (`cargo xtask tidy` looks): lines are handed to a thread for each stream, so that a terminal, a pipe or a disk
//! that takes nothing holds up nobody. Who waits how long for a reader is decided here for the whole process.

mod hang_up;
mod printer;
mod screen;

use std::backtrace::{Backtrace, BacktraceStatus};
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::panic;
use std::sync::{Arc, OnceLock};
use std::thread;

use anstream::{AutoStream, ColorChoice};
use anstyle::{AnsiColor, Style};

pub(crate) use hang_up::on_hang_up;
pub(crate) use printer::Printer;
use printer::{Policy, Stream};
pub(crate) use screen::with_screen;

use crate::visible::Visible;

/// For titles.
pub(crate) const TITLE: Style = Style::new().bold();
/// For what matters less.
pub(crate) const FAINT: Style = Style::new().dimmed();
/// For what went well.
pub(crate) const GOOD: Style = AnsiColor::Green.on_default().bold();
/// For what did not.
pub(crate) const BAD: Style = AnsiColor::Red.on_default().bold();
/// For what deserves a look.
pub(crate) const WARN: Style = AnsiColor::Yellow.on_default().bold();

/// Where words for people go: a stream that drops colours where nobody sees them.
pub(crate) type Words = Box<dyn Write + Send>;

/// How long this process waits for readers.
static POLICY: Policy = Policy::new();
static OUT: OnceLock<Arc<Stream>> = OnceLock::new();
static ERR: OnceLock<Arc<Stream>> = OnceLock::new();

/// When to use colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Color {
    /// On a terminal, unless NO_COLOR is set.
    #[default]
    Auto,
    /// Also in a pipe.
    Always,
    /// Nowhere.
    Never,
}

/// Chooses for the whole process.
pub(crate) fn choose(color: Color) {
    match color {
        Color::Auto => ColorChoice::Auto,
        Color::Always => ColorChoice::Always,
        Color::Never => ColorChoice::Never,
    }
    .write_global();
}

/// Standard output.
pub(crate) fn out() -> Words {
    let plain = AutoStream::choice(&io::stdout()) == ColorChoice::Never;
    Box::new(Visible::new(Printer::new(Arc::clone(stdout()), plain)))
}

/// Standard output, as it is: for pictures, and for a view that has the terminal.
pub(crate) fn raw_out() -> Printer {
    Printer::new(Arc::clone(stdout()), false)
}

/// Standard error.
pub(crate) fn err() -> Words {
    let plain = AutoStream::choice(&io::stderr()) == ColorChoice::Never;
    Box::new(Visible::new(Printer::new(Arc::clone(stderr()), plain)))
}

/// A file or pipe of lines that a program reads; what is dropped there is counted, and not told among them.
pub(crate) fn lines_to(file: File) -> Printer {
    Printer::new(Stream::begin("lines", file, &POLICY, false), false)
}

/// Whether a person sits at both ends.
pub(crate) fn is_interactive() -> bool {
    io::stdin().is_terminal() && io::stdout().is_terminal()
}

/// Whether standard output is a terminal.
pub(crate) fn out_is_terminal() -> bool {
    io::stdout().is_terminal()
}

/// Whether standard error is a terminal.
pub(crate) fn err_is_terminal() -> bool {
    io::stderr().is_terminal()
}

/// From now on nobody who prints waits, until the answer is dropped: then only for readers that go on reading.
pub(crate) fn wait_for_nobody() -> NoWaiting {
    POLICY.wait_for_nobody();
    NoWaiting(())
}

/// Nobody who prints waits while it lives.
pub(crate) struct NoWaiting(());

impl Drop for NoWaiting {
    fn drop(&mut self) {
        POLICY.hurry();
    }
}

/// The process was asked to end: whoever prints waits only for readers that go on reading.
pub(crate) fn let_go() {
    POLICY.let_go();
}

/// What is printed is waited for again: for a shell, whose verbs end one by one.
pub(crate) fn wait_again() {
    POLICY.wait();
}

/// Waits until everything is written, for as long as the process has patience.
///
/// # Errors
/// Standard output could not be written. Whoever closed standard error does not want to hear.
pub(crate) fn settle() -> io::Result<()> {
    let out = OUT.get().map_or(Ok(()), |out| out.settle());
    let _ = ERR.get().map(|err| err.settle());
    out
}

/// How many lines of standard output, and of standard error, nobody read in time.
pub(crate) fn lost() -> [u64; 2] {
    [&OUT, &ERR].map(|stream| stream.get().map_or(0, |stream| stream.lost()))
}

/// Has panics told on standard error as everything else is: a thread that panics may be one that a robot waits for.
pub(crate) fn tell_panics() {
    panic::set_hook(Box::new(|info| {
        let thread = thread::current();
        let name = thread.name().unwrap_or("?");
        let mut words = err();
        let backtrace = Backtrace::capture();
        let _ = match backtrace.status() {
            BacktraceStatus::Captured => writeln!(words, "thread '{name}' {info}\n{backtrace}"),
            _ => writeln!(words, "thread '{name}' {info}"),
        };
        drop(words);
        if name == "main" {
            // The process ends by it.
            POLICY.let_go();
            let _ = settle();
        }
    }));
}

fn stdout() -> &'static Arc<Stream> {
    OUT.get_or_init(|| begin("stdout", io::stdout().as_fd()))
}

fn stderr() -> &'static Arc<Stream> {
    ERR.get_or_init(|| begin("stderr", io::stderr().as_fd()))
}

/// Written past the standard library's own locks: whoever waits for a reader must not hold one.
fn begin(name: &str, stream: BorrowedFd<'_>) -> Arc<Stream> {
    let file = stream.try_clone_to_owned().map(File::from);
    let file = file.or_else(|_| File::options().write(true).open("/dev/null"));
    let file = file.expect("a process that can open no file can print nothing");
    Stream::begin(name, file, &POLICY, true)
}
