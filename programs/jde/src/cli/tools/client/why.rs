//! `jde why`: why a schema won, lost or did not act, in a running application or a recording.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;

use clap::{Args, ValueHint};
use clap_complete::ArgValueCompleter;
use jde_files::LeftOut;
use jde_link::Remote;
use jde_link::message::{SchemaInfo, VariableInfo};
use jde_log::{RecordedHierarchy, RecordedVariables, Recording, record};
use jde_records::event::{Occurrence, What};
use jde_records::{CandidateRecord, Decision, RecordKind, RunRecord};
use jde_session::cli::print_json;
use jde_terminal::{self as terminal, WARN};
use jde_timeline::{Hierarchy, Keep, LogLimits, Timeline};
use jde_types::{ChunkStep, Value as _};
use serde::Serialize;

use super::resolve::split_one_application;
use super::target::recording_instead;
use super::{Context, Target};
use crate::complete;
use crate::failure::{Failure, display_path};
use crate::quantity;
use crate::why::{self, Answer, Asleep, DueStep, KnownSpan, MissingValue, Past, Question};

/// Number of records of each kind requested from a running application: all that it keeps.
const MAX_RECORDS: usize = 1_000_000;

/// What is kept of a run: all states, and no records, which are in lists.
const KEEP: Keep = Keep {
    marks: 0,
    records: LogLimits {
        records: 0,
        candidates: 0,
        switches: 0,
    },
    ..Keep::ALL
};

/// Say why a schema won, lost or did not act, or why nobody won.
///
/// A question names schemas, and a group or a time if needed; the words between them are optional. Without a
/// time it means the last such takeover; a time alone means the choice in force then. A running application
/// keeps its last thousand selections, and of those before the ones that changed a winner, for hours; a recording has all.
#[derive(Args)]
#[command(after_help = "Examples:
  jde why vff
  jde why did vff take over from goon at 12.4s
  jde why is goon not the winner
  jde why nobody in example/base    the last selection without a winner, or why all sleep
  jde why at 12.4s --in drive.mcap
  jde why at 19:06:45Z --in drive.mcap    a time of day in UTC")]
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
#[serde(untagged)]
enum SelectionOutput<'d> {
    Selection {
        decision: &'d Decision,
        before: Option<&'d Decision>,
        after: Option<&'d Decision>,
        limits: Vec<&'d Occurrence<String>>,
        steps: Vec<&'d DueStep>,
        #[serde(skip_serializing_if = "Vec::is_empty")]
        without_value: Vec<&'d MissingValue>,
    },
    Asleep {
        asleep: Asleep<'d>,
    },
}

