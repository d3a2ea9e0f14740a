//! `jde web`: serves the page of a running application.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::thread;

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_session::log::{Filter, Log};
use jde_terminal as terminal;
use jde_web::Addresses;
use tokio::sync::oneshot;

use super::client::{Context, Target};
use crate::complete;
use crate::failure::Failure;
use crate::page_file;

/// Serve a page for browsers on a running application: phones, tablets, computers without jde.
///
/// The page shows who acts and why, schemas, values and the log, stops everything, and drives by hand. It is a client of
/// the link, with an address of its own that contains a token. `jde run APP --web` serves one from the start. Without
/// --page it is for browsers of this machine alone.
#[derive(Args)]
#[command(after_help = "Examples:
  jde run safe-navigation --web              prints the address
  jde run safe-navigation --web=page.toml    as a file states: on the network, with TLS
  jde web safe-navigation                    of an application that runs already
  jde web --at tls/robot2:7447 --key me.toml")]
pub(crate) struct Web {
    /// The name of a running application.
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(complete::applications))]
    name: Option<String>,
    /// A file that states where the page listens, its names, TLS, and what its visitors may do.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    page: Option<PathBuf>,
    /// Serve the page of the run that started this process, with these settings in JSON.
    #[arg(long, hide = true, value_name = "SETTINGS", conflicts_with = "page")]
    beside_run: Option<String>,
    #[command(flatten)]
    target: Target,
}

impl Web {
    pub(super) fn run(self, context: &Context, filter: Option<Filter>) -> Result<(), Failure> {
        Log::start(filter.unwrap_or_default());
        let settings = match &self.beside_run {
            Some(settings) => {
                serde_json::from_str(settings).map_err(|error| Failure::broken(error.to_string()))?
            }
            None => page_file::read(self.page.as_deref())?,
        };
        let remote = context.remote(&self.target, self.name.as_deref())?;
        let (end, ended) = oneshot::channel::<()>();
        if self.beside_run.is_some() {
            thread::Builder::new().name("run".to_owned()).spawn(move || {
                // The run holds the other end, and writes nothing.
                let _ = io::copy(&mut io::stdin(), &mut io::sink());
                let _ = end.send(());
            })?;
        } else {
            // Nobody ends it but the application, or a signal.
            std::mem::forget(end);
        }
        let mut unwritten = Ok(());
        let opened = |addresses: &Addresses| unwritten = show(addresses, self.beside_run.is_some());
        let ended = async {
            let _ = ended.await;
        };
        jde_web::serve(&settings, remote, opened, ended).map_err(|error| match error {
            jde_web::Error::Link(error) => Failure::Link(error),
            jde_web::Error::Listen { .. } => Failure::usage(
                error.to_string(),
                "another program may have it: state another port in listen of --page FILE",
            ),
            jde_web::Error::Certificate { .. } | jde_web::Error::System(_) => {
                Failure::broken(error.to_string())
            }
        })?;
        Ok(unwritten?)
    }
}

fn show(addresses: &Addresses, is_beside_run: bool) -> io::Result<()> {
    let mut out = terminal::out();
    if is_beside_run {
        writeln!(out, "{}", serde_json::to_string(addresses)?)?;
    } else {
        if let Some(operate) = &addresses.operate {
            writeln!(out, "page: {operate}")?;
        }
        writeln!(out, "to look only: {}", addresses.read)?;
        writeln!(out, "foxglove: {}", addresses.foxglove)?;
    }
    out.flush()
}
