//! Fathers that need no code: they wake the children that the application names, all at once or one after another. The
//! application defines the groups, policies and fallbacks. They arbitrate nothing and command nothing.

mod steps;

use jde_schema::prelude::*;

pub use steps::Steps;

/// Keeps all its children awake, whatever their number and names.
///
/// The children compete in one group, unless the application defines others:
/// `groups.NAME = { members = [...] }`. Each group has its own policy and fallback.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "5ms")]
pub struct All {
    /// The children that the application names.
    #[child(group = "all")]
    children: Children,
}

impl Schema for All {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.children.wake(cx);
        Ok(())
    }
}

jde_schema::export!("father", "Fathers that need no code.", [All, Steps]);

#[cfg(test)]
mod tests;