impl Why {
    pub(crate) fn run(self, context: &Context) -> Result<(), Failure> {
        let (named, words) = split_one_application(&self.question)?;
        let selections = match &self.recording {
            Some(file) => {
                if self.target.has_typed_endpoint() {
                    return Err(Failure::usage(
                        "--at names no time here: the time of a question is a part of it",
                        "write jde why at 12.4s --in FILE",
                    ));
                }
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
        if let Answer::Match { decision, .. } = &answer {
            for missing in selections.missing(&question, decision) {
                writeln!(out, "  {WARN}no value{WARN:#}    {}", missing.text())?;
            }
        }
        out.flush()?;
        Ok(())
    }
}

/// Selections, the time range that they cover, and the names that a question may contain.
pub(crate) struct Selections {
    pub(crate) decisions: Vec<Decision>,
    /// The events of limited commands.
    limits: Vec<Occurrence<String>>,
    /// Why schemas sleep.
    causes: Vec<Occurrence<String>>,
    timeline: Timeline,
    /// The commands of chunks that came due. Of a running application, the last of each schema.
    steps: Vec<DueStep>,
    /// Of a running application, the imports that have no value now.
    missing: Vec<MissingValue>,
    known: KnownSpan,
    /// When the run started, ns since 1970.
    start_ns: u64,
    schemas: Vec<String>,
    groups: Vec<String>,
    /// What is damaged or missing, in words.
    pub(crate) notes: Vec<String>,
}

/// The records of a run by what is asked of them.
struct SortedRecords {
    decisions: Vec<Decision>,
    limits: Vec<Occurrence<String>>,
    causes: Vec<Occurrence<String>>,
    timeline: Timeline,
    steps: Vec<DueStep>,
}

impl SortedRecords {
    fn new(hierarchy: Hierarchy) -> Self {
        Self {
            decisions: Vec::new(),
            limits: Vec::new(),
            causes: Vec::new(),
            timeline: Timeline::new(hierarchy, KEEP),
            steps: Vec::new(),
        }
    }

    fn add(&mut self, record: RunRecord) {
        self.timeline.add(&record);
        match record {
            RunRecord::Decision(decision) => self.decisions.push(decision),
            RunRecord::Other(event) if is_limit(&event) => self.limits.push(event),
            RunRecord::Other(event) if why::is_cause(&event) => self.causes.push(event),
            RunRecord::Other(_) | RunRecord::State(_) => {}
        }
    }
}

/// Returns the schema that has a variable.
fn owner(variable: &str) -> &str {
    variable.rsplit_once('.').map_or(variable, |(owner, _)| owner)
}

/// Returns the imports that have no value now.
fn missing_values(schemas: &[SchemaInfo], variables: &[VariableInfo]) -> Vec<MissingValue> {
    let mut missing = Vec::new();
    for schema in schemas {
        for port in schema.ports.iter().filter(|port| port.role == "import") {
            let source = port.variable.as_ref();
            // A modulation or a command always has a value.
            let source = source.and_then(|source| {
                let mut exports = variables.iter().filter(|variable| variable.access == "export");
                exports.find(|variable| variable.name == *source)
            });
            let status = source.and_then(|source| source.status.as_ref());
            if let (Some(source), Some(status)) = (source, status)
                && (status.sequence == 0 || status.retracted)
            {
                missing.push(MissingValue {
                    schema: schema.name.clone(),
                    import: port.name.clone(),
                    variable: source.name.clone(),
                    age_s: status.age_s.filter(|_| status.sequence > 0),
                });
            }
        }
    }
    missing
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
        let damage = damage.map(|damage| format!("{}; the part before it is read", damage.sentence()));
        let gaps = recording.gaps().iter().map(ToString::to_string);
        let notes = damage.into_iter().chain(gaps).chain(recording.left_out().lines());
        let notes: Vec<String> = notes.collect();
        let start = recording.metadata("jde").and_then(|jde| jde.get("start_ns"));
        let (first, _) = recording.times().unwrap_or_default();
        let start: u64 = start.and_then(|start| start.parse().ok()).unwrap_or(first);
        let mut until = 0;
        let hierarchy = RecordedHierarchy::of_recording(&recording);
        let hierarchy = hierarchy.map_or_else(Hierarchy::default, |recorded| recorded.hierarchy());
        let mut sorted = SortedRecords::new(hierarchy);
        let (variables, step_type) = (RecordedVariables::of(&recording), ChunkStep::describe());
        let mut unread = LeftOut::default();
        for message in recording.messages()? {
            let message = message?;
            until = message.log_time.saturating_sub(start);
            if let Some(record) = record::read(&message) {
                sorted.add(record);
            } else if let Some(variable) = variables.get(&message.channel)
                && variable.value_type.name == step_type.name
                && let Ok(Some(step)) = variable.decode_as(&message.data, &mut unread)
            {
                let step = DueStep::new(owner(&variable.name), until as f64 / 1e9, &step);
                // It is given again until the next one is due.
                if sorted.steps.last().is_none_or(|last| !step.is_same(last)) {
                    sorted.steps.push(step);
                }
            }
        }
        let decisions = &sorted.decisions;
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
        let names = [Vec::new(), Vec::new()];
        Ok(Self::new(sorted, (known, start), names, notes))
    }

    /// Requests the last selections of a running application.
    ///
    /// # Errors
    /// It gives no answer.
    pub(crate) fn of_application(remote: &Remote) -> Result<Self, Failure> {
        let known = remote.schemas()?;
        let missing = missing_values(&known.schemas, &remote.variables(true)?);
        let names = [
            known.schemas.into_iter().map(|schema| schema.name).collect(),
            known.groups.into_iter().map(|group| group.name).collect(),
        ];
        let (sender, receiver) = channel();
        let watching = remote.events(&RecordKind::ALL, MAX_RECORDS, move |event| {
            // The receiver is dropped after the reply.
            let _ = sender.send(event.record);
        })?;
        // All earlier ones have arrived when this returns.
        drop(watching);
        let snapshot = remote.hierarchy()?;
        let mut sorted = SortedRecords::new(Hierarchy::of_snapshot(&snapshot));
        receiver.try_iter().for_each(|record| sorted.add(record));
        sorted.timeline.add_snapshot(&snapshot);
        let step_type = ChunkStep::describe();
        for variable in remote.variables(false)? {
            if variable.type_name != step_type.name {
                continue;
            }
            let sample = remote.get(&variable.name)?;
            let step = sample.bytes.as_deref().and_then(ChunkStep::from_bytes);
            let step = step.map(|step| DueStep::new(&variable.owner, sample.time as f64 / 1e9, &step));
            sorted.steps.extend(step);
        }
        let known = KnownSpan {
            from: match sorted.decisions.first() {
                Some(first) if first.number > 1 => first.time_s,
                Some(_) | None => 0.0,
            },
            until: snapshot.time as f64 / 1e9,
        };
        let start = remote.about().started_ns;
        Ok(Self {
            missing,
            ..Self::new(sorted, (known, start), names, Vec::new())
        })
    }

    fn new(
        SortedRecords {
            decisions,
            limits,
            causes,
            timeline,
            steps,
        }: SortedRecords,
        (known, start_ns): (KnownSpan, u64),
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
            causes,
            timeline,
            steps,
            missing: Vec::new(),
            known,
            start_ns,
            schemas,
            groups,
            notes,
        }
    }

