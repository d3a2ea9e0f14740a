//! Where the functions of an instance run: in this process, or in one of their own. The rest of the host
//! treats both alike.

#![allow(unsafe_code)]

use jde_panel::{Gesture, List};

use super::host_table::HOST;
use super::{Call, Given, Here, Question, Remembered, Verdict};
use crate::apart::Apart;

/// The functions of an instance that was created.
pub(crate) enum Body {
    Here(Here),
    Apart(Box<Apart>),
}

/// Each function returns a status of the ABI. The reason for a failure is in the call.
impl Body {
    pub(super) fn create(call: &mut Call<'_>) -> Option<Self> {
        match call.engine.room(call.number) {
            // SAFETY: the table was checked.
            None => unsafe { Here::create(call.build.table, &HOST, context(call)) }.map(Self::Here),
            Some(room) => Apart::create(call, &room).map(|apart| Self::Apart(Box::new(apart))),
        }
    }

    pub(super) fn awake(&mut self, call: &mut Call<'_>) -> i32 {
        match self {
            Self::Here(here) => here.awake(context(call)),
            Self::Apart(apart) => apart.awake(call),
        }
    }

    pub(super) fn check(&mut self, call: &mut Call<'_>) -> (i32, bool, f64) {
        match self {
            Self::Here(here) => here.check(context(call)),
            Self::Apart(apart) => apart.check(call),
        }
    }

    pub(super) fn iterate(&mut self, call: &mut Call<'_>) -> i32 {
        match self {
            Self::Here(here) => here.iterate(context(call)),
            Self::Apart(apart) => apart.iterate(call),
        }
    }

    pub(super) fn arbitrate(&mut self, call: &mut Call<'_>, question: &Question) -> (i32, Verdict) {
        match self {
            Self::Here(here) => here.arbitrate(context(call), question),
            Self::Apart(apart) => apart.arbitrate(call, question),
        }
    }

    pub(super) fn sleep(&mut self, call: &mut Call<'_>) {
        match self {
            Self::Here(here) => here.sleep(context(call)),
            Self::Apart(apart) => apart.sleep(call),
        }
    }

    pub(super) fn draw(&mut self, call: &mut Call<'_>) -> (i32, Result<List, String>) {
        let now = call.engine.clock.now();
        match self {
            Self::Here(here) => here.draw(context(call), now),
            Self::Apart(apart) => apart.draw(call),
        }
    }

    pub(super) fn touch(&mut self, call: &mut Call<'_>, by: &str, gesture: &Gesture) -> i32 {
        match self {
            Self::Here(here) => here.touch(context(call), by, gesture),
            Self::Apart(apart) => apart.touch(call, by, gesture),
        }
    }

    pub(super) fn save(&mut self, call: &mut Call<'_>) -> (i32, Result<Vec<u8>, String>) {
        match self {
            Self::Here(here) => here.save(context(call)),
            Self::Apart(apart) => apart.save(call),
        }
    }

    pub(super) fn restore(&mut self, call: &mut Call<'_>, remembered: &Remembered) -> i32 {
        match self {
            Self::Here(here) => here.restore(context(call), remembered),
            Self::Apart(apart) => apart.restore(call, remembered),
        }
    }

    /// Whether its process is dead.
    pub(super) fn is_dead(&self) -> bool {
        match self {
            Self::Here(_) => false,
            Self::Apart(apart) => apart.is_dead(),
        }
    }

    /// Whether the rules must be informed of a failure. A death returns true only once.
    pub(super) fn is_to_tell(&self) -> bool {
        match self {
            Self::Here(_) => true,
            Self::Apart(apart) => apart.is_to_tell(),
        }
    }
}

/// The context that the functions of [`HOST`] expect.
fn context<'c>(call: &'c mut Call<'_>) -> Given<'c> {
    // SAFETY: the functions of `HOST` expect a `Call` behind their context.
    unsafe { Given::new(call) }
}
