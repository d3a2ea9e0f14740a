//! A father that needs no code: it wakes whom the application names. Groups, policies and fallbacks are the application's; it decides
//! nothing and commands nothing.

use jde_schema::prelude::*;

/// Keeps all its children awake, whatever their number and names.
///
/// They compete in one group, unless the application says otherwise: `groups.NAME = { members = [...] }`, each with a policy and a
/// fallback of its own.
#[derive(Describe)]
#[schema(motor, period = "100ms", budget = "5ms")]
pub struct All {
    /// Whom the application names.
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
