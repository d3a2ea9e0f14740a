//! The policy that an instance has. A write of `file` replaces it between two steps, and the one before stays ready for a
//! trial: a new policy that cannot be read never comes into force, and one whose network fails within the trial goes again.

use jde_schema::Imports;
use jde_schema::prelude::*;

use crate::mind::{Mind, Plain, Unfit, words};

/// The steps for which the policy before is kept.
const TRIAL_STEPS: u32 = 30;

/// The numbers that a network sees.
#[derive(Clone, Copy, Value)]
#[repr(C)]
#[value(name = "jde_msgs/msg/PolicySeen")]
pub(crate) struct Seen {
    /// As they went into it; the first ones, if there are more.
    pub(crate) data: Seq<f32, 1024>,
}

/// A policy, and the one before it.
#[derive(Default)]
pub(crate) struct Held {
    mind: Option<Mind>,
    before: Option<Mind>,
    /// The steps that are left of the trial.
    trial: u32,
    /// The number of the write of `file` that was read.
    written: Option<u64>,
}

/// The ports that state a policy.
#[derive(PortBundle)]
pub(crate) struct Stated {
    /// The text file that describes the policy. A write reads it again, also of the same name: a policy that is broken
    /// leaves the one before in force.
    #[modulation(default = "", unit = "file")]
    pub(crate) file: Modulation<Text<1024>>,
    /// The target, for policies that see it.
    #[modulation(default = Target::NONE)]
    pub(crate) target: Modulation<Target>,
    /// The SHA-256 of the network's file and of its weights.
    #[export(lasting)]
    pub(crate) network: Export<Text<64>>,
    /// What went into the network in the last step, in the order of the file: a recording of it is data to train with.
    #[export]
    pub(crate) seen: Export<Seen>,
}

/// Whether a schema takes a policy.
pub(crate) type Takes = fn(&Mind) -> Result<(), String>;

impl Stated {
    /// Reads the policy of the file.
    fn read(&self, cx: &Context, inputs: &Imports<Plain>, takes: Takes) -> Result<Mind, Vec<Unfit>> {
        let mind = Mind::load(self.file.get(cx).as_str(), inputs)?;
        takes(&mind).map_err(|words| vec![Unfit::File(words)])?;
        Ok(mind)
    }

    /// Reports what does not fit, each at its place in the application's file.
    pub(crate) fn inspect(
        &self,
        cx: &Context,
        inputs: &Imports<Plain>,
        takes: Takes,
        problems: &mut Problems,
    ) {
        for unfit in self.read(cx, inputs, takes).err().into_iter().flatten() {
            match unfit {
                Unfit::File(words) => problems.wrong(&self.file, words),
                Unfit::Entry(index, words) => problems.wrong(&inputs[index], words),
            }
        }
    }

    /// Exports what the network saw.
    fn show(&mut self, cx: &Context, mind: &Mind) {
        if mind.decided.is_err() {
            return self.seen.retract(cx);
        }
        let numbers = mind.seen();
        let mut seen = self.seen.loan(cx);
        let room = seen.data.resize(numbers.len());
        room.copy_from_slice(&numbers[..room.len()]);
        seen.publish();
    }

    fn announce(&mut self, cx: &Context, mind: &Mind) {
        info!(
            cx,
            "{}: the network has the SHA-256 {}",
            self.file.get(cx).as_str(),
            mind.runner.hash()
        );
        self.network.write(cx, Text::truncated(mind.runner.hash()));
    }
}

impl Held {
    /// Reads the policy if the instance has none, and begins anew.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn awake(
        &mut self,
        cx: &Context,
        stated: &mut Stated,
        inputs: &Imports<Plain>,
        takes: Takes,
    ) -> Result {
        if self.mind.is_none() {
            self.written = Some(stated.file.sample(cx).sequence());
            self.mind = Some(stated.read(cx, inputs, takes).map_err(|unfit| words(&unfit))?);
        }
        if let Some(mind) = &mut self.mind {
            mind.reset();
            stated.announce(cx, mind);
        }
        Ok(())
    }

    /// Takes a policy that was written, and decides. Returns the policy.
    pub(crate) fn step(
        &mut self,
        cx: &Context,
        stated: &mut Stated,
        inputs: &Imports<Plain>,
        takes: Takes,
    ) -> Option<&Mind> {
        let written = stated.file.sample(cx).sequence();
        if self.written.replace(written) != Some(written) {
            match stated.read(cx, inputs, takes) {
                Ok(mind) => {
                    stated.announce(cx, &mind);
                    self.before = self.mind.replace(mind);
                    self.trial = TRIAL_STEPS;
                }
                Err(unfit) => error!(cx, "the policy before stays in force: {}", words(&unfit)),
            }
        }
        let target = stated.target.get(cx).get();
        let mind = self.mind.as_mut()?;
        let has_failed = mind.step(cx, inputs, target);
        self.trial = self.trial.saturating_sub(1);
        if has_failed && let Some(before) = self.before.take() {
            error!(cx, "the policy before is in force again");
            stated.network.write(cx, Text::truncated(before.runner.hash()));
            let mind = self.mind.insert(before);
            mind.reset();
            mind.step(cx, inputs, target);
        } else if self.trial == 0 {
            self.before = None;
        }
        stated.show(cx, self.mind.as_ref()?);
        self.mind.as_ref()
    }

    /// Returns the policy in force.
    pub(crate) fn mind(&self) -> Option<&Mind> {
        self.mind.as_ref()
    }

    /// Keeps what was commanded.
    pub(crate) fn gave(&mut self, command: [f64; 3]) {
        if let Some(mind) = &mut self.mind {
            mind.gave(command);
        }
    }
}
