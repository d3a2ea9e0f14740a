//! The campaign: runs cases until enough faults were injected, and judges each separately.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};
use clap::ValueEnum as _;
use jde_watchdog::Watchdog;

use crate::application::{Root, TestApplication};
use crate::case::{Case, RunMode, Scenario, name};
use crate::observer::Tamper;
use crate::plan::{Kind, plan};
use crate::processes;
use crate::run::{CaseResult, LeakDetector, Resources, RunOptions, run};
use crate::table::Table;

/// Longest real time of a case, including its processes, before it counts as hanging.
const CASE_TIMEOUT: Duration = Duration::from_secs(120);

/// Bytes that a case leaks for [`Tamper::Memory`].
const LEAKED_BYTES: usize = 4 << 20;
/// Shares of all faults by clock and application.
const SHARES: [(RunMode, Scenario, u64); 5] = [
    (RunMode::Lockstep, Scenario::Demo, 30),
    (RunMode::Lockstep, Scenario::Hundred, 30),
    (RunMode::RealTime, Scenario::Demo, 15),
    (RunMode::RealTime, Scenario::Hundred, 20),
    (RunMode::Outside, Scenario::Demo, 5),
];

/// The parameters of a campaign.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// The seed of all random choices.
    pub seed: u64,
    /// The number of faults.
    pub count: u64,
    /// Only faults of these kinds.
    pub kinds: Vec<Kind>,
    /// Only cases of these clocks.
    pub clocks: Vec<RunMode>,
    /// Only this case.
    pub case: Option<Case>,
    /// Additional folders of plugins.
    pub plugins: Vec<PathBuf>,
    /// The executable for cases in processes of their own.
    pub jde: Option<PathBuf>,
    /// The root of the workspace.
    pub root: Root,
    /// Whether periods are judged in real time.
    pub rhythm: bool,
    /// False data for the observer, to test that it finds them.
    pub tamper: Option<Tamper>,
}

/// Receives the progress of a campaign.
pub trait Progress {
    /// A case begins; `injected` faults have been injected before.
    fn begins(&mut self, case: Case, injected: u64);
    /// A case has ended.
    fn ended(&mut self, report: &CaseResult);
}

/// The results of a campaign.
pub struct CampaignResult {
    /// The faults injected and survived.
    pub table: Table,
    /// The resources that the process held at the end, as text.
    pub resources: String,
    /// Memory beyond the allowed amount.
    pub leak: Option<String>,
    /// The least share of its turns that a bystander had in real time.
    pub min_turn_share: Option<f64>,
    /// The numbers of cases in real time without and with a judgement of periods.
    pub rhythms: [u64; 2],
}

impl Campaign {
    /// Runs the campaign to its end, or until `stop` is set.
    ///
    /// # Errors
    /// The campaign cannot run: plugins, the demonstration or the executable are missing.
    pub fn run(&self, stop: &AtomicBool, progress: &mut dyn Progress) -> Result<CampaignResult> {
        let resources = Resources::new(&self.plugins)?;
        let mut table = Table::default();
        let mut leaks = LeakDetector::default();
        let mut min_turn_share: Option<f64> = None;
        let mut rhythms = [0; 2];
        for (clock, scenario, quota) in self.quotas()? {
            leaks.warms_up();
            let mut injected = 0;
            let mut number = self.case.map_or(0, |case| case.number);
            // A case without a suitable fault injects nothing. After 100 such cases in a row the column ends.
            let mut empty = 0;
            while injected < quota && empty < 100 && !stop.load(Ordering::Relaxed) {
                let case = Case {
                    clock,
                    scenario,
                    number,
                };
                let max_faults = if self.case.is_some() {
                    u64::MAX
                } else {
                    quota - injected
                };
                progress.begins(case, table.injected());
                let message = format!(
                    "broken: {case} has not ended\n  again: {}",
                    self.repeat_command(case)
                );
                // A hang is a failure that the campaign has to report.
                let watchdog = Watchdog::new(CASE_TIMEOUT, move || message);
                let report = self.case(&resources, case, max_faults, &mut leaks, stop)?;
                drop(watchdog);
                number += 1;
                empty = if report.faults.is_empty() { empty + 1 } else { 0 };
                injected += report.faults.len() as u64;
                if let Some(judged) = report.rhythm {
                    rhythms[usize::from(judged)] += 1;
                }
                min_turn_share = [min_turn_share, report.min_turn_share]
                    .into_iter()
                    .flatten()
                    .reduce(f64::min);
                table.add(&report);
                progress.ended(&report);
                if self.case.is_some() {
                    break;
                }
            }
        }
        Ok(CampaignResult {
            table,
            resources: leaks.summary(),
            leak: leaks.conclude(),
            min_turn_share,
            rhythms,
        })
    }

