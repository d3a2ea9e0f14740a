//! The life of an instance from its creation to its end, as a host would lead it.

#![allow(unsafe_code)]

use std::fmt;
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_abi::describe::{Kind, Schema};
use jde_abi::raw;
use jde_loader::SchemaFunctions;
use jde_loader::instance::{ArbitrationQuery, CandidateChild, InProcessInstance};

use crate::bench::{Bench, Circumstances};

/// The type of schema that is checked.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'s> {
    pub(crate) schema: &'s Schema,
    pub(crate) functions: SchemaFunctions,
    /// Who asks for the check. A byte before each life tells it that the check goes on.
    pub(crate) asker: &'s UnixStream,
}

/// An instance with its host.
pub(crate) struct Life<'s> {
    pub(crate) bench: Box<Bench<'s>>,
    pub(crate) instance: InProcessInstance,
    subject: Subject<'s>,
}

/// What a life was like.
#[derive(Default)]
pub(crate) struct Account {
    /// The first call that failed.
    pub(crate) failure: Option<FailedCall>,
    /// As in [`Bench`].
    pub(crate) breaches: Vec<(&'static str, String)>,
    /// As in [`Bench`].
    pub(crate) publications: Vec<(u32, u64, Vec<u8>)>,
}

/// A call that failed.
pub(crate) struct FailedCall {
    pub(crate) call: &'static str,
    pub(crate) status: i32,
    /// The reason that it stated.
    pub(crate) reason: Option<String>,
}

/// With values, bound and with authority.
pub(crate) const USUAL: Circumstances = Circumstances {
    has_values: true,
    is_bound: true,
    has_authority: true,
    is_old: false,
};

/// What is written to who asks. It may precede the JSON of a report.
const BETWEEN_LIVES: &[u8] = b"\n";

/// The turns of a life.
const TURNS_PER_LIFE: usize = 4;

impl<'s> Subject<'s> {
    /// Creates an instance. `Err` contains the reason that it stated, if any.
    pub(crate) fn create(self, circumstances: Circumstances) -> Result<Life<'s>, Option<String>> {
        static APPLICATIONS: AtomicU64 = AtomicU64::new(1);
        let application = APPLICATIONS.fetch_add(1, Ordering::Relaxed);
        // Whoever does not hear it ends this process.
        let _ = (&mut &*self.asker).write_all(BETWEEN_LIVES);
        let mut bench = Box::new(Bench::new(self.schema, circumstances, application));
        let table = bench.table();
        let (instance, reason) = bench.call("create", |context| {
            // SAFETY: the table was checked when its plugin was loaded.
            unsafe { InProcessInstance::create(self.functions, table, context, &[], self.schema.ports.len()) }
        });
        match instance {
            Ok(instance) => Ok(Life {
                bench,
                instance,
                subject: self,
            }),
            Err(_) => Err(reason),
        }
    }

    /// Leads a whole life under these circumstances.
    pub(crate) fn live(self, circumstances: Circumstances) -> Account {
        match self.create(circumstances) {
            Err(reason) => Account {
                failure: failure("create", (raw::FAILED, reason)),
                ..Account::default()
            },
            Ok(mut life) => {
                let failure = life.wake_up().or_else(|| life.take_turns(TURNS_PER_LIFE));
                life.fall_asleep();
                life.end(failure)
            }
        }
    }
}

