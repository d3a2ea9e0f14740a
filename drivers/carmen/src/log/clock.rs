//! When the records of a log were, from the stamps of its lines. It knows no file and no message.
//!
//! Logs are copied, converted and corrected by many programs, and their clocks with them: one of the two stands still, is
//! rounded until it does, starts anew, counts below 0 as an unsigned number does, or has nonsense on some lines. The lines
//! are in the order in which they were written, so the scans are played in this order, and a stamp counts if the ones
//! after it agree. What the stamps do not tell is spread evenly.

/// The longest pause between two lines, s. What is longer is a clock that was set; if it was a pause, nothing is lost.
const PAUSE: f64 = 60.0;
/// How many of the next stamps decide whether one of them counts.
const STAMPS_AHEAD: usize = 16;
/// By how much a stamp differs from those around it where it is worth a word, s.
const WORTH_A_WORD: f64 = 1.0;

/// When the scans were.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Clock {
    /// The time of each scan since the first one, s; each later than the one before.
    pub(crate) times: Vec<f64>,
    /// What is to be taken from the stamps around each scan, so that they are on the same scale, s.
    offsets: Vec<Option<f64>>,
    /// How many scans are between two stamps that count.
    covered: usize,
    /// How many stamps count.
    kept: usize,
    /// Whether all stamps are the same.
    pub(crate) stands_still: bool,
    /// What is wrong with the stamps.
    pub(crate) faults: Faults,
}

/// What is wrong with a clock: how often, and the first case, as the scan and the two stamps.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Faults {
    pub(crate) jumps: Option<(usize, Fault)>,
    pub(crate) strange: Option<(usize, Fault)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fault {
    pub(crate) scan: usize,
    pub(crate) last: f64,
    pub(crate) stamp: f64,
}

impl Faults {
    fn count(fault: &mut Option<(usize, Fault)>, first: Fault) {
        fault.get_or_insert((0, first)).0 += 1;
    }
}

/// A stamp that counts.
struct Kept {
    scan: usize,
    stamp: f64,
    /// Whether the clock was set before it.
    is_jump: bool,
}

/// Whether a stamp may be the next one.
fn follows(last: f64, stamp: f64) -> bool {
    (0.0..=PAUSE).contains(&(stamp - last))
}

/// Whether the stamps of the lines between two scans lead from the stamp of one to that of the other: a robot that stands has
/// no new scan for long in a log that leaves such scans out.
pub(crate) fn leads(stamps: impl Iterator<Item = Option<f64>>, from: f64, to: f64) -> bool {
    let mut between = stamps.flatten().filter(|stamp| (from..=to).contains(stamp));
    let last = between.try_fold(from, |last, stamp| follows(last, stamp).then_some(stamp));
    last.is_some_and(|last| follows(last, to))
}

impl Clock {
    /// Reads the stamps of the scans, in the order of the log. `is_led_to` tells whether other lines lead to the stamp of a scan
    /// from that of the scan before.
    pub(crate) fn new(stamps: &[Option<f64>], is_led_to: &dyn Fn(usize) -> bool, interval: f64) -> Self {
        let mut faults = Faults::default();
        let kept = keep(stamps, is_led_to, &mut faults);
        let steps = || kept.windows(2).filter(|pair| !pair[1].is_jump);
        let covered = steps().map(|pair| pair[1].scan - pair[0].scan).sum();
        let mut gaps: Vec<f64> = steps()
            .map(|pair| (pair[1].stamp - pair[0].stamp) / (pair[1].scan - pair[0].scan) as f64)
            .collect();
        gaps.sort_by(f64::total_cmp);
        let usual = gaps.get(gaps.len() / 2).copied().unwrap_or(interval);
        let mut clock = Self {
            times: Vec::with_capacity(stamps.len()),
            offsets: Vec::with_capacity(stamps.len()),
            covered,
            kept: kept.len(),
            stands_still: stamps.iter().flatten().all(|stamp| Some(*stamp) == stamps[0]),
            faults,
        };
        let first = kept.first().map_or(0, |first| first.scan);
        clock.spread(first, 0.0, usual, None);
        let mut now = first as f64 * usual;
        for (index, Kept { scan, stamp, .. }) in kept.iter().enumerate() {
            let (next, step) = match kept.get(index + 1) {
                Some(next) if next.is_jump => (next.scan, usual),
                Some(next) => (next.scan, (next.stamp - stamp) / (next.scan - scan) as f64),
                None => (stamps.len(), usual),
            };
            clock.spread(next - scan, now, step, Some(stamp - now));
            now += (next - scan) as f64 * step;
        }
        if kept.is_empty() {
            clock.spread(stamps.len(), 0.0, interval, None);
        }
        clock
    }

    /// Returns scans that are so far apart, s, with a clock that tells nothing.
    pub(crate) fn apart(gaps: &[f64]) -> Self {
        let mut clock = Self::new(&vec![None; gaps.len() + 1], &|_| false, 1.0);
        let mut now = 0.0;
        for (time, gap) in clock.times[1..].iter_mut().zip(gaps) {
            now += gap;
            *time = now;
        }
        clock
    }

