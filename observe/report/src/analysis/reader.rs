//! Collects an analysis from the messages of a recording, one after the other.

use std::collections::{BTreeMap, HashMap};

use jde_core::{Nanos, State};
use jde_log::{
    Message, ReadError, RecordedHierarchy, RecordedVariables, Recording, SchemaProblems, Survey, record,
};
use jde_records::turn::Turn;
use jde_records::{Decision, RunRecord};
use jde_ros::cdr;
use jde_types::Value as _;

use super::bounded::Ends;
use super::drive::{self, DriveCollector, Reading};
use super::{
    Analysis, Band, Columns, DriveSummary, Events, GroupStatistics, Hierarchy, SchemaTiming, Series, Trace,
    Wanted,
};

/// The topic of the schemas' turns.
const TURNS: &str = "/jde/turns";
/// Switches of a recording that are stored completely: so many of the first, and of the last.
const FIRST_SWITCHES: usize = 4000;
const LAST_SWITCHES: usize = 1000;
/// Most columns of small charts.
const COARSE: usize = 300;

/// The analysis so far, and what is known of the present.
pub(super) struct Reader {
    pub(super) analysis: Analysis,
    drive: DriveCollector,
    /// The application's clock zero, ns since 1970.
    start: u64,
    first: u64,
    last: u64,
    /// The present winner of each group.
    winners: Vec<Option<usize>>,
    /// The schemas that act at present.
    acting: Vec<usize>,
    /// The indices of traced numbers by topic.
    series: HashMap<String, Vec<usize>>,
    /// The schemas by the topic of their configured period.
    periods: HashMap<String, String>,
    /// The owner and publication times of exports, by topic.
    exports: BTreeMap<String, (String, SchemaTiming)>,
    /// The channels whose messages are values.
    variables: RecordedVariables,
}

