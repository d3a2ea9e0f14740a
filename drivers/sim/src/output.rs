//! The measurements of a sensor on their way to its export: when the next one is due, and those that have been made and
//! have not arrived yet.

use core::time::Duration;
use std::collections::VecDeque;

use jde_schema::prelude::*;
use jde_schema::types::Value;
use jde_sim::{Delivery, RobotId, World, WorldError};

use crate::scenery;

/// What a sensor has measured and its readers do not have yet.
pub(crate) struct Output<T> {
    /// The time of the next measurement; `None` before the first one.
    due: Option<Duration>,
    /// The oldest first.
    waiting: VecDeque<Waiting<T>>,
}

/// A measurement on its way.
struct Waiting<T> {
    arrives: Duration,
    measured: Duration,
    value: Box<T>,
}

/// A measurement that is made now.
pub(crate) struct Measurement {
    /// The time that it states.
    pub(crate) time: Duration,
    /// How long it takes to arrive; `None` if it is lost.
    pub(crate) delay: Option<Duration>,
}

impl Measurement {
    /// Returns a measurement of a time by a sensor of a robot. `stream` separates the sensors of the robot.
    pub(crate) fn new(
        time: Duration,
        (world, robot): (&World, RobotId),
        (delivery, stream): (&Delivery, u16),
    ) -> Result<Self, WorldError> {
        let delay = world.delay(robot, delivery, stream)?;
        Ok(Self { time, delay })
    }
}

impl<T> Default for Output<T> {
    fn default() -> Self {
        Self {
            due: None,
            waiting: VecDeque::new(),
        }
    }
}

impl<T: Value + Default> Output<T> {
    /// Returns whether the sensor measures now, and counts that it does. Without a period it always does.
    pub(crate) fn is_due(&mut self, now: Duration, period: Option<Duration>) -> bool {
        period.is_none_or(|period| scenery::is_time(&mut self.due, now, period))
    }

    /// Publishes what has arrived.
    pub(crate) fn deliver(&mut self, cx: &Context, export: &mut Export<T>) {
        while let Some(first) = self.waiting.pop_front_if(|first| first.arrives <= cx.now()) {
            export.write_at(cx, *first.value, first.measured);
        }
    }

    /// Publishes a measurement that `fill` writes, now or when it arrives. None overtakes an earlier one.
    pub(crate) fn measure(
        &mut self,
        cx: &Context,
        export: &mut Export<T>,
        Measurement { time, delay }: Measurement,
        fill: impl FnOnce(&mut T) -> Result,
    ) -> Result {
        let Some(delay) = delay else {
            return Ok(());
        };
        if delay == Duration::ZERO && self.waiting.is_empty() {
            let mut value = export.loan(cx);
            fill(&mut value)?;
            if time == cx.now() {
                value.publish();
            } else {
                value.publish_at(time);
            }
            return Ok(());
        }
        let mut value = Box::<T>::default();
        fill(&mut value)?;
        let last = self.waiting.back().map_or(Duration::ZERO, |last| last.arrives);
        self.waiting.push_back(Waiting {
            arrives: (cx.now() + delay).max(last),
            measured: time,
            value,
        });
        Ok(())
    }

    /// Forgets what is on its way: its readers sleep, or it is no longer true.
    pub(crate) fn clear(&mut self) {
        self.waiting.clear();
    }
}
