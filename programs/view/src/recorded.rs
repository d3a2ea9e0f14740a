//! The whole of a recording: its states, selections, marks and curves, from its beginning to its end, wherever it plays. A
//! thread reads the file once, and once more for curves. It plays nothing.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use eframe::egui;
use jde_log::log_line::{self, LogLine};
use jde_log::{LeftOut, RecordedHierarchy, RecordedVariables, Recording, record};
use jde_timeline::{Hierarchy, Keep, LogLimits, Timeline, Trace};
use parking_lot::Mutex;

use crate::moments::{Moment, MomentKind, Moments};
use crate::window::scope::source::Source;

/// What is kept of a recording: all, but for the selections that changed nothing, of which the last hundred thousand are.
const KEEP: Keep = Keep {
    records: LogLimits {
        records: 100_000,
        candidates: 1_000_000,
        switches: 100_000,
    },
    ..Keep::ALL
};
/// The most values of a curve: an hour at 500 Hz, 32 MB.
const MAX_VALUES: usize = 2_000_000;
/// The most lines of schemas.
const MAX_LINES: usize = 100_000;

/// A recording that is read besides being played. Dropping it ends the thread after its present task.
pub(crate) struct Recorded {
    known: Arc<Mutex<Known>>,
    requests: Sender<Request>,
}

/// What has been read so far.
#[derive(Default)]
struct Known {
    past: Option<Arc<Past>>,
    curves: HashMap<String, Curve>,
}

/// The values of a number.
#[derive(Clone)]
enum Curve {
    Requested,
    Read(Arc<Trace>),
}

/// A curve to read: its name, and where its numbers come from.
type Request = (String, Source);

/// What happened from the beginning of a recording to its end.
pub(crate) struct Past {
    pub(crate) timeline: Timeline,
    /// What the schemas logged, in the order of the file.
    pub(crate) log: Vec<LogLine>,
    /// What deserves a look, in the order of its time.
    pub(crate) moments: Vec<Moment>,
    /// From when until when nothing was recorded, s.
    pub(crate) gaps: Vec<(f64, f64)>,
    /// The time of the last message, s.
    pub(crate) end_s: f64,
}

impl Recorded {
    /// Begins to read a recording.
    pub(crate) fn open(file: PathBuf, repaint: egui::Context) -> Self {
        let known = Arc::new(Mutex::new(Known::default()));
        let (requests, received) = channel();
        let found = Arc::clone(&known);
        let worker = move || {
            if let Err(reason) = read(&file, &found, &received, &repaint) {
                tracing::warn!("{} is shown as it plays: {reason}", file.display());
            }
        };
        // The thread ends with its sender, so its handle is not kept.
        if let Err(error) = thread::Builder::new()
            .name("view-recording".to_owned())
            .spawn(worker)
        {
            tracing::error!("no thread to read a recording: {error}");
        }
        Self { known, requests }
    }

    /// Returns what happened, once the file has been read.
    pub(crate) fn past(&self) -> Option<Arc<Past>> {
        self.known.lock().past.clone()
    }

    /// Returns the values of a number, once they have been read. The first call requests them.
    pub(crate) fn curve(&self, name: &str, source: &Source) -> Option<Arc<Trace>> {
        let mut known = self.known.lock();
        match known.curves.get(name) {
            Some(Curve::Read(trace)) => return Some(Arc::clone(trace)),
            Some(Curve::Requested) => return None,
            None => {}
        }
        known.curves.insert(name.to_owned(), Curve::Requested);
        // Without the thread, the curve is that of what plays; the log has the reason.
        let _ = self.requests.send((name.to_owned(), source.clone()));
        None
    }
}

/// Reads the recording, and then the curves that are requested.
fn read(
    file: &Path,
    known: &Mutex<Known>,
    requests: &Receiver<Request>,
    repaint: &egui::Context,
) -> Result<(), String> {
    let recording = Recording::open(file).map_err(|error| error.to_string())?;
    let variables = RecordedVariables::of(&recording);
    let start = recording.metadata("jde").and_then(|jde| jde.get("start_ns"));
    let first = recording.times().map_or(0, |(first, _)| first);
    let start = start.and_then(|start| start.parse().ok()).unwrap_or(first);
    let past = Past::read(&recording, &variables, start)?;
    known.lock().past = Some(Arc::new(past));
    repaint.request_repaint();
    while let Ok(request) = requests.recv() {
        // Those that were requested together are read together.
        let requests: Vec<_> = [request].into_iter().chain(requests.try_iter()).collect();
        let curves = read_curves(&recording, &variables, start, &requests)?;
        let curves = curves
            .into_iter()
            .map(|(name, trace)| (name, Curve::Read(Arc::new(trace))));
        known.lock().curves.extend(curves);
        repaint.request_repaint();
    }
    Ok(())
}

