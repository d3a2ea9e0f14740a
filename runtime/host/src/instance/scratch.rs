//! Memory for exports of a build that the application does not have: they are written and discarded.

use std::collections::BTreeMap;

use jde_loader::AlignedBytes;

/// Memory by port, as the build numbers them.
#[derive(Default)]
pub(super) struct Scratch {
    buffers: BTreeMap<u32, AlignedBytes>,
    /// The ports loaned in the current call.
    loaned: Vec<u32>,
}

impl Scratch {
    pub(super) fn buffer(&mut self, port: u32, bytes: usize) -> &mut [u8] {
        if !self.is_loaned(port) {
            self.loaned.push(port);
        }
        let entry = self.buffers.entry(port);
        entry.or_insert_with(|| AlignedBytes::zeros(bytes)).bytes_mut()
    }

    /// Whether the port was loaned in the current call.
    pub(super) fn is_loaned(&self, port: u32) -> bool {
        self.loaned.contains(&port)
    }

    pub(super) fn discard(&mut self) {
        self.loaned.clear();
    }
}
