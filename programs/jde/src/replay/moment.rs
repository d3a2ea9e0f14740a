//! A recording as it is at one time, which verbs of this process ask as they ask an application that runs.

use std::path::Path;
use std::sync::Arc;

use jde_board::Board;
use jde_link::{Events, Link, Settings, as_name};

use super::index::Index;
use super::interface::PlayedRecording;
use super::lookup::{self, Asked};
use super::panel_store::PanelStore;
use super::player::Player;
use super::publisher::Publisher;
use crate::failure::Failure;
use crate::quantity;
use crate::why::KnownSpan;

/// The advice for a wrong `--at` of a recording.
pub(crate) const TIME_HELP: &str =
    "with --in, --at is one time of the recording, such as 12.4s, or 19:06:45Z in UTC";
/// The longest name of an application on the link, bytes.
const MAX_NAME: usize = 64;

/// A recording that stands still. It can be asked until this value is dropped.
pub(crate) struct Moment {
    link: Link,
    /// What is wrong with the recording, in lines.
    pub(crate) notes: Vec<String>,
}

impl Moment {
    /// Serves of a recording what is asked, as it was at a time of the application, that one included; without one, at the
    /// end. The time is as it was typed. It reads no more than that needs.
    ///
    /// # Errors
    /// The recording cannot be read, the text is no time, the recording does not cover it, or nothing can be served.
    pub(crate) fn serve(recording: &Path, at: Option<&str>, asked: &Asked) -> Result<Self, Failure> {
        let mut index = Index::open(recording)?;
        if matches!(asked, Asked::Hierarchy) && !index.is_described {
            // Its records name the schemas, the later ones too.
            index = Index::read(recording)?;
        }
        let at = at.map(|at| quantity::moment(at, index.start_ns)).transpose();
        let at = at.map_err(|error| Failure::usage(error, TIME_HELP))?;
        let known = KnownSpan {
            from: index.begin as f64 / 1e9,
            until: index.end as f64 / 1e9,
        };
        let outside =
            at.and_then(|at| known.outside_reason(at as f64 / 1e9, "the messages of the recording"));
        if let Some(reason) = outside {
            return Err(Failure::NoMatch(reason));
        }
        let mut notes: Vec<_> = index.damage().into_iter().chain(index.gaps()).collect();
        let board = Arc::new(Board::new());
        let panels = PanelStore::new(index.panels.values());
        let mut publisher = Publisher::new(&board, &mut index, Arc::clone(&panels));
        let events = Events::of_records();
        // No other process finds it by its application's name.
        let name = unique_name(&index.application, std::process::id());
        let is_timed = at.is_some();
        let at = at.unwrap_or(index.end);
        let player = Arc::new(Player::new(index, true, 1.0, false, at.saturating_add(1)));
        player.stand();
        if let Some(error) = lookup::read(&player, at, asked, &mut publisher, &events)? {
            // A state needs every record until its time.
            if is_timed && matches!(asked, Asked::Hierarchy) {
                return Err(error.into());
            }
            notes.push(error.to_string());
        }
        let played = PlayedRecording::standing(player, board, panels, recording.display().to_string());
        let link = Link::open(&Settings::local(&name), Arc::new(played) as _, &events)?;
        Ok(Self { link, notes })
    }

    /// The name under which this process finds it.
    pub(crate) fn name(&self) -> &str {
        &self.link.about().name
    }
}

/// Returns a valid name that ends with the number of this process. A long name of an application is cut.
fn unique_name(application: &str, process: u32) -> String {
    let number = format!("-{process}");
    let mut name = as_name(application);
    // A valid name is ASCII.
    name.truncate(MAX_NAME - number.len());
    name + &number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_is_cut_before_the_number() {
        let long = "robot".repeat(20);
        let name = unique_name(&long, u32::MAX);
        assert_eq!((name.len(), name.ends_with("-4294967295")), (64, true), "{name}");
        assert!(jde_link::is_name(&name));
        assert_eq!(unique_name("robot2", 7), "robot2-7");
    }
}
