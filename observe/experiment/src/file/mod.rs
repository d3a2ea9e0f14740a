//! Reads an experiment file and checks it against its application: every fault at once, with its position. It
//! runs nothing.

mod axes;
mod expressions;
mod judge;
mod mocks;
mod steps;
mod values;
mod worlds;

use std::ops::Range;
use std::path::{Path, PathBuf};

use jde_abi::describe::{Port, Role};
use jde_app::{Application, Binding, FaultLocation, Faults, Override, ignores_faults, time};
use jde_board::value::{Value, decode};
use jde_document::{FaultReport, Section, quote};
use jde_sim::{Footprint, RobotModel};

use crate::applications::Applications;
use crate::experiment::{Experiment, Mission, Variant, WORLD};
use crate::result::Columns;
use expressions::Expressions;

/// The keys of an experiment.
const KEYS: [&str; 15] = [
    "name",
    "doc",
    "application",
    "for",
    "end",
    "mission",
    "faults",
    "budgets",
    "axes",
    "cases",
    "set",
    "must",
    "measure",
    "steps",
    "mock",
];

/// The name of the property that the mission is.
const MISSION: &str = "the mission is done";

/// A value that an experiment sets, and its position in the file.
pub(crate) struct SetValue {
    pub(crate) value: Override,
    pub(crate) span: std::ops::Range<usize>,
}

/// What the parts of a file are checked against.
struct Subject<'a> {
    /// The experiment's file, absolute.
    file: &'a Path,
    text: &'a str,
    application: &'a Application,
}

/// Reads and checks an experiment, of `given` if that is another application than the file's. `applications` returns
/// what loads the application; the caller keeps it for the drives.
///
/// # Errors
/// All faults of the file, or those of its application.
pub fn read(
    path: &Path,
    given: Option<&Path>,
    applications: impl FnOnce(PathBuf) -> Applications,
) -> Result<(Experiment, Applications), Faults> {
    let text = jde_document::read(path, "an experiment file")?;
    let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut report = FaultReport::new(path, &text);
    let Some(document) = jde_document::parse(&mut report, &text) else {
        return Err(report.into_faults());
    };
    let root = Section::new("the experiment", 0..0, document.get_ref());
    root.refuse_unknown(&mut report, &KEYS);
    let folder = file.parent().unwrap_or(Path::new("/")).to_owned();
    let given = given.map(|given| std::path::absolute(given).unwrap_or_else(|_| given.to_owned()));
    let Some(application_file) = given.or_else(|| application_file(&mut report, &root, &folder)) else {
        return Err(report.into_faults());
    };
    let mut applications = applications(application_file.clone()).with_mocks(mocks::names(&root));
    let set = axes::read_set(&mut report, &root, &text, &folder);
    let variants = axes::read_variants(&mut report, &root, &folder);
    let application = load(&mut report, &mut applications, &set, &variants[0])?;
    let Some(application) = application else {
        return Err(report.into_faults());
    };
    let subject = Subject {
        file: &file,
        text: &text,
        application: &application,
    };
    let axes = axes::read(&mut report, &root, &subject, &variants);
    axes::check_values(&mut report, &axes, &set, &variants, &mut applications)?;
    let axes: Vec<_> = axes.into_iter().map(axes::DraftAxis::finish).collect();
    let mut expressions = Expressions::new(&application);
    let mission = mission(&mut report, &root, &application);
    let mut judged = judge::read(&mut report, &root, &subject, &mut expressions);
    if mission == Mission::Required {
        judged.properties.names.push(MISSION.to_owned());
    }
    let columns = Columns {
        axes: axes.iter().map(|axis| axis.name.clone()).collect(),
        properties: judged.properties.names,
        measures: judged.measures.columns,
    };
    judge::refuse_equal_columns(&mut report, &root, &columns);
    let limit = time::of(&mut report, &root, "for");
    if root.get("for").is_none() {
        report
            .file_fault("it has no `for`, the longest time of a drive")
            .advise("add it, such as `for = \"300s\"`");
    }
    let end = root
        .text(&mut report, "end")
        .and_then(|text| expressions.condition(&mut report, &subject, &text));
    let steps = steps::read(&mut report, &root, &subject, &axes, &mut expressions);
    let mocks = mocks::read(&mut report, &root, &subject);
    let name = root.text(&mut report, "name").map(|name| name.text.to_owned());
    let doc = root.text(&mut report, "doc").map(|doc| doc.text.to_owned());
    let mut experiment = Experiment {
        name: name.unwrap_or_else(|| stem(&file)),
        doc: doc.unwrap_or_default(),
        file: file.clone(),
        application: application_file,
        limit: limit.unwrap_or_default(),
        axes,
        set: set.into_iter().map(|set| set.value).collect(),
        variants,
        expressions: expressions.into_list(),
        end,
        mission,
        judges_budgets: judges_budgets(&mut report, &root),
        ignores_faults: ignores_faults(&mut report, &root) || application.ignores_faults,
        properties: judged.properties.list,
        measures: judged.measures.list,
        steps,
        mocks: mocks.list,
        recordings: mocks.recordings,
        world: initial(&application, WORLD).and_then(|world| match world {
            Value::Text(path) => Some(PathBuf::from(path)),
            _ => None,
        }),
        robot: robot(&application),
        columns,
        concerns: None,
    };
    if experiment.drives() > Experiment::MAX_DRIVES {
        report
            .fault(
                &root.key_span("axes"),
                format!("the axes have {} drives as their product", experiment.drives()),
            )
            .advise(format!("at most {} are possible", Experiment::MAX_DRIVES));
    }
    experiment.concerns = report.finish()?;
    Ok((experiment, applications))
}

