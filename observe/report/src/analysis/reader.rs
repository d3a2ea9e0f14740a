//! Collects an analysis from the messages of a recording, one after the other.

use std::collections::{BTreeMap, HashMap};

use jde_core::{Nanos, State};
use jde_log::{ReadError, RecordedHierarchy, RecordedMessage, RecordedVariables, Recording, Survey, record};
use jde_records::RunRecord;
use jde_records::turn::Turn;
use jde_ros::cdr;
use jde_timeline::{Hierarchy, Keep, Span, Timeline};
use jde_types::Value as _;

use super::bounded::Ends;
use super::drive::{self, DriveCollector, MessageDecoder};
use super::{
    Analysis, Band, Columns, DriveSummary, Events, GroupStatistics, SchemaTiming, Series, Trace, Wanted,
};

/// The topic of the schemas' turns.
const TURNS: &str = "/jde/turns";
/// Switches of a recording that are stored completely: so many of the first, and of the last.
const FIRST_SWITCHES: usize = 4000;
const LAST_SWITCHES: usize = 1000;
/// Most columns of small charts.
const COARSE_COLUMNS: usize = 300;

/// The analysis so far, and what is known of the present.
pub(super) struct AnalysisReader {
    pub(super) analysis: Analysis,
    drive: DriveCollector,
    /// The application's clock zero, ns since 1970.
    start: u64,
    first: u64,
    last: u64,
    /// The indices of traced numbers by topic.
    series: HashMap<String, Vec<usize>>,
    /// The schemas by the topic of their configured period.
    periods: HashMap<String, String>,
    /// The owner and publication times of exports, by topic.
    exports: BTreeMap<String, (String, SchemaTiming)>,
    /// The channels whose messages are values.
    variables: RecordedVariables,
}

impl AnalysisReader {
    pub(super) fn new(recording: &Recording, wanted: Wanted) -> Result<Self, ReadError> {
        let survey = Survey::begin(recording)?;
        let (first, last) = recording.times().unwrap_or_default();
        // A recording of another program begins with its first message.
        let start = survey.application_start_ns.unwrap_or(first);
        let since = |time: u64| time.saturating_sub(start);
        let from = wanted.from.unwrap_or_else(|| since(first));
        let to = wanted.to.unwrap_or_else(|| since(last));
        let columns = Columns::new(from, to.max(from), wanted.columns);
        let coarse = Columns::new(from, columns.to, wanted.columns.min(COARSE_COLUMNS));
        let title = survey.application.clone().unwrap_or_else(|| {
            let stem = recording.path().file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        });
        let recorded = RecordedHierarchy::of_recording(recording);
        let lockstep = recorded.as_ref().map(|recorded| recorded.lockstep);
        let hierarchy = recorded.map_or_else(Hierarchy::default, |recorded| recorded.hierarchy());
        let keep = Keep {
            ended: true,
            ..Keep::PRESENT
        };
        let variables = RecordedVariables::of(recording);
        let mut series: HashMap<String, Vec<usize>> = HashMap::new();
        for (number, wanted) in wanted.series.iter().enumerate() {
            series.entry(wanted.topic.clone()).or_default().push(number);
        }
        let mut periods = HashMap::new();
        let mut exports = BTreeMap::new();
        for channel in recording.channels() {
            let metadata = |key: &str| channel.metadata.get(key).map_or("", String::as_str);
            if let Some((owner, name)) = metadata("variable").rsplit_once('.') {
                match (metadata("access"), name) {
                    ("modulation", "period") => {
                        periods.insert(channel.topic.clone(), owner.to_owned());
                    }
                    ("export", _) => {
                        exports.insert(
                            channel.topic.clone(),
                            (owner.to_owned(), SchemaTiming::new(coarse)),
                        );
                    }
                    _ => {}
                }
            }
        }
        let traces = wanted.series.into_iter();
        let traces = traces.map(|series| (series, Trace::new(columns))).collect();
        let mut reader = Self {
            drive: DriveCollector::new(recording, columns.from),
            analysis: Analysis {
                survey,
                title,
                columns,
                coarse,
                timeline: Timeline::new(hierarchy, keep).beginning(from),
                bands: Vec::new(),
                timings: Vec::new(),
                periods: Vec::new(),
                groups: Vec::new(),
                switches: Ends::new(FIRST_SWITCHES, LAST_SWITCHES),
                events: Events::new(),
                ending: DriveSummary::default(),
                traces,
                left_out: variables.left_out().clone(),
                has_turns: false,
                lockstep,
            },
            start,
            first,
            last,
            series,
            periods,
            exports,
            variables,
        };
        reader.grow();
        Ok(reader)
    }

    /// The share of the recording read when a message arrives.
    pub(super) fn share(&self, log_time: u64) -> f64 {
        let total = self.last.saturating_sub(self.first).max(1);
        (log_time.saturating_sub(self.first) as f64 / total as f64).min(1.0)
    }

