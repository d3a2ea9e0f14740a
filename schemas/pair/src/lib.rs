//! The smallest export and import: one schema counts, another logs the numbers.

use jde_schema::prelude::*;

/// Counts its iterations.
#[derive(Describe)]
#[schema(perceptive, period = "100ms")]
pub struct Talker {
    /// Iterations so far.
    #[export]
    count: Export<u64>,
    so_far: u64,
}

/// Logs each number that it imports. It commands no actuator.
#[derive(Describe)]
#[schema(motor, period = "100ms")]
pub struct Listener {
    /// The number to log.
    #[import(trigger)]
    count: Import<u64>,
    logged: u64,
}

impl Schema for Talker {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.so_far += 1;
        self.count.write(cx, self.so_far);
        Ok(())
    }
}

impl Schema for Listener {
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        Ok(self
            .count
            .get(cx)
            .is_some_and(|count| *count != self.logged)
            .into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.logged = *self.count.require(cx)?.value();
        info!(cx, "heard {}", self.logged);
        Ok(())
    }
}

jde_schema::export!(
    "pair",
    "An export and an import in the smallest form.",
    [Talker, Listener]
);

#[cfg(test)]
mod tests;
