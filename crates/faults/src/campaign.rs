//! The campaign: case after case until enough faults were injected, each judged by itself.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};
use jde_watchdog::Watchdog;

use crate::case::{Case, Clock, What};
use crate::observer::Tamper;
use crate::outside;
use crate::plan::{Kind, plan};
use crate::run::{Gear, How, Leaks, Report, run};
use crate::stage::{Root, Stage};
use crate::table::Table;

/// How long a case may take of the machine's time, processes included, before it counts as one that never ends.
const CASE: Duration = Duration::from_secs(120);

/// Bytes that a case loses which is told to lose memory.
const LOST: usize = 4 << 20;
/// Shares of all faults, by where they are injected.
const SHARES: [(Clock, What, u64); 5] = [
    (Clock::Lockstep, What::Demo, 30),
    (Clock::Lockstep, What::Hundred, 30),
    (Clock::RealTime, What::Demo, 15),
    (Clock::RealTime, What::Hundred, 20),
    (Clock::Outside, What::Demo, 5),
];

/// What a campaign is.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// What all choices follow from.
    pub seed: u64,
    /// Faults.
    pub count: u64,
    /// The kinds of these alone.
    pub kinds: Vec<Kind>,
    /// By these clocks alone.
    pub clocks: Vec<Clock>,
    /// This case alone.
    pub case: Option<Case>,
    /// More folders of plugins.
    pub plugins: Vec<PathBuf>,
    /// The executable, for processes of its own.
    pub jde: Option<PathBuf>,
    /// Where the workspace is.
    pub root: Root,
    /// Whether periods are judged in real time.
    pub rhythm: bool,
    /// A lie, to see that it is found.
    pub tamper: Option<Tamper>,
}

/// Hears how it goes.
pub trait Progress {
    /// A case begins.
    fn begins(&mut self, case: Case, injected: u64);
    /// A case is over.
    fn ended(&mut self, report: &Report);
}

/// What came of a campaign.
pub struct Finished {
    /// What was injected and survived.
    pub table: Table,
    /// What the process held at the end, in words.
    pub held: String,
    /// Memory that it held beyond what it may.
    pub leak: Option<String>,
    /// The least share of turns that any bystander had in real time.
    pub kept: Option<f64>,
    /// Cases in real time in which periods were not judged, and in which they were.
    pub rhythms: [u64; 2],
}

impl Campaign {
    /// Runs it, until it is done or `stop` is set.
    ///
    /// # Errors
    /// It cannot be run: plugins, the demonstration or the executable are missing.
    pub fn run(&self, stop: &AtomicBool, progress: &mut dyn Progress) -> Result<Finished> {
        let gear = Gear::new(&self.plugins)?;
        let mut table = Table::default();
        let mut leaks = Leaks::default();
        let mut kept: Option<f64> = None;
        let mut rhythms = [0; 2];
        for (clock, what, quota) in self.lanes()? {
            leaks.warms_up();
            let mut injected = 0;
            let mut number = self.case.map_or(0, |case| case.number);
            // A case in which nothing fits injects nothing: there are not more of these than this in a row.
            let mut empty = 0;
            while injected < quota && empty < 100 && !stop.load(Ordering::Relaxed) {
                let case = Case { clock, what, number };
                let most = if self.case.is_some() {
                    u64::MAX
                } else {
                    quota - injected
                };
                progress.begins(case, table.injected());
                let again = format!("broken: {case} has not ended\n  again: {}", self.again(case));
                // What hangs then is what the campaign looks for.
                let watchdog = Watchdog::new(CASE, move || again);
                let report = self.case(&gear, case, most, &mut leaks, stop)?;
                drop(watchdog);
                number += 1;
                empty = if report.faults.is_empty() { empty + 1 } else { 0 };
                injected += report.faults.len() as u64;
                if let Some(judged) = report.rhythm {
                    rhythms[usize::from(judged)] += 1;
                }
                kept = [kept, report.kept].into_iter().flatten().reduce(f64::min);
                table.add(&report);
                progress.ended(&report);
                if self.case.is_some() {
                    break;
                }
            }
        }
        Ok(Finished {
            table,
            held: leaks.words(),
            leak: leaks.conclude(),
            kept,
            rhythms,
        })
    }

