//! A running application seen from outside: what its answers look like. How they are fetched is the business of `jde-link`.

pub(crate) mod hierarchy;
pub(crate) mod live;
pub(crate) mod name;
pub(crate) mod panel;
pub(crate) mod part;
pub(crate) mod table;
