//! The numbers of all traces, up to the longest time that can be shown.

use jde_timeline::{Trace, range};

use super::TracePoint;

/// Numbers kept for a trace: half an hour at 50 per second.
const MAX_POINTS: usize = 90_000;

/// The numbers of all traces.
pub(super) struct Traces {
    pub(super) names: Vec<String>,
    traces: Vec<Trace>,
    now: f64,
    /// The time at the right edge while the picture is paused.
    paused: Option<f64>,
}

impl Traces {
    pub(super) fn new(names: Vec<String>) -> Self {
        Self {
            traces: vec![Trace::new(MAX_POINTS); names.len()],
            names,
            now: 0.0,
            paused: None,
        }
    }

    /// Adds a number. If time goes back by more than 1 s, all traces start anew: the application was
    /// restarted, or a recording was moved back.
    pub(super) fn add(&mut self, sample: TracePoint) {
        if sample.time + 1.0 < self.now {
            self.clear();
        }
        self.now = self.now.max(sample.time);
        if let Some(trace) = self.traces.get_mut(sample.trace) {
            trace.add(sample.time, sample.value);
        }
    }

    pub(super) fn pause(&mut self) {
        self.paused = match self.paused {
            Some(_) => None,
            None => Some(self.now),
        };
    }

    pub(super) fn is_paused(&self) -> bool {
        self.paused.is_some()
    }

    pub(super) fn clear(&mut self) {
        self.traces.iter_mut().for_each(Trace::clear);
        (self.now, self.paused) = (0.0, None);
    }

    /// Returns the time at the right edge of the picture.
    pub(super) fn end(&self) -> f64 {
        self.paused.unwrap_or(self.now)
    }

    /// Returns the newest number of a trace; `None` in a gap.
    pub(super) fn newest(&self, trace: usize) -> Option<f64> {
        self.traces[trace].at(self.end())
    }

    /// Returns the finite numbers of a trace in the last `window` seconds, each as (seconds relative to the
    /// end, number). A number that is not finite ends a piece.
    pub(super) fn pieces(&self, trace: usize, window: f64) -> Vec<Vec<(f64, f64)>> {
        let end = self.end();
        let mut pieces = vec![Vec::new()];
        // It begins before the window, so that the line reaches the left edge.
        for (time, value) in self.traces[trace].between(end - window, end) {
            match (value.is_finite(), pieces.last_mut()) {
                (true, Some(piece)) => piece.push((time - end, value)),
                _ => pieces.push(Vec::new()),
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }

    /// Returns the least and the greatest number shown, with a margin that also separates them if all numbers
    /// are equal.
    pub(super) fn range(&self, window: f64) -> (f64, f64) {
        let pieces = (0..self.names.len()).flat_map(|trace| self.pieces(trace, window));
        let Some((least, greatest)) = range(pieces.flatten().map(|(_, value)| value)) else {
            return (0.0, 1.0);
        };
        let margin = ((greatest - least) * 0.05)
            .max(greatest.abs().max(least.abs()) * 1e-3)
            .max(1e-6);
        (least - margin, greatest + margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn traces(values: &[(f64, f64)]) -> Traces {
        let mut traces = Traces::new(vec!["v".to_owned()]);
        for (time, value) in values {
            traces.add(TracePoint {
                trace: 0,
                time: *time,
                value: *value,
            });
        }
        traces
    }

    #[test]
    fn a_chart_shows_the_last_seconds_and_the_line_up_to_its_edge() {
        let traces = traces(&[(0.0, 1.0), (1.0, 2.0), (9.0, 3.0), (10.0, 4.0)]);
        assert_eq!(traces.pieces(0, 2.0), [[(-9.0, 2.0), (-1.0, 3.0), (0.0, 4.0)]]);
        assert_eq!(traces.newest(0), Some(4.0));
    }

    #[test]
    fn a_missing_number_interrupts_the_line() {
        let traces = traces(&[(0.0, 1.0), (1.0, f64::INFINITY), (2.0, 3.0)]);
        assert_eq!(traces.pieces(0, 5.0), [[(-2.0, 1.0)], [(0.0, 3.0)]]);
        let (least, greatest) = traces.range(5.0);
        assert!(least < 1.0 && least > 0.8 && greatest > 3.0 && greatest < 3.2);
    }

    #[test]
    fn a_paused_chart_does_not_move_when_numbers_arrive() {
        let mut traces = traces(&[(0.0, 1.0), (1.0, 2.0)]);
        traces.pause();
        traces.add(TracePoint {
            trace: 0,
            time: 1.5,
            value: 9.0,
        });
        assert_eq!(traces.newest(0), Some(2.0));
        assert_eq!(traces.pieces(0, 5.0), [[(-1.0, 1.0), (0.0, 2.0)]]);
        traces.pause();
        assert_eq!(traces.newest(0), Some(9.0));
    }

    #[test]
    fn a_decreasing_time_starts_again() {
        let mut traces = traces(&[(100.0, 1.0), (101.0, 2.0)]);
        traces.add(TracePoint {
            trace: 0,
            time: 0.1,
            value: 5.0,
        });
        assert_eq!(traces.pieces(0, 10.0), [[(0.0, 5.0)]]);
    }

    #[test]
    fn an_empty_chart_has_a_range() {
        assert_eq!(traces(&[]).range(10.0), (0.0, 1.0));
        let (least, greatest) = traces(&[(0.0, 5.0)]).range(10.0);
        assert!(least < 5.0 && greatest > 5.0);
    }
}
