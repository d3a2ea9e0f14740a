//! A motor schema with a panel, which draws what the test defines.

use std::sync::Arc;

use jde_schema::prelude::*;

use super::scenario::Scenario;

/// A motor schema with a panel.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub(crate) struct PanelMotor {
    /// The number of the scenario.
    #[modulation(default = 0, fixed)]
    scenario: Modulation<u32>,
    /// An input.
    #[import(optional)]
    pub(crate) input: Import<f64>,
    /// A child.
    #[child(group = "base", optional)]
    pub(crate) child: Child,
    /// Speeds of the base.
    #[actuator(optional)]
    pub(crate) base: Actuator<Twist>,
    /// The value of `input` at the last iteration.
    pub(crate) seen: Option<f64>,
    pub(crate) iterations: u64,
    pub(crate) ready: Ready,
}

pub(crate) struct Ready(pub(crate) bool);

impl Default for Ready {
    fn default() -> Self {
        Self(true)
    }
}

/// Draws the panel of a [`PanelMotor`].
pub(crate) type DrawFn = Arc<dyn Fn(&PanelMotor, &Context, &mut Pen) + Send + Sync>;

impl Schema for PanelMotor {
    fn check(&mut self, _: &Context) -> Result<Precondition> {
        Ok(self.ready.0.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.seen = self.input.get(cx).map(|input| *input.value());
        self.iterations += 1;
        Scenario::of(self.scenario.get(cx)).record(|| format!("{} iterate", cx.name()));
        Ok(())
    }
}

impl Panel for PanelMotor {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let scenario = Scenario::of(self.scenario.get(cx));
        scenario.record(|| format!("{} draw", cx.name()));
        if let Some(draw) = scenario.draw_fn(cx.name()) {
            draw(self, cx, pen);
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let scenario = Scenario::of(self.scenario.get(cx));
        scenario.record(|| format!("{} {}", gesture.by(), gesture.words(cx.name())));
        if gesture.pressed("fail") {
            return Err("an operator pressed `fail`".into());
        }
        assert!(!gesture.pressed("panic"), "an operator pressed `panic`");
        if let Some(ready) = gesture.toggled("ready") {
            self.ready.0 = ready;
        }
        Ok(())
    }
}
