//! Turns a file into an application. Runs every check independently of the results of the others, so that all
//! faults are reported at once. Starts nothing.

use std::path::Path;
use std::sync::Arc;

use jde_abi::describe::Plugin;
use jde_core::{SchemaId, Table};

use super::children::{self, NamedChild};
use super::drafts::InstanceContext;
use super::hierarchy::DeclaredHierarchy;
use super::interfaces::Types;
use super::outline::Outline;
use super::remote::RemoteVariables;
use super::settings::InstanceSettings;
use super::values::Paths;
use super::{
    Application, Catalogue, Faults, Inspection, InstanceConfig, Isolation, Override, conflict, groups,
    guards, inspect, lists, modulations, needs, types, variadic, wiring,
};
use jde_document::FaultReport;

/// Reads and checks an application file. Paths in it are relative to its folder, paths in `overrides` to
/// theirs.
///
/// # Errors
/// All faults of the file and of `overrides`.
pub fn load(path: &Path, overrides: &[Override], catalogue: &dyn Catalogue) -> Result<Application, Faults> {
    load_text(&read_text(path)?, path, overrides, catalogue)
}

/// Reads the text of an application file.
///
/// # Errors
/// It cannot be read, or is no text.
pub fn read_text(path: &Path) -> Result<String, Faults> {
    jde_document::read(path, "an application file")
}

/// Checks a text that was read from `path`, as [`load`] does.
///
/// # Errors
/// All faults of the text and of `overrides`.
pub fn load_text(
    text: &str,
    path: &Path,
    overrides: &[Override],
    catalogue: &dyn Catalogue,
) -> Result<Application, Faults> {
    read(text, path, overrides, catalogue, true)
}

/// Checks the text of an application file; `path` is its real or supposed path. The files that it names need
/// not exist.
///
/// # Errors
/// All faults of the text and of `overrides`.
pub fn parse(
    text: &str,
    path: &Path,
    overrides: &[Override],
    catalogue: &dyn Catalogue,
) -> Result<Application, Faults> {
    read(text, path, overrides, catalogue, false)
}

/// Reads and checks a text. With `check_files`, also checks that required files exist.
fn read(
    text: &str,
    path: &Path,
    overrides: &[Override],
    catalogue: &dyn Catalogue,
    check_files: bool,
) -> Result<Application, Faults> {
    let mut report = FaultReport::new(path, text);
    let Some(document) = jde_document::parse(&mut report, text) else {
        return Err(report.into_faults());
    };
    let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut outline = Outline::read(&mut report, document.get_ref(), &file, check_files);
    let plugins = types::resolve(
        &mut report,
        &mut outline.drafts,
        overrides,
        catalogue,
        &outline.plugin_dirs,
    );
    variadic::name_children(&mut report, &mut outline.drafts);
    let folder = file.parent().unwrap_or(Path::new("/"));
    let plugins_and_folder = lists::Sources {
        types: Types {
            plugins: &plugins,
            recorded: &outline.recorded,
            folders: &outline.interfaces,
        },
        folder,
    };
    lists::state_ports(&mut report, &mut outline.drafts, plugins_and_folder);
    let input = CheckInput {
        overrides,
        file: &file,
        catalogue,
    };
    let checked = check(&mut report, outline, plugins, input);
    let concerns = report.finish()?;
    let mut application = checked.expect("an application without faults is complete");
    application.concerns = concerns;
    application.spec().validate().map_err(|errors| {
        let mut report = FaultReport::new(path, text);
        for error in errors {
            report.file_fault(error.to_string());
        }
        report.into_faults()
    })?;
    Ok(application)
}

/// The inputs of a check.
#[derive(Clone, Copy)]
struct CheckInput<'g> {
    overrides: &'g [Override],
    /// The absolute path of the file.
    file: &'g Path,
    catalogue: &'g dyn Catalogue,
}

