//! The modem signals of a serial line. It knows no device: the owner of the line decides what a signal means.
#![expect(unsafe_code, reason = "rustix has no safe function for them")]

use std::fs::File;

use rustix::ioctl::{Opcode, Setter, ioctl};

/// Switches signals off, by `asm-generic/ioctls.h`.
const TIOCMBIC: Opcode = 0x5417;
/// Data terminal ready, by `asm-generic/termios.h`.
const TIOCM_DTR: i32 = 0x002;

/// Switches off the signal DTR. Fails at a line without modem signals.
pub(super) fn clear_dtr(line: &File) -> rustix::io::Result<()> {
    // SAFETY: the request reads one `int` through its argument, and writes nothing.
    unsafe { ioctl(line, Setter::<TIOCMBIC, i32>::new(TIOCM_DTR)) }
}

#[cfg(test)]
mod tests {
    use rustix::io::Errno;

    use super::*;
    use crate::port::Pty;

    #[test]
    fn a_line_without_modem_signals_refuses_the_request() {
        let pty = Pty::open().expect("a pseudo-terminal");
        let line = File::open(pty.path()).expect("a line");
        let refusal = clear_dtr(&line).expect_err("a pseudo-terminal has none");
        assert!([Errno::NOTTY, Errno::INVAL].contains(&refusal), "{refusal}");
    }
}