    fn case(
        &self,
        resources: &Resources,
        case: Case,
        max_faults: u64,
        leaks: &mut LeakDetector,
        stop: &AtomicBool,
    ) -> Result<CaseResult> {
        if case.clock == RunMode::Outside {
            return processes::run(self, case, stop);
        }
        let application = TestApplication::of(&self.root, self.seed, case)?;
        let faults = plan(self.seed, case, &self.kinds, max_faults);
        let leak = (self.tamper == Some(Tamper::Leak)).then(|| std::fs::File::open("/proc/self/stat"));
        let memory = (self.tamper == Some(Tamper::Memory)).then(|| vec![1_u8; LEAKED_BYTES]);
        let options = RunOptions {
            seed: self.seed ^ case.number,
            rhythm: self.rhythm,
            tamper: self.tamper,
        };
        let mut report = run(resources, case, &application, faults, options, stop)?;
        // The first case creates what all cases share.
        if leaks.has_begun() {
            report.violations.extend(leaks.judge(report.leftovers));
        } else {
            leaks.begin(report.leftovers);
        }
        // Leaked on purpose, until the process ends.
        std::mem::forget((leak, memory));
        Ok(report)
    }

    fn quotas(&self) -> Result<Vec<(RunMode, Scenario, u64)>> {
        if let Some(Case { clock, scenario, .. }) = self.case {
            return Ok(vec![(clock, scenario, u64::MAX)]);
        }
        let fits =
            |clock: RunMode| self.clocks.contains(&clock) && self.kinds.iter().any(|kind| kind.fits(clock));
        let columns: Vec<_> = SHARES.into_iter().filter(|(clock, ..)| fits(*clock)).collect();
        if columns.is_empty() {
            bail!("none of these kinds can be injected there; leave out --kind or --only");
        }
        let all: u64 = columns.iter().map(|(.., share)| share).sum();
        let quota = |share: u64| (self.count * share).div_ceil(all).max(1);
        Ok(columns
            .into_iter()
            .map(|(clock, scenario, share)| (clock, scenario, quota(share)))
            .collect())
    }

    /// The command that repeats a case.
    #[must_use]
    pub fn repeat_command(&self, case: Case) -> String {
        let kinds = if self.kinds.len() == Kind::value_variants().len() {
            String::new()
        } else {
            self.kinds
                .iter()
                .map(|kind| format!(" --kind {}", name(kind)))
                .collect()
        };
        format!("cargo xtask faults --seed {}{kinds} --case {case}", self.seed)
    }
}

impl CampaignResult {
    /// The parameters, the machine and the measurements besides the table.
    #[must_use]
    pub fn summary(&self, campaign: &Campaign) -> String {
        let processors = std::thread::available_parallelism().map_or(0, usize::from);
        let kernel = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
        let least = self.min_turn_share.map_or_else(String::new, |share| {
            format!(
                ": no bystander in this process had less than {:.1} % of its turns",
                share * 100.0
            )
        });
        let [unjudged, judged] = self.rhythms;
        let periods = match (unjudged, judged) {
            (0, 0) => String::new(),
            (0, _) => format!(" Periods were judged in all {judged} cases in real time{least}."),
            _ => format!(
                " Periods were judged in {judged} of {} cases in real time{least}; in the others, other programs took more than a quarter of the processors.",
                judged + unjudged
            ),
        };
        let dev = if cfg!(debug_assertions) { " --dev" } else { "" };
        format!(
            "`cargo xtask faults{dev} --seed {} --count {}`: {} faults on {processors} processors, Linux {}. {}.{periods}",
            campaign.seed,
            campaign.count,
            self.table.injected(),
            kernel.trim(),
            self.resources
        )
    }
}