    fn spread(&mut self, scans: usize, start: f64, step: f64, offset: Option<f64>) {
        let times = (0..scans).map(|scan| start + scan as f64 * step);
        self.times.extend(times);
        self.offsets.extend(core::iter::repeat_n(offset, scans));
    }

    /// Whether it tells when most of the scans were.
    pub(crate) fn is_usable(&self) -> bool {
        self.times.len() < 2 || self.covered * 2 >= self.times.len() - 1
    }

    /// How much it tells; of two clocks, the one that tells more counts.
    pub(crate) fn tells(&self) -> (usize, usize) {
        (self.covered, self.kept)
    }

    /// Returns when other records were, by their stamps: those between the scans `before` and `before + 1`, in order; before
    /// the first scan if there is none. What they do not tell is spread evenly, before the first and after the last scan
    /// over `interval`.
    pub(crate) fn between(&self, before: Option<usize>, stamps: &[Option<f64>], interval: f64) -> Vec<f64> {
        let after = before.map_or(0, |scan| scan + 1);
        let time = |scan: Option<usize>| scan.and_then(|scan| self.times.get(scan)).copied();
        let (start, end) = (time(before), time(Some(after)));
        let offsets = [
            before.and_then(|scan| self.offsets[scan]),
            self.offsets.get(after).copied().flatten(),
        ];
        let at = |stamp: Option<f64>, is_next: &dyn Fn(f64) -> bool| {
            let mut times = offsets.iter().map(|offset| Some(stamp? - (*offset)?));
            times.find_map(|time| time.filter(|time| is_next(*time)))
        };
        let mut times = vec![None; stamps.len()];
        if let Some(start) = start {
            let end = end.unwrap_or(f64::INFINITY);
            let mut last = start;
            for (time, stamp) in times.iter_mut().zip(stamps) {
                *time = at(*stamp, &|time| time > last && time < end && time - last <= PAUSE);
                last = time.unwrap_or(last);
            }
        } else if let Some(mut next) = end {
            for (time, stamp) in times.iter_mut().zip(stamps).rev() {
                *time = at(*stamp, &|time| time < next && next - time <= PAUSE);
                next = time.unwrap_or(next);
            }
        }
        fill(&times, start, end, interval)
    }
}

/// Returns the stamps that count.
fn keep(stamps: &[Option<f64>], is_led_to: &dyn Fn(usize) -> bool, faults: &mut Faults) -> Vec<Kept> {
    let known: Vec<(usize, f64)> = (stamps.iter().enumerate())
        .filter_map(|(scan, stamp)| Some((scan, (*stamp)?)))
        .collect();
    let mut kept: Vec<Kept> = Vec::new();
    for (index, &(scan, stamp)) in known.iter().enumerate() {
        let ahead = &known[index + 1..known.len().min(index + 1 + STAMPS_AHEAD)];
        let agree = |from: f64| ahead.iter().filter(|(_, stamp)| follows(from, *stamp)).count();
        let is_jump = match kept.last() {
            None if ahead.is_empty() || agree(stamp) > 0 => false,
            None => continue,
            // Rounded, or the same scan again: the time until the next one is shared.
            Some(last) if last.stamp == stamp => continue,
            Some(&Kept {
                scan: before,
                stamp: last,
                ..
            }) => {
                let fault = Fault { scan, last, stamp };
                let is_led = || before + 1 == scan && is_led_to(scan);
                let follows = follows(last, stamp) || is_led();
                let more = agree(stamp).cmp(&agree(last));
                if follows && more.is_ge() {
                    false
                } else if !follows && more.is_gt() {
                    Faults::count(&mut faults.jumps, fault);
                    true
                } else {
                    if (stamp - last).abs() > WORTH_A_WORD {
                        Faults::count(&mut faults.strange, fault);
                    }
                    continue;
                }
            }
        };
        kept.push(Kept { scan, stamp, is_jump });
    }
    kept
}

