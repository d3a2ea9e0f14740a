//! Frames of one instant. It gives no set in which a frame is missing, so that nothing of one instant is taken together with
//! something of another.

use core::time::Duration;

use crate::frame::Frame;

pub(crate) const ACCELERATION: u8 = 0x51;
pub(crate) const RATES: u8 = 0x52;
pub(crate) const ANGLES: u8 = 0x53;
pub(crate) const QUATERNION: u8 = 0x59;
const KINDS: usize = 16;

/// Sets of the same kinds after which these are what the unit sends.
const CONFIRMED: u32 = 3;
/// A set that takes this part of the time from one to the next is of two instants: frames between are lost.
const MAX_SPAN: f64 = 0.95;
/// Readings are so far apart at most, s: a set that is read in two pieces is still one.
const READING: f64 = 0.025;

/// The frames of an instant: the numbers of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Set {
    numbers: [Option<[i16; 4]>; KINDS],
}

/// Puts frames together.
#[derive(Debug, Default)]
pub(crate) struct Sets {
    open: Set,
    last: Option<u8>,
    /// When its first frame was read.
    began: Duration,
    /// Whether a frame of it is not sure, or it began in the middle.
    is_broken: bool,
    /// The kinds of a set, as a bit each, and how often they came in sequence.
    kinds: (u16, u32),
    /// The mean time from one set to the next, s.
    period: Option<f64>,
}

impl Set {
    pub(crate) fn get(&self, kind: u8) -> Option<[i16; 4]> {
        self.numbers[usize::from(kind & 0xf)]
    }

    fn kinds(&self) -> u16 {
        (0..KINDS)
            .filter(|at| self.numbers[*at].is_some())
            .fold(0, |kinds, at| kinds | 1 << at)
    }
}

impl Sets {
    /// Adds a frame that is read now. Returns the set that ends with it, or with the one before: kinds ascend in a set.
    pub(crate) fn add(&mut self, frame: &Frame, now: Duration) -> Option<Set> {
        let mut ended = None;
        if self.last.is_none_or(|last| frame.kind <= last) {
            ended = self.end(now);
            (self.open, self.began) = (Set::default(), now);
            self.is_broken = false;
        }
        self.is_broken |= !frame.follows;
        self.last = Some(frame.kind);
        self.open.numbers[usize::from(frame.kind & 0xf)] = Some(frame.numbers);
        // The last kind of a set need not wait for the next set.
        if self.kinds.1 >= CONFIRMED && self.open.kinds() == self.kinds.0 {
            return self.end(now);
        }
        ended
    }

    fn end(&mut self, now: Duration) -> Option<Set> {
        let (open, last) = (self.open, self.last.take());
        last?;
        let kinds = open.kinds();
        if self.is_broken {
            return None;
        }
        if kinds != self.kinds.0 {
            // One that lacks a kind is no new form of sets until it has come again and again.
            self.kinds.1 = self.kinds.1.saturating_sub(1);
            if self.kinds.1 == 0 {
                self.kinds = (kinds, 1);
            }
            return None;
        }
        self.kinds.1 = (self.kinds.1 + 1).min(2 * CONFIRMED);
        let span = now.saturating_sub(self.began).as_secs_f64();
        let is_whole = self.kinds.1 >= CONFIRMED
            && self
                .period
                .is_none_or(|period| span <= READING.max(MAX_SPAN * period));
        is_whole.then_some(open)
    }

    /// Notes that so many sets came in a time: the mean of some seconds is the rate.
    pub(crate) fn count(&mut self, sets: u32, seconds: f64) {
        if sets > 0 {
            self.period = Some(seconds / f64::from(sets));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(kind: u8, value: i16) -> Frame {
        Frame {
            kind,
            numbers: [value; 4],
            follows: true,
        }
    }

    /// The sets of frames that come every 100 ms, without those that are lost.
    fn sets(lost: impl Fn(i16, u8) -> bool) -> Vec<Set> {
        let mut sets = Sets::default();
        sets.count(10, 1.0);
        let mut found = Vec::new();
        for instant in 0..20 {
            for kind in [ACCELERATION, RATES, ANGLES] {
                let now = Duration::from_millis(100 * instant as u64 + 5 * u64::from(kind - ACCELERATION));
                if !lost(instant, kind) {
                    found.extend(sets.add(&frame(kind, instant), now));
                }
            }
        }
        found
    }

    #[test]
    fn no_set_has_frames_of_two_instants_whatever_is_lost() {
        assert!(sets(|_, _| false).len() >= 17);
        for lost in 0..64_u32 {
            // Any of six frames that follow each other.
            let is_lost = |instant: i16, kind: u8| {
                let at = i32::from(instant - 10) * 3 + i32::from(kind - ACCELERATION);
                (0..6).contains(&at) && lost >> at & 1 == 1
            };
            let found = sets(is_lost);
            assert!(found.len() >= 15, "{lost:b}: {}", found.len());
            for set in found {
                let kinds = [ACCELERATION, RATES, ANGLES].map(|kind| set.get(kind));
                assert!(
                    kinds
                        .iter()
                        .all(|numbers| *numbers == kinds[0] && numbers.is_some()),
                    "{lost:b}: {set:?}"
                );
            }
        }
    }
}
