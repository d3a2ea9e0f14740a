//! The open readers and writers of a variable, and the granted writers. Holds names and numbers; the cell
//! holds the grants.

use std::collections::BTreeSet;

/// Writers by index, readers by ticket, grants by id.
pub(crate) struct Register {
    /// Indexed like the grants in the cell.
    writers: Vec<Option<(u32, String)>>,
    /// Indexed by ticket. Readers beyond the declared number copy their values.
    readers: Vec<Option<String>>,
    /// Ids that hold a grant, whether open or not.
    pub(crate) granted: BTreeSet<u32>,
}

impl Register {
    pub(crate) fn new(max_writers: usize) -> Self {
        Self {
            writers: vec![None; max_writers],
            readers: Vec::new(),
            granted: BTreeSet::new(),
        }
    }

    /// Returns the index of a new writer, if one is free.
    pub(crate) fn open_writer(&mut self, id: u32, name: &str) -> Option<usize> {
        let writer_index = self.writers.iter().position(Option::is_none)?;
        self.writers[writer_index] = Some((id, name.to_owned()));
        Some(writer_index)
    }

    pub(crate) fn close_writer(&mut self, writer_index: usize) {
        self.writers[writer_index] = None;
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

    /// Returns the indices at which this writer is open.
    pub(crate) fn grants_of(&self, id: u32) -> impl Iterator<Item = usize> {
        let writers = self.writers.iter().enumerate();
        writers
            .filter(move |(_, writer)| matches!(writer, Some((open, _)) if *open == id))
            .map(|(writer_index, _)| writer_index)
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
