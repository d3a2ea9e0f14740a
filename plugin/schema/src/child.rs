//! The children of a father: how it wakes, observes and puts them to sleep.

#![allow(unsafe_code)]

use jde_abi::raw;
use jde_core::Policy;

use crate::context::{Context, broken};
use crate::output::Outcome;

/// A role for a child. The application binds it to an instance.
#[derive(Debug)]
pub struct Child {
    index: u32,
    name: &'static str,
}

/// A role for any number of children. The application names them and assigns them to groups, in which they
/// compete.
#[derive(Debug)]
pub struct Children {
    first: u32,
    name: &'static str,
}

/// The state of a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Asleep: uses no processor time, keeps its memory.
    Slept,
    /// Awake, precondition false at the last check.
    Checking,
    /// Awake, precondition true, not chosen.
    Ready,
    /// Awake, and iterates.
    Winner,
}

/// What a father can see of a child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// Its state.
    pub state: State,
    /// Whether it is Faulted.
    pub faulted: bool,
}

impl Child {
    /// Wakes the child. Has no effect on a child that is awake.
    pub fn wake(&self, cx: &Context<'_>) -> Outcome {
        // SAFETY: the context is that of the present call.
        self.outcome("wake", unsafe { (cx.host.wake)(cx.raw.as_ptr(), self.index) })
    }

    /// Puts the child and everything below it to sleep.
    pub fn sleep(&self, cx: &Context<'_>) -> Outcome {
        // SAFETY: the context is that of the present call.
        self.outcome("sleep", unsafe { (cx.host.sleep)(cx.raw.as_ptr(), self.index) })
    }

    /// Returns the child's status. `None` if the application left an optional child unbound.
    #[must_use]
    pub fn status(&self, cx: &Context<'_>) -> Option<Status> {
        let (code, status) = self.query_status(cx);
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

    /// Returns the child's state. SLEPT if the application left an optional child unbound.
    #[must_use]
    pub fn state(&self, cx: &Context<'_>) -> State {
        self.status(cx).map_or(State::Slept, |status| status.state)
    }

    /// Changes the policy of the group in which the child competes.
    pub fn set_policy(&self, cx: &Context<'_>, policy: Policy) -> Outcome {
        let (code, time, number) = (policy.kind().code, policy.time(), policy.number());
        // SAFETY: the context is that of the present call.
        let code = unsafe { (cx.host.set_policy)(cx.raw.as_ptr(), self.index, code, time, number) };
        self.outcome("set_policy", code)
    }

    /// Its index among the roles of its father.
    pub(crate) fn index(&self) -> u32 {
        self.index
    }

    /// Requests the child's status from the host.
    fn query_status(&self, cx: &Context<'_>) -> (i32, raw::ChildStatus) {
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

    /// For generated code only. The host refuses a number that is not a child's.
    #[doc(hidden)]
    #[must_use]
    pub const fn new(index: u32, name: &'static str) -> Self {
        Self { index, name }
    }
}

impl Children {
    /// Wakes all of them, in the order in which the application names them. Has no effect on those that are
    /// awake. Returns the last outcome that is not `Accepted`, if there is one.
    pub fn wake(&self, cx: &Context<'_>) -> Outcome {
        self.each(cx, |child| child.wake(cx))
    }

    /// Puts all of them to sleep, with everything below them. Returns the last outcome that is not
    /// `Accepted`, if there is one.
    pub fn sleep(&self, cx: &Context<'_>) -> Outcome {
        self.each(cx, |child| child.sleep(cx))
    }

    /// Returns each of them, in the order in which the application names them.
    pub fn iter<'a>(&'a self, cx: &'a Context<'_>) -> impl Iterator<Item = Child> + 'a {
        let numbers = (self.first..).map(|number| Child::new(number, self.name));
        // Ends at the first number that is not a child's. It also ends in a call that the host has
        // given up, because all its requests are refused.
        numbers.take_while(|child| child.query_status(cx).0 == raw::OK)
    }

    fn each(&self, cx: &Context<'_>, request: impl Fn(&Child) -> Outcome) -> Outcome {
        let outcomes = self.iter(cx).map(|child| request(&child));
        let missed = outcomes.filter(|outcome| *outcome != Outcome::Accepted).last();
        missed.unwrap_or(Outcome::Accepted)
    }

    /// For generated code only. The host refuses a number that is not a child's.
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
