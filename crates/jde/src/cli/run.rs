//! `jde run`: runs an application.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use jde_core::Nanos;
use jde_host::app::Override;

use super::recording::Recording;
use super::{conclude, log, quantity};
use crate::failure::Failure;
use crate::load;
use crate::log::Filter;
use crate::session::{self, How, LinkWanted, Telling, View};
use crate::summary::Summary;
use crate::terminal;

/// Run an application: on a terminal under the oscilloscope, in a pipe with a line for every takeover and its reason.
///
/// Ends when the mission is done or failed, when the time is up, or when it is asked to stop (Ctrl-C: actuators first, then
/// everything in order; a second one ends at once). A summary follows: how long each schema was WINNER, the worst takeovers
/// against their contracts, faults. The exit status is 0 if the mission was done, or if there is none and it ran until its time was up or somebody stopped it.
#[derive(Args)]
#[command(after_help = "Examples:
  jde run apps/safe-navigation.toml
  jde run safe-navigation --lockstep --for 60s --picture path.png
  jde run safe-navigation --record drive.mcap --record-only 'pioneer.*' '*.mission'
  jde run safe-navigation --record drive.mcap --when collision --when 'pioneer.laser.ranges.exists(r, r < 0.3)'
  jde run safe-navigation --view
  jde run safe-navigation --watch                         cargo build in another terminal, and the robot drives by the new code
  jde run real-log --plain
  jde run safe-navigation --set 'goon.fast=0.3 m/s' --log vff=debug")]
pub(super) struct Run {
    /// The application's file, or the name of one in apps.
    #[arg(value_name = "APP", value_hint = ValueHint::FilePath)]
    application: PathBuf,
    #[command(flatten)]
    time: Time,
    /// End when the application has run this long.
    #[arg(long = "for", value_name = "TIME", value_parser = quantity::time)]
    limit: Option<Nanos>,
    /// Give a modulation another value at the start (repeatable).
    #[arg(long, value_name = "SCHEMA.VARIABLE=VALUE")]
    set: Vec<Override>,
    /// Reload schemas when the files of their plugins change, as jde reload does.
    #[arg(long, conflicts_with = "lockstep")]
    watch: bool,
    /// Lines instead of the oscilloscope.
    #[arg(long)]
    plain: bool,
    /// End standard output with one line of JSON; all words go to standard error.
    #[arg(long)]
    json: bool,
    /// Write every selection with its reason to this file, a line of JSON each.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    decisions: Option<PathBuf>,
    /// Draw the drive, coloured by who won, to this PNG file.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    picture: Option<PathBuf>,
    #[command(flatten)]
    record: Recording,
    #[command(flatten)]
    link: Link,
}

/// How tools get in.
#[derive(Args)]
pub(super) struct Link {
    /// The name by which tools and other robots call it, instead of the application's.
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Let no tool in, whatever the application says.
    #[arg(long, conflicts_with_all = ["name", "link"])]
    no_link: bool,
    /// Let tools in also in lockstep, which is usually over before anybody looks.
    #[arg(long)]
    link: bool,
    /// Open windows beside it: oscilloscope, sensors and motors, 3D, panels.
    #[cfg(feature = "view")]
    #[arg(long, conflicts_with = "no_link")]
    view: bool,
}

impl Link {
    #[cfg(feature = "view")]
    fn view(&self) -> bool {
        self.view
    }

    #[cfg(not(feature = "view"))]
    fn view(&self) -> bool {
        false
    }
}

impl From<Link> for LinkWanted {
    fn from(link: Link) -> Self {
        let view = link.view();
        Self {
            view,
            on: match (link.no_link, link.link || view || link.name.is_some()) {
                (true, _) => Some(false),
                (false, true) => Some(true),
                (false, false) => None,
            },
            name: link.name,
        }
    }
}

/// How time passes, and what chance starts from.
#[derive(Args)]
pub(super) struct Time {
    /// Run in virtual time, as fast as the machine goes; the same seed gives the same run to the bit.
    #[arg(long)]
    pub(super) lockstep: bool,
    /// What all randomness starts from, instead of the application's.
    #[arg(long, value_name = "N")]
    pub(super) seed: Option<u64>,
    /// Run this many times as fast as real time.
    #[arg(long, value_name = "FACTOR", value_parser = quantity::speed, default_value = "1x", conflicts_with = "lockstep")]
    pub(super) speed: f64,
}

impl Run {
    /// Runs it.
    pub(super) fn run(self, filter: Option<Filter>) -> Result<(), Failure> {
        let mut loaded = load::to_start(&self.application, &self.set)?;
        let log = log(filter, &loaded)?;
        if let Some(seed) = self.time.seed {
            loaded.application.seed = seed;
        }
        let lines = self.plain || self.json || self.time.lockstep || !terminal::is_interactive();
        let how = How {
            lockstep: self.time.lockstep,
            limit: self.limit,
            speed: self.time.speed,
            view: if lines {
                View::Lines(Telling::Takeovers)
            } else {
                View::Screen
            },
            words: if self.json {
                terminal::err()
            } else {
                terminal::out()
            },
            decisions: self.decisions,
            picture: self.picture,
            record: self.record.wanted()?,
            link: self.link.into(),
            watch: self.watch,
        };
        let finished = session::run(loaded, how, &log)?;
        conclude(finished, "", self.json, Summary::is_fulfilled)
    }
}
