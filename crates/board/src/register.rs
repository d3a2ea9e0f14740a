//! The open readers and writers of a variable, and the granted writers. Holds names and numbers; the cell
//! holds the grants.

use std::collections::BTreeSet;

/// Writers by seat, readers by ticket, grants by id.
pub(crate) struct Register {
    /// Indexed by seat. Grants in the cell have the same numbers.
    writers: Vec<Option<(u32, String)>>,
    /// Indexed by ticket. Readers beyond the declared number copy their values.
    readers: Vec<Option<String>>,
    /// Ids that hold a grant, whether open or not.
    pub(crate) granted: BTreeSet<u32>,
}

impl Register {
    pub(crate) fn new(seats: usize) -> Self {
        Self {
            writers: vec![None; seats],
            readers: Vec::new(),
            granted: BTreeSet::new(),
        }
    }

    /// Returns a seat for a writer, if one is free.
    pub(crate) fn open_writer(&mut self, id: u32, name: &str) -> Option<usize> {
        let seat = self.writers.iter().position(Option::is_none)?;
        self.writers[seat] = Some((id, name.to_owned()));
        Some(seat)
    }

    pub(crate) fn close_writer(&mut self, seat: usize) {
        self.writers[seat] = None;
    }

    /// Returns the lowest free ticket.
    pub(crate) fn open_reader(&mut self, name: &str) -> usize {
        let free = self.readers.iter().position(Option::is_none);
        let ticket = free.unwrap_or_else(|| {
            self.readers.push(None);
            self.readers.len() - 1
        });
        self.readers[ticket] = Some(name.to_owned());
        ticket
    }

    /// Returns an empty name for a free ticket.
    pub(crate) fn reader_name(&self, ticket: usize) -> &str {
        self.readers[ticket].as_deref().unwrap_or_default()
    }

    pub(crate) fn close_reader(&mut self, ticket: usize) {
        self.readers[ticket] = None;
    }

    /// Returns the seats on which this writer is open.
    pub(crate) fn grants_of(&self, id: u32) -> impl Iterator<Item = usize> {
        let seats = self.writers.iter().enumerate();
        seats
            .filter(move |(_, writer)| matches!(writer, Some((open, _)) if *open == id))
            .map(|(seat, _)| seat)
    }

    pub(crate) fn writers(&self) -> Vec<String> {
        self.writers
            .iter()
            .flatten()
            .map(|(_, name)| name.clone())
            .collect()
    }

    pub(crate) fn readers(&self) -> Vec<String> {
        self.readers.iter().flatten().cloned().collect()
    }
}
