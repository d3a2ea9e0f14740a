//! A campaign of faults: hundreds of them, of every kind, at random moments in running applications, and an observer that says what
//! does not hold all the same. One seed gives one campaign. It mends nothing and excuses nothing.

pub mod campaign;
pub mod case;
pub mod chance;
pub mod observer;
mod outside;
pub mod plan;
pub mod run;
pub mod stage;
pub mod table;
