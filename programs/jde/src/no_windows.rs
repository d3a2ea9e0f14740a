//! In a build without the feature `view`: there are no windows.

use std::path::PathBuf;

use jde_link::Reach;

use crate::failure::Failure;

pub(crate) fn check() -> Result<(), Failure> {
    Err(Failure::usage(
        "this jde was built without windows",
        "jde top shows a run in this terminal; jde view --at does it on a machine whose jde has windows",
    ))
}

pub(crate) fn open(_: Reach, _: Option<String>, _: Option<PathBuf>) -> Result<(), Failure> {
    check()
}