    /// Returns the imports without a value of the schemas that were not ready in a selection, if the question is about
    /// these.
    fn missing(&self, question: &Question, decision: &Decision) -> Vec<&MissingValue> {
        let is_asked = |candidate: &CandidateRecord| {
            let is_named = question.negated && question.winner.as_ref() == Some(&candidate.name);
            !candidate.ready && (is_named || decision.choice.is_none())
        };
        let is_of = |missing: &MissingValue| {
            let mut candidates = decision.candidates.iter();
            candidates.any(|candidate| candidate.name == missing.schema && is_asked(candidate))
        };
        self.missing.iter().filter(|missing| is_of(missing)).collect()
    }

    /// Reads a question about them.
    ///
    /// # Errors
    /// It contains a word that is neither a name nor one of a question.
    pub(crate) fn read_question(&self, words: &[String]) -> Result<Question, Failure> {
        let sentence = words.join(" ");
        let words = sentence.split_whitespace().map(|word| {
            let plain = word.trim_end_matches('?');
            if !quantity::is_time_of_day(plain) {
                return Ok(word.to_owned());
            }
            let since = quantity::moment(plain, self.start_ns);
            let since = since.map(|since| format!("{}s", since as f64 / 1e9));
            since.map_err(|error| Failure::usage(error, "or give the seconds since its start, such as 12.4s"))
        });
        let words = words.collect::<Result<Vec<_>, _>>()?;
        Question::parse(&words, &self.schemas, &self.groups)
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
                steps,
            } => Ok(SelectionOutput::Selection {
                without_value: self.missing(question, decision),
                decision,
                before,
                after,
                limits,
                steps,
            }),
            Answer::Asleep(asleep) => Ok(SelectionOutput::Asleep { asleep }),
            Answer::NoMatch(reason) => Err(Failure::NoMatch(reason)),
        }
    }

    fn answer(&self, question: &Question) -> Result<Answer<'_>, Failure> {
        let past = Past {
            timeline: &self.timeline,
            decisions: &self.decisions,
            events: &self.causes,
            steps: &self.steps,
            known: self.known,
        };
        match question.answer(past, &self.limits) {
            Answer::NoMatch(reason) => {
                let is_of = |missing: &&MissingValue| question.winner.as_ref() == Some(&missing.schema);
                let missing = self.missing.iter().filter(is_of);
                let reasons: Vec<_> = [reason]
                    .into_iter()
                    .chain(missing.map(MissingValue::text))
                    .collect();
                Err(Failure::NoMatch(reasons.join("; ")))
            }
            found @ (Answer::Match { .. } | Answer::Asleep(_)) => Ok(found),
        }
    }
}