/// Calls return the first failure.
impl Life<'_> {
    pub(crate) fn wake_up(&mut self) -> Option<FailedCall> {
        let Self { bench, instance, .. } = self;
        failure("awake", bench.call("awake", |context| instance.awake(context)))
    }

    /// Takes turns, with a drawing after each.
    pub(crate) fn take_turns(&mut self, turns: usize) -> Option<FailedCall> {
        (0..turns).find_map(|_| {
            let (is_ready, failed) = self.check();
            failed
                .or_else(|| self.iterate(is_ready))
                .or_else(|| self.draw())
                .or_else(|| self.arbitrate())
        })
    }

    /// Also returns whether the precondition is true.
    fn check(&mut self) -> (bool, Option<FailedCall>) {
        if self.subject.schema.kind != Kind::Motor {
            return (true, None);
        }
        let Self { bench, instance, .. } = self;
        let ((status, is_ready, urgency), reason) = bench.call("check", |context| instance.check(context));
        if status == raw::OK && !urgency.is_finite() {
            let words = format!("its check returned the urgency {urgency}");
            bench.breaches.push(("preconditions", words));
        }
        (
            is_ready && status == raw::OK,
            turn_failure("check", (status, reason)),
        )
    }

    fn iterate(&mut self, is_ready: bool) -> Option<FailedCall> {
        let Self { bench, instance, .. } = self;
        if !bench.may_iterate(is_ready) {
            return None;
        }
        turn_failure(
            "iterate",
            bench.call("iterate", |context| instance.iterate(context)),
        )
    }

    fn draw(&mut self) -> Option<FailedCall> {
        if !self.subject.schema.panel {
            return None;
        }
        let Self { bench, instance, .. } = self;
        let now = bench.now();
        let ((status, list), reason) = bench.call("draw", |context| instance.draw(context, now));
        let wrong = match list {
            _ if status != raw::OK => None,
            Ok(list) => jde_panel::check(&list).err().map(|error| error.to_string()),
            Err(error) => Some(error),
        };
        if let Some(wrong) = wrong {
            bench
                .breaches
                .push(("panel", format!("its panel cannot be shown: {wrong}")));
        }
        failure("draw", (status, reason))
    }

    /// Asks a father about its first group, all of whose children are READY.
    fn arbitrate(&mut self) -> Option<FailedCall> {
        let schema = self.subject.schema;
        let group = schema
            .children
            .iter()
            .find(|child| child.motor)
            .map(|child| &child.group)?;
        if !schema.arbitrates {
            return None;
        }
        let children = schema.children.iter().enumerate();
        let candidates = children.filter(|(_, child)| child.motor && child.group == *group);
        let query = ArbitrationQuery {
            case: raw::COLLISION,
            group: group.clone(),
            candidates: candidates
                .map(|(number, _)| CandidateChild {
                    child: number as u32,
                    state: raw::READY,
                    ready: true,
                    urgency: 0.0,
                })
                .collect(),
            winner: None,
        };
        let Self { bench, instance, .. } = self;
        let ((status, verdict), reason) =
            bench.call("arbitrate", |context| instance.arbitrate(context, &query));
        let candidate = |child| query.candidates.iter().any(|candidate| candidate.child == child);
        match verdict.child {
            _ if status != raw::OK => {}
            Some(child) if !candidate(child) => {
                let words = format!("it chose child {child}, which is not a candidate");
                bench.breaches.push(("arbitrates", words));
            }
            _ if verdict.reason.is_empty() => {
                let words = String::from("it gave no reason for its choice");
                bench.breaches.push(("arbitrates", words));
            }
            _ => {}
        }
        failure("arbitrate", (status, reason))
    }

    pub(crate) fn fall_asleep(&mut self) {
        let Self { bench, instance, .. } = self;
        bench.call("sleep", |context| instance.sleep(context));
    }

    /// Ends the instance.
    pub(crate) fn end(self, failure: Option<FailedCall>) -> Account {
        let Self {
            mut bench, instance, ..
        } = self;
        // The host remains until the instance has ended.
        drop(instance);
        if bench.is_misused() {
            bench.call("destroy", |_| ());
        }
        Account {
            failure,
            breaches: std::mem::take(&mut bench.breaches),
            publications: std::mem::take(&mut bench.publications),
        }
    }
}

fn failure(call: &'static str, (status, reason): (i32, Option<String>)) -> Option<FailedCall> {
    (status != raw::OK).then_some(FailedCall { call, status, reason })
}

/// Of a check or an iteration: it may find an import without a value.
fn turn_failure(call: &'static str, ended: (i32, Option<String>)) -> Option<FailedCall> {
    failure(call, ended).filter(|failure| failure.status != raw::NO_VALUE)
}

impl fmt::Display for FailedCall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = self.reason.as_deref().unwrap_or("it gives no reason");
        match self.status {
            raw::PANICKED => write!(f, "`{}` panicked: {reason}", self.call),
            status => write!(f, "`{}` returned {status}: {reason}", self.call),
        }
    }
}
