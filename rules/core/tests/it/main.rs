//! The state machine: its rules in scenarios, in random orders of events and in all orders, and its specifications.

mod edges;
mod family;
mod invariants;
mod loss;
mod model;
mod operators;
mod policies;
mod random;
mod scenario;
mod scenarios;
mod specification;
