//! How much memory a thread of the tests obtains.

#![allow(unsafe_code, reason = "an allocator is unsafe")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts what a thread obtains.
struct Counter;

thread_local! {
    /// The bytes that this thread has obtained so far.
    pub(super) static OBTAINED: Cell<usize> = const { Cell::new(0) };
}

#[global_allocator]
static COUNTER: Counter = Counter;

// SAFETY: the system's allocator does the work.
unsafe impl GlobalAlloc for Counter {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        OBTAINED.set(OBTAINED.get() + layout.size());
        // SAFETY: the caller's layout is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's memory and layout are passed on.
        unsafe { System.dealloc(memory, layout) }
    }
}
