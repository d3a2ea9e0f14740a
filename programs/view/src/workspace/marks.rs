//! The marks on the slider of a recording: where winners changed, robots touched something, schemas faulted and missions
//! failed.

use eframe::egui::{Rangef, Rect, Response, Stroke, Ui};
use jde_panel::Ink;

use crate::moments::{Moment, MomentKind};
use crate::style::{self, Style, Units};

/// Farthest distance of the pointer from a mark that it describes, in points.
const REACH: f32 = 4.0;

/// Draws the marks of a recording from its beginning to its end, s. Of those of one pixel, the most important is drawn.
pub(super) fn draw(ui: &Ui, rect: Rect, moments: &[Moment], span: (f64, f64)) {
    let style = Style::of(ui.ctx(), Units::default());
    let pixel = 1.0 / ui.pixels_per_point();
    let count = (rect.width() / pixel).ceil().max(1.0) as usize;
    let mut columns = vec![None; count];
    for moment in moments {
        let column = ((place(rect, span, moment.time_s) - rect.left()) / pixel).max(0.0) as usize;
        let drawn = &mut columns[column.min(count - 1)];
        *drawn = (*drawn).max(Some(moment.kind));
    }
    for (column, kind) in columns.into_iter().enumerate() {
        let Some(kind) = kind else { continue };
        let (ink, height, width) = match kind {
            MomentKind::Takeover => (Ink::Faint, 0.45, 1.0),
            MomentKind::Contact => (Ink::Warn, 0.7, 2.0),
            MomentKind::Fault | MomentKind::Failure => (Ink::Bad, 1.0, 2.0),
        };
        let x = rect.left() + (column as f32 + 0.5) * pixel;
        let y = Rangef::new(rect.bottom() - height * rect.height(), rect.bottom());
        ui.painter()
            .vline(x, y, Stroke::new(width, style::color_of(ink, &style)));
    }
}

/// Describes the most important moment under the pointer.
pub(super) fn at(slider: &Response, moments: &[Moment], span: (f64, f64)) -> Option<String> {
    let pointer = slider.hover_pos()?;
    let near = |moment: &&Moment| (place(slider.rect, span, moment.time_s) - pointer.x).abs() <= REACH;
    let moment = moments.iter().filter(near).max_by_key(|moment| moment.kind)?;
    Some(format!("{:.2} s: {}", moment.time_s, moment.text))
}

/// The position of a time on the slider, whose handle does not go to its very ends.
fn place(rect: Rect, (begin, end): (f64, f64), time_s: f64) -> f32 {
    let margin = rect.height() / 2.5;
    let share = ((time_s - begin) / (end - begin).max(1e-9)).clamp(0.0, 1.0) as f32;
    rect.left() + margin + share * (rect.width() - 2.0 * margin)
}