/// Runs all checks that follow the resolution of types. Returns `None` only if there are faults.
fn check(
    report: &mut FaultReport,
    outline: Outline,
    plugins: Vec<Arc<Plugin>>,
    input: CheckInput<'_>,
) -> Option<Application> {
    let drafts = &outline.drafts;
    modulations::refuse_unknown_schemas(report, drafts, input.overrides);
    let hierarchy = DeclaredHierarchy::read(report, drafts, &outline.roots);
    let fathers = hierarchy.fathers(report, drafts);
    if hierarchy.is_too_deep(report, drafts, &fathers) {
        return None;
    }
    let levels = outline.roots.levels.iter().zip(&hierarchy.roots);
    let mut groups: Vec<_> = levels
        .map(|(level, roots)| groups::of_roots(report, drafts, level, roots))
        .collect();
    for (father, children) in hierarchy.children.entries() {
        groups.extend(groups::of_father(report, drafts, father, children));
    }
    let groups = Table::from(groups);
    let mut remotes = RemoteVariables::new(&outline.link);
    let mut instances = hierarchy.children.map_ids(|id| {
        let children = &hierarchy.children[id];
        check_instance(report, &outline, &plugins, input, (id, children), &mut remotes)
    });
    let remotes = remotes.into_list();
    let mut group_of = drafts.list.map_ids(|_| None);
    for (id, group) in groups.entries() {
        for member in &group.members {
            group_of[*member].get_or_insert(id);
        }
    }
    for (id, father) in fathers.entries() {
        if let Some(instance) = &mut instances[id] {
            instance.father = *father;
            instance.group = group_of[id];
        }
    }
    for instance in instances.iter_mut().flatten() {
        for role in instance.child_order.clone() {
            instance.child_groups[role] = instance.children[role].and_then(|child| group_of[child]);
        }
    }
    needs::refuse_cycles(report, drafts, &instances);
    needs::refuse_self_triggers(report, drafts, &instances);
    needs::refuse_stale_modulations(report, drafts, &instances);
    conflict::refuse_conflicts(report, drafts, &instances, &groups);
    guards::refuse_mismatches(report, drafts, &instances, &groups);
    let awake = needs::of_the_roots(report, drafts, &outline.awake);
    let mission = outline
        .mission
        .as_ref()
        .and_then(|written| wiring::mission(report, drafts, written));
    Some(Application {
        name: outline.name,
        doc: outline.doc,
        path: input.file.to_owned(),
        seed: outline.seed,
        executor: outline.executor,
        awake,
        mission,
        mission_stalls_ns: outline.mission_stalls_ns,
        ignores_faults: outline.ignores_faults,
        plugins,
        instances: instances.into_iter().collect::<Option<_>>()?,
        groups,
        link: outline.link,
        web: outline.web,
        remotes,
        concerns: None,
    })
}

/// Checks one instance and returns it without its place among the groups. If its type is unknown, returns
/// `None` and checks only what does not depend on the type.
fn check_instance(
    report: &mut FaultReport,
    outline: &Outline,
    plugins: &[Arc<Plugin>],
    input: CheckInput<'_>,
    (id, named_children): (SchemaId, &[NamedChild]),
    remotes: &mut RemoteVariables,
) -> Option<InstanceConfig> {
    let draft = &outline.drafts.list[id];
    let (section, schema) = (&draft.section, outline.drafts.schema(id));
    let mut settings = InstanceSettings::read(report, section, schema.map(Arc::as_ref));
    let found = draft.resolved.clone()?;
    let schema = found.schema;
    let instance = InstanceContext {
        drafts: &outline.drafts,
        id,
        schema: &schema,
    };
    let mut bindings = wiring::unbound(&schema);
    let check_files = outline.check_files;
    let overrides = input.overrides;
    let faults = report.count();
    let folder = input.file.parent().unwrap_or(Path::new("/"));
    modulations::from_file(
        report,
        section,
        &schema,
        Paths { folder, check_files },
        |port| {
            overrides.iter().any(|given| {
                given.schema == draft.name && schema.modulation_named(&given.variable) == Some(port)
            })
        },
        &mut bindings,
    );
    for given in overrides.iter().filter(|given| given.schema == draft.name) {
        let folder = &given.folder;
        let paths = Paths { folder, check_files };
        report.in_option(given.to_string(), |report| {
            modulations::from_option(report, given, &instance, paths, &mut settings, &mut bindings);
        });
    }
    // A refused value needs no inspection.
    let is_inspected = check_files && schema.inspects && report.count() == faults;
    wiring::imports(report, &instance, remotes, &mut bindings);
    let mut absent = Vec::new();
    if is_inspected {
        let inspection = Inspection {
            number: found.number,
            name: draft.name,
            bindings: &bindings,
            listed: &found.listed,
        };
        absent = inspect::report_problems(
            report,
            input.catalogue,
            &plugins[found.plugin],
            (&instance, &inspection),
            overrides,
        );
    }
    wiring::triggers(report, &instance, &mut bindings);
    wiring::actuators(report, &instance, &mut bindings);
    children::bind_modulations(report, &instance, named_children, &mut bindings);
    let mut children = Table::from(vec![None; schema.children.len()]);
    let mut child_order = Vec::with_capacity(named_children.len());
    for child in named_children {
        if let Some(role) = child.role {
            children[role] = Some(child.child);
            child_order.push(role);
        }
    }
    Some(InstanceConfig {
        name: draft.name.to_owned(),
        doc: settings.doc,
        plugin: found.plugin,
        number: found.number,
        period_ns: settings.period_ns,
        stated_period_ns: settings.stated_period_ns,
        budget_ns: settings.budget_ns,
        hang_ns: settings.hang_ns,
        restart: settings.restart,
        isolate: settings
            .isolate
            .or(plugins[found.plugin].isolated.then(Isolation::default)),
        debugged: false,
        father: None,
        group: None,
        child_groups: children.map_ids(|_| None),
        children,
        child_order,
        bindings,
        listed: found.listed,
        line: report.line(section.span.start),
        absent,
        schema,
    })
}
