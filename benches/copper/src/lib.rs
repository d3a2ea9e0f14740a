//! A row of tasks of copper-rs that hand a value on, as schemas do beside them: the manner of its example `caterpillar`. The graph is in
//! `caterpillar.ron`, from which its macro makes the code that runs it. Measures nothing.

use anyhow::{Result, anyhow};
use cu29::prelude::*;

/// The first: says yes and no in turn.
#[derive(Reflect)]
struct Head {
    said: f64,
}

/// One of the row: says what the one before it says.
#[derive(Reflect)]
struct Segment;

/// The last: hears what the one before it says, which is never the same twice.
#[derive(Reflect)]
struct Tail {
    heard: f64,
}

impl Freezable for Head {}
impl Freezable for Segment {}
impl Freezable for Tail {}

impl CuSrcTask for Head {
    type Resources<'r> = ();
    type Output<'m> = output_msg!(f64);

    fn new(_: Option<&ComponentConfig>, (): ()) -> CuResult<Self> {
        Ok(Self { said: 0.0 })
    }

    fn process(&mut self, _: &CuContext, output: &mut Self::Output<'_>) -> CuResult<()> {
        self.said = 1.0 - self.said;
        output.set_payload(self.said);
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
        let said = input.payload().copied();
        output.set_payload(said.unwrap_or_default());
        Ok(())
    }
}

impl CuSinkTask for Tail {
    type Resources<'r> = ();
    type Input<'m> = input_msg!(f64);

    fn new(_: Option<&ComponentConfig>, (): ()) -> CuResult<Self> {
        Ok(Self { heard: 0.0 })
    }

    fn process(&mut self, _: &CuContext, input: &Self::Input<'_>) -> CuResult<()> {
        let said = input.payload().copied().filter(|said| *said != self.heard);
        self.heard = said.ok_or_else(|| CuError::from("what the first says does not arrive"))?;
        Ok(())
    }
}

/// What copper-rs notes the beginning and the end of every task with.
#[derive(Clone, Copy, Debug)]
pub enum Clock {
    /// The processor's, as in a robot.
    Running,
    /// One that stands still, as in its tests.
    Held,
}

/// The tasks, ready to pass so many times from the first to the last.
///
/// # Errors
/// What copper-rs says when it cannot start.
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
            assert!(passed.is_ok(), "it hands the value on: {passed:?}");
        }
    })
}

#[copper_runtime(config = "caterpillar.ron")]
struct Caterpillar {}
