//! Changes of a world while it runs, as a text. A world makes them; this module changes nothing.
//!
//! ```toml
//! { place = { robot = "pioneer", x = 9.5, y = 7.1, heading_deg = 90 } }  # the robot: another one than the own
//! { add = { name = "door", center = [2, 1], size = [0.9, 0.1] } }        # the keys of a box of a world file
//! { remove = "door" }                                                    # all things of that name
//! { halt = "anna" }                                                      # a mover or a person
//! { resume = "anna" }
//! { raise = "anna" }                                                     # a person, who raises the colour `signal`
//! { lower = "anna" }
//! ```
//!
//! Several are a list, `[{ remove = "door" }, { halt = "anna" }]`, or a numbered one, see [`EditQueue`].

use std::collections::VecDeque;

use crate::error::WorldError;
use crate::file::{self, BoxPlan};
use crate::geometry::Pose2;

/// The longest text of edits, in bytes.
const MAX_BYTES: usize = 4096;

/// One change of a world.
pub struct Edit {
    pub(crate) action: EditAction,
    /// Its table in the text.
    text: String,
}

pub(crate) enum EditAction {
    /// Another robot than the own, if it is named.
    Place(Option<String>, Pose2),
    Add(BoxPlan),
    Remove(String),
    Halt(String),
    Resume(String),
    Raise(String),
    Lower(String),
}

/// The changes of one text.
#[derive(Default)]
pub struct Edits {
    /// The number of the first edit. The others have the numbers after it.
    pub number: Option<u64>,
    /// The edits, in the order of the text.
    pub edits: Vec<Edit>,
}

/// Writes edits for a reader that sees only the newest text: each text repeats as many earlier edits as fit.
/// Their numbers tell the reader which ones it has made already.
#[derive(Debug)]
pub struct EditQueue {
    /// The number of the next edit.
    next: u64,
    recent: VecDeque<String>,
}

impl Edit {
    pub(crate) fn new(action: EditAction, text: &str) -> Self {
        let text = text.to_owned();
        Self { action, text }
    }
}

impl Edits {
    /// Parses a text; an empty one has no edits.
    ///
    /// # Errors
    /// All faults of the text.
    pub fn parse(text: &str) -> Result<Self, WorldError> {
        if text.is_empty() {
            return Ok(Self::default());
        }
        Ok(file::read_edits(text)?)
    }
}

impl Default for EditQueue {
    fn default() -> Self {
        Self {
            next: 1,
            recent: VecDeque::new(),
        }
    }
}

impl EditQueue {
    /// Appends edits, whatever their numbers in their own text. Returns the text to write, of at most 4096
    /// bytes.
    ///
    /// # Errors
    /// The new edits do not fit into one text. The queue is then unchanged.
    pub fn push(&mut self, edits: &Edits) -> Result<String, WorldError> {
        // Room for the number and the keys.
        let most = MAX_BYTES - 64;
        let bytes = |text: &String| text.len() + 2;
        let added: usize = edits.edits.iter().map(|edit| bytes(&edit.text)).sum();
        if added > most {
            return Err(WorldError::TooManyEdits { bytes: added, most });
        }
        self.next += edits.edits.len() as u64;
        self.recent
            .extend(edits.edits.iter().map(|edit| edit.text.clone()));
        while self.recent.iter().map(bytes).sum::<usize>() > most {
            self.recent.pop_front();
        }
        let number = self.next - self.recent.len() as u64;
        let list = Vec::from_iter(self.recent.iter().map(String::as_str)).join(", ");
        Ok(format!("{{ number = {number}, edits = [{list}] }}"))
    }
}
