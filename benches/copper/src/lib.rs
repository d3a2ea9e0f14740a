//! A chain of copper-rs tasks that forward a value, for comparison with schemas that do the same. It follows
//! copper-rs's example `caterpillar`. Its macro generates the code from the graph in `caterpillar.ron`.
//! Measures nothing.

use anyhow::{Result, anyhow};
use cu29::prelude::*;

/// The first task. Its output alternates between 0 and 1.
#[derive(Reflect)]
struct Head {
    value: f64,
}

/// A task in the middle: outputs its input.
#[derive(Reflect)]
struct Segment;

/// The last task. It fails if its input is the same as in the pass before.
#[derive(Reflect)]
struct Tail {
    last: f64,
}

impl Freezable for Head {}
impl Freezable for Segment {}
impl Freezable for Tail {}

impl CuSrcTask for Head {
    type Resources<'r> = ();
    type Output<'m> = output_msg!(f64);

    fn new(_: Option<&ComponentConfig>, (): ()) -> CuResult<Self> {
        Ok(Self { value: 0.0 })
    }

    fn process(&mut self, _: &CuContext, output: &mut Self::Output<'_>) -> CuResult<()> {
        self.value = 1.0 - self.value;
        output.set_payload(self.value);
        Ok(())
    }
}

impl CuTask for Segment {
    type Resources<'r> = ();
    type Input<'m> = input_msg!(f64);
    type Output<'m> = output_msg!(f64);

    fn new(_: Option<&ComponentConfig>, (): ()) -> CuResult<Self> {
        Ok(Self)
    }

    fn process(
        &mut self,
        _: &CuContext,
        input: &Self::Input<'_>,
        output: &mut Self::Output<'_>,
    ) -> CuResult<()> {
        let value = input.payload().copied();
        output.set_payload(value.unwrap_or_default());
        Ok(())
    }
}

impl CuSinkTask for Tail {
    type Resources<'r> = ();
    type Input<'m> = input_msg!(f64);

    fn new(_: Option<&ComponentConfig>, (): ()) -> CuResult<Self> {
        Ok(Self { last: 0.0 })
    }

    fn process(&mut self, _: &CuContext, input: &Self::Input<'_>) -> CuResult<()> {
        let value = input.payload().copied().filter(|value| *value != self.last);
        self.last = value.ok_or_else(|| CuError::from("the value of the first task does not arrive"))?;
        Ok(())
    }
}

/// The clock with which copper-rs records the beginning and the end of every task.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    /// The processor's clock, as in a robot.
    Running,
    /// A clock that does not advance, as in copper-rs's tests.
    Held,
}

/// Starts the tasks. The returned function runs the given number of passes from the first task to the last.
///
/// # Errors
/// The error of copper-rs if it cannot start.
pub fn caterpillar(clock: Clock) -> Result<impl FnMut(u64)> {
    let clock = match clock {
        Clock::Running => RobotClock::new(),
        Clock::Held => RobotClock::mock().0,
    };
    let built = Caterpillar::builder().with_clock(clock).build();
    let started = built.map_err(|error| anyhow!("{error}"))?.start();
    let mut running = started.map_err(|error| anyhow!("{error}"))?;
    Ok(move |times| {
        for _ in 0..times {
            let passed = running.run_one_iteration();
            assert!(passed.is_ok(), "a task failed: {passed:?}");
        }
    })
}

#[copper_runtime(config = "caterpillar.ron")]
struct Caterpillar {}
