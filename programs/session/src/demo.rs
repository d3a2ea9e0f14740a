//! `jde demo`: runs the paper's application in the simulator.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_terminal::{self as terminal, FAINT, TITLE};

use crate::cli::{conclude, start_log};
use crate::clock::Time;
use crate::failure::{self, Failure};
use crate::load;
use crate::log::Filter;
use crate::run::{self, Extension, ProgressMode, RunOptions, RunView};
use crate::summary::RunSummary;

/// The application to run.
const APPLICATION: &str = "safe-navigation";
/// Limit of the mission in the application's time: about four times the duration of the mission. A robot that
/// exceeds it is lost.
const MISSION_LIMIT: Nanos = 1200 * 1_000_000_000;
/// Interval between two progress lines in real time, long enough to read them.
const STATUS_INTERVAL: Nanos = 5_000_000_000;
/// The same interval in lockstep, where minutes pass in a second.
const STATUS_INTERVAL_LOCKSTEP: Nanos = 20_000_000_000;

/// Watch a simulated robot navigate a building with people in it: the example of the paper, section 5.
///
/// Ends when the robot has reached all its targets. Writes a picture of its path and all decisions to
/// target/demo. The exit status is 0 only if every target was reached without a collision.
#[derive(Args)]
#[command(after_help = "Examples:
  jde demo
  jde demo --headless --lockstep --seed 1")]
pub struct Demo {
    /// Print lines instead of the oscilloscope.
    #[arg(long, alias = "plain")]
    headless: bool,
    #[command(flatten)]
    time: Time,
    /// End standard output with one line of JSON; all other text goes to standard error.
    #[arg(long)]
    json: bool,
    /// The folder for path.png and decisions.jsonl.
    #[arg(long, value_name = "DIR", default_value = "target/demo", value_hint = ValueHint::DirPath)]
    out: PathBuf,
}

impl Demo {
    /// Runs the demonstration with what accompanies it.
    ///
    /// # Errors
    /// It did not start, or a target was not reached, or the robot collided.
    pub fn run(self, filter: Option<Filter>, extensions: Vec<Box<dyn Extension>>) -> Result<(), Failure> {
        let mut loaded = load::load_to_start(Path::new(APPLICATION), &[])?;
        let log = start_log(filter, &loaded)?;
        if let Some(seed) = self.time.seed {
            loaded.application.seed = seed;
        }
        let mut output = terminal::text_out(self.json);
        let prints_lines = self.headless || self.json || self.time.lockstep || !terminal::is_interactive();
        if prints_lines {
            let application = &loaded.application;
            let (name, file, seed) = (
                &application.name,
                failure::display_path(&application.path),
                application.seed,
            );
            writeln!(
                output,
                "{TITLE}{name}{TITLE:#} {FAINT}({file}, seed {seed}){FAINT:#}: {}",
                application.doc
            )?;
            writeln!(output)?;
        }
        let status_interval = if self.time.lockstep {
            STATUS_INTERVAL_LOCKSTEP
        } else {
            STATUS_INTERVAL
        };
        let above = self.out.parent().unwrap_or(Path::new(""));
        let created = fs::create_dir_all(above).and_then(|()| jde_files::create_folder(&self.out));
        created.map_err(Failure::file(&self.out))?;
        let options = RunOptions {
            lockstep: self.time.lockstep,
            limit: Some(MISSION_LIMIT),
            speed: self.time.speed,
            view: if prints_lines {
                RunView::Lines(ProgressMode::Status(status_interval))
            } else {
                RunView::Screen
            },
            output,
            decisions: Some(self.out.join("decisions.jsonl")),
            picture: Some(self.out.join("path.png")),
            extensions,
            stopped: false,
            watch: false,
        };
        let finished = run::run(loaded, options, &log)?;
        let RunSummary {
            decisions_sha256,
            sim_seconds,
            wall_seconds,
            ..
        } = &finished.summary;
        let out = self.out.display();
        let lines = [
            format!("{sim_seconds:.1} s of simulation took {wall_seconds:.1} s of real time"),
            format!("{out}/path.png         the path in the colours of the winners"),
            format!("{out}/decisions.jsonl  every selection and its reason"),
            format!("decisions_sha256: {decisions_sha256}"),
        ];
        let lines = lines.map(|line| line + "\n").concat();
        conclude(finished, &lines, self.json, |summary| {
            summary.is_fulfilled() && summary.collisions == Some(0) && summary.reached == summary.targets
        })
    }
}
