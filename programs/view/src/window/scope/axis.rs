//! The time axis: the visible part of the past, and the position of each time on the screen.

use eframe::egui::Rangef;

/// Approximate number of grid lines of a window.
pub(super) const DIVISIONS: f64 = 10.0;
/// Shortest window, in s: a few wake-ups of a thread.
const SHORTEST_WINDOW: f64 = 200e-6;
/// Share of the window for what follows the position of a recording.
const AHEAD: f64 = 0.3;
/// Longest window, in s.
const LONGEST_WINDOW: f64 = 100_000.0;

/// The visible part of the past.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// Width of the window, in s.
    span: f64,
    edge: Edge,
    /// Whether only the user moves the window.
    paused: bool,
    /// The time until which something is known, s: more than the present in a recording.
    end: f64,
}

/// The time of the right edge.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Edge {
    /// The present, or a little more where that is known.
    Live,
    /// A fixed time, in s since the application's start.
    At(f64),
}

/// The mapping of times to the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// The time at the left edge, in s.
    pub(super) from: f64,
    /// The time at the right edge, in s.
    pub(super) to: f64,
    /// From the left edge to the right, in points.
    pub(super) x: Rangef,
}

impl Axis {
    pub(super) fn new(span: f64) -> Self {
        Self {
            span: span.clamp(SHORTEST_WINDOW, LONGEST_WINDOW),
            edge: Edge::Live,
            paused: false,
            end: 0.0,
        }
    }

    /// Sets the time until which something is known, s.
    pub(super) fn set_end(&mut self, end: f64) {
        self.end = end;
    }

    pub(super) fn span(&self) -> f64 {
        self.span
    }

    pub(super) fn is_paused(&self) -> bool {
        self.paused
    }

    /// Whether the window follows the present.
    pub(super) fn is_live(&self) -> bool {
        self.edge == Edge::Live
    }

    pub(super) fn scale(&self, now: f64, x: Rangef) -> Scale {
        let to = self.right(now);
        Scale {
            from: to - self.span,
            to,
            x,
        }
    }

    /// Follows the present.
    pub(super) fn follow(&mut self) {
        (self.edge, self.paused) = (Edge::Live, false);
    }

    /// Stops the window at its current time.
    pub(super) fn pause(&mut self, now: f64) {
        (self.edge, self.paused) = (Edge::At(self.right(now)), true);
    }

    /// Shows a time at a fraction of the window's width. The axis is not paused by this.
    pub(super) fn show_at(&mut self, time: f64, share: f64) {
        self.edge = Edge::At(time + (1.0 - share) * self.span);
    }

    /// Centers a time and pauses, unless it is already visible.
    pub(super) fn reveal(&mut self, time: f64, now: f64) {
        let to = self.right(now);
        if !(to - self.span..=to).contains(&time) {
            self.show_at(time, 0.5);
            self.paused = true;
        }
    }

    /// Moves the window by a time in s, and pauses.
    pub(super) fn pan(&mut self, by: f64, now: f64) {
        // What follows the end is empty, so at least 5 % of the window shows what is before it.
        let to = (self.right(now) + by).clamp(0.05 * self.span, now.max(self.end) + 0.95 * self.span);
        (self.edge, self.paused) = (Edge::At(to), true);
    }

    /// Zooms by `factor`. The time `at` stays in place. A window that follows the present continues to do so.
    pub(super) fn zoom(&mut self, factor: f64, at: f64) {
        let span = (self.span * factor).clamp(SHORTEST_WINDOW, LONGEST_WINDOW);
        if let Edge::At(to) = self.edge {
            self.edge = Edge::At(at + (to - at) * span / self.span);
        }
        self.span = span;
    }

    /// Sets the time between grid lines, in s. The middle of the window stays in place.
    pub(super) fn set_division(&mut self, division: f64, now: f64) {
        let middle = self.right(now) - self.span / 2.0;
        self.zoom(division * DIVISIONS / self.span, middle);
    }

