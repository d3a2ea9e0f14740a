//! `jde why`: why a schema won, lost or did not act, in a running application or a recording.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_link::Remote;
use jde_log::{Recording, record};
use jde_records::event::{Occurrence, What};
use jde_records::{Decision, RecordKind, RunRecord};
use jde_session::cli::print_json;
use jde_terminal as terminal;
use serde::Serialize;

use super::resolve::split_one_application;
use super::target::recording_instead;
use super::{Context, Target};
use crate::complete;
use crate::failure::{Failure, display_path};
use crate::why::{self, Answer, KnownSpan, Question};

/// Number of selections requested from a running application: all that it keeps.
const MAX_SELECTIONS: usize = 1000;

/// Say why a schema won, lost or did not act, or why nobody won.
///
/// A question names schemas, and a group or a time if needed; the words between them are optional. Without a
/// time it means the last such takeover; a time alone means the choice in force then. A running application
/// keeps its last thousand selections; a recording has all of them.
#[derive(Args)]
#[command(after_help = "Examples:
  jde why vff
  jde why did vff take over from goon at 12.4s
  jde why is goon not the winner
  jde why nobody in example/base    the last selection without a winner
  jde why at 12.4s --in drive.mcap")]
pub(crate) struct Why {
    /// The question.
    #[arg(value_name = "QUESTION", add = ArgValueCompleter::new(complete::schemas))]
    question: Vec<String>,
    /// Ask this recording instead of an application.
    #[arg(long = "in", value_name = "FILE.mcap", value_hint = ValueHint::FilePath)]
    recording: Option<PathBuf>,
    #[command(flatten)]
    target: Target,
    /// Print the selection as one line of JSON.
    #[arg(long)]
    json: bool,
}

/// The output of `--json`.
#[derive(Serialize)]
struct SelectionOutput<'d> {
    decision: &'d Decision,
    before: Option<&'d Decision>,
    after: Option<&'d Decision>,
    limits: Vec<&'d Occurrence<String>>,
}

impl Why {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let (named, words) = split_one_application(&self.question)?;
        let selections = match &self.recording {
            Some(file) => {
                let selections = Selections::of_recording(file)?;
                for note in &selections.notes {
                    writeln!(terminal::err(), "{}: {note}", display_path(file))?;
                }
                selections
            }
            None => {
                if let Some(file) = words
                    .iter()
                    .find(|word| word.ends_with(".mcap") && Path::new(word).is_file())
                {
                    return Err(recording_instead(file));
                }
                Selections::of_application(&context.remote(&self.target, named)?)?
            }
        };
        let question = selections.read_question(&words)?;
        if self.json {
            return Ok(print_json(&selections.find(&question)?)?);
        }
        let answer = selections.answer(&question)?;
        let marked = question.winner.as_deref().filter(|_| question.negated);
        let mut out = terminal::out();
        why::write(&answer, marked, &mut out)?;
        out.flush()?;
        Ok(())
    }
}

/// Selections, the time range that they cover, and the names that a question may contain.
pub(crate) struct Selections {
    pub(crate) decisions: Vec<Decision>,
    /// The events of limited commands.
    limits: Vec<Occurrence<String>>,
    known: KnownSpan,
    schemas: Vec<String>,
    groups: Vec<String>,
    /// What is damaged or missing, in words.
    pub(crate) notes: Vec<String>,
}

/// Whether an event is of limited commands.
fn is_limit(event: &Occurrence<String>) -> bool {
    matches!(event.what, What::Limited { .. })
}

impl Selections {
    /// Reads all selections of a recording, up to its damage if it has any.
    ///
    /// # Errors
    /// It cannot be read, or contains none.
    pub(crate) fn of_recording(file: &Path) -> Result<Self, Failure> {
        let recording = Recording::open(file)?;
        let damage = recording.damage();
        let damage = damage.map(|damage| format!("it ends too soon, {damage}; the part before it is read"));
        let gaps = recording.gaps().iter().map(ToString::to_string);
        let notes = damage.into_iter().chain(gaps).chain(recording.left_out().lines());
        let notes: Vec<String> = notes.collect();
        let start = recording.metadata("jde").and_then(|jde| jde.get("start_ns"));
        let (first, _) = recording.times().unwrap_or_default();
        let start: u64 = start.and_then(|start| start.parse().ok()).unwrap_or(first);
        let mut until = 0;
        let (mut decisions, mut limits) = (Vec::new(), Vec::new());
        for message in recording.messages()? {
            let message = message?;
            until = message.log_time.saturating_sub(start);
            match record::read(&message) {
                Some(RunRecord::Decision(decision)) => decisions.push(decision),
                Some(RunRecord::Other(event)) if is_limit(&event) => limits.push(event),
                Some(RunRecord::Other(_) | RunRecord::State(_)) | None => {}
            }
        }
        if decisions.is_empty() {
            let missing = notes.iter().map(|note| format!(": {note}")).collect::<String>();
            return Err(Failure::usage(
                format!("{} contains no selections{missing}", display_path(file)),
                "`jde run APP --record FILE` records them",
            ));
        }
        // A recording that started later also contains the choice in force at its start.
        let from = first.saturating_sub(start) as f64 / 1e9;
        let known = KnownSpan {
            from: from.min(decisions[0].time_s),
            until: until as f64 / 1e9,
        };
        Ok(Self::new(
            decisions,
            limits,
            known,
            [Vec::new(), Vec::new()],
            notes,
        ))
    }