    pub(super) fn message(&mut self, message: &RecordedMessage, record: Option<RunRecord>) {
        let time = message.log_time.saturating_sub(self.start);
        if time > self.analysis.columns.to {
            return;
        }
        // Values in force at the beginning were written before it.
        let in_range = self.analysis.columns.has(time) && message.publish_time >= self.first;
        let topic = &message.channel.topic;
        if let Some(record) = record {
            self.record(time, record, in_range);
            return;
        }
        // A record of a newer version that cannot be read is skipped.
        if record::kind(&message.channel).is_some() {
            return;
        }
        if topic == TURNS {
            self.turn(message);
            return;
        }
        // The topic may have messages of another type.
        let Some(variable) = self.variables.get(&message.channel).cloned() else {
            return;
        };
        let columns = self.analysis.columns;
        let mut read = Ok(());
        for number in self.series.get(topic).into_iter().flatten() {
            let (series, trace) = &mut self.analysis.traces[*number];
            let number = (series.number)(&message.data).map_err(|error| read = Err(error));
            trace.add(columns, time, number.unwrap_or_default());
        }
        if let Some(owner) = self.periods.get(topic).cloned() {
            self.period(&owner, message);
        }
        if let Some((_, work)) = self.exports.get_mut(topic).filter(|_| in_range) {
            work.add_start(self.analysis.coarse, time);
        }
        let drawn = {
            let mut reading = MessageDecoder {
                message,
                variable: &variable,
                left_out: &mut self.analysis.left_out,
            };
            self.drive.message(time, &mut reading, &self.analysis.timeline)
        };
        if let Err(error) = read.and(drawn) {
            let what = format_args!("a message of {topic}");
            self.analysis.left_out.add_again(what, error);
        }
    }

    fn record(&mut self, time: Nanos, record: RunRecord, in_range: bool) {
        let columns = self.analysis.columns;
        self.analysis.timeline.add(&record);
        self.grow();
        let analysis = &mut self.analysis;
        for Span {
            schema,
            state,
            from,
            to,
        } in analysis.timeline.take_ended()
        {
            analysis.bands[schema].fill(columns, state, from, to);
        }
        if let Some(variable) = record.retracted_variable() {
            let is_retracted = |(series, _): &&mut (Series, Trace)| series.variable == variable;
            for (_, trace) in analysis.traces.iter_mut().filter(is_retracted) {
                trace.add(columns, time, None);
            }
        }
        match record {
            RunRecord::Decision(decision) if in_range => {
                let hierarchy = analysis.timeline.hierarchy();
                let Some(group) = hierarchy.find_group(&decision.group) else {
                    return;
                };
                analysis.groups[group].add_decision(columns, time, &decision);
                if decision.changed {
                    if let Some(to) = decision.choice.as_deref().and_then(|name| hierarchy.find(name)) {
                        self.drive.timeline.add_takeover(to, hierarchy);
                    }
                    analysis.switches.add(decision);
                }
            }
            RunRecord::Other(event) if in_range => {
                analysis.events.add(event);
            }
            RunRecord::State(_) | RunRecord::Decision(_) | RunRecord::Other(_) => {}
        }
    }

    fn turn(&mut self, message: &RecordedMessage) {
        let turn = cdr::decode(&Turn::describe(), &message.data);
        let Some(turn) = turn.ok().and_then(|bytes| Turn::from_bytes(&bytes)) else {
            return;
        };
        self.analysis.has_turns = true;
        let columns = self.analysis.columns;
        if let Some(work) = self.analysis.timings.get_mut(turn.schema as usize)
            && columns.has(turn.time())
        {
            work.add_turn(self.analysis.coarse, &turn);
        }
    }

    fn period(&mut self, owner: &str, message: &RecordedMessage) {
        let seconds = drive::number(message);
        let schema = self.analysis.timeline.describe(|hierarchy| hierarchy.add(owner));
        if let (Some(schema), Some(seconds)) = (schema, seconds) {
            self.grow();
            self.analysis.periods[schema] = Some(seconds);
        }
    }

    /// Extends the lists to all known schemas and groups.
    fn grow(&mut self) {
        let analysis = &mut self.analysis;
        let hierarchy = analysis.timeline.hierarchy();
        let (schemas, groups) = (hierarchy.schemas().len(), hierarchy.groups().len());
        analysis
            .bands
            .resize_with(schemas, || Band::new(analysis.columns));
        analysis
            .timings
            .resize_with(schemas, || SchemaTiming::new(analysis.coarse));
        for schema in analysis.periods.len()..schemas {
            let period = hierarchy.schemas()[schema].period;
            analysis.periods.push(period.map(|period| period as f64 / 1e9));
        }
        analysis
            .groups
            .resize_with(groups, || GroupStatistics::new(analysis.columns));
    }

    pub(super) fn finish(mut self) -> Analysis {
        let analysis = &mut self.analysis;
        let columns = analysis.columns;
        analysis.survey.finish();
        for (band, known) in analysis.bands.iter_mut().zip(analysis.timeline.schemas()) {
            if let Some(last) = known.states.last() {
                band.fill(columns, last.value, last.from, columns.to);
            }
        }
        for (_, trace) in &mut analysis.traces {
            trace.finish(columns);
        }
        // Without turns, a schema's most frequent export indicates its period.
        let mut most_frequent: HashMap<String, SchemaTiming> = HashMap::new();
        for (owner, work) in self.exports.into_values() {
            let known_count = most_frequent.get(&owner).map_or(0, |known| known.periods.count());
            if work.periods.count() > known_count {
                most_frequent.insert(owner, work);
            }
        }
        let hierarchy = analysis.timeline.hierarchy();
        for (schema, work) in hierarchy.schemas().iter().zip(&mut analysis.timings) {
            if work.cycles == 0
                && let Some(published) = most_frequent.remove(&schema.name)
            {
                *work = published;
            }
            work.over_time.finish(analysis.coarse);
        }
        let won = |schema: &usize| analysis.bands[*schema].time(State::Winner) > 0;
        let schemas = (0..analysis.bands.len()).filter(won);
        let winners = schemas.filter(|schema| hierarchy.is_actor(*schema)).collect();
        analysis.ending = self.drive.finish(analysis.title.clone(), hierarchy, winners);
        self.analysis
    }
}
