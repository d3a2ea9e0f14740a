//! Schemas that do almost nothing, so that the surrounding costs can be measured. They are loaded as any
//! plugin.

mod ros2;

use std::fs;

use jde_schema::prelude::*;

use ros2::{Listen, Sensors, Talk};

/// The environment variable that names the file for the times of [`Clockwork`], and of each [`Listen`] with its name.
const TIMES_FILE: &str = "JDE_BENCH_NOTES";
/// The environment variable that names the file to which [`First`] writes at its first iteration.
const FIRST_FILE: &str = "JDE_BENCH_FIRST";

/// A perceptive schema that exports nothing.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
pub struct Idle {
    /// Never written.
    #[export]
    out: Export<f64>,
}

/// Is always ready, and does nothing.
#[derive(Describe)]
#[schema(motor, period = "1ms")]
pub struct Act {
    /// An import that keeps another schema awake.
    #[import(optional)]
    input: Import<f64>,
}

/// The first of a chain. Its output alternates between 0 and 1.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
pub struct Head {
    /// 0 or 1.
    #[export]
    out: Export<f64>,
    value: f64,
}

/// One of a chain. It exports its input.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
pub struct Segment {
    /// The export of the schema before.
    #[import]
    input: Import<f64>,
    /// The same value.
    #[export]
    out: Export<f64>,
}

/// Reports its first iteration to the process that started this one.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub struct First {
    reported: bool,
}

/// Records when its periods begin, and is never ready.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub struct Clockwork {
    times: Vec<u64>,
}

impl Schema for Clockwork {
    fn awake(&mut self, _: &Context) -> Result {
        self.times = Vec::with_capacity(10_000);
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        if self.times.len() < self.times.capacity() {
            self.times.push(now(cx));
        }
        Ok(false.into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        let Some(file) = std::env::var_os(TIMES_FILE) else {
            return;
        };
        let text: String = self.times.iter().map(|time| format!("{time}\n")).collect();
        if let Err(error) = fs::write(file, text) {
            error!(cx, "cannot write the times: {error}");
        }
    }
}

fn now(cx: &Context) -> u64 {
    cx.now().as_nanos() as u64
}

impl Schema for Idle {
    fn iterate(&mut self, _: &Context) -> Result {
        let _ = &self.out;
        Ok(())
    }
}

impl Schema for Act {
    fn iterate(&mut self, _: &Context) -> Result {
        let _ = &self.input;
        Ok(())
    }
}

impl Schema for Head {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.value = 1.0 - self.value;
        self.out.write(cx, self.value);
        Ok(())
    }
}

impl Schema for Segment {
    fn iterate(&mut self, cx: &Context) -> Result {
        let value = self.input.get(cx).map(|value| *value);
        self.out.write(cx, value.unwrap_or_default());
        Ok(())
    }
}

impl Schema for First {
    fn iterate(&mut self, _: &Context) -> Result {
        if !self.reported {
            self.reported = true;
            let file = std::env::var_os(FIRST_FILE).ok_or("JDE_BENCH_FIRST is not set")?;
            fs::write(file, "iterated")?;
        }
        Ok(())
    }
}

jde_schema::export!(
    "bench-000",
    "Schemas that do almost nothing.",
    [Idle, Act, Head, Segment, First, Clockwork, Talk, Listen, Sensors]
);
