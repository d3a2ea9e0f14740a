//! `jde shell`: the verbs for running applications, one per line, with completion, history and help.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};

use clap::builder::Resettable;
use clap::{Args, Command, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::ArgValueCompleter;
use jde_session::cli::print_help;
use jde_session::log::Log;
use jde_terminal::interrupt::{SignalListener, exit_by_signal};
use jde_terminal::{self as terminal, FAINT, TITLE};
use ratatui::crossterm::terminal::disable_raw_mode;
use reedline::{
    ColumnarMenu, Completer, CompletionResult, DefaultHinter, Emacs, FileBackedHistory, KeyCode,
    KeyModifiers, MenuBuilder, Prompt, PromptEditMode, PromptHistorySearch, PromptHistorySearchStatus,
    Reedline, ReedlineEvent, ReedlineMenu, Signal, Span, Suggestion, default_emacs_keybindings,
};
use signal_hook::consts::{SIGHUP, SIGINT};

use super::client::{Client, Context, Target};
use crate::complete;
use crate::failure::Failure;

/// The most lines of history.
const HISTORY_LINES: usize = 5000;
/// The line that Ctrl-X runs, whatever has been typed so far.
const STOP_LINE: &str = "stop --all";
/// Name of the completion menu.
const MENU: &str = "completions";

/// Type the verbs for running applications, with completion of names, history and help.
///
/// On a terminal it is interactive. In a pipe it runs each line that it reads, and ends with the first that
/// fails.
#[derive(Args)]
#[command(after_help = "Examples:
  jde shell
  jde shell --app robot2 --at tls/robot2:7447 --key lab.toml
  printf 'stop goon\\nps\\n' | jde shell")]
pub(crate) struct Shell {
    #[command(flatten)]
    target: Target,
}

/// A line of the shell.
#[derive(Parser)]
#[command(
    name = "jde",
    no_binary_name = true,
    disable_version_flag = true,
    arg_required_else_help = true,
    subcommand_required = true,
    help_template = "{subcommands}\n\nTab completes, the up arrow goes back, Ctrl-R searches, Ctrl-X stops everything, Ctrl-D exits; `help VERB` prints details.\n"
)]
struct ShellCommand {
    #[command(subcommand)]
    verb: ShellVerb,
}

#[derive(Subcommand)]
enum ShellVerb {
    #[command(flatten)]
    Client(Box<Client>),
    /// Choose the application for the following verbs.
    Use {
        /// Its name; without it, the only running one.
        #[arg(value_name = "APP", add = ArgValueCompleter::new(complete::applications))]
        application: Option<String>,
    },
    /// Leave the shell.
    #[command(alias = "quit")]
    Exit,
}

/// What happens after a line.
enum Flow {
    Continue,
    Exit,
}

impl Shell {
    /// Reads lines and runs them.
    pub(super) fn run(self, log: Log) -> Result<(), Failure> {
        let context = Context::new(log);
        context.target.replace(self.target);
        if terminal::is_interactive() {
            run_interactive(&context)
        } else {
            run_piped(&context)
        }
    }
}

/// Runs each line of standard input. The first that fails ends the shell.
fn run_piped(context: &Context) -> Result<(), Failure> {
    let signals = ShellSignals::install()?;
    for line in std::io::stdin().lines() {
        let line = line?;
        if let Flow::Exit = signals.run_verb(|| execute(&line, context))? {
            break;
        }
        if signals.last_signal.load(Ordering::SeqCst) == SIGINT {
            return Err(Failure::broken(format!(
                "interrupted at `{line}`; the lines after it were not run"
            )));
        }
    }
    Ok(())
}

/// Handles signals for a whole shell, and the loss of its terminal, which counts as SIGHUP. A running verb
/// ends by itself first; then the shell ends, unless the signal was Ctrl-C.
struct ShellSignals {
    busy: Arc<AtomicBool>,
    /// The last signal that arrived while a verb ran; 0 for none. Ctrl-C never replaces another signal.
    last_signal: Arc<AtomicI32>,
    _interrupts: SignalListener,
}

impl ShellSignals {
    fn install() -> Result<Self, Failure> {
        let busy = Arc::new(AtomicBool::new(false));
        let last_signal = Arc::new(AtomicI32::new(0));
        let (is_busy, signal_before) = (Arc::clone(&busy), Arc::clone(&last_signal));
        let interrupts = SignalListener::on_each(move |signal, alone| {
            if signal != SIGINT || signal_before.load(Ordering::SeqCst) == 0 {
                signal_before.store(signal, Ordering::SeqCst);
            }
            // No verb runs, or the running verb has no listener and would not end.
            if !is_busy.load(Ordering::SeqCst) || alone && signal != SIGINT {
                // The line editor has the terminal in raw mode. The shell ends even if it cannot be restored.
                let _ = disable_raw_mode();
                exit_by_signal(signal);
            }
        })?;
        Ok(Self {
            busy,
            last_signal,
            _interrupts: interrupts,
        })
    }

