//! An application in lockstep that advances period by period.

use std::path::Path;

use anyhow::{Result, anyhow};
use jde_app::parse;
use jde_host::{Lockstep, Options};
use jde_loader::Plugins;

/// The period of the schemas whose iterations are counted, ns.
const PERIOD: u64 = 1_000_000;

/// An application in lockstep.
pub struct Periods {
    lockstep: Lockstep,
    now: u64,
}

impl Periods {
    /// Starts the application of `text` with these plugins.
    ///
    /// # Errors
    /// If the text has faults, or the application does not start.
    pub fn of(text: &str, plugins: &Plugins) -> Result<Self> {
        let application =
            parse(text, Path::new("bench.toml"), &[], plugins).map_err(|faults| anyhow!("{faults}"))?;
        let lockstep = Lockstep::start(application, plugins, Options::default())?;
        Ok(Self { lockstep, now: 0 })
    }

    /// Returns the current value of a variable.
    ///
    /// # Errors
    /// If there is no such variable, or it has another type.
    pub fn value(&self, variable: &str) -> Result<Option<f64>> {
        let value = self.lockstep.handle().value(variable);
        value.map_err(|error| anyhow!("{error}"))
    }

    /// Runs the given number of periods of 1 ms.
    ///
    /// # Panics
    /// If the application ends.
    pub fn pass(&mut self, periods: u64) {
        self.now += periods * PERIOD;
        let ended = self.lockstep.run_until(self.now);
        assert!(ended.is_none(), "the application ended");
    }
}
