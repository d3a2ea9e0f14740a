//! The terminal, while a debugger holds a call: one process at a time has it.

use parking_lot::{Mutex, MutexGuard};
use rustix::stdio::stdin;
use rustix::termios::{OptionalActions, Termios, tcgetattr, tcsetattr};

static TERMINAL: Mutex<()> = Mutex::new(());

/// The terminal at standard input, for one process. Dropping it restores the modes of the terminal, which a process
/// that was killed leaves as its line editor set them.
pub struct HeldTerminal {
    modes: Option<Termios>,
    _alone: MutexGuard<'static, ()>,
}

impl HeldTerminal {
    /// Waits until no other process has the terminal.
    #[must_use]
    pub fn wait() -> Self {
        let alone = TERMINAL.lock();
        Self {
            modes: tcgetattr(stdin()).ok(),
            _alone: alone,
        }
    }
}

impl Drop for HeldTerminal {
    fn drop(&mut self) {
        if let Some(modes) = &self.modes {
            // Fails only if the terminal is gone.
            let _ = tcsetattr(stdin(), OptionalActions::Now, modes);
        }
    }
}
