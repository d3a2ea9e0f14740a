//! The executors: which thread calls the runners, and when. The selection is the engine's and the same for
//! all executors (R16).

mod calendar;
mod capacity;
pub(crate) mod lockstep;
pub(crate) mod pool;
mod shutdown;
pub(crate) mod supervisor;
pub(crate) mod threads;