/// Gives the missing times places that are evenly between the known ones.
fn fill(times: &[Option<f64>], start: Option<f64>, end: Option<f64>, interval: f64) -> Vec<f64> {
    let mut filled = Vec::with_capacity(times.len());
    let mut last = start;
    for run in times.split_inclusive(Option::is_some) {
        let next = run.last().copied().flatten();
        let missing = run.len() - usize::from(next.is_some());
        let until = next.or(end);
        let (from, step) = match (last, until) {
            (Some(last), Some(until)) => (last, (until - last) / (missing + 1) as f64),
            (Some(last), None) => (last, interval / (missing + 1) as f64),
            (None, Some(until)) => (until - interval, interval / (missing + 1) as f64),
            (None, None) => (0.0, interval),
        };
        filled.extend((1..=missing).map(|index| from + index as f64 * step));
        filled.extend(next);
        last = filled.last().copied().or(last);
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(stamps: &[f64]) -> Clock {
        let stamps: Vec<_> = stamps.iter().map(|stamp| Some(*stamp)).collect();
        Clock::new(&stamps, &|_| false, 0.2)
    }

    #[track_caller]
    fn near(found: &[f64], expected: &[f64]) {
        let is_near =
            found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(is_near, "{found:?} is not {expected:?}");
    }

    #[test]
    fn stamps_that_agree_count() {
        let read = clock(&[100.0, 100.5, 103.0]);
        near(&read.times, &[0.0, 0.5, 3.0]);
        assert!(read.is_usable());
        assert_eq!(read.faults, Faults::default());
    }

    #[test]
    fn a_stamp_far_from_those_around_it_does_not_count() {
        for strange in [0.0, -5.0, 4.29e9, 1e300, 140.0] {
            let read = clock(&[100.0, 101.0, strange, 103.0, 104.0, 105.0]);
            near(&read.times, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
            assert_eq!(read.faults.strange.map(|(count, _)| count), Some(1), "{strange}");
            let read = clock(&[strange, 101.0, 102.0, 103.0, 104.0]);
            near(&read.times, &[0.0, 1.0, 2.0, 3.0, 4.0]);
        }
        let read = clock(&[100.0, 101.0, 102.0, 4.29e9]);
        near(&read.times, &[0.0, 1.0, 2.0, 3.0]);
    }

    #[test]
    fn a_clock_that_is_set_goes_on() {
        for other in [1.1e9, -3000.0, 20.0] {
            let read = clock(&[100.0, 101.0, 102.0, other, other + 1.0, other + 3.0]);
            near(&read.times, &[0.0, 1.0, 2.0, 3.0, 4.0, 6.0]);
            let (count, fault) = read.faults.jumps.expect("it was set");
            assert_eq!((count, fault.scan, fault.last, fault.stamp), (1, 3, 102.0, other));
        }
    }

    #[test]
    fn a_long_pause_is_played_if_other_lines_lead_through_it() {
        let stamps = [100.0, 101.0, 301.0, 302.0, 303.0].map(Some);
        let read = Clock::new(&stamps, &|scan| scan == 2, 0.2);
        near(&read.times, &[0.0, 1.0, 201.0, 202.0, 203.0]);
        assert_eq!(read.faults, Faults::default());
        let lines = |stamps: &[f64]| {
            let stamps: Vec<_> = stamps.iter().copied().map(Some).collect();
            leads(stamps.into_iter(), 101.0, 301.0)
        };
        assert!(
            lines(&[0.0, 150.0, 200.0, 7e9, 250.0]),
            "what is not between them does not count"
        );
        assert!(
            !lines(&[]) && !lines(&[150.0, 250.0]),
            "a pause between two lines"
        );
        assert!(!lines(&[150.0, 200.0, 110.0, 250.0]), "it goes back");
    }

    #[test]
    fn rounded_stamps_share_their_time() {
        let read = clock(&[100.0, 100.0, 110.0, 110.0, 110.0, 110.0, 120.0]);
        near(&read.times, &[0.0, 5.0, 10.0, 12.5, 15.0, 17.5, 20.0]);
        assert!(read.is_usable());
    }

    #[test]
    fn a_clock_without_an_order_tells_nothing() {
        let still = clock(&[1.1e9; 9]);
        assert!(!still.is_usable() && still.stands_still);
        // Two instants, 10,000 s apart, as six digits of the time since 1970 are.
        let rounded: Vec<f64> = (0..99)
            .map(|scan| if scan < 70 { 1.13486e9 } else { 1.13487e9 })
            .collect();
        assert!(!clock(&rounded).is_usable());
        // It counts down, and as an unsigned number it is stuck at the top.
        let down: Vec<f64> = (0..99)
            .map(|scan| if scan < 9 { -f64::from(scan) } else { 4.29497e9 })
            .collect();
        assert!(!clock(&down).is_usable());
        let leaps: Vec<f64> = (0..99).map(|scan| 1e4 * f64::from(scan)).collect();
        assert!(!clock(&leaps).is_usable());
    }

    #[test]
    fn records_between_scans_are_between_them_in_time() {
        let read = clock(&[100.0, 101.0]);
        let between = |before, stamps: &[f64]| {
            let stamps: Vec<_> = stamps.iter().map(|stamp| Some(*stamp)).collect();
            read.between(before, &stamps, 0.2)
        };
        near(&between(Some(0), &[100.2, 100.9]), &[0.2, 0.9]);
        near(
            &between(Some(0), &[100.0, 0.0, 100.6, 7e9, 101.0]),
            &[0.2, 0.4, 0.6, 0.6 + 0.4 / 3.0, 0.6 + 0.8 / 3.0],
        );
        near(&between(None, &[0.0, 99.0, 99.5]), &[-1.1, -1.0, -0.5]);
        near(&between(Some(1), &[101.5, 0.0]), &[1.5, 1.6]);
        near(
            &Clock::apart(&[0.2]).between(Some(0), &[None; 3], 0.2),
            &[0.05, 0.1, 0.15],
        );
        near(
            &Clock::apart(&[0.2]).between(None, &[None; 3], 0.2),
            &[-0.15, -0.1, -0.05],
        );
    }
}
