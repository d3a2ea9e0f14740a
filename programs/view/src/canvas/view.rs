//! The visible part of a plane, and the transform from metres to the screen and back. It draws nothing.

use eframe::egui::{Pos2, Rect, Vec2, pos2};
use jde_panel::Area;
use serde::{Deserialize, Serialize};

use super::Gestures;

/// Least and greatest scale, in points of the screen per metre: a screen shows from 1 mm to 100 km.
const SCALE_RANGE: (f64, f64) = (0.01, 1.0e6);
/// Fraction of the screen that the home area fills.
const HOME_SHARE: f64 = 0.92;

/// The user's view of a plane, kept from frame to frame and from one start to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct View {
    /// The view after a pan or zoom. `None` shows the whole home area of the plane.
    seen: Option<Seen>,
    /// Gestures in progress.
    #[serde(skip)]
    pub(super) gestures: Gestures,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Seen {
    /// The middle, in m.
    center: [f64; 2],
    /// Points of the screen per metre.
    scale: f64,
}

/// The transform from metres to the screen and back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    rect: Rect,
    center: [f64; 2],
    scale: f64,
    forward_up: bool,
}

impl View {
    /// Shows the home area of the plane again.
    pub(crate) fn fit(&mut self) {
        self.seen = None;
    }

    /// Whether the home area is shown, without pan or zoom.
    pub(crate) fn is_fitted(&self) -> bool {
        self.seen.is_none()
    }

    /// Centers the view on a position and keeps the scale. A fitted view does not change.
    pub(crate) fn follow(&mut self, place: [f64; 2]) {
        if let Some(seen) = &mut self.seen {
            seen.center = place;
        }
    }

    /// The transform from metres to the screen, for a plane with the home area `home` shown in `rect`.
    pub(crate) fn transform(&self, rect: Rect, home: Area, forward_up: bool) -> Transform {
        let seen = self.seen.unwrap_or_else(|| {
            let size = [home.greatest[0] - home.least[0], home.greatest[1] - home.least[1]];
            let [across, up] = if forward_up { [size[1], size[0]] } else { size };
            let scale = (f64::from(rect.width()) / across).min(f64::from(rect.height()) / up);
            Seen {
                center: [
                    f64::midpoint(home.least[0], home.greatest[0]),
                    f64::midpoint(home.least[1], home.greatest[1]),
                ],
                scale: (scale * HOME_SHARE).clamp(SCALE_RANGE.0, SCALE_RANGE.1),
            }
        });
        Transform {
            rect,
            center: seen.center,
            scale: seen.scale,
            forward_up,
        }
    }

    /// Zooms by `factor`. The point at `at` on the screen stays in place.
    pub(crate) fn zoom(&mut self, rect: Rect, home: Area, forward_up: bool, at: Pos2, factor: f64) {
        let before = self.transform(rect, home, forward_up);
        let place = before.plane(at);
        let scale = (before.scale * factor).clamp(SCALE_RANGE.0, SCALE_RANGE.1);
        let mut after = Transform { scale, ..before };
        let shifted = after.plane(at);
        after.center[0] += place[0] - shifted[0];
        after.center[1] += place[1] - shifted[1];
        self.seen = Some(after.seen());
    }

    /// Moves the plane by points of the screen.
    pub(crate) fn pan(&mut self, rect: Rect, home: Area, forward_up: bool, by: Vec2) {
        let mut transform = self.transform(rect, home, forward_up);
        transform.center = transform.plane(rect.center() - by);
        self.seen = Some(transform.seen());
    }
}

impl Transform {
    /// The position on the screen of a position on the plane.
    pub(crate) fn screen(&self, [x, y]: [f64; 2]) -> Pos2 {
        let (across, up) = self.offset([x, y]);
        let middle = self.rect.center();
        pos2(middle.x + across as f32, middle.y - up as f32)
    }

    /// The position on the plane of a point of the screen, in m.
    pub(crate) fn plane(&self, at: Pos2) -> [f64; 2] {
        let middle = self.rect.center();
        let across = f64::from(at.x - middle.x) / self.scale;
        let up = f64::from(middle.y - at.y) / self.scale;
        if self.forward_up {
            [self.center[0] + up, self.center[1] - across]
        } else {
            [self.center[0] + across, self.center[1] + up]
        }
    }

    /// Points of the screen per metre.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// The rectangle of the screen in which the plane is shown.
    pub(crate) fn rect(&self) -> Rect {
        self.rect
    }

    /// Whether x points upwards.
    pub(crate) fn forward_up(&self) -> bool {
        self.forward_up
    }

