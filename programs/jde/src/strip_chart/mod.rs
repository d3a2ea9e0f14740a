//! A strip chart in a terminal: numbers over time, one trace each, drawn as they arrive.
//!
//! It reads its numbers through [`NumberSource`] alone, and does not depend on where they come from.

mod draw;
mod traces;

use std::io;
use std::time::{Duration, Instant};

use jde_terminal as terminal;
use ratatui::crossterm::event::{KeyCode, KeyModifiers};

use traces::Traces;

/// Time between two redraws.
const REDRAW_INTERVAL: Duration = Duration::from_millis(50);
/// The spans of time that the picture can show, s.
const WINDOW_SECONDS: [f64; 7] = [2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 1800.0];

/// A source of numbers.
pub(crate) trait NumberSource {
    /// Returns the numbers that arrived since the last call, in order. It does not wait.
    fn take_samples(&mut self) -> Vec<TracePoint>;

    /// Returns a text for the line below the picture, for example that the application is gone.
    fn status(&self) -> Option<String>;

    /// Whether the view must end, because the process was asked to.
    fn is_over(&self) -> bool;
}

/// A number of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TracePoint {
    /// The index of the trace.
    pub(crate) trace: usize,
    /// Time, s.
    pub(crate) time: f64,
    /// The number. A number that is not finite breaks the line.
    pub(crate) value: f64,
}

/// Shows traces until the user leaves. `names` are the names of the traces, with their units.
///
/// # Errors
/// Standard input or output is not a terminal, or the terminal is gone.
pub(crate) fn run(title: &str, names: Vec<String>, source: &mut dyn NumberSource) -> io::Result<()> {
    terminal::with_screen(|terminal| {
        let mut traces = Traces::new(names);
        let mut window = 2;
        loop {
            for sample in source.take_samples() {
                traces.add(sample);
            }
            if source.is_over() {
                return Ok(());
            }
            let status = source.status();
            terminal
                .draw(|frame| draw::draw(frame, &traces, title, WINDOW_SECONDS[window], status.as_deref()))?;
            let redraw = Instant::now() + REDRAW_INTERVAL;
            if let Some(key) = terminal.read_key(redraw)? {
                match key.code {
                    KeyCode::Char('q') | KeyCode::Esc => return Ok(()),
                    KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return Ok(()),
                    KeyCode::Char(' ') => traces.pause(),
                    KeyCode::Char('[') => window = window.saturating_sub(1),
                    KeyCode::Char(']') => window = (window + 1).min(WINDOW_SECONDS.len() - 1),
                    KeyCode::Char('c') => traces.clear(),
                    _ => {}
                }
            }
        }
    })
}
