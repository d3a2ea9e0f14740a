//! The snapshot of a group that a father arbitrates, and the father's verdict.

#![allow(unsafe_code)]

use core::ffi::CStr;

use jde_abi::{raw, table};

use crate::child::{Child, State};

/// The awake children of a group at one instant.
#[derive(Debug)]
pub struct Level<'call> {
    group: &'call str,
    case: Case,
    candidates: Vec<Candidate>,
    winner: Option<u32>,
}

/// The reason for an arbitration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// Two or more candidates are READY.
    Collision,
    /// No candidate is READY.
    Absence,
}

/// A child that competes in a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    child: u32,
    /// Its state.
    pub state: State,
    /// Whether its precondition held at its last check.
    pub ready: bool,
    /// The urgency that its last check returned.
    pub urgency: f64,
}

/// The father's choice, a child or none, and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    pub(crate) child: Option<u32>,
    pub(crate) reason: String,
}

impl<'call> Level<'call> {
    /// Returns the name of the group.
    #[must_use]
    pub fn group(&self) -> &'call str {
        self.group
    }

    /// Returns the reason for this arbitration.
    #[must_use]
    pub fn case(&self) -> Case {
        self.case
    }

    /// Returns the awake children, in the father's order.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Returns `child` as a candidate, if it is awake in this group.
    #[must_use]
    pub fn candidate(&self, child: &Child) -> Option<&Candidate> {
        self.candidates.iter().find(|candidate| candidate.is(child))
    }

    /// Returns whether the precondition of `child` held at its last check. False if it is asleep.
    #[must_use]
    pub fn is_ready(&self, child: &Child) -> bool {
        self.candidate(child).is_some_and(|candidate| candidate.ready)
    }

    /// Returns the child that is WINNER now, if any.
    #[must_use]
    pub fn winner(&self) -> Option<&Candidate> {
        self.candidates
            .iter()
            .find(|candidate| Some(candidate.child) == self.winner)
    }

    /// Reads the host's table. `None` if the table breaks the contract of the ABI.
    ///
    /// # Safety
    /// `level` and all it points to follow the rules of `raw`, and live until the present call returns.
    pub(crate) unsafe fn of(level: *const raw::Level) -> Option<Self> {
        // SAFETY: the caller's.
        unsafe {
            let level = table::read(level).ok()?;
            let case = match level.case {
                raw::COLLISION => Case::Collision,
                raw::ABSENCE => Case::Absence,
                _ => return None,
            };
            let group = if level.group.is_null() {
                ""
            } else {
                CStr::from_ptr(level.group).to_str().ok()?
            };
            let mut candidates = Vec::with_capacity(level.candidate_count as usize);
            if level.candidate_count > 0 {
                let stride = level.candidates.as_ref()?.size as usize;
                for index in 0..level.candidate_count as usize {
                    let candidate = table::read(level.candidates.byte_add(index * stride)).ok()?;
                    candidates.push(Candidate {
                        child: candidate.child,
                        state: State::of(candidate.state)?,
                        ready: candidate.ready != 0,
                        urgency: candidate.urgency,
                    });
                }
            }
            Some(Self {
                group,
                case,
                candidates,
                winner: u32::try_from(level.winner).ok(),
            })
        }
    }
}

impl Candidate {
    /// Returns whether this candidate is `child`.
    #[must_use]
    pub fn is(&self, child: &Child) -> bool {
        self.child == child.index()
    }
}

impl Verdict {
    /// Chooses `child` as the winner.
    #[must_use]
    pub fn choose(child: &Child, reason: impl Into<String>) -> Self {
        Self {
            child: Some(child.index()),
            reason: reason.into(),
        }
    }

    /// Chooses no winner. The group's absence policy (R9) decides what the actuators do.
    #[must_use]
    pub fn nobody(reason: impl Into<String>) -> Self {
        Self {
            child: None,
            reason: reason.into(),
        }
    }
}
