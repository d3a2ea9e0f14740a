//! This program as the process of one schema, which a running application starts for each that wants one of its own. It is no verb: nobody
//! types it.

use std::io::Write as _;
use std::process::ExitCode;

use jde_host::apart::{Program, serve};
use jde_host::plugin::Plugins;

/// What it is called with then.
const ARGUMENT: &str = "--serve-schema";

/// This very program, whatever has become of its file since it was started.
pub(crate) fn program() -> Program {
    Program {
        path: "/proc/self/exe".into(),
        arguments: vec![ARGUMENT.into()],
    }
}

/// Serves a schema, if that is what this process is for.
pub(crate) fn main() -> Option<ExitCode> {
    if std::env::args_os().nth(1)? != ARGUMENT {
        return None;
    }
    Some(match serve(&Plugins::default()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // There is nobody to tell that this could not be told.
            drop(writeln!(std::io::stderr(), "jde: {error}"));
            ExitCode::from(2)
        }
    })
}
