//! The name of a case: one run of an application with some faults. The seed and this name determine
//! everything in it.

use std::fmt;
use std::str::FromStr;

use anyhow::{Context as _, bail};
use clap::ValueEnum;

/// The clock and the process of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum RunMode {
    /// Virtual time on one thread.
    Lockstep,
    /// Real time, in this process.
    RealTime,
    /// Real time, in processes of their own.
    Outside,
}

/// The application of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Scenario {
    /// Safe navigation, with additional schemas that misbehave on command.
    Demo,
    /// A hundred schemas in deep and wide groups.
    Hundred,
}

/// One run of an application with some faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Case {
    /// The clock.
    pub clock: RunMode,
    /// The application.
    pub scenario: Scenario,
    /// The number among cases of this clock and application.
    pub number: u64,
}

/// Returns a value's name on the command line.
pub fn name(value: &impl ValueEnum) -> String {
    let value = value.to_possible_value().expect("no value is hidden");
    value.get_name().to_owned()
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}/{}/{}",
            name(&self.clock),
            name(&self.scenario),
            self.number
        )
    }
}

impl FromStr for Case {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let error = || {
            format!("`{text}` is not a case; write one as a failure shows it, such as lockstep/hundred/12")
        };
        let mut parts = text.split('/');
        let (clock, scenario, number) = (parts.next(), parts.next(), parts.next());
        let clock = clock.and_then(|name| RunMode::from_str(name, false).ok());
        let scenario = scenario.and_then(|name| Scenario::from_str(name, false).ok());
        let number = number.and_then(|number| number.parse().ok());
        let case = Self {
            clock: clock.with_context(error)?,
            scenario: scenario.with_context(error)?,
            number: number.with_context(error)?,
        };
        if parts.next().is_some() || (case.clock == RunMode::Outside && case.scenario == Scenario::Hundred) {
            bail!(error());
        }
        Ok(case)
    }
}

#[cfg(test)]
mod tests {
    use super::Case;

    #[test]
    fn a_case_is_parsed_from_its_display_text() {
        for text in ["lockstep/hundred/12", "real-time/demo/0", "outside/demo/3"] {
            let case: Case = text.parse().expect(text);
            assert_eq!(case.to_string(), text);
        }
        for text in [
            "",
            "lockstep",
            "lockstep/demo",
            "lockstep/demo/x",
            "outside/hundred/1",
            "lockstep/demo/1/2",
        ] {
            assert!(text.parse::<Case>().is_err(), "{text}");
        }
    }
}
