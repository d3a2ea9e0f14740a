//! The time axis: which part of the past is on the screen, and where each moment is.

use eframe::egui::Rangef;

/// Grid lines of a window, about.
pub(super) const DIVISIONS: f64 = 10.0;
/// The shortest window, s: a few wake-ups of a thread.
const SHORTEST: f64 = 200e-6;
/// The longest, s.
const LONGEST: f64 = 100_000.0;

/// What part of the past is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// s from the left edge to the right.
    span: f64,
    edge: Edge,
    /// Nothing but a person moves the window.
    paused: bool,
}

/// Where the right edge is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Edge {
    /// At the present.
    Live,
    /// At a moment, s since the application's start.
    At(f64),
}

/// Where moments are on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    /// The time at the left edge, s.
    pub(super) from: f64,
    /// The time at the right edge, s.
    pub(super) to: f64,
    /// From the left edge to the right, points.
    pub(super) x: Rangef,
}

impl Axis {
    pub(super) fn new(span: f64) -> Self {
        Self {
            span: span.clamp(SHORTEST, LONGEST),
            edge: Edge::Live,
            paused: false,
        }
    }

    pub(super) fn span(&self) -> f64 {
        self.span
    }

    pub(super) fn is_paused(&self) -> bool {
        self.paused
    }

    /// Whether the right edge is the present.
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

    /// Shows the present as it comes.
    pub(super) fn follow(&mut self) {
        (self.edge, self.paused) = (Edge::Live, false);
    }

    /// Stays where it is.
    pub(super) fn pause(&mut self, now: f64) {
        (self.edge, self.paused) = (Edge::At(self.right(now)), true);
    }

    /// Shows a moment at a share of the window, and goes on.
    pub(super) fn show_at(&mut self, moment: f64, share: f64) {
        self.edge = Edge::At(moment + (1.0 - share) * self.span);
    }

    /// Stays at a moment if it is not on the screen already.
    pub(super) fn reveal(&mut self, moment: f64, now: f64) {
        let to = self.right(now);
        if !(to - self.span..=to).contains(&moment) {
            self.show_at(moment, 0.5);
            self.paused = true;
        }
    }

    /// Moves the window by s, and stays there.
    pub(super) fn pan(&mut self, by: f64, now: f64) {
        // What is ahead is empty: the present stays on the screen.
        let to = (self.right(now) + by).clamp(0.05 * self.span, now + 0.95 * self.span);
        (self.edge, self.paused) = (Edge::At(to), true);
    }

    /// Shows more or less, with a moment left where it is; a window that follows the present goes on doing so.
    pub(super) fn zoom(&mut self, factor: f64, at: f64) {
        let span = (self.span * factor).clamp(SHORTEST, LONGEST);
        if let Edge::At(to) = self.edge {
            self.edge = Edge::At(at + (to - at) * span / self.span);
        }
        self.span = span;
    }

    /// Sets the time between grid lines, s.
    pub(super) fn set_division(&mut self, division: f64, now: f64) {
        let middle = self.right(now) - self.span / 2.0;
        self.zoom(division * DIVISIONS / self.span, middle);
    }

    /// The time between grid lines, s: 1, 2 or 5 with zeros.
    pub(super) fn division(&self) -> f64 {
        nice(self.span / DIVISIONS)
    }

    fn right(&self, now: f64) -> f64 {
        match self.edge {
            Edge::Live => now,
            Edge::At(to) => to,
        }
    }
}

impl Scale {
    /// Where a moment is.
    pub(super) fn x(&self, time: f64) -> f32 {
        self.x.min + ((time - self.from) / (self.to - self.from) * f64::from(self.x.span())) as f32
    }

    /// Which moment is there.
    pub(super) fn time(&self, x: f32) -> f64 {
        self.from + f64::from((x - self.x.min) / self.x.span()) * (self.to - self.from)
    }

    /// s in a point.
    pub(super) fn per_point(&self) -> f64 {
        (self.to - self.from) / f64::from(self.x.span().max(1.0))
    }

    /// Whether a moment is on the screen.
    pub(super) fn holds(&self, time: f64) -> bool {
        (self.from..=self.to).contains(&time)
    }
}

/// The next 1, 2 or 5 with zeros that is not less.
pub(super) fn nice(number: f64) -> f64 {
    let size = 10_f64.powf((number * 0.999_999).log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|step| step * size);
    step.into_iter()
        .find(|step| *step >= number * 0.999_999)
        .unwrap_or(step[3])
}

/// The next step of 1, 2, 5 after or before one.
pub(super) fn step(division: f64, up: bool) -> f64 {
    nice(division * if up { 1.5 } else { 0.35 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zoom_leaves_the_moment_under_the_pointer_where_it_is() {
        let mut axis = Axis::new(10.0);
        axis.pause(100.0);
        let x = Rangef::new(0.0, 1000.0);
        let before = axis.scale(100.0, x).x(97.0);
        axis.zoom(0.3, 97.0);
        assert_eq!(axis.span(), 3.0);
        assert!((axis.scale(200.0, x).x(97.0) - before).abs() < 1e-3);
    }

    #[test]
    fn a_window_that_follows_the_present_does_so_while_it_is_zoomed_and_stops_when_it_is_moved() {
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
    fn divisions_go_up_and_down_in_steps_of_one_two_and_five() {
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