fn read_curves(
    recording: &Recording,
    variables: &RecordedVariables,
    start: u64,
    requests: &[Request],
) -> Result<Vec<(String, Trace)>, String> {
    let mut curves: Vec<_> = requests
        .iter()
        .map(|(name, source)| (name.clone(), source.clone(), Trace::new(MAX_VALUES)))
        .collect();
    let wanted: BTreeSet<_> = requests
        .iter()
        .flat_map(|(_, source)| source.variables())
        .collect();
    let mut left_out = LeftOut::default();
    let mut add = |variable: &str, time_s: f64, bytes: Option<&[u8]>| {
        for (_, source, trace) in &mut curves {
            if let Some(value) = source.take(variable, bytes) {
                trace.add(time_s, value);
            }
        }
    };
    let mut gaps = recording.gaps().iter().peekable();
    // The first unreadable message is the place of the damage, which the player reports.
    for message in recording
        .messages()
        .map_err(|error| error.to_string())?
        .map_while(Result::ok)
    {
        let time = message.log_time.saturating_sub(start);
        let time_s = time as f64 / 1e9;
        while let Some(gap) = gaps.next_if(|gap| gap.from <= time) {
            wanted
                .iter()
                .for_each(|variable| add(variable, gap.from as f64 / 1e9, None));
        }
        if let Some(variable) = variables.get(&message.channel) {
            if wanted.contains(&variable.name)
                && let Ok(bytes) = variable.decode(&message.data, &mut left_out)
            {
                add(&variable.name, time_s, Some(&bytes));
            }
        } else if let Some(record) = record::read(&message)
            && let Some(variable) = record.retracted_variable()
        {
            add(variable, time_s, None);
        }
    }
    Ok(curves.into_iter().map(|(name, _, trace)| (name, trace)).collect())
}

impl Past {
    /// Reads a recording whose application started at a time, ns since 1970.
    fn read(recording: &Recording, variables: &RecordedVariables, start: u64) -> Result<Self, String> {
        let hierarchy = RecordedHierarchy::of_recording(recording);
        let hierarchy = hierarchy.map_or_else(Hierarchy::default, |recorded| recorded.hierarchy());
        let (mut timeline, mut moments, mut end) =
            (Timeline::new(hierarchy, KEEP), Moments::new(variables), 0);
        let mut log = Vec::new();
        for message in recording
            .messages()
            .map_err(|error| error.to_string())?
            .map_while(Result::ok)
        {
            let time = message.log_time.saturating_sub(start);
            end = end.max(time);
            if let Some(variable) = variables.get(&message.channel) {
                moments.value(time as f64 / 1e9, &variable.name, &message.data);
            } else if log_line::is_log(&message.channel) {
                if log.len() < MAX_LINES {
                    log.extend(log_line::read(&message.data));
                }
            } else if let Some(record) = record::read(&message) {
                timeline.add(&record);
                moments.record(&record);
            }
        }
        moments
            .list
            .sort_by(|one, other| one.time_s.total_cmp(&other.time_s));
        let end_s = end as f64 / 1e9;
        let seconds = |time: u64| time as f64 / 1e9;
        let gaps = recording.gaps().iter();
        let gaps = gaps.map(|gap| (seconds(gap.from), gap.until.map_or(end_s, seconds)));
        Ok(Self {
            timeline,
            log,
            moments: moments.list,
            gaps: gaps.collect(),
            end_s,
        })
    }

    /// Returns the last takeover before a time, s.
    pub(crate) fn takeover_before(&self, time_s: f64) -> Option<&Moment> {
        let takeovers = self
            .moments
            .iter()
            .filter(|moment| moment.kind == MomentKind::Takeover);
        takeovers.take_while(|moment| moment.time_s < time_s).last()
    }

    /// Returns the first takeover after a time, s.
    pub(crate) fn takeover_after(&self, time_s: f64) -> Option<&Moment> {
        let mut takeovers = self
            .moments
            .iter()
            .filter(|moment| moment.kind == MomentKind::Takeover);
        takeovers.find(|moment| moment.time_s > time_s)
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, SystemTime};

    use jde_core::{Health, State};
    use jde_recorder::{Origin, Recorder, RecorderOptions, Stamps, Topic};
    use jde_records::event::{StateChange, What};
    use jde_records::{Decision, RunRecord};
    use jde_types::{Mission, Truth, Value};

    use super::*;
    use crate::window::scope::field;

    const SECOND: u64 = 1_000_000_000;

    fn export<T: Value>(recorder: &Recorder, name: &str) -> Topic {
        let about = [
            ("variable", format!("robot.{name}")),
            ("access", "export".to_owned()),
        ];
        let about = about.map(|(key, value)| (key.to_owned(), value));
        recorder.topic(&format!("/robot/{name}"), Arc::new(T::describe()), about.into())
    }

