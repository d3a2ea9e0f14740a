//! The windows of this program.

use std::env;
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use jde_link::Reach;
use jde_view::{Error, Opening};

use crate::failure::Failure;

/// Checks that windows can be opened beside a run.
///
/// # Errors
/// There is no screen.
pub(crate) fn check() -> Result<(), Failure> {
    match jde_view::has_screen() {
        true => Ok(()),
        false => Err(Failure::usage(
            Error::NoScreen.to_string(),
            "run it without --view, and use jde view --at on a machine that has a screen",
        )),
    }
}

/// Shows windows on an application or a recording until they are closed. `link` has the options of this program by which
/// it reaches the application.
///
/// # Errors
/// They cannot be opened, or were lost.
pub(crate) fn open(
    reach: Reach,
    application: Option<String>,
    recording: Option<PathBuf>,
    from: Option<u64>,
    link: &[OsString],
) -> Result<(), Failure> {
    let program = env::current_exe()
        .map_err(|error| Failure::broken(format!("the path of this program cannot be found: {error}")))?;
    let opening = Opening {
        reach,
        application,
        recording,
        from,
        player: [program.as_os_str()]
            .into_iter()
            .chain(["replay", "--plain", "--stay", "--until-eof"].map(OsStr::new))
            .map(OsStr::to_owned)
            .collect(),
        recorder: [program.as_os_str()]
            .into_iter()
            .chain(["record", "--until-eof"].map(OsStr::new))
            .chain(link.iter().map(OsString::as_os_str))
            .map(OsStr::to_owned)
            .collect(),
        recordings: env::current_dir().into_iter().collect(),
    };
    jde_view::run(opening).map_err(|error| match error {
        Error::NoScreen => Failure::usage(
            error.to_string(),
            "without a screen: jde top in this terminal, or jde view --at on a machine that has one",
        ),
        Error::NoCard(_) | Error::Lost(_) | Error::Taken(_) | Error::Window(_) => {
            Failure::broken(error.to_string())
        }
    })
}
