//! What the tests of recordings share.

use std::time::SystemTime;

use jde_log::{Options, Origin};

/// A recording of nobody's, that panics when the disk takes no more.
pub(crate) fn options(application: &str, lossless: bool) -> Options<'static> {
    Options {
        origin: Origin {
            application: application.to_owned(),
            seed: 0,
            started: SystemTime::UNIX_EPOCH,
            folder: None,
            file: None,
            cast: None,
        },
        application: None,
        overwrite: false,
        lossless,
        on_trouble: Box::new(|trouble| panic!("{trouble}")),
    }
}
