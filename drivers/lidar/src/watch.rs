//! Watches over a lidar: whether turns come, and why not, in words. It has no clock: the time is an argument.

use core::time::Duration;

/// Time without a turn after which a lidar counts as lost: several turns of the slowest.
pub(crate) const SILENCE: Duration = Duration::from_secs(1);
/// Time limit of the first turn: a motor needs up to 3 s to reach its speed.
const START: Duration = Duration::from_secs(5);

/// Time without a reading after which what has waited is too old: systems keep some seconds of a line, and discard the
/// rest. Also the time in which what has waited is read, and turns do not count: networks are faster than lidars.
const BACKLOG: Duration = Duration::from_millis(500);
/// Bytes of a reading that has left others behind, as a port reads no more at once.
const FULL: usize = 64 << 10;

/// What a lidar says when no turns come.
#[derive(Debug)]
pub(crate) struct Words {
    /// No byte came.
    pub(crate) silent: &'static str,
    /// No byte was part of a measurement.
    pub(crate) foreign: &'static str,
    /// Most measurements were corrupt.
    pub(crate) corrupt: &'static str,
    /// The measurements make no turn.
    pub(crate) incomplete: &'static str,
}

/// What arrived since the last turn; from half of the time limit on, since then.
#[derive(Debug, Default)]
struct Tally {
    is_recent: bool,
    bytes: usize,
    good: usize,
    corrupt: usize,
    /// Why a turn was refused.
    problem: Option<String>,
}

/// The watch over one connection.
#[derive(Debug)]
pub(crate) struct Watch {
    deadline: Duration,
    /// Time of the last reading.
    read: Duration,
    /// Time from which turns count.
    resume: Duration,
    tally: Tally,
    /// Corrupt measurements minus good ones, in this turn.
    excess: i64,
    ready: bool,
    warned: bool,
}

impl Watch {
    /// Starts to wait for the first turn.
    pub(crate) fn new(now: Duration) -> Self {
        Self {
            deadline: now + START,
            read: now,
            resume: now + BACKLOG,
            tally: Tally::default(),
            excess: 0,
            ready: false,
            warned: false,
        }
    }

    /// Whether a turn was accepted.
    pub(crate) fn is_ready(&self) -> bool {
        self.ready
    }

    /// Notes that so many bytes arrived. Returns whether they may be used: after a pause of the driver, nothing tells how
    /// old they are.
    pub(crate) fn receive(&mut self, bytes: usize, now: Duration) -> bool {
        let pause = now.saturating_sub(core::mem::replace(&mut self.read, now));
        if pause > BACKLOG || bytes >= FULL {
            self.distrust(now);
        }
        if pause > BACKLOG {
            self.deadline = self.deadline.max(self.resume + SILENCE);
            return false;
        }
        if !self.tally.is_recent && now + SILENCE / 2 >= self.deadline {
            self.tally = Tally {
                is_recent: true,
                ..Tally::default()
            };
        }
        self.tally.bytes += bytes;
        true
    }

    /// Notes a part of a measurement that is right.
    pub(crate) fn good(&mut self, size: usize) {
        self.tally.good += size;
        self.excess -= size as i64;
    }

    /// Notes a part of a measurement that is corrupt.
    pub(crate) fn corrupt(&mut self, size: usize) {
        self.tally.corrupt += size;
        self.excess += size as i64;
    }

    /// Lets no turn count for a while, because nothing tells how old it is.
    pub(crate) fn distrust(&mut self, now: Duration) {
        self.resume = now + BACKLOG;
    }

    /// Ends a turn. Returns whether it counts: most of it was right, and it did not wait.
    pub(crate) fn end_turn(&mut self, now: Duration) -> bool {
        core::mem::take(&mut self.excess) <= 0 && now >= self.resume
    }

    /// Notes why a turn was refused.
    pub(crate) fn refuse(&mut self, problem: String) {
        self.tally.problem = Some(problem);
    }

    /// Notes that a turn was accepted.
    pub(crate) fn accept(&mut self, now: Duration) {
        self.tally = Tally::default();
        self.deadline = now + SILENCE;
        self.ready = true;
    }

    /// Returns whether to warn of corrupt measurements, at most once.
    pub(crate) fn warns(&mut self) -> bool {
        let warns = self.ready && !self.warned && self.tally.corrupt > 0;
        self.warned |= warns;
        warns
    }

    /// Returns why the lidar is lost, if it is.
    pub(crate) fn lost(&self, now: Duration, words: &Words) -> Option<String> {
        let tally = &self.tally;
        let reason = match &tally.problem {
            _ if tally.bytes == 0 => words.silent,
            _ if tally.good == 0 && tally.corrupt == 0 => words.foreign,
            _ if tally.corrupt > tally.good => words.corrupt,
            Some(problem) => problem.as_str(),
            None => words.incomplete,
        };
        (now >= self.deadline).then(|| reason.to_owned())
    }
}