    /// Ends the shell when its terminal closes: the line editor would wait for keys forever. A running verb
    /// ends by itself first.
    fn watch_terminal(&self) -> Result<(), Failure> {
        let (busy, last_signal) = (Arc::clone(&self.busy), Arc::clone(&self.last_signal));
        terminal::on_hang_up(move || {
            last_signal.store(SIGHUP, Ordering::SeqCst);
            terminal::finish_soon();
            if !busy.load(Ordering::SeqCst) {
                exit_by_signal(SIGHUP);
            }
        })?;
        Ok(())
    }

    fn run_verb<T>(&self, verb: impl FnOnce() -> T) -> T {
        self.busy.store(true, Ordering::SeqCst);
        terminal::resume_blocking();
        let result = verb();
        // Flush before the line editor takes the terminal again.
        let _ = terminal::drain();
        self.busy.store(false, Ordering::SeqCst);
        let signal = self.last_signal.load(Ordering::SeqCst);
        if ![0, SIGINT].contains(&signal) {
            exit_by_signal(signal);
        }
        result
    }
}

fn run_interactive(context: &Context) -> Result<(), Failure> {
    let signals = ShellSignals::install()?;
    signals.watch_terminal()?;
    let mut keys = default_emacs_keybindings();
    keys.add_binding(
        KeyModifiers::NONE,
        KeyCode::Tab,
        ReedlineEvent::UntilFound(vec![
            ReedlineEvent::Menu(MENU.to_owned()),
            ReedlineEvent::MenuNext,
        ]),
    );
    keys.add_binding(KeyModifiers::SHIFT, KeyCode::BackTab, ReedlineEvent::MenuPrevious);
    keys.add_binding(
        KeyModifiers::CONTROL,
        KeyCode::Char('x'),
        ReedlineEvent::ExecuteHostCommand(STOP_LINE.to_owned()),
    );
    let mut editor = Reedline::create()
        .with_completer(Box::new(ShellCompleter))
        .with_menu(ReedlineMenu::EngineCompleter(Box::new(
            ColumnarMenu::default().with_name(MENU),
        )))
        .with_edit_mode(Box::new(Emacs::new(keys)))
        .with_quick_completions(true)
        .with_partial_completions(true)
        .with_hinter(Box::new(DefaultHinter::default()))
        .with_ansi_colors(std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()));
    if let Some(file) = history_file()
        && let Ok(history) = FileBackedHistory::with_file(HISTORY_LINES, file)
    {
        editor = editor.with_history(Box::new(history));
    }
    writeln!(
        terminal::out(),
        "{TITLE}jde{TITLE:#} {FAINT}Tab completes, `help` lists the verbs, Ctrl-X stops everything, Ctrl-D exits{FAINT:#}"
    )?;
    terminal::drain()?;
    loop {
        let prompt = ShellPrompt(context.target.borrow().app.clone());
        match editor.read_line(&prompt) {
            // A typed line, or the line of a key; the latter keeps the text typed so far.
            Ok(Signal::Success(line) | Signal::HostCommand(line)) => {
                match signals.run_verb(|| execute(&line, context)) {
                    Ok(Flow::Continue) => {}
                    Ok(Flow::Exit) => return Ok(()),
                    Err(failure) if failure.is_closed_pipe() => return Ok(()),
                    Err(failure) => {
                        failure.report();
                        let _ = terminal::drain();
                    }
                }
            }
            Ok(Signal::CtrlC) => {}
            Ok(Signal::CtrlD) => return Ok(()),
            Ok(_) => {}
            Err(error) => return Err(Failure::broken(format!("the terminal cannot be read: {error}"))),
        }
    }
}

/// Runs a line.
fn execute(line: &str, context: &Context) -> Result<Flow, Failure> {
    let line = line.trim();
    if line.is_empty() || line.starts_with('#') {
        return Ok(Flow::Continue);
    }
    let arguments = split_words(line)?;
    let parsed = command()
        .try_get_matches_from(arguments)
        .and_then(|matches| ShellCommand::from_arg_matches(&matches));
    match parsed {
        Ok(ShellCommand {
            verb: ShellVerb::Exit,
        }) => Ok(Flow::Exit),
        Ok(ShellCommand {
            verb: ShellVerb::Use { application },
        }) => {
            // Check the connection now, not at the next verb.
            let target = Target {
                app: application,
                ..context.target.borrow().clone()
            };
            context.remote(&target, None)?;
            context.target.replace(target);
            Ok(Flow::Continue)
        }
        Ok(ShellCommand {
            verb: ShellVerb::Client(verb),
        }) => verb.run(context).map(|()| Flow::Continue),
        Err(error) if error.use_stderr() => Err(Failure::usage(
            error_text(&error),
            "`help` lists the verbs, `help VERB` prints details",
        )),
        Err(error) => {
            print_help(&error);
            Ok(Flow::Continue)
        }
    }
}

