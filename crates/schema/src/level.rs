//! The snapshot of a group that a father arbitrates, and its verdict.

#![allow(unsafe_code)]

use core::ffi::CStr;

use jde_abi::{raw, table};

use crate::child::{Child, State};

/// The awake children of a group, at one instant.
#[derive(Debug)]
pub struct Level<'call> {
    group: &'call str,
    case: Case,
    candidates: Vec<Candidate>,
    winner: Option<u32>,
}

/// Why the father is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// Two or more are READY.
    Collision,
    /// None is READY.
    Absence,
}

/// A child that competes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    child: u32,
    /// What it is doing.
    pub state: State,
    /// Whether its precondition held at its last check.
    pub ready: bool,
    /// What it offered at its last check.
    pub urgency: f64,
}

/// The father's answer: a child or nobody, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    pub(crate) child: Option<u32>,
    pub(crate) reason: String,
}

impl<'call> Level<'call> {
    /// Name of the group.
    #[must_use]
    pub fn group(&self) -> &'call str {
        self.group
    }

    /// Why the father is asked.
    #[must_use]
    pub fn case(&self) -> Case {
        self.case
    }

    /// The awake children, in the father's order.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// `child` as a candidate, if it is awake in this group.
    #[must_use]
    pub fn candidate(&self, child: &Child) -> Option<&Candidate> {
        self.candidates.iter().find(|candidate| candidate.is(child))
    }

    /// Whether the precondition of `child` held at its last check; false if it is asleep.
    #[must_use]
    pub fn is_ready(&self, child: &Child) -> bool {
        self.candidate(child).is_some_and(|candidate| candidate.ready)
    }

    /// The child that is WINNER now.
    #[must_use]
    pub fn winner(&self) -> Option<&Candidate> {
        self.candidates
            .iter()
            .find(|candidate| Some(candidate.child) == self.winner)
    }

    /// Reads the host's table; `None` for what breaks the contract of the ABI.
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
    /// Whether this is `child`.
    #[must_use]
    pub fn is(&self, child: &Child) -> bool {
        self.child == child.index()
    }
}

impl Verdict {
    /// `child` is to win.
    #[must_use]
    pub fn choose(child: &Child, reason: impl Into<String>) -> Self {
        Self {
            child: Some(child.index()),
            reason: reason.into(),
        }
    }

    /// Nobody is to win; the group's policy of absence says what becomes of the actuators.
    #[must_use]
    pub fn nobody(reason: impl Into<String>) -> Self {
        Self {
            child: None,
            reason: reason.into(),
        }
    }
}
