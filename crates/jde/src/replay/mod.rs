//! Plays a recording as if its application ran: tools inspect it in the same way.

mod clock;
mod hierarchy;
mod index;
mod interface;
mod panel_store;
mod player;
mod publisher;
mod screen;
mod state;

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use jde_board::Board;
use jde_core::Nanos;
use jde_link::{Events, Link, Settings, as_name};

use crate::failure::{Failure, display_path};
use crate::interrupt::SignalListener;
use crate::terminal::{self, FAINT, TITLE, WARN};
use index::Index;
pub(crate) use index::{RecordedVariable, variables};
use interface::{CONTROL_SCHEMA, PlayedRecording};
use panel_store::PanelStore;
use player::{Player, StopPlayerOnDrop};
use publisher::Publisher;

/// The interval at which the position is written for tools.
const UPDATE_INTERVAL: Duration = Duration::from_millis(50);

/// What to play, and how.
pub(crate) struct PlayOptions {
    /// The recording.
    pub(crate) file: PathBuf,
    /// The name under which tools find it.
    pub(crate) name: Option<String>,
    /// Start at this time of the application, in ns.
    pub(crate) from: Nanos,
    /// Seconds of the recording per second.
    pub(crate) speed: f64,
    /// Start paused.
    pub(crate) paused: bool,
    /// Start again at the end.
    pub(crate) looping: bool,
    /// Print lines instead of showing a screen.
    pub(crate) plain: bool,
    /// Wait at the end instead of ending there.
    pub(crate) wait_at_end: bool,
    /// End at the end of standard input.
    pub(crate) until_eof: bool,
}

/// Plays a recording to its end, or on a terminal until the user leaves.
///
/// # Errors
/// The recording cannot be read, or the link for tools cannot be opened.
pub(crate) fn play(how: PlayOptions) -> Result<(), Failure> {
    let index = Index::read(&how.file)?;
    let file = display_path(&how.file);
    let mut words = terminal::out();
    if let Some(damage) = index.damage() {
        writeln!(words, "{WARN}{file}{WARN:#}: {damage}; what is before is played")?;
    }
    let board = Arc::new(Board::new());
    let gallery = PanelStore::new(index.panels.values());
    let mut stage = Publisher::new(&board, &index, Arc::clone(&gallery));
    let events = Events::of_records();
    let mut settings = Settings::local(&as_name(&index.application));
    settings.require_name = how.name.is_some();
    if let Some(name) = &how.name {
        settings.name.clone_from(name);
    }
    let player = Arc::new(Player::new(index, how.paused, how.speed, how.looping, how.from));
    let playing = Arc::new(PlayedRecording::new(
        Arc::clone(&player),
        Arc::clone(&board),
        gallery,
        file.clone(),
    ));
    // From its first instant on, tools see the recording at its place.
    player.go_to_start(&mut stage, &events)?;
    playing.publish_state();
    let link = Link::open(&settings, Arc::clone(&playing) as _, &events)?;
    let name = &link.about().name;
    let lines = how.plain || !terminal::is_interactive();
    if lines {
        writeln!(
            words,
            "playing {TITLE}{file}{TITLE:#}, {:.1} s, as `{name}` {FAINT}(jde set {CONTROL_SCHEMA}.paused true, jde top, jde vars){FAINT:#}",
            (player.index.end - player.index.begin) as f64 / 1e9
        )?;
        words.flush()?;
    }
    let interrupted = Arc::clone(&player);
    let _interrupts = SignalListener::on_first(move || interrupted.stop())?;
    if how.until_eof {
        let left = Arc::clone(&player);
        // The thread is not joined. It ends at the latest with the process.
        thread::Builder::new().name("stdin".to_owned()).spawn(move || {
            // The end of the input and an error both mean that the parent process is gone.
            let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
            left.stop();
        })?;
    }
    thread::scope(|scope| {
        let stop = StopPlayerOnDrop(Arc::clone(&player));
        let told = events.clone();
        let turns = {
            let player = &player;
            scope.spawn(move || player.play(&mut stage, &told, lines && !how.wait_at_end))
        };
        let shown = if lines {
            while !turns.is_finished() {
                playing.publish_state();
                thread::sleep(UPDATE_INTERVAL);
            }
            Ok(())
        } else {
            let (show, shown) = std::sync::mpsc::channel::<()>();
            let playing = &playing;
            scope.spawn(move || {
                while let Err(std::sync::mpsc::RecvTimeoutError::Timeout) =
                    shown.recv_timeout(UPDATE_INTERVAL)
                {
                    playing.publish_state();
                }
            });
            let left = screen::run(&player, &format!("{file}  as {name}"));
            drop(show);
            left
        };
        drop(stop);
        let played = turns
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        shown?;
        played
    })
}