    /// Requests the last selections of a running application.
    ///
    /// # Errors
    /// It gives no answer.
    pub(crate) fn of_application(remote: &Remote) -> Result<Self, Failure> {
        let known = remote.schemas()?;
        let names = [
            known.schemas.into_iter().map(|schema| schema.name).collect(),
            known.groups.into_iter().map(|group| group.name).collect(),
        ];
        let records = |kind: RecordKind| -> Result<Vec<RunRecord>, Failure> {
            let (sender, receiver) = channel();
            let watching = remote.events(&[kind], MAX_SELECTIONS, move |event| {
                // The receiver is dropped after the reply.
                let _ = sender.send(event.record);
            })?;
            // All earlier ones have arrived when this returns.
            drop(watching);
            Ok(receiver.try_iter().collect())
        };
        let selections = records(RecordKind::Decision)?.into_iter();
        let decisions: Vec<Decision> = selections
            .filter_map(|record| match record {
                RunRecord::Decision(decision) => Some(decision),
                RunRecord::State(_) | RunRecord::Other(_) => None,
            })
            .collect();
        let events = records(RecordKind::Event)?.into_iter();
        let limits = events.filter_map(|record| match record {
            RunRecord::Other(event) if is_limit(&event) => Some(event),
            RunRecord::Other(_) | RunRecord::State(_) | RunRecord::Decision(_) => None,
        });
        let limits = limits.collect();
        let known = KnownSpan {
            from: match decisions.first() {
                Some(first) if decisions.len() >= MAX_SELECTIONS => first.time_s,
                Some(_) | None => 0.0,
            },
            until: remote.hierarchy()?.time as f64 / 1e9,
        };
        Ok(Self::new(decisions, limits, known, names, Vec::new()))
    }

    fn new(
        decisions: Vec<Decision>,
        limits: Vec<Occurrence<String>>,
        known: KnownSpan,
        [mut schemas, mut groups]: [Vec<String>; 2],
        notes: Vec<String>,
    ) -> Self {
        groups.extend(decisions.iter().map(|decision| decision.group.clone()));
        let candidates = decisions.iter().flat_map(|decision| &decision.candidates);
        schemas.extend(candidates.map(|candidate| candidate.name.clone()));
        for names in [&mut groups, &mut schemas] {
            names.sort_unstable();
            names.dedup();
        }
        Self {
            decisions,
            limits,
            known,
            schemas,
            groups,
            notes,
        }
    }

    /// Reads a question about them.
    ///
    /// # Errors
    /// It contains a word that is neither a name nor one of a question.
    pub(crate) fn read_question(&self, words: &[String]) -> Result<Question, Failure> {
        Question::parse(words, &self.schemas, &self.groups)
    }

    /// Returns the selection that a question asks for, with its neighbours, as the object that `--json` prints.
    ///
    /// # Errors
    /// There is no such selection: the reason in words.
    pub(crate) fn find(&self, question: &Question) -> Result<impl Serialize, Failure> {
        match self.answer(question)? {
            Answer::Match {
                decision,
                before,
                after,
                limits,
            } => Ok(SelectionOutput {
                decision,
                before,
                after,
                limits,
            }),
            Answer::NoMatch(reason) => Err(Failure::NoMatch(reason)),
        }
    }

    fn answer(&self, question: &Question) -> Result<Answer<'_>, Failure> {
        match question.answer(&self.decisions, &self.limits, self.known) {
            Answer::NoMatch(reason) => Err(Failure::NoMatch(reason)),
            found @ Answer::Match { .. } => Ok(found),
        }
    }
}
