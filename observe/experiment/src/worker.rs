//! The process of a job: it runs the drives whose numbers it reads, one line each with the seed if it is
//! another than the drive's own, and answers each with the line of its result. It ends at the end of its
//! input, and at once when its parent is gone.

use std::fs::File;
use std::io::{self, BufRead, Write};
use std::path::PathBuf;

use jde_host::Options;
use jde_isolation::Program;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::process::{
    PidfdFlags, Resource, Rlimit, Signal, getpid, getppid, kill_process, pidfd_open, setrlimit,
};

use crate::applications::Applications;
use crate::drive::{PreparedDrive, unjudged};
use crate::experiment::Experiment;
use crate::file;
use crate::folder::fingerprint;
use crate::result::{DriveResult, Outcome};

/// What a job's process is started with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerArguments {
    /// The experiment's file.
    pub file: PathBuf,
    /// The application's file.
    pub application: PathBuf,
    /// The fingerprint of the experiment that the parent checked.
    pub fingerprint: String,
    /// The most memory of the process, bytes.
    pub memory: u64,
}

impl WorkerArguments {
    /// Returns the arguments in their order.
    #[must_use]
    pub fn to_vec(&self) -> Vec<String> {
        vec![
            self.file.display().to_string(),
            self.application.display().to_string(),
            self.fingerprint.clone(),
            self.memory.to_string(),
        ]
    }

    /// Reads the arguments; `None` if they are not those of [`Self::to_vec`].
    pub fn read(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        Some(Self {
            file: arguments.next()?.into(),
            application: arguments.next()?.into(),
            fingerprint: arguments.next()?,
            memory: arguments.next()?.parse().ok()?,
        })
    }
}

/// Serves drives until the input ends. `isolation_program` runs schemas that need processes of their own, and
/// `inspector` describes those in Python.
///
/// # Errors
/// The experiment cannot be read any more, or has changed; the parent is gone.
pub fn serve(
    arguments: &WorkerArguments,
    isolation_program: &Program,
    inspector: &Program,
) -> Result<(), String> {
    let mut output = take_output().map_err(|error| format!("no output: {error}"))?;
    end_with_parent().map_err(|error| format!("the parent cannot be watched: {error}"))?;
    limit_memory(arguments.memory).map_err(|error| format!("the memory cannot be limited: {error}"))?;
    let (experiment, mut applications) = read(arguments, inspector)?;
    if fingerprint(&experiment, &mut applications).map_err(|error| error.to_string())?
        != arguments.fingerprint
    {
        return Err(String::from(
            "the experiment, its application, a world or a plugin has changed since the start",
        ));
    }
    for line in io::stdin().lock().lines() {
        let line = line.map_err(|error| error.to_string())?;
        let mut words = line.split(' ').map(str::parse::<u64>);
        let Some(Ok(drive)) = words.next() else {
            return Err(format!("`{line}` is not a drive"));
        };
        let seed = words.next().and_then(Result::ok);
        let result = run(
            &experiment,
            (drive as usize, seed),
            &mut applications,
            isolation_program,
        );
        writeln!(output, "{}", result.to_line(&experiment.columns)).map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn read(
    WorkerArguments {
        file, application, ..
    }: &WorkerArguments,
    inspector: &Program,
) -> Result<(Experiment, Applications), String> {
    let with_inspector = |application| Applications::new(application, Some(inspector.clone()));
    file::read(file, Some(application), with_inspector).map_err(|faults| faults.to_string())
}

/// Runs a drive; one that cannot begin is a result too.
fn run(
    experiment: &Experiment,
    (drive, seed): (usize, Option<u64>),
    applications: &mut Applications,
    isolation_program: &Program,
) -> DriveResult {
    let options = Options {
        isolation_program: Some(isolation_program.clone()),
        ..Options::default()
    };
    PreparedDrive::new(experiment, drive, seed, applications)
        .map_err(|faults| faults.list()[0].to_string())
        .and_then(|prepared| {
            prepared
                .run(experiment, options)
                .map_err(|error| error.to_string())
        })
        .unwrap_or_else(|why| unjudged(experiment, drive, Outcome::Broken, why))
}

/// Takes standard output for the results. What plugins print goes to standard error.
fn take_output() -> io::Result<File> {
    let output = rustix::io::dup(rustix::stdio::stdout())?;
    rustix::stdio::dup2_stdout(rustix::stdio::stderr())?;
    Ok(output.into())
}

/// Ends this process when its parent is gone, also within a drive, whose result nobody reads any more.
fn end_with_parent() -> io::Result<()> {
    let Some(parent) = getppid() else {
        return Ok(());
    };
    let parent = pidfd_open(parent, PidfdFlags::empty())?;
    let wait = move || {
        let mut watched = [PollFd::new(&parent, PollFlags::IN)];
        while poll(&mut watched, None) == Err(Errno::INTR) {}
        // No handler of a plugin delays it.
        let _ = kill_process(getpid(), Signal::KILL);
    };
    std::thread::Builder::new()
        .name("parent".to_owned())
        .spawn(wait)
        .map(drop)
}

fn limit_memory(bytes: u64) -> io::Result<()> {
    let limit = Rlimit {
        current: Some(bytes),
        maximum: Some(bytes),
    };
    setrlimit(Resource::Data, limit).map_err(io::Error::from)
}
