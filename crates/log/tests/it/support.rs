//! Shared code of the tests of recordings.

use std::time::SystemTime;

use jde_log::{Options, Origin};

/// Options for a recording without an application. It panics when the disk accepts no more.
pub(crate) fn options(application: &str, lossless: bool) -> Options<'static> {
    Options {
        origin: Origin {
            application: application.to_owned(),
            seed: 0,
            started: SystemTime::UNIX_EPOCH,
            folder: None,
            file: None,
            hierarchy: None,
        },
        application: None,
        overwrite: false,
        lossless,
        on_error: Box::new(|trouble| panic!("{trouble}")),
    }
}