fn application_file(report: &mut FaultReport, root: &Section, folder: &Path) -> Option<PathBuf> {
    if root.get("application").is_none() {
        report
            .file_fault("it has no `application`, the file of the application that drives")
            .advise("add it, relative to this file, such as `application = \"../apps/patrol.toml\"`");
    }
    Some(folder.join(root.text(report, "application")?.text))
}

fn mission(report: &mut FaultReport, root: &Section, application: &Application) -> Mission {
    match root.text(report, "mission") {
        Some(word) if word.text != "ignored" => {
            let message = format!("`mission` is {}", quote(word.text));
            report
                .fault(&word.span, message)
                .advise("write \"ignored\", or leave it out: then the mission must be done, if there is one");
            Mission::Ignored
        }
        None if application.mission.is_some() => Mission::Required,
        Some(_) | None => Mission::Ignored,
    }
}

fn judges_budgets(report: &mut FaultReport, root: &Section) -> bool {
    let word = root.text(report, "budgets");
    if let Some(word) = word.as_ref().filter(|word| word.text != "judged") {
        report
            .fault(&word.span, format!("`budgets` is {}", quote(word.text)))
            .advise(
                "write \"judged\", or leave it out: then a drive does not depend on how fast the machine is",
            );
    }
    word.is_some()
}

/// Loads the application with values of the experiment. Faults of the values are reported at their positions;
/// `None` if there are any.
///
/// # Errors
/// Faults of the application itself.
fn load(
    report: &mut FaultReport,
    applications: &mut Applications,
    set: &[SetValue],
    variant: &Variant,
) -> Result<Option<Application>, Faults> {
    let overrides: Vec<_> = set.iter().map(|set| set.value.clone()).collect();
    let faults = match applications.load(&overrides, variant) {
        Ok(application) => {
            for concern in application.concerns.iter().flat_map(Faults::list) {
                if let FaultLocation::Option(option) = &concern.location {
                    report.concern(&span(set, option), concern.message.clone());
                }
            }
            return Ok(Some(application));
        }
        Err(faults) => faults,
    };
    let mut foreign = false;
    for fault in faults.list() {
        let FaultLocation::Option(option) = &fault.location else {
            foreign = true;
            continue;
        };
        let mine = report.fault(&span(set, option), fault.message.clone());
        if let Some(help) = &fault.help {
            mine.advise(help.clone());
        }
    }
    if foreign && report.count() == 0 {
        Err(faults)
    } else {
        Ok(None)
    }
}

/// Returns the place of a value of the experiment, which the application knows as an option.
fn span(set: &[SetValue], option: &str) -> Range<usize> {
    let mut set = set.iter();
    let at = set.find(|set| set.value.to_string() == option);
    at.map_or(0..0, |set| set.span.clone())
}

/// Returns the initial value of a modulation of the first simulated robot.
fn initial(application: &Application, name: &str) -> Option<Value> {
    let has_world = |port: &Port| port.name == WORLD && matches!(port.role, Role::Modulation { .. });
    let mut robots = application.instances.iter();
    let robot = robots.find(|instance| instance.schema.ports.iter().any(has_world))?;
    let place = robot.schema.ports.iter().position(|port| port.name == name)?;
    let Binding::Modulation { initial, .. } = &robot.bindings[place] else {
        return None;
    };
    Some(decode(&robot.schema.ports[place].value_type, initial).into_only_field())
}

/// The body of the simulated robot, from its robot file.
fn robot(application: &Application) -> Option<Footprint> {
    let Value::Text(model) = initial(application, "model")? else {
        return None;
    };
    Some(RobotModel::find(&model).ok()?.config.footprint)
}

fn stem(file: &Path) -> String {
    file.file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}
