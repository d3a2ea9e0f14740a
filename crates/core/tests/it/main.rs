//! The state machine: its rules in stories, in random and in all orders of events, and its specifications.

mod edges;
mod falls;
mod family;
mod invariants;
mod model;
mod policies;
mod random;
mod scenarios;
mod specification;
mod story;
