//! The Model Context Protocol: robots for agents, over standard input and output.
//!
//! An agent has the rights of the person who started the server, or fewer, and nothing that it says widens them. The
//! tools call the functions of the verbs; none makes a command line. [`tools::TOOL_TABLE`] lists them, each with its right.

mod answer;
mod call;
mod end;
mod folder;
mod holds;
mod lines;
mod output;
mod server;
mod session;
mod tools;
mod transport;

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use jde_terminal as terminal;
use rmcp::ServiceExt;
use rmcp::service::ServerInitializeError;

use crate::cli::tools::client::Target;
use crate::failure::Failure;
use end::End;
use folder::Folder;
use output::Output;
use server::Server;
use session::Session;
use transport::LineTransport;

/// How long the calls under way have after the end began.
const LAST_CALLS: Duration = Duration::from_secs(1);
/// How long the client has to read what is left.
const LAST_ANSWERS: Duration = Duration::from_millis(300);

/// What a server is started with. No call changes it.
pub(crate) struct Options {
    /// Where applications are looked for, and the only one that may be named, if any.
    pub(crate) target: Target,
    /// Whether agents may operate.
    pub(crate) operate: bool,
    /// The folder of all files.
    pub(crate) folder: PathBuf,
    /// Processes at a time of a test or an experiment.
    pub(crate) jobs: usize,
    /// The longest time of a test or an experiment.
    pub(crate) limit: Duration,
}

/// Serves until the client goes: its end of the input is closed, nobody reads the output, the process that started this
/// one is gone, or a signal asks for it.
///
/// # Errors
/// The folder does not exist, or the system refuses a thread or a descriptor.
pub(crate) fn serve(options: Options) -> Result<(), Failure> {
    let folder = Folder::open(&options.folder)?;
    if io::stdin().is_terminal() {
        writeln!(
            terminal::err(),
            "this verb talks to a client of the Model Context Protocol, which starts it; `jde mcp --help` has its \
             configuration, and Ctrl-D ends it"
        )?;
    }
    let (printer, stream) = terminal::reserve_out()?;
    let end = End::watch(stream)?;
    let output = Output::start(printer, &end)?;
    let session = Arc::new(Session::new(options, folder));
    let transport = LineTransport::start(output.clone(), &end)?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()?;
    runtime.block_on(async {
        tokio::select! {
            () = converse(&session, transport) => {}
            () = finish(&session, &end) => {}
        }
    });
    end.begin("the session ended");
    session.abort_calls();
    let holds = end_holds(&session);
    output.finish(LAST_ANSWERS);
    if let Ok(holds) = holds {
        // A panic of it would end nothing more.
        let _ = holds.join();
    }
    // Calls under way have threads of their own, which nobody waits for.
    runtime.shutdown_background();
    Ok(())
}

/// Answers the client until its input ends. A lifecycle that could not begin is begun again.
async fn converse(session: &Arc<Session>, transport: LineTransport) {
    loop {
        match Server::new(Arc::clone(session)).serve(transport.clone()).await {
            Ok(running) => {
                // How it ended makes no difference.
                let _ = running.waiting().await;
                return;
            }
            Err(ServerInitializeError::ConnectionClosed(_)) => return,
            Err(error) => {
                tracing::debug!("no session began: {error}");
                transport.begin_again();
            }
        }
    }
}

/// Waits for the end, ends the holds at once, and leaves a little time to the calls under way.
async fn finish(session: &Arc<Session>, end: &End) {
    end.begun().await;
    // It goes on beside the calls.
    let _ = end_holds(session);
    tokio::time::sleep(LAST_CALLS).await;
}

/// Ends all holds on a thread: each waits for the confirmation of its application, which may be slow.
fn end_holds(session: &Arc<Session>) -> io::Result<JoinHandle<()>> {
    let session = Arc::clone(session);
    let thread = Builder::new().name("mcp-holds".to_owned());
    thread.spawn(move || session.holds.end())
}