    /// A minute in which a number is 1 for the first tenth of each second, `goon` and `vff` take turns of ten seconds, the
    /// robot touches something at 30 s, and the mission fails at 50 s.
    fn record(file: &Path) {
        let options = RecorderOptions {
            origin: Origin {
                application: "turns".to_owned(),
                seed: 7,
                started: SystemTime::UNIX_EPOCH + Duration::from_secs(1000),
                folder: None,
                file: None,
                hierarchy: None,
            },
            application: None,
            overwrite: true,
            lossless: true,
            on_trouble: Box::new(|trouble| panic!("{trouble}")),
        };
        let recorder = Recorder::create(file, options).expect("the file is created");
        let pulse = export::<f64>(&recorder, "pulse");
        let truth = export::<Truth>(&recorder, "truth");
        let mission = export::<Mission>(&recorder, "mission");
        for step in 0..600_u64 {
            let time = step * SECOND / 10;
            let stamps = Stamps {
                published: time,
                measured: time,
                sequence: step + 1,
            };
            if step % 100 == 0 {
                let names = [["goon", "vff"], ["vff", "goon"]][usize::from(step % 200 == 0)];
                recorder.push_record(RunRecord::Decision(Decision {
                    number: step / 100 + 1,
                    time_s: time as f64 / 1e9,
                    group: "roots".to_owned(),
                    before: (step > 0).then(|| names[0].to_owned()),
                    choice: Some(names[1].to_owned()),
                    changed: true,
                    ..Decision::default()
                }));
                for (schema, from, to) in [
                    (names[0], State::Winner, State::Checking),
                    (names[1], State::Checking, State::Winner),
                ] {
                    let schema = schema.to_owned();
                    recorder.push_record(RunRecord::State(StateChange {
                        time,
                        schema,
                        from,
                        to,
                    }));
                }
            }
            pulse.put(f64::from(u8::from(step % 10 == 0)).as_bytes(), stamps);
            let seen = Truth {
                collisions: u64::from(step >= 300),
                ..Truth::default()
            };
            truth.put(seen.as_bytes(), stamps);
            let mut state = Mission::zeroed();
            state.state = if step >= 500 {
                Mission::FAILED
            } else {
                Mission::RUNNING
            };
            mission.put(state.as_bytes(), stamps);
        }
        let faulted = What::HealthChanged {
            schema: "goon".to_owned(),
            health: Health::Faulted("it panicked".to_owned()),
        };
        recorder.push_record(faulted.at(59_500_000_000).into());
        recorder.finish();
    }

    #[test]
    fn all_of_a_recording_is_known_wherever_it_plays() {
        let folder = tempfile::tempdir().expect("the folder is created");
        let file = folder.path().join("turns.mcap");
        record(&file);
        let recording = Recording::open(&file).expect("it is a recording");
        let variables = RecordedVariables::of(&recording);
        let start = 1000 * SECOND;
        let past = Past::read(&recording, &variables, start).expect("it can be read");

        let goon = past.timeline.schema("goon").expect("a record names it");
        let states: Vec<_> = goon
            .states
            .iter()
            .map(|state| (state.from / SECOND, state.value))
            .collect();
        assert_eq!(states.len(), 6, "{states:?}");
        assert_eq!(past.timeline.log().switches().len(), 6);
        let kinds: Vec<_> = past
            .moments
            .iter()
            .map(|moment| (moment.time_s, moment.kind))
            .collect();
        use MomentKind::{Contact, Failure, Fault, Takeover};
        let expected = [
            (0.0, Takeover),
            (10.0, Takeover),
            (20.0, Takeover),
            (30.0, Takeover),
            (30.0, Contact),
            (40.0, Takeover),
            (50.0, Takeover),
            (50.0, Failure),
            (59.5, Fault),
        ];
        assert_eq!(kinds, expected);
        let times = |moment: Option<&Moment>| moment.map(|moment| moment.time_s);
        assert_eq!(times(past.takeover_before(30.0)), Some(20.0));
        assert_eq!(times(past.takeover_after(30.0)), Some(40.0));
        assert_eq!(
            (times(past.takeover_before(0.0)), times(past.takeover_after(55.0))),
            (None, None)
        );

        // A curve is whole, and not flat where nothing was played.
        let place = field::find(&f64::describe(), "").expect("it is a number");
        let variable = "robot.pulse".to_owned();
        let request = (variable.clone(), Source::Field { variable, place });
        let curves = read_curves(&recording, &variables, start, &[request]).expect("it can be read");
        let pulses = curves[0].1.between(0.0, 60.0).filter(|(_, value)| *value == 1.0);
        assert_eq!(pulses.count(), 60);
    }

    #[test]
    fn a_file_that_cannot_be_read_leaves_what_plays() {
        let recorded = Recorded::open(PathBuf::from("/missing.mcap"), egui::Context::default());
        assert!(recorded.past().is_none());
        let place = field::find(&f64::describe(), "").expect("it is a number");
        let variable = "a.b".to_owned();
        assert!(
            recorded
                .curve("a.b", &Source::Field { variable, place })
                .is_none()
        );
    }
}
