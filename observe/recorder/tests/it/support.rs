//! Options that the tests share.

use std::sync::Arc;
use std::time::SystemTime;

use jde_recorder::{Origin, RecorderOptions, Trouble};
use parking_lot::Mutex;

/// Returns options for a recording without an application. The recorder panics at an error of the disk.
pub(crate) fn options(application: &str, lossless: bool) -> RecorderOptions<'static> {
    RecorderOptions {
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
        on_trouble: Box::new(|error| panic!("{error}")),
    }
}

/// Returns options whose recorder passes on what hinders it.
pub(crate) fn with_troubles(
    application: &str,
    lossless: bool,
) -> (RecorderOptions<'static>, Arc<Mutex<Vec<Trouble>>>) {
    let troubles = Arc::<Mutex<Vec<Trouble>>>::default();
    let reported = Arc::clone(&troubles);
    let options = RecorderOptions {
        on_trouble: Box::new(move |trouble| reported.lock().push(trouble.clone())),
        ..options(application, lossless)
    };
    (options, troubles)
}
