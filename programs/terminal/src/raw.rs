//! Text that is written on standard error at once, past the queues: panics, and what is wrong before the streams are
//! open. It takes no memory, no lock and no descriptor, and does not wait: what finds no room is lost.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::fmt::{self, Write};
use std::{panic, thread};

use jde_files::is_control;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::stdio::stderr;

use super::{POLICY, drain};

/// Bytes that are written at once: fewer than a pipe or a terminal takes whenever it says that it has room.
const PIECE_BYTES: usize = 256;

/// Standard error with a piece of text that is not written yet.
struct RawError {
    piece: [u8; PIECE_BYTES],
    length: usize,
}

impl RawError {
    fn flush(&mut self) {
        let piece = &self.piece[..std::mem::take(&mut self.length)];
        let stream = stderr();
        let mut ready = [PollFd::new(&stream, PollFlags::OUT)];
        if poll(&mut ready, Some(&Timespec::default())).is_ok_and(|ready| ready > 0) {
            // There is no place left to report to.
            let _ = rustix::io::write(stream, piece);
        }
    }
}

impl Write for RawError {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for letter in text.chars() {
            // No text controls the terminal.
            let letter = if is_control(letter) && letter != '\n' {
                '?'
            } else {
                letter
            };
            let mut bytes = [0; 4];
            let bytes = letter.encode_utf8(&mut bytes).as_bytes();
            if self.length + bytes.len() > PIECE_BYTES {
                self.flush();
            }
            self.piece[self.length..][..bytes.len()].copy_from_slice(bytes);
            self.length += bytes.len();
        }
        Ok(())
    }
}

/// Writes a text on standard error.
pub fn write_raw(text: fmt::Arguments<'_>) {
    let mut error = RawError {
        piece: [0; PIECE_BYTES],
        length: 0,
    };
    // Fails only if a value that is shown fails to show itself; what came before is written.
    let _ = error.write_fmt(text);
    error.flush();
}

/// Prints panics past the queues: whatever panicked may hold their locks, and a robot may wait for its thread.
pub fn install_panic_hook() {
    panic::set_hook(Box::new(|info| {
        let thread = thread::current();
        let name = thread.name().unwrap_or("?");
        write_raw(format_args!("thread '{name}' {info}\n"));
        // It needs memory, files and a lock, so only a person who sets RUST_BACKTRACE gets one, after the message.
        let backtrace = Backtrace::capture();
        if backtrace.status() == BacktraceStatus::Captured {
            write_raw(format_args!("{backtrace}\n"));
        }
        if name == "main" {
            // A panic of the main thread ends the process.
            POLICY.finish_soon();
            let _ = drain();
        }
    }));
}