impl Reader {
    pub(super) fn new(recording: &Recording, wanted: Wanted) -> Result<Self, ReadError> {
        let survey = Survey::begin(recording)?;
        let (first, last) = recording.times().unwrap_or_default();
        // A recording of another program begins with its first message.
        let start = survey.application_start_ns.unwrap_or(first);
        let since = |time: u64| time.saturating_sub(start);
        let from = wanted.from.unwrap_or_else(|| since(first));
        let to = wanted.to.unwrap_or_else(|| since(last));
        let columns = Columns::new(from, to.max(from), wanted.columns);
        let coarse = Columns::new(from, columns.to, wanted.columns.min(COARSE));
        let title = survey.application.clone().unwrap_or_else(|| {
            let stem = recording.path().file_stem().unwrap_or_default();
            stem.to_string_lossy().into_owned()
        });
        let hierarchy = RecordedHierarchy::of_recording(recording);
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
            drive: DriveCollector::new(recording),
            analysis: Analysis {
                survey,
                title,
                columns,
                coarse,
                hierarchy: Hierarchy::new(hierarchy.as_ref()),
                bands: Vec::new(),
                timings: Vec::new(),
                periods: Vec::new(),
                groups: Vec::new(),
                switches: Ends::new(FIRST_SWITCHES, LAST_SWITCHES),
                events: Events::new(),
                troubled: Vec::new(),
                ending: DriveSummary::default(),
                traces,
                left_out: variables.left_out().clone(),
                has_turns: false,
                lockstep: hierarchy.map(|hierarchy| hierarchy.lockstep),
            },
            start,
            first,
            last,
            winners: Vec::new(),
            acting: Vec::new(),
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

    pub(super) fn message(&mut self, message: &Message) {
        let time = message.log_time.saturating_sub(self.start);
        if time > self.analysis.columns.to {
            return;
        }
        // Values in force at the beginning were written before it.
        let in_range = self.analysis.columns.has(time) && message.publish_time >= self.first;
        let topic = &message.channel.topic;
        if record::kind(&message.channel).is_some() {
            // A line of a newer version that cannot be read is skipped.
            if let Some(line) = record::read(message) {
                self.line(time, line, in_range);
            }
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
        let (hierarchy, acting, is_alone) = (&self.analysis.hierarchy, &self.acting, self.drive.is_alone());
        let acting_for = |robot: &str| {
            let mut acting = acting.iter().copied();
            acting.find(|schema| is_alone || hierarchy.acts_for(*schema, robot))
        };
        let drawn = {
            let mut reading = Reading {
                message,
                variable: &variable,
                left_out: &mut self.analysis.left_out,
            };
            self.drive.message(columns, time, &mut reading, acting_for)
        };
        if let Err(error) = read.and(drawn) {
            let what = format_args!("a message of {topic}");
            self.analysis.left_out.add_again(what, error);
        }
    }

    fn line(&mut self, time: Nanos, line: RunRecord, in_range: bool) {
        let columns = self.analysis.columns;
        let retracted = line.retracted_variable().map(str::to_owned);
        match line {
            RunRecord::State(change) => {
                let Some(schema) = self.analysis.hierarchy.schema(&change.schema) else {
                    return;
                };
                self.grow();
                self.analysis.bands[schema].change(columns, time, change.from, change.to);
                self.update_acting(schema, change.to);
            }
            RunRecord::Decision(decision) => {
                let Some(group) = self.analysis.hierarchy.add_decision(&decision) else {
                    return;
                };
                self.grow();
                self.take_states_of(&decision);
                if in_range {
                    self.analysis.groups[group].add_decision(columns, time, &decision);
                    if decision.changed {
                        let to = decision.choice.as_deref();
                        let to = to.and_then(|name| self.analysis.hierarchy.find(name));
                        if let Some(to) = to.filter(|to| self.analysis.hierarchy.is_actor(*to)) {
                            let (hierarchy, is_alone) = (&self.analysis.hierarchy, self.drive.is_alone());
                            self.drive
                                .add_takeover(to, |robot| is_alone || hierarchy.acts_for(to, robot));
                        }
                        self.analysis.switches.add(decision);
                    }
                }
            }
            RunRecord::Other(event) => {
                if let Some(variable) = retracted {
                    let is_retracted = |(series, _): &&mut (Series, Trace)| series.variable == variable;
                    for (_, trace) in self.analysis.traces.iter_mut().filter(is_retracted) {
                        trace.add(columns, time, None);
                    }
                }
                if in_range {
                    SchemaProblems::count(&mut self.analysis.troubled, &event);
                    self.analysis.events.add(event);
                }
            }
        }
    }

    /// Takes the state of a schema from a selection if it is not known otherwise.
    fn take_states_of(&mut self, decision: &Decision) {
        let columns = self.analysis.columns;
        for candidate in &decision.candidates {
            if let Some(schema) = self.analysis.hierarchy.find(&candidate.name)
                && self.analysis.bands[schema].state().is_none()
            {
                let state = candidate.state;
                self.analysis.bands[schema].change(columns, columns.from, state, state);
                self.update_acting(schema, state);
            }
        }
    }

    /// Updates the acting schemas after a change of state.
    fn update_acting(&mut self, schema: usize, state: State) {
        let hierarchy = &self.analysis.hierarchy;
        let Some(group) = hierarchy.schemas[schema].group else {
            return;
        };
        let winner = &mut self.winners[group];
        match state {
            State::Winner => *winner = Some(schema),
            State::Slept | State::Checking | State::Ready if *winner == Some(schema) => *winner = None,
            State::Slept | State::Checking | State::Ready => return,
        }
        let roots = (0..hierarchy.groups.len()).filter(|group| hierarchy.father(*group).is_none());
        let mut winning: Vec<usize> = roots.filter_map(|group| self.winners[group]).collect();
        let mut acting = Vec::new();
        // Bounded by the number of schemas, since the file may describe a cycle.
        for _ in 0..=hierarchy.schemas.len() {
            let (actors, fathers): (Vec<_>, Vec<_>) = winning
                .into_iter()
                .partition(|schema| hierarchy.is_actor(*schema));
            acting.extend(actors);
            let groups = fathers.into_iter().flat_map(|father| hierarchy.groups_of(father));
            winning = groups.filter_map(|group| self.winners[group]).collect();
            if winning.is_empty() || acting.len() > hierarchy.schemas.len() {
                break;
            }
        }
        self.acting = acting;
    }

    fn turn(&mut self, message: &Message) {
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

    fn period(&mut self, owner: &str, message: &Message) {
        let seconds = drive::number(message);
        if let (Some(schema), Some(seconds)) = (self.analysis.hierarchy.schema(owner), seconds) {
            self.grow();
            self.analysis.periods[schema] = Some(seconds);
        }
    }

    /// Extends the lists to all known schemas and groups.
    fn grow(&mut self) {
        let analysis = &mut self.analysis;
        let (schemas, groups) = (analysis.hierarchy.schemas.len(), analysis.hierarchy.groups.len());
        analysis
            .bands
            .resize_with(schemas, || Band::new(analysis.columns));
        analysis
            .timings
            .resize_with(schemas, || SchemaTiming::new(analysis.coarse));
        for schema in analysis.periods.len()..schemas {
            let period = analysis.hierarchy.schemas[schema].period;
            analysis.periods.push(period.map(|period| period as f64 / 1e9));
        }
        analysis
            .groups
            .resize_with(groups, || GroupStatistics::new(analysis.columns));
        self.winners.resize(groups, None);
    }

    pub(super) fn finish(mut self) -> Analysis {
        let analysis = &mut self.analysis;
        let columns = analysis.columns;
        analysis.survey.finish();
        for band in &mut analysis.bands {
            band.finish(columns);
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
        for (schema, work) in analysis.hierarchy.schemas.iter().zip(&mut analysis.timings) {
            if work.cycles == 0
                && let Some(published) = most_frequent.remove(&schema.name)
            {
                *work = published;
            }
            work.over_time.finish(analysis.coarse);
        }
        let names = analysis.hierarchy.schemas.iter();
        let names = names.map(|schema| schema.name.clone()).collect();
        let won = |schema: &usize| analysis.bands[*schema].time(State::Winner) > 0;
        let schemas = (0..analysis.bands.len()).filter(won);
        let winners = schemas
            .filter(|schema| analysis.hierarchy.is_actor(*schema))
            .collect();
        let led_robot = self
            .drive
            .mission_owner()
            .and_then(|owner| analysis.hierarchy.robot_of(owner));
        analysis.ending = self
            .drive
            .finish(analysis.title.clone(), names, winners, led_robot.as_deref());
        self.analysis
    }
}
