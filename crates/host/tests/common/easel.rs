//! A motor schema with a panel, which draws what the test defines.

use std::sync::Arc;

use jde_schema::prelude::*;

use super::stage::Stage;

/// A motor schema with a panel.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
pub(crate) struct Easel {
    /// The number of its stage.
    #[modulation(default = 0, fixed)]
    stage: Modulation<u32>,
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

/// Draws the panel of an easel.
pub(crate) type Brush = Arc<dyn Fn(&Easel, &Context, &mut Pen) + Send + Sync>;

impl Schema for Easel {
    fn check(&mut self, _: &Context) -> Result<Precondition> {
        Ok(self.ready.0.into())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        self.seen = self.input.get(cx).map(|input| *input.value());
        self.iterations += 1;
        Stage::of(self.stage.get(cx)).note(|| format!("{} iterate", cx.name()));
        Ok(())
    }
}

impl Panel for Easel {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let stage = Stage::of(self.stage.get(cx));
        stage.note(|| format!("{} draw", cx.name()));
        if let Some(brush) = stage.brush(cx.name()) {
            brush(self, cx, pen);
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let stage = Stage::of(self.stage.get(cx));
        stage.note(|| format!("{} {}", gesture.by(), gesture.words(cx.name())));
        if gesture.pressed("fail") {
            return Err("somebody pressed `fail`".into());
        }
        assert!(!gesture.pressed("panic"), "somebody pressed `panic`");
        if let Some(ready) = gesture.toggled("ready") {
            self.ready.0 = ready;
        }
        Ok(())
    }
}