    /// The time between grid lines, in s: 1, 2 or 5 times a power of ten.
    pub(super) fn division(&self) -> f64 {
        nice(self.span / DIVISIONS)
    }

    fn right(&self, now: f64) -> f64 {
        match self.edge {
            // What follows the position of a recording is known, and worth a look.
            Edge::Live => (now + AHEAD * self.span).min(now.max(self.end)),
            Edge::At(to) => to,
        }
    }
}

impl Scale {
    /// The position of a time.
    pub(super) fn x(&self, time: f64) -> f32 {
        self.x.min + ((time - self.from) / (self.to - self.from) * f64::from(self.x.span())) as f32
    }

    /// The time at a position, in s.
    pub(super) fn time(&self, x: f32) -> f64 {
        self.from + f64::from((x - self.x.min) / self.x.span()) * (self.to - self.from)
    }

    /// Seconds per point.
    pub(super) fn per_point(&self) -> f64 {
        (self.to - self.from) / f64::from(self.x.span().max(1.0))
    }

    /// Whether a time is visible.
    pub(super) fn holds(&self, time: f64) -> bool {
        (self.from..=self.to).contains(&time)
    }
}

/// The smallest 1, 2 or 5 times a power of ten that is not less than `number`.
pub(super) fn nice(number: f64) -> f64 {
    let size = 10_f64.powf((number * 0.999_999).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|step| step * size);
    step.into_iter()
        .find(|step| *step >= number * 0.999_999)
        .unwrap_or(step[3])
}

/// The next or previous step in the sequence 1, 2, 5.
pub(super) fn step(division: f64, up: bool) -> f64 {
    nice(division * if up { 1.5 } else { 0.35 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zoom_keeps_the_time_under_the_pointer() {
        let mut axis = Axis::new(10.0);
        axis.pause(100.0);
        let x = Rangef::new(0.0, 1000.0);
        let before = axis.scale(100.0, x).x(97.0);
        axis.zoom(0.3, 97.0);
        assert_eq!(axis.span(), 3.0);
        assert!((axis.scale(200.0, x).x(97.0) - before).abs() < 1e-3);
    }

    #[test]
    fn a_zoom_keeps_following_the_present_and_a_pan_pauses() {
        let mut axis = Axis::new(10.0);
        axis.zoom(2.0, 95.0);
        let x = Rangef::new(0.0, 1.0);
        assert_eq!(axis.scale(100.0, x).to, 100.0);
        axis.pan(-5.0, 100.0);
        assert!(axis.is_paused());
        assert_eq!(axis.scale(200.0, x).to, 95.0);
        axis.follow();
        assert_eq!(axis.scale(200.0, x).to, 200.0);
    }

    #[test]
    fn a_recording_shows_what_follows_its_position_up_to_its_end() {
        let mut axis = Axis::new(10.0);
        axis.set_end(200.0);
        let right = |axis: &Axis, now: f64| axis.scale(now, Rangef::new(0.0, 1.0)).to;
        assert_eq!(
            [50.0, 199.0, 200.0].map(|now| right(&axis, now)),
            [53.0, 200.0, 200.0]
        );
        axis.pan(120.0, 50.0);
        assert_eq!(right(&axis, 50.0), 173.0);
    }

    #[test]
    fn divisions_follow_the_sequence_one_two_five() {
        assert_eq!([0.7, 1.0, 1.1, 3.0, 0.03].map(nice), [1.0, 1.0, 2.0, 5.0, 0.05]);
        let mut division = 1.0;
        let up = [(); 3].map(|()| {
            division = step(division, true);
            division
        });
        assert_eq!(up, [2.0, 5.0, 10.0]);
        let down = [(); 4].map(|()| {
            division = step(division, false);
            (division * 1e6).round() / 1e6
        });
        assert_eq!(down, [5.0, 2.0, 1.0, 0.5]);
    }
}
