//! One suite for all executors: threads, pool and lockstep keep the same rules. The name of each test states
//! its rule.

#[path = "../common/mod.rs"]
mod common;

mod arbitration;
mod chattering;
mod contracts;
mod failing_exports;
mod faults;
mod gestures;
mod guards;
mod hangs;
mod hangs_at_the_end;
mod hangs_in_c;
mod many_schemas;
mod mocks;
mod operators;
mod panels;
mod panels_in_time;
mod records;
mod reload;
mod remote;
mod selection;
mod shutdown;
mod stopping;
mod takeover;
mod time;
mod unload;
mod values;
