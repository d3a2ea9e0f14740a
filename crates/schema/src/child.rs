//! What a father does with its children: wakes them, puts them to sleep, looks at them.

#![allow(unsafe_code)]

use core::time::Duration;

use jde_abi::raw;

use crate::context::{Context, broken};
use crate::output::Outcome;

/// A role that the application gives to an instance.
#[derive(Debug)]
pub struct Child {
    index: u32,
    name: &'static str,
}

/// A role that any number of children have: the application names them, and says who competes with whom.
#[derive(Debug)]
pub struct Children {
    first: u32,
    name: &'static str,
}

/// What a schema is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Costs no CPU; keeps its memory.
    Slept,
    /// Awake, precondition false at the last check.
    Checking,
    /// Awake, precondition true, not chosen.
    Ready,
    /// Iterates.
    Winner,
}

/// What a father sees of a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// What it is doing.
    pub state: State,
    /// Whether it is Faulted.
    pub faulted: bool,
}

/// Who decides a collision or an absence among the children of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Policy {
    /// The order in which the father names its children.
    Priority,
    /// The highest urgency that a candidate offers.
    Urgency,
    /// The winner stays for `dwell`, and until a rival is more urgent by `hysteresis`.
    Sticky {
        /// How long at least.
        dwell: Duration,
        /// By how much.
        hysteresis: f64,
    },
    /// Each READY child in turn.
    RoundRobin {
        /// For how long each.
        turn: Duration,
    },
    /// The father's own function.
    Father,
}

impl Child {
    /// Wakes it; waking one that is awake changes nothing.
    pub fn wake(&self, cx: &Context<'_>) -> Outcome {
        // SAFETY: the context is that of the present call.
        self.outcome("wake", unsafe { (cx.host.wake)(cx.raw.as_ptr(), self.index) })
    }

    /// Puts it and everything below it to sleep.
    pub fn sleep(&self, cx: &Context<'_>) -> Outcome {
        // SAFETY: the context is that of the present call.
        self.outcome("sleep", unsafe { (cx.host.sleep)(cx.raw.as_ptr(), self.index) })
    }

    /// What it is doing; `None` if the application left an optional child unbound.
    #[must_use]
    pub fn status(&self, cx: &Context<'_>) -> Option<Status> {
        let (code, status) = self.look(cx);
        match code {
            raw::OK => {}
            raw::UNBOUND => return None,
            code => broken(self.name, "child", code),
        }
        Some(Status {
            state: State::of(status.state).unwrap_or_else(|| broken(self.name, "child", raw::BAD_ARGUMENT)),
            faulted: status.faulted != 0,
        })
    }

    /// What it is doing; SLEPT if the application left an optional child unbound.
    #[must_use]
    pub fn state(&self, cx: &Context<'_>) -> State {
        self.status(cx).map_or(State::Slept, |status| status.state)
    }

    /// Changes the policy of the group it competes in.
    pub fn set_policy(&self, cx: &Context<'_>, policy: Policy) -> Outcome {
        let nanos = |time: Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        let (policy, dwell, hysteresis) = match policy {
            Policy::Priority => (raw::POLICY_PRIORITY, 0, 0.0),
            Policy::Urgency => (raw::POLICY_URGENCY, 0, 0.0),
            Policy::Sticky { dwell, hysteresis } => (raw::POLICY_STICKY, nanos(dwell), hysteresis),
            Policy::RoundRobin { turn } => (raw::POLICY_ROUND_ROBIN, nanos(turn), 0.0),
            Policy::Father => (raw::POLICY_FATHER, 0, 0.0),
        };
        // SAFETY: the context is that of the present call.
        let code = unsafe { (cx.host.set_policy)(cx.raw.as_ptr(), self.index, policy, dwell, hysteresis) };
        self.outcome("set_policy", code)
    }

    /// Its place among the roles of its father.
    pub(crate) fn index(&self) -> u32 {
        self.index
    }

    /// What the host answers about it.
    fn look(&self, cx: &Context<'_>) -> (i32, raw::ChildStatus) {
        let mut status = raw::ChildStatus {
            size: size_of::<raw::ChildStatus>() as u32,
            state: raw::SLEPT,
            faulted: 0,
            reserved: 0,
        };
        // SAFETY: the context is that of the present call.
        let code = unsafe { (cx.host.child)(cx.raw.as_ptr(), self.index, &raw mut status) };
        (code, status)
    }

    fn outcome(&self, call: &str, code: i32) -> Outcome {
        Outcome::of(code).unwrap_or_else(|| broken(self.name, call, code))
    }

    /// For derived code alone: a number that is no child's is refused by the host.
    #[doc(hidden)]
    #[must_use]
    pub const fn new(index: u32, name: &'static str) -> Self {
        Self { index, name }
    }
}

impl Children {
    /// Wakes them all, in the order in which the application names them; waking one that is awake changes nothing. Answers what
    /// became of the last that was not accepted.
    pub fn wake(&self, cx: &Context<'_>) -> Outcome {
        self.each(cx, |child| child.wake(cx))
    }

    /// Puts them all to sleep, with everything below them. Answers what became of the last that was not accepted.
    pub fn sleep(&self, cx: &Context<'_>) -> Outcome {
        self.each(cx, |child| child.sleep(cx))
    }

    fn each(&self, cx: &Context<'_>, ask: impl Fn(&Child) -> Outcome) -> Outcome {
        let numbers = (self.first..).map(|number| Child::new(number, self.name));
        // Whoever was given up is refused even that, and gets to an end too.
        let known = numbers.take_while(|child| child.look(cx).0 == raw::OK);
        let asked = known.map(|child| ask(&child));
        let missed = asked.filter(|outcome| *outcome != Outcome::Accepted).last();
        missed.unwrap_or(Outcome::Accepted)
    }

    /// For derived code alone: a number that is no child's is refused by the host.
    #[doc(hidden)]
    #[must_use]
    pub const fn new(first: u32, name: &'static str) -> Self {
        Self { first, name }
    }
}

impl State {
    pub(crate) fn of(state: u32) -> Option<Self> {
        match state {
            raw::SLEPT => Some(Self::Slept),
            raw::CHECKING => Some(Self::Checking),
            raw::READY => Some(Self::Ready),
            raw::WINNER => Some(Self::Winner),
            _ => None,
        }
    }

    pub(crate) fn code(self) -> u32 {
        match self {
            Self::Slept => raw::SLEPT,
            Self::Checking => raw::CHECKING,
            Self::Ready => raw::READY,
            Self::Winner => raw::WINNER,
        }
    }
}
