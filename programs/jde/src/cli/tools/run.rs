//! `jde run`: runs an application.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_app::{Application, Override};
use jde_core::Nanos;
use jde_session::cli::{conclude, start_log};
use jde_session::clock::Time;
use jde_session::load;
use jde_session::log::Filter;
use jde_session::run::{self as session, Extension, ProgressMode, RunOptions, RunView};
use jde_terminal as terminal;

use super::link::Link;
use super::recording::RecordingArgs;
use super::ros_args::RosArgs;
use crate::extensions::{Breakpoints, LinkOptions, PageOptions, RecordOptions, RosOptions};
use crate::failure::Failure;
use crate::page_file;
use crate::quantity;

/// Run an application: on a terminal with the oscilloscope, in a pipe with a line for every takeover and its
/// reason.
///
/// Ends when the mission is done or failed, when the time is up, or on request (Ctrl-C: actuators first, then
/// everything in order; a second one ends at once). A summary follows: how long each schema was WINNER, the
/// worst takeovers against their contracts, faults. The exit status is 0 if the mission was done, or if there
/// is none and the run ended when its time was up or on request.
#[derive(Args)]
#[command(after_help = "Examples:
  jde run apps/safe-navigation.toml
  jde run safe-navigation --lockstep --for 60s --picture path.png
  jde run safe-navigation --record drive.mcap --record-only 'pioneer.*' '*.mission'
  jde run safe-navigation --record drive.mcap --when conflict --when 'pioneer.laser.ranges.exists(r, r < 0.3)'
  jde run safe-navigation --view
  jde run safe-navigation --web             a page for browsers, at the address that it prints
  jde run safe-navigation --break 'vff.won and clearance < 0.2'
  jde run app.toml --debug-python shy                     breakpoint() in the schema shy stops it here
  jde run safe-navigation --watch                         cargo build in another terminal, and the robot drives by the new code
  jde run real-log --plain
  jde run safe-navigation --ros-args -r __node:=scout -p goon.fast:=0.3      a node of ROS 2; ros2 param list /scout
  jde run safe-navigation --set 'goon.fast=0.3 m/s' --log vff=debug")]
pub(crate) struct Run {
    /// The application's file, or the name of one in the folder apps.
    #[arg(value_name = "APP", value_hint = ValueHint::FilePath)]
    application: PathBuf,
    #[command(flatten)]
    time: Time,
    /// End when the application has run this long.
    #[arg(long = "for", value_name = "TIME", allow_hyphen_values = true, value_parser = quantity::time)]
    limit: Option<Nanos>,
    /// Set another initial value of a modulation, or another type of a schema (repeatable).
    #[arg(long, value_name = "SCHEMA.VARIABLE=VALUE")]
    set: Vec<Override>,
    /// Start with everything stopped, until an operator releases it, as by jde release --all.
    #[arg(long, conflicts_with = "lockstep")]
    stopped: bool,
    /// Reload schemas when the files of their plugins change, as jde reload does.
    #[arg(long, conflicts_with = "lockstep")]
    watch: bool,
    /// Let time stand still when this condition becomes true (repeatable), to look at everything; then
    /// continue, make a step or quit. The conditions are those of --when. Drivers of devices refuse it.
    #[arg(long = "break", value_name = "CONDITION")]
    breakpoints: Vec<String>,
    /// Let breakpoint() in this schema in Python stop it at this terminal (repeatable). Meanwhile its commands are neutral, and its call does not count as late.
    #[arg(long, value_name = "SCHEMA", conflicts_with = "breakpoints")]
    debug_python: Vec<String>,
    /// Print lines instead of the oscilloscope.
    #[arg(long)]
    plain: bool,
    /// End standard output with one line of JSON; all other text goes to standard error.
    #[arg(long)]
    json: bool,
    /// Write every selection with its reason to this file, one line of JSON each.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    decisions: Option<PathBuf>,
    /// Draw the drive, coloured by winner, to this PNG file.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    picture: Option<PathBuf>,
    #[command(flatten)]
    record: RecordingArgs,
    #[command(flatten)]
    link: Link,
    /// Serve a page for browsers beside it: as [web] of the application states, or this file instead; without both, on this
    /// machine alone.
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true, conflicts_with = "no_link",
          value_hint = ValueHint::FilePath)]
    web: Option<Option<PathBuf>>,
    /// Serve no page, although the application has a section [web].
    #[arg(long, conflicts_with = "web")]
    no_web: bool,
    #[command(flatten)]
    ros: RosArgs,
}

