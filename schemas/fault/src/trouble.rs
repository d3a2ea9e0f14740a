//! Faults that any call can cause on purpose. Faults in commanded or exported values are made where the
//! values are written.

#![allow(unsafe_code, reason = "an invalid pointer and a fork are among the faults")]

use std::hint::black_box;
use std::time::Duration;

use jde_schema::prelude::*;

use crate::request::FaultKind;

/// Longer than any schema of a campaign may take before it counts as hung.
const DAWDLE_TIME: Duration = Duration::from_millis(900);
/// Several times the budget of this plugin's schemas, and shorter than the time after which a call counts as
/// hung.
const SLOW_TIME: Duration = Duration::from_millis(35);

/// Causes the fault, if it is one that any call can cause. Does nothing for the others.
///
/// # Errors
/// If `fault` is [`FaultKind::Error`].
pub(crate) fn cause(fault: FaultKind) -> Result {
    match fault {
        FaultKind::Panic => panic!("requested fault"),
        FaultKind::Error => Err("requested fault".into()),
        FaultKind::Hang => loop {
            std::thread::park();
        },
        FaultKind::Dawdle => {
            std::thread::sleep(DAWDLE_TIME);
            Ok(())
        }
        FaultKind::Slow => {
            std::thread::sleep(SLOW_TIME);
            Ok(())
        }
        FaultKind::Segfault => {
            // SAFETY: deliberately unsound. No page is mapped at address 8, so the write ends this process.
            unsafe { black_box(std::ptr::without_provenance_mut::<u64>(8)).write_volatile(1) };
            Ok(())
        }
        FaultKind::Abort => std::process::abort(),
        FaultKind::Exit => std::process::exit(3),
        FaultKind::Overflow => {
            black_box(overflow_stack(black_box(1)));
            Ok(())
        }
        FaultKind::Eat => {
            let mut allocated = Vec::new();
            loop {
                allocated.push(black_box(vec![1_u8; 1 << 20]));
            }
        }
        FaultKind::Fork => {
            // SAFETY: the child calls nothing but `pause`, which a signal handler may call, too.
            if unsafe { libc::fork() } != 0 {
                std::process::abort();
            }
            loop {
                // SAFETY: it has no argument.
                unsafe { libc::pause() };
            }
        }
        FaultKind::Leave | FaultKind::Double => {
            // SAFETY: the child calls nothing, and returns to its host, which must end it.
            if unsafe { libc::fork() } != 0 && matches!(fault, FaultKind::Leave) {
                std::process::abort();
            }
            Ok(())
        }
        FaultKind::Silence
        | FaultKind::Nan
        | FaultKind::Infinity
        | FaultKind::Beyond
        | FaultKind::Reckless
        | FaultKind::Flood
        | FaultKind::Trespass
        | FaultKind::Chatter
        | FaultKind::Meddle => Ok(()),
    }
}

/// Recurses until the stack overflows.
fn overflow_stack(depth: u64) -> u64 {
    let page = black_box([depth; 512]);
    if black_box(depth) == 0 {
        return page[0];
    }
    overflow_stack(depth + 1) + page[1]
}
