//! Memory for exports of a build that the application does not have: they are written and discarded.

use std::collections::BTreeMap;

use crate::history::Aligned;

/// Memory by port, as the build numbers them.
#[derive(Default)]
pub(super) struct Scratch {
    rooms: BTreeMap<u32, Aligned>,
    /// The ports loaned in the present call.
    loaned: Vec<u32>,
}

impl Scratch {
    pub(super) fn room(&mut self, port: u32, bytes: usize) -> &mut [u8] {
        if !self.has(port) {
            self.loaned.push(port);
        }
        let room = self.rooms.entry(port);
        room.or_insert_with(|| Aligned::new(&vec![0; bytes])).bytes_mut()
    }

    /// Whether the port was loaned in the present call.
    pub(super) fn has(&self, port: u32) -> bool {
        self.loaned.contains(&port)
    }

    pub(super) fn discard(&mut self) {
        self.loaned.clear();
    }
}
