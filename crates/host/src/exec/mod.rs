//! The executors: which thread calls the runners, and when. The selection is the engine's and the same for
//! all executors (R16).

mod calendar;
mod capacity;
mod ending;
pub(crate) mod lockstep;
pub(crate) mod pool;
pub(crate) mod supervisor;
pub(crate) mod threads;
