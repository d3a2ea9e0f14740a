//! A father that needs no code: it wakes the children that the application names. The application defines the
//! groups, policies and fallbacks. The schema arbitrates nothing and commands nothing.

use jde_schema::prelude::*;

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

jde_schema::export!("father", "Fathers that need no code.", [All]);

#[cfg(test)]
mod tests;
