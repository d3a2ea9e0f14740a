//! This program as the process of one schema, which a running application starts for each that wants one of its own, and as the process that
//! looks at plugins' files before anybody maps them. They are no verbs: nobody types them.

use std::process::ExitCode;

use jde_host::apart::{Program, serve};
use jde_host::plugin::{Plugins, serve_inspections};

use crate::terminal;

/// What it is called with to run a schema.
const SCHEMA: &str = "--serve-schema";
/// What it is called with to look at plugins.
const INSPECTOR: &str = "--serve-inspections";

/// What runs a schema in a process of its own.
pub(crate) fn program() -> Program {
    itself(SCHEMA)
}

/// What looks at plugins.
pub(crate) fn inspector() -> Program {
    itself(INSPECTOR)
}

/// This very program, whatever has become of its file since it was started.
fn itself(argument: &str) -> Program {
    Program {
        path: "/proc/self/exe".into(),
        arguments: vec![argument.into()],
    }
}

/// Does what this process is for, if that is no verb.
pub(crate) fn main() -> Option<ExitCode> {
    let argument = std::env::args_os().nth(1)?;
    let served = if argument == SCHEMA {
        serve(&Plugins::default())
    } else if argument == INSPECTOR {
        serve_inspections()
    } else {
        return None;
    };
    Some(match served {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // There is nobody to tell that this could not be told.
            drop(writeln!(terminal::err(), "jde: {error}"));
            terminal::let_go();
            let _ = terminal::settle();
            ExitCode::from(2)
        }
    })
}
