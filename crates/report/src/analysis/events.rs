//! What happened besides selections and changes of state. Of a great many the first and the last are kept, the rest is counted.

use std::collections::{BTreeMap, VecDeque};

use jde_host::story::Happening;

/// Events that are kept: the first so many, and the last.
const FIRST: usize = 1000;
const LAST: usize = 500;
/// Kinds that are told apart.
const MOST_KINDS: usize = 64;

/// Events in their order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Events {
    first: Vec<Happening>,
    last: VecDeque<Happening>,
    /// Those between.
    pub(crate) left_out: u64,
    /// How many of which kind.
    pub(crate) kinds: BTreeMap<String, u64>,
}

impl Events {
    pub(crate) fn add(&mut self, happening: Happening) {
        if let Some(count) = self.kinds.get_mut(&happening.kind) {
            *count += 1;
        } else if self.kinds.len() < MOST_KINDS {
            self.kinds.insert(happening.kind.clone(), 1);
        }
        if self.first.len() < FIRST {
            self.first.push(happening);
            return;
        }
        self.last.push_back(happening);
        if self.last.len() > LAST {
            self.last.pop_front();
            self.left_out += 1;
        }
    }

    /// How many of a kind.
    pub(crate) fn count(&self, kind: &str) -> u64 {
        self.kinds.get(kind).copied().unwrap_or(0)
    }

    /// The last of a kind.
    pub(crate) fn last_of(&self, kind: &str) -> Option<&Happening> {
        self.kept().filter(|happening| happening.kind == kind).last()
    }

    /// Those that are kept.
    pub(crate) fn kept(&self) -> impl Iterator<Item = &Happening> {
        self.first.iter().chain(&self.last)
    }
}