/// Returns the message of a wrong line, without clap's usage text.
fn error_text(error: &clap::Error) -> String {
    let text = error.to_string();
    let first = text
        .trim_start_matches("error: ")
        .lines()
        .take_while(|line| !line.is_empty());
    first.map(str::trim).collect::<Vec<_>>().join(" ")
}

fn split_words(line: &str) -> Result<Vec<String>, Failure> {
    shlex::split(line).ok_or_else(|| Failure::usage(format!("`{line}` has an open quote"), "close it"))
}

fn command() -> Command {
    // The shell read the environment at its start. Ignore it now: a later `use` has precedence.
    ShellCommand::command().mut_subcommands(|verb| verb.mut_args(|argument| argument.env(Resettable::Reset)))
}

fn history_file() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let state = state.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/state")))?;
    Some(state.join("jde/history"))
}

/// The prompt: shows the chosen application before the cursor.
struct ShellPrompt(Option<String>);

impl Prompt for ShellPrompt {
    fn render_prompt_left(&self) -> Cow<'_, str> {
        match &self.0 {
            Some(name) => Cow::Owned(format!("jde {name}")),
            None => Cow::Borrowed("jde"),
        }
    }

    fn render_prompt_right(&self) -> Cow<'_, str> {
        Cow::Borrowed("")
    }

    fn render_prompt_indicator(&self, _: PromptEditMode) -> Cow<'_, str> {
        Cow::Borrowed("> ")
    }

    fn render_prompt_multiline_indicator(&self) -> Cow<'_, str> {
        Cow::Borrowed("  ")
    }

    fn render_prompt_history_search_indicator(&self, search: PromptHistorySearch) -> Cow<'_, str> {
        let failing = match search.status {
            PromptHistorySearchStatus::Passing => "",
            PromptHistorySearchStatus::Failing => "nothing like ",
        };
        Cow::Owned(format!("({failing}{}) ", search.term))
    }
}

/// Completes verbs and options, and names of schemas and variables.
struct ShellCompleter;

impl Completer for ShellCompleter {
    fn complete(&mut self, line: &str, at: usize) -> CompletionResult {
        let before = &line[..at];
        let start = before.rfind(char::is_whitespace).map_or(0, |space| space + 1);
        let before_word = shlex::split(&before[..start]).unwrap_or_default();
        let words: Vec<_> = std::iter::once("jde".to_owned())
            .chain(before_word)
            .chain([before[start..].to_owned()])
            .map(Into::into)
            .collect();
        let last = words.len() - 1;
        // clap's engine expects a program name before the words.
        let mut command = command().no_binary_name(false);
        let candidates = clap_complete::engine::complete(&mut command, words, last, None).unwrap_or_default();
        let suggestions: Vec<_> = candidates
            .into_iter()
            .map(|candidate| Suggestion {
                value: candidate.get_value().to_string_lossy().into_owned(),
                description: candidate.get_help().map(ToString::to_string),
                span: Span::new(start, at),
                append_whitespace: true,
                ..Suggestion::default()
            })
            .collect();
        CompletionResult::fresh(suggestions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_commands_of_the_shell_are_valid() {
        command().debug_assert();
    }

    #[test]
    fn verbs_and_options_are_completed_at_the_cursor() {
        let values = |line: &str| -> Vec<String> {
            let result = ShellCompleter.complete(line, line.len());
            result
                .suggestions()
                .iter()
                .map(|suggestion| suggestion.value.clone())
                .collect()
        };
        assert_eq!(values("pla"), ["play"]);
        assert!(values("events --on").contains(&"--once".to_owned()));
        assert!(values("").contains(&"watch".to_owned()));
    }

    #[test]
    fn an_unknown_verb_is_reported_in_one_line_and_comments_are_ignored() {
        let context = Context::default();
        assert!(matches!(execute("  # nothing", &context), Ok(Flow::Continue)));
        assert!(matches!(execute("quit", &context), Ok(Flow::Exit)));
        let Err(Failure::Run(crate::failure::RunFailure::Usage { message, .. })) =
            execute("plya goon", &context)
        else {
            panic!("the verb is unknown");
        };
        assert!(message.contains("unrecognized subcommand 'plya'"), "{message}");
        assert!(!message.contains('\n'));
        assert!(execute("set 'goon.fast", &context).is_err());
    }
}