    /// The visible area, in m.
    pub(crate) fn area(&self) -> Area {
        let (a, b) = (self.plane(self.rect.min), self.plane(self.rect.max));
        Area {
            least: [a[0].min(b[0]), a[1].min(b[1])],
            greatest: [a[0].max(b[0]), a[1].max(b[1])],
        }
    }

    /// The offset from the middle of the screen to the right and up, in points of the screen, in double
    /// precision.
    pub(super) fn offset(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        let (x, y) = (
            (x - self.center[0]) * self.scale,
            (y - self.center[1]) * self.scale,
        );
        if self.forward_up { (-y, x) } else { (x, y) }
    }

    fn seen(&self) -> Seen {
        Seen {
            center: self.center,
            scale: self.scale,
        }
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::vec2;

    use super::*;

    const HOME: Area = Area {
        least: [-1.0, -2.0],
        greatest: [3.0, 2.0],
    };

    fn rect() -> Rect {
        Rect::from_min_size(pos2(10.0, 20.0), vec2(400.0, 200.0))
    }

    fn is_near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-4
    }

    #[test]
    fn the_home_area_is_visible_and_the_aspect_ratio_is_kept() {
        for forward_up in [false, true] {
            let transform = View::default().transform(rect(), HOME, forward_up);
            for corner in [HOME.least, HOME.greatest] {
                assert!(rect().contains(transform.screen(corner)), "{corner:?}");
            }
            let (origin, x, y) = (
                transform.screen([0.0, 0.0]),
                transform.screen([1.0, 0.0]),
                transform.screen([0.0, 1.0]),
            );
            assert!((origin.distance(x) - origin.distance(y)).abs() < 1e-3);
        }
    }

    #[test]
    fn with_forward_up_x_points_up_and_y_points_left() {
        let transform = View::default().transform(rect(), HOME, true);
        let origin = transform.screen([0.0, 0.0]);
        assert!(transform.screen([1.0, 0.0]).y < origin.y);
        assert!(transform.screen([0.0, 1.0]).x < origin.x);
        let plain = View::default().transform(rect(), HOME, false);
        let origin = plain.screen([0.0, 0.0]);
        assert!(plain.screen([1.0, 0.0]).x > origin.x);
        assert!(plain.screen([0.0, 1.0]).y < origin.y);
    }

    #[test]
    fn a_position_survives_the_way_to_the_screen_and_back() {
        for forward_up in [false, true] {
            let mut view = View::default();
            view.zoom(rect(), HOME, forward_up, pos2(70.0, 90.0), 3.7);
            let transform = view.transform(rect(), HOME, forward_up);
            for place in [[0.0, 0.0], [0.3, -1.7], [2.5, 1.1]] {
                let back = transform.plane(transform.screen(place));
                assert!(is_near(place, back), "{place:?} came back as {back:?}");
            }
        }
    }

    #[test]
    fn a_zoom_keeps_the_point_under_the_pointer() {
        for forward_up in [false, true] {
            let at = pos2(333.0, 47.0);
            let mut view = View::default();
            let before = view.transform(rect(), HOME, forward_up).plane(at);
            view.zoom(rect(), HOME, forward_up, at, 2.5);
            assert!(!view.is_fitted());
            assert!(is_near(
                before,
                view.transform(rect(), HOME, forward_up).plane(at)
            ));
        }
    }

    #[test]
    fn a_pan_moves_the_plane_by_the_drag() {
        for forward_up in [false, true] {
            let mut view = View::default();
            let before = view.transform(rect(), HOME, forward_up).screen([1.0, 0.5]);
            view.pan(rect(), HOME, forward_up, vec2(31.0, -12.0));
            let after = view.transform(rect(), HOME, forward_up).screen([1.0, 0.5]);
            assert!((after - before - vec2(31.0, -12.0)).length() < 1e-2);
            view.fit();
            assert_eq!(
                view.transform(rect(), HOME, forward_up).screen([1.0, 0.5]),
                before
            );
        }
    }

    #[test]
    fn the_zoom_is_bounded() {
        let mut view = View::default();
        for _ in 0..200 {
            view.zoom(rect(), HOME, false, rect().center(), 10.0);
        }
        assert!(view.transform(rect(), HOME, false).scale() <= SCALE_RANGE.1);
        for _ in 0..200 {
            view.zoom(rect(), HOME, false, rect().center(), 0.1);
        }
        assert!(view.transform(rect(), HOME, false).scale() >= SCALE_RANGE.0);
    }
}
