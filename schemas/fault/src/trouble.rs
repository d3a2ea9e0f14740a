//! Faults that any call can cause on purpose. Faults in commanded or exported values are made where the
//! values are written.

#![allow(
    unsafe_code,
    reason = "one of the faults is a write through an invalid pointer"
)]

use std::hint::black_box;
use std::time::Duration;

use jde_schema::prelude::*;

use crate::request::Trouble;

/// Longer than any schema of a campaign may take before it counts as hung.
const DAWDLE: Duration = Duration::from_millis(900);
/// Several times the budget of this plugin's schemas, and shorter than the time after which a call counts as
/// hung.
const SLOW: Duration = Duration::from_millis(35);

/// Causes the fault, if it is one that any call can cause. Does nothing for the others.
///
/// # Errors
/// If `trouble` is [`Trouble::Error`].
pub(crate) fn cause(trouble: Trouble) -> Result {
    match trouble {
        Trouble::Panic => panic!("as it was told"),
        Trouble::Error => Err("as it was told".into()),
        Trouble::Hang => loop {
            std::thread::park();
        },
        Trouble::Dawdle => {
            std::thread::sleep(DAWDLE);
            Ok(())
        }
        Trouble::Slow => {
            std::thread::sleep(SLOW);
            Ok(())
        }
        Trouble::Segfault => {
            // SAFETY: deliberately unsound. No page is mapped at address 8, so the write ends this process.
            unsafe { black_box(std::ptr::without_provenance_mut::<u64>(8)).write_volatile(1) };
            Ok(())
        }
        Trouble::Abort => std::process::abort(),
        Trouble::Exit => std::process::exit(3),
        Trouble::Overflow => {
            black_box(deeper(black_box(1)));
            Ok(())
        }
        Trouble::Eat => {
            let mut blocks = Vec::new();
            loop {
                blocks.push(black_box(vec![1_u8; 1 << 20]));
            }
        }
        Trouble::Silence
        | Trouble::Nan
        | Trouble::Infinity
        | Trouble::Beyond
        | Trouble::Flood
        | Trouble::Trespass
        | Trouble::Chatter
        | Trouble::Meddle => Ok(()),
    }
}

/// Recurses until the stack overflows.
fn deeper(depth: u64) -> u64 {
    let page = black_box([depth; 512]);
    if black_box(depth) == 0 {
        return page[0];
    }
    deeper(depth + 1) + page[1]
}