impl Run {
    /// Runs the application.
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        let mut ros = self.ros.parse(&self.application)?;
        let mut set = self.set;
        set.extend(ros.iter_mut().flat_map(|ros| ros.parameters.drain(..)));
        let mut loaded = load::load_to_start(&self.application, &set)?;
        let sim_time = ros.as_ref().map(|ros| ros.apply(&mut loaded.application));
        let sim_time = sim_time.transpose()?.unwrap_or_default();
        let ros_filter = ros.as_mut().and_then(|ros| ros.filter.take());
        let log = start_log(ros_filter.or(filter), &loaded)?;
        if let Some(seed) = self.time.seed {
            loaded.application.seed = seed;
        }
        debug_python(&mut loaded.application, &self.debug_python)?;
        // A debugger and the oscilloscope would read the same keys.
        let lines = self.plain
            || self.json
            || self.time.lockstep
            || !self.debug_python.is_empty()
            || !terminal::is_interactive();
        // The recording comes first: it fails before the link opens.
        let mut extensions: Vec<Box<dyn Extension>> = Vec::new();
        if let Some(record) = self.record.into_settings()? {
            let log = Some(log.clone());
            extensions.push(Box::new(RecordOptions { log, ..record }));
        }
        // A fault of the page's file is found before the robot moves.
        let link = LinkOptions::from(self.link);
        let stated = loaded.application.web.take().map(page_file::settings);
        let settings = match self.web {
            Some(None) if stated.is_some() => stated,
            Some(file) => Some(page_file::read(file.as_deref())?),
            None => stated.filter(|_| !self.no_web && !self.time.lockstep && link.enabled != Some(false)),
        };
        let page = settings.map(|settings| PageOptions {
            settings,
            log: log.clone(),
        });
        extensions.push(Box::new(LinkOptions {
            stands_still: !self.breakpoints.is_empty() || !self.debug_python.is_empty(),
            enabled: link.enabled.or(page.is_some().then_some(true)),
            page,
            ..link
        }));
        let is_node = ros.is_some();
        if let Some(ros) = ros {
            extensions.push(Box::new(RosOptions {
                remaps: ros.remaps,
                sim_time,
                log: log.clone(),
            }));
        }
        if !self.breakpoints.is_empty() {
            extensions.push(Box::new(Breakpoints {
                conditions: self.breakpoints,
                asks: lines,
            }));
        }
        let options = RunOptions {
            lockstep: self.time.lockstep,
            limit: self.limit,
            speed: self.time.speed,
            view: if lines {
                RunView::Lines(ProgressMode::Takeovers)
            } else {
                RunView::Screen
            },
            output: terminal::text_out(self.json),
            decisions: self.decisions,
            picture: self.picture,
            extensions,
            stopped: self.stopped,
            watch: self.watch,
        };
        let finished = session::run(loaded, options, &log)?;
        // A node of ROS 2 that is asked to end has done what was asked, whatever its mission.
        Ok(conclude(finished, "", self.json, |summary| {
            summary.is_fulfilled() || is_node && summary.was_stopped()
        })?)
    }
}

/// Marks the schemas whose debugger uses this terminal.
fn debug_python(application: &mut Application, names: &[String]) -> Result<(), Failure> {
    for name in names {
        let Some(id) = application.instance(name) else {
            let known = application
                .instances
                .iter()
                .map(|instance| instance.name.as_str());
            return Err(Failure::unknown("schema", name, known));
        };
        let instance = &mut application.instances[id];
        if !application.plugins[instance.plugin].isolated {
            return Err(Failure::usage(
                format!("schema `{name}` is not in Python"),
                "name a schema whose type is in a file of Python",
            ));
        }
        instance.debugged = true;
    }
    if !names.is_empty() && !terminal::is_interactive() {
        return Err(Failure::usage(
            "--debug-python needs a terminal for standard input and output",
            "run it in a terminal, without a pipe",
        ));
    }
    Ok(())
}
