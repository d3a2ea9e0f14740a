//! Schemas that do next to nothing, so that what is around them can be measured. They are loaded as any plugin is.

use std::fs;

use jde_schema::prelude::*;

/// The file that gets the notes of [`Clockwork`].
const NOTES: &str = "JDE_BENCH_NOTES";
/// The file that hears of the first iteration of [`First`].
const HEARS: &str = "JDE_BENCH_FIRST";

/// Perceives nothing.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
pub struct Idle {
    /// Nothing.
    #[export]
    out: Export<f64>,
}

/// Wants to act always, and does nothing.
#[derive(Describe)]
#[schema(motor, period = "1ms")]
pub struct Act {
    /// Something that is kept awake for it.
    #[import(optional)]
    input: Import<f64>,
}

/// The first of a row: says yes and no in turn.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
pub struct Head {
    /// Yes or no.
    #[export]
    out: Export<f64>,
    said: f64,
}

/// One of a row: says what the one before it says.
#[derive(Describe)]
#[schema(perceptive, period = "1ms")]
pub struct Segment {
    /// What the one before says.
    #[import]
    input: Import<f64>,
    /// The same.
    #[export]
    out: Export<f64>,
}

/// Tells whoever started the process that it has iterated.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub struct First {
    told: bool,
}

/// Notes when its periods begin, and never wants to act.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub struct Clockwork {
    began: Vec<u64>,
}

impl Schema for Clockwork {
    fn awake(&mut self, _: &Context) -> Result {
        self.began = Vec::with_capacity(10_000);
        Ok(())
    }

    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        if self.began.len() < self.began.capacity() {
            self.began.push(now(cx));
        }
        Ok(false.into())
    }

    fn iterate(&mut self, _: &Context) -> Result {
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        let Some(file) = std::env::var_os(NOTES) else {
            return;
        };
        let notes: String = self.began.iter().map(|time| format!("{time}\n")).collect();
        if let Err(error) = fs::write(file, notes) {
            error!(cx, "cannot write its notes: {error}");
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
        self.said = 1.0 - self.said;
        self.out.write(cx, self.said);
        Ok(())
    }
}

impl Schema for Segment {
    fn iterate(&mut self, cx: &Context) -> Result {
        let said = self.input.get(cx).map(|said| *said);
        self.out.write(cx, said.unwrap_or_default());
        Ok(())
    }
}

impl Schema for First {
    fn iterate(&mut self, _: &Context) -> Result {
        if !self.told {
            self.told = true;
            let file = std::env::var_os(HEARS).ok_or("nobody hears of it")?;
            fs::write(file, "iterated")?;
        }
        Ok(())
    }
}

jde_schema::export!(
    "bench-000",
    "Schemas that do next to nothing.",
    [Idle, Act, Head, Segment, First, Clockwork]
);
