//! Plays a recording as if its application ran: tools inspect it in the same way.

mod clock;
mod hierarchy;
mod index;
mod interface;
mod lookup;
mod moment;
mod panel_store;
mod player;
mod publisher;
mod screen;
mod state;

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use clap::Args;
use jde_board::Board;
use jde_core::Nanos;
use jde_link::{Events, Link, Settings, as_name};
use jde_session::clock::speed;
use jde_terminal::escape::escape;
use jde_terminal::interrupt::SignalListener;
use jde_terminal::{self as terminal, FAINT, TITLE, WARN};

use crate::failure::{Failure, display_path};
use index::Index;
use interface::{CONTROL_SCHEMA, PlayedRecording};
use panel_store::PanelStore;
use player::{Player, StopPlayerOnDrop};
use publisher::Publisher;

pub(crate) use lookup::Asked;
pub(crate) use moment::{Moment, TIME_HELP};

/// The interval at which the position is written for tools.
const UPDATE_INTERVAL: Duration = Duration::from_millis(50);

/// How to play the recording.
#[derive(Args)]
pub(crate) struct PlayOptions {
    /// Play this many times as fast as real time.
    #[arg(long, value_name = "FACTOR", value_parser = speed, default_value = "1x", conflicts_with = "decide")]
    pub(crate) speed: f64,
    /// Start again at the end.
    #[arg(long = "loop", conflicts_with = "decide")]
    pub(crate) looping: bool,
    /// Start paused.
    #[arg(long, conflicts_with = "decide")]
    pub(crate) paused: bool,
    /// The name under which tools find it, instead of the application's.
    #[arg(long, value_name = "NAME", conflicts_with = "decide")]
    pub(crate) name: Option<String>,
    /// Play to the end without a screen.
    #[arg(long, conflicts_with = "decide")]
    pub(crate) plain: bool,
    /// Wait at the end until it is stopped, instead of ending there.
    #[arg(long, conflicts_with = "decide")]
    pub(crate) stay: bool,
    /// End at the end of standard input, and so with the process that started this one, even if that is
    /// killed.
    #[arg(long, hide = true, requires = "plain")]
    pub(crate) until_eof: bool,
}

/// Plays a recording from a time of the application, ns, to its end, or on a terminal until the user leaves.
///
/// # Errors
/// The recording cannot be read, or the link for tools cannot be opened.
pub(crate) fn play(recording: &Path, from: Nanos, options: PlayOptions) -> Result<(), Failure> {
    let mut index = Index::read(recording)?;
    let file = display_path(recording);
    let mut output = terminal::out();
    if let Some(damage) = index.damage() {
        writeln!(
            output,
            "{WARN}{file}{WARN:#}: {damage}; the part before it is played"
        )?;
    }
    for line in index.gaps() {
        writeln!(output, "{WARN}{file}{WARN:#}: {}", escape(&line))?;
    }
    let board = Arc::new(Board::new());
    let panels = PanelStore::new(index.panels.values());
    let mut publisher = Publisher::new(&board, &mut index, Arc::clone(&panels));
    for line in index.left_out.lines() {
        writeln!(output, "{WARN}not played{WARN:#}: {}", escape(&line))?;
    }
    let events = Events::of_records();
    let mut settings = Settings::local(&as_name(&index.application));
    settings.require_name = options.name.is_some();
    if let Some(name) = &options.name {
        settings.name.clone_from(name);
    }
    let player = Arc::new(Player::new(
        index,
        options.paused,
        options.speed,
        options.looping,
        from,
    ));
    let playing = Arc::new(PlayedRecording::new(
        Arc::clone(&player),
        Arc::clone(&board),
        panels,
        // Whoever shows it may read the file too.
        std::path::absolute(recording)
            .unwrap_or_else(|_| recording.to_owned())
            .display()
            .to_string(),
    ));
    // Tools see the recording at its start position from the beginning.
    player.go_to_start(&mut publisher, &events)?;
    playing.publish_state();
    let link = Link::open(&settings, Arc::clone(&playing) as _, &events)?;
    let name = &link.about().name;
    let lines = options.plain || !terminal::is_interactive();
    if lines {
        writeln!(
            output,
            "playing {TITLE}{file}{TITLE:#}, {:.1} s, as `{name}` {FAINT}(jde set {CONTROL_SCHEMA}.paused true, jde top, jde vars){FAINT:#}",
            (player.index.end - player.index.begin) as f64 / 1e9
        )?;
        output.flush()?;
    }
    let player_to_stop = Arc::clone(&player);
    let _interrupts = SignalListener::on_first(move || player_to_stop.stop())?;
    if options.until_eof {
        let player_to_end = Arc::clone(&player);
        // The thread is not joined. It ends at the latest with the process.
        thread::Builder::new().name("stdin".to_owned()).spawn(move || {
            // The end of the input and an error both mean that the parent process is gone.
            let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
            player_to_end.stop();
        })?;
    }
    thread::scope(|scope| {
        let stop = StopPlayerOnDrop(Arc::clone(&player));
        let line_events = events.clone();
        let playback = {
            let player = &player;
            scope.spawn(move || player.play(&mut publisher, &line_events, lines && !options.stay))
        };
        let screen_result = if lines {
            while !playback.is_finished() {
                playing.publish_state();
                thread::sleep(UPDATE_INTERVAL);
            }
            Ok(())
        } else {
            let (screen_open, screen_closed) = std::sync::mpsc::channel::<()>();
            let playing = &playing;
            scope.spawn(move || {
                while let Err(std::sync::mpsc::RecvTimeoutError::Timeout) =
                    screen_closed.recv_timeout(UPDATE_INTERVAL)
                {
                    playing.publish_state();
                }
            });
            let result = screen::run(&player, &format!("{file}  as {name}"));
            drop(screen_open);
            result
        };
        drop(stop);
        let played = playback
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        screen_result?;
        played
    })
}
