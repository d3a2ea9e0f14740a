//! Trouble, made on purpose: all that can go wrong in any call. What goes wrong with what a schema commands is its own affair.

#![allow(unsafe_code, reason = "a wild pointer is one of the troubles")]

use std::hint::black_box;
use std::time::Duration;

use jde_schema::prelude::*;

use crate::orders::Trouble;

/// Longer than any schema of a campaign may take before it counts as hung.
const DAWDLE: Duration = Duration::from_millis(900);
/// Some budgets of the schemas of this plugin, and less than what counts as hung.
const SLOW: Duration = Duration::from_millis(35);

/// Makes the trouble, if it is one that can be made in any call.
///
/// # Errors
/// When that is the trouble.
pub(crate) fn make(trouble: Trouble) -> Result {
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
            // SAFETY: there is none, which is the point: the page at address 8 is nobody's, and this process ends here.
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
            let mut kept = Vec::new();
            loop {
                kept.push(black_box(vec![1_u8; 1 << 20]));
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

/// Goes on until there is no stack left.
fn deeper(depth: u64) -> u64 {
    let page = black_box([depth; 512]);
    if black_box(depth) == 0 {
        return page[0];
    }
    deeper(depth + 1) + page[1]
}
