//! Options that the tests share.

use std::time::SystemTime;

use jde_log::{Options, Origin};

/// Returns options for a recording without an application. The recorder panics at an error of the disk.
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
        on_error: Box::new(|error| panic!("{error}")),
    }
}