    fn case(
        &self,
        gear: &Gear,
        case: Case,
        most: u64,
        leaks: &mut Leaks,
        stop: &AtomicBool,
    ) -> Result<Report> {
        if case.clock == Clock::Outside {
            return outside::run(self, case, stop);
        }
        let stage = Stage::of(&self.root, self.seed, case)?;
        let faults = plan(self.seed, case, &self.kinds, most);
        let leak = (self.tamper == Some(Tamper::Leak)).then(|| std::fs::File::open("/proc/self/stat"));
        let memory = (self.tamper == Some(Tamper::Memory)).then(|| vec![1_u8; LOST]);
        let how = How {
            seed: self.seed ^ case.number,
            rhythm: self.rhythm,
            tamper: self.tamper,
        };
        let mut report = run(gear, case, &stage, faults, how, stop)?;
        // The first case makes what all of them use.
        if leaks.is_begun() {
            report.broken.extend(leaks.judge(report.left));
        } else {
            leaks.begin(report.left);
        }
        // Kept until the process ends, as what leaks is.
        std::mem::forget((leak, memory));
        Ok(report)
    }

    fn lanes(&self) -> Result<Vec<(Clock, What, u64)>> {
        if let Some(Case { clock, what, .. }) = self.case {
            return Ok(vec![(clock, what, u64::MAX)]);
        }
        let fits =
            |clock: Clock| self.clocks.contains(&clock) && self.kinds.iter().any(|kind| kind.fits(clock));
        let lanes: Vec<_> = SHARES.into_iter().filter(|(clock, ..)| fits(*clock)).collect();
        if lanes.is_empty() {
            bail!("none of these kinds can be injected there; leave out --kind or --only");
        }
        let all: u64 = lanes.iter().map(|(.., share)| share).sum();
        let quota = |share: u64| (self.count * share).div_ceil(all).max(1);
        Ok(lanes
            .into_iter()
            .map(|(clock, what, share)| (clock, what, quota(share)))
            .collect())
    }

    /// The one command that runs a case again.
    #[must_use]
    pub fn again(&self, case: Case) -> String {
        let kinds = if self.kinds.len() == Kind::ALL.len() {
            String::new()
        } else {
            self.kinds
                .iter()
                .map(|kind| format!(" --kind {}", kind.name()))
                .collect()
        };
        format!("cargo xtask faults --seed {}{kinds} --case {case}", self.seed)
    }
}

impl Finished {
    /// What was run, on what, and what was measured beside the table.
    #[must_use]
    pub fn words(&self, campaign: &Campaign) -> String {
        let processors = std::thread::available_parallelism().map_or(0, usize::from);
        let kernel = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
        let kept = self.kept.map_or_else(String::new, |kept| {
            format!(
                ": no bystander in this process had less than {:.1} % of its turns",
                kept * 100.0
            )
        });
        let [unjudged, judged] = self.rhythms;
        let kept = match (unjudged, judged) {
            (0, 0) => String::new(),
            (0, _) => format!(" Periods were judged in all {judged} cases in real time{kept}."),
            _ => format!(
                " Periods were judged in {judged} of {} cases in real time{kept}; in the others, other programs took more than a quarter of the processors.",
                judged + unjudged
            ),
        };
        let dev = if cfg!(debug_assertions) { " --dev" } else { "" };
        format!(
            "`cargo xtask faults{dev} --seed {} --count {}`: {} faults on {processors} processors, Linux {}. {}.{kept}",
            campaign.seed,
            campaign.count,
            self.table.injected(),
            kernel.trim(),
            self.held
        )
    }
}
