//! The panel: the live picture with the pixels of the chosen colour, and the calibration of its range by
//! clicks.

use jde_schema::panel::Words;
use jde_schema::prelude::*;
use jde_vision::{ColorRange, Pixels};

use crate::Color;
use crate::colors::{ColorLimits, Colors};

/// Pixels around a click that are sampled, in each direction: more than the noise of one pixel, less than a
/// small ball.
const SAMPLE_RADIUS: usize = 2;
/// Most samples of a range: a hundred clicks.
const MOST_SAMPLES: usize = 2500;
/// How much darker a pixel of another colour is shown.
const DIM_FACTOR: u8 = 4;

impl Panel for Color {
    fn draw(&self, cx: &Context, pen: &mut Pen) {
        let colors = self.current_colors(cx);
        let names = colors.ranges.iter().map(|limits| limits.name.as_str());
        let chosen = self.chosen(&colors);
        pen.row(|pen| {
            pen.choice("color", "Colour", names, chosen);
            pen.toggle("extend", "Clicks add to the range", self.tuning.extends);
            pen.button("reset", "As in the application")
                .enabled(self.tuning.colors.is_some());
        });
        let Some(image) = self.image.get(cx) else {
            pen.text("No picture");
            return;
        };
        pen.text("Click on the colour in the picture. Pixels of other colours are dark.");
        let mut shown = Box::new(*image.value());
        if darken(&mut shown, &colors.ranges[chosen].range()).is_err() {
            pen.text("The picture is not in colour");
        }
        pen.image("picture", &shown).wants_clicks();
        if self.tuning.colors.is_some() {
            pen.text("For the application file:");
            pen.words(Words::Code, colors.to_string());
        }
    }

    fn touched(&mut self, cx: &Context, gesture: &Gesture) -> Result {
        let colors = self.current_colors(cx);
        if let Some(number) = gesture.chose("color") {
            self.tuning.chosen = number;
            self.tuning.samples.clear();
        } else if let Some(extends) = gesture.toggled("extend") {
            self.tuning.extends = extends;
        } else if gesture.pressed("reset") {
            self.tuning.colors = None;
            self.tuning.samples.clear();
        } else if let Some(place) = gesture.clicked("picture") {
            self.pick(cx, place, self.chosen(&colors), colors);
        }
        Ok(())
    }
}

impl Color {
    /// Returns the number of the colour that clicks set.
    fn chosen(&self, colors: &Colors) -> usize {
        self.tuning.chosen.min(colors.ranges.len().saturating_sub(1))
    }

    /// Makes the range of a colour from the pixels around a place of the picture. A place that is nearly grey
    /// changes nothing.
    fn pick(&mut self, cx: &Context, [column, row, _]: [f64; 3], chosen: usize, mut colors: Colors) {
        let Some(image) = self.image.get(cx) else {
            return;
        };
        let Ok(pixels) = Pixels::of(&image) else {
            return;
        };
        let [width, height] = pixels.size();
        let around = |middle: f64, size: usize| {
            let middle = middle.max(0.0) as usize;
            middle.saturating_sub(SAMPLE_RADIUS)..(middle.saturating_add(SAMPLE_RADIUS + 1)).min(size)
        };
        let mut samples = core::mem::take(&mut self.tuning.samples);
        if !self.tuning.extends || samples.len() >= MOST_SAMPLES {
            samples.clear();
        }
        for row in around(row, height) {
            samples.extend(around(column, width).map(|column| pixels.at(row, column)));
        }
        if let Some(range) = ColorRange::around(&samples) {
            let limits: &mut ColorLimits = &mut colors.ranges.as_mut_slice()[chosen];
            *limits = limits.with(&range);
            self.tuning.colors = Some(colors);
            self.tuning.samples = samples;
        }
    }
}

/// Keeps what was calibrated when another build replaces this one.
impl Memory for Color {
    fn save(&self, cx: &Context, saving: &mut Saving) {
        let calibrated = Flag::from(self.tuning.colors.is_some());
        saving.put(&calibrated);
        saving.put(&self.current_colors(cx));
    }

    fn restore(&mut self, _: &Context, saved: &mut Saved) -> Result {
        let calibrated: Flag = saved.take()?;
        let colors: Colors = saved.take()?;
        self.tuning.colors = calibrated.get().then_some(colors);
        Ok(())
    }
}

/// Darkens the pixels outside a range.
fn darken(image: &mut Image, range: &ColorRange) -> Result<(), jde_vision::UnknownPixels> {
    let pixels = Pixels::of(image)?;
    let [width, height] = pixels.size();
    let outside: Vec<bool> = (0..height)
        .flat_map(|row| (0..width).map(move |column| (row, column)))
        .map(|(row, column)| !range.contains(pixels.at(row, column)))
        .collect();
    let step = image.step as usize;
    let rows = image.data.as_mut_slice().chunks_mut(step.max(1));
    for (row, outside) in rows.zip(outside.chunks(width.max(1))) {
        for (pixel, _) in row.chunks_mut(3).zip(outside).filter(|(_, outside)| **outside) {
            pixel.iter_mut().for_each(|part| *part /= DIM_FACTOR);
        }
    }
    Ok(())
}
