//! A drawing as SVG within a page. Colours are CSS variables, so that the page's light or dark style applies.
//! Texts remain readable, searchable and copyable. All text from the recording is escaped.

use std::fmt::{self, Write};

use tiny_skia::Rect;

use crate::{Align, Drawing, DrawnShape, Element, ElementKind, Fill, LineStyle, Point};

/// The SVG under construction.
struct Svg<'d> {
    drawing: &'d Drawing,
    text: String,
    clips: Vec<Rect>,
    /// Whether a group with a tooltip is open.
    in_note: bool,
}

impl Drawing {
    /// Converts the drawing into SVG of the page's width. `label` describes it for screen readers; `prefix`
    /// distinguishes its ids from those of other drawings on the page.
    #[must_use]
    pub fn svg(&self, label: &str, prefix: &str) -> String {
        let mut svg = Svg {
            drawing: self,
            text: String::new(),
            clips: Vec::new(),
            in_note: false,
        };
        // Writing to a string cannot fail.
        let _ = svg.write(label, prefix);
        svg.text
    }
}

impl Svg<'_> {
    fn write(&mut self, label: &str, prefix: &str) -> fmt::Result {
        let (width, height) = (self.drawing.width, self.drawing.height);
        write!(
            self.text,
            r#"<svg viewBox="0 0 {} {}" role="img" aria-label="{}">"#,
            Rounded(width),
            Rounded(height),
            escaped(label)
        )?;
        let marks = &self.drawing.marks;
        let mut at = 0;
        while let Some(mark) = marks.get(at) {
            at += match bars(&marks[at..]) {
                Some((count, ink)) => {
                    self.bars(&marks[at..at + count], ink, prefix)?;
                    count
                }
                None => {
                    self.mark(mark, prefix)?;
                    1
                }
            };
        }
        if self.in_note {
            self.text.push_str("</g>");
        }
        for (number, clip) in self.clips.iter().enumerate() {
            write!(
                self.text,
                r#"<clipPath id="{prefix}{number}"><rect x="{}" y="{}" width="{}" height="{}"/></clipPath>"#,
                Rounded(clip.x()),
                Rounded(clip.y()),
                Rounded(clip.width()),
                Rounded(clip.height())
            )?;
        }
        self.text.push_str("</svg>");
        Ok(())
    }

    /// Writes rectangles of one colour as one path, since there may be thousands.
    fn bars(&mut self, marks: &[Element], ink: Fill, prefix: &str) -> fmt::Result {
        self.text.push_str("<path d=\"");
        for mark in marks {
            if let ElementKind::Fill(DrawnShape::Box(rect), _) = &mark.what {
                let (width, height) = (Rounded(rect.width()), Rounded(rect.height()));
                write!(
                    self.text,
                    "M{} {}h{width}v{height}h-{width}z",
                    Rounded(rect.x()),
                    Rounded(rect.y())
                )?;
            }
        }
        self.text.push('"');
        self.filled(ink)?;
        self.clipped(marks[0].clip, prefix)?;
        self.text.push_str("/>");
        Ok(())
    }

    fn mark(&mut self, mark: &Element, prefix: &str) -> fmt::Result {
        match &mark.what {
            ElementKind::Fill(shape, ink) => {
                self.shape(shape)?;
                self.filled(*ink)?;
            }
            ElementKind::Stroke(shape, line) => {
                self.shape(shape)?;
                self.stroked(*line)?;
            }
            ElementKind::Text {
                text,
                size,
                at: (x, y),
                align,
                ink,
            } => {
                let (x, y, size) = (Rounded(*x), Rounded(*y), Rounded(*size));
                write!(self.text, r#"<text x="{x}" y="{y}" font-size="{size}""#)?;
                self.text.push_str(match align {
                    Align::Left => "",
                    Align::Middle => r#" text-anchor="middle""#,
                    Align::Right => r#" text-anchor="end""#,
                });
                self.filled(*ink)?;
                self.clipped(mark.clip, prefix)?;
                return write!(self.text, ">{}</text>", escaped(text));
            }
            ElementKind::Note(note) => {
                if std::mem::replace(&mut self.in_note, note.is_some()) {
                    self.text.push_str("</g>");
                }
                if let Some(note) = note {
                    write!(self.text, "<g><title>{}</title>", escaped(note))?;
                }
                return Ok(());
            }
        }
        self.clipped(mark.clip, prefix)?;
        self.text.push_str("/>");
        Ok(())
    }

    fn shape(&mut self, shape: &DrawnShape) -> fmt::Result {
        match shape {
            DrawnShape::Line(points) => self.path_through(points, ""),
            DrawnShape::Area(points) => self.path_through(points, "z"),
            DrawnShape::Disc((x, y), radius) => {
                let (x, y, radius) = (Rounded(*x), Rounded(*y), Rounded(*radius));
                write!(self.text, r#"<circle cx="{x}" cy="{y}" r="{radius}""#)
            }
            DrawnShape::Box(rect) => {
                let (x, y) = (Rounded(rect.x()), Rounded(rect.y()));
                let (width, height) = (Rounded(rect.width()), Rounded(rect.height()));
                write!(
                    self.text,
                    r#"<rect x="{x}" y="{y}" width="{width}" height="{height}""#
                )
            }
        }
    }

    fn path_through(&mut self, points: &[Point], end: &str) -> fmt::Result {
        self.text.push_str("<path d=\"");
        for (number, (x, y)) in points.iter().enumerate() {
            let step = match number {
                0 => 'M',
                1 => 'L',
                _ => ' ',
            };
            write!(self.text, "{step}{} {}", Rounded(*x), Rounded(*y))?;
        }
        write!(self.text, "{end}\"")
    }

    fn filled(&mut self, ink: Fill) -> fmt::Result {
        write!(self.text, r#" fill="var({})""#, ink.tone)?;
        if ink.opacity < 1.0 {
            write!(self.text, r#" fill-opacity="{}""#, Rounded(ink.opacity))?;
        }
        Ok(())
    }

    fn stroked(&mut self, line: LineStyle) -> fmt::Result {
        let (tone, width) = (line.ink.tone, Rounded(line.width));
        write!(
            self.text,
            r#" fill="none" stroke="var({tone})" stroke-width="{width}""#
        )?;
        if line.ink.opacity < 1.0 {
            write!(self.text, r#" stroke-opacity="{}""#, Rounded(line.ink.opacity))?;
        }
        if let Some([line, gap]) = line.dash {
            write!(
                self.text,
                r#" stroke-dasharray="{} {}""#,
                Rounded(line),
                Rounded(gap)
            )?;
        }
        Ok(())
    }

    fn clipped(&mut self, clip: Option<Rect>, prefix: &str) -> fmt::Result {
        let Some(clip) = clip else { return Ok(()) };
        let known = self.clips.iter().position(|known| *known == clip);
        let number = known.unwrap_or_else(|| {
            self.clips.push(clip);
            self.clips.len() - 1
        });
        write!(self.text, r#" clip-path="url(#{prefix}{number})""#)
    }
}

/// The number of rectangles of one colour that follow, if any.
fn bars(marks: &[Element]) -> Option<(usize, Fill)> {
    let bar = |mark: &Element| match mark.what {
        ElementKind::Fill(DrawnShape::Box(_), ink) => Some((ink, mark.clip)),
        _ => None,
    };
    let first = bar(marks.first()?)?;
    let count = marks.iter().take_while(|mark| bar(mark) == Some(first)).count();
    Some((count, first.0))
}

fn escaped(text: &str) -> String {
    jde_files::escape(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// A number rounded to the two digits that are visible.
#[derive(Clone, Copy)]
struct Rounded(f32);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = (self.0 * 100.0).round() / 100.0;
        // Adding zero turns "-0" into "0".
        write!(f, "{}", rounded + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Align, ColorRole, Drawing, LineStyle};

    #[test]
    fn text_from_a_recording_never_becomes_markup() {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.note(Some("<b>\"".to_owned()));
        drawing.text(
            "<script>alert(1)</script>",
            5.0,
            (1.0, 2.0),
            Align::Left,
            ColorRole::Ink,
        );
        let svg = drawing.svg("a & \"b\"", "c");
        assert!(!svg.contains("<script>") && !svg.contains("<b>"), "{svg}");
        assert!(
            svg.contains("&lt;script&gt;") && svg.contains("a &amp; &quot;b&quot;"),
            "{svg}"
        );
    }

    #[test]
    fn bars_of_one_colour_are_one_path_and_groups_are_closed() {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.note(Some("three".to_owned()));
        for x in [0.0, 2.0, 4.0] {
            drawing.bar((x, 0.5), 1.0, 2.25, ColorRole::Of(8));
        }
        drawing.bar((6.0, 0.5), 1.0, 2.0, ColorRole::Bad.faded(0.5));
        drawing.polyline(
            &[(0.0, 0.0), (1.0, 1.0)],
            LineStyle::new(ColorRole::Ink, 1.0).dashed(1.0, 2.0),
        );
        let svg = drawing.svg("bars", "c");
        assert!(svg.contains("M0 0.5h1v2.25h-1zM2 0.5h1"), "{svg}");
        assert_eq!(svg.matches("<path").count(), 3, "{svg}");
        assert_eq!((svg.matches("<g>").count(), svg.matches("</g>").count()), (1, 1));
        assert!(
            svg.contains("var(--of1)") && svg.contains("fill-opacity=\"0.5\""),
            "{svg}"
        );
    }
}
