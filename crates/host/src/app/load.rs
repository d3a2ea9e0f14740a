//! From a file to an application: reads, then runs every check whatever the others found, so that all faults come at once.

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use jde_abi::describe::Plugin;
use toml::de::DeTable;

use super::cycle::Edge;
use super::family::Kin;
use super::outline::{Here, Outline};
use super::report::{Report, quote};
use super::settings::Settings;
use super::suggest::nearest;
use super::{
    Application, Catalogue, Faults, Instance, Override, conflict, family, groups, modulations, needs, types,
    wiring,
};

/// Largest application file: room for ten thousand schemas, and what is larger is something else.
const MOST_BYTES: u64 = 4 << 20;
/// Most syntax faults of one file: in noise, every byte is one.
const MOST_SYNTAX: usize = 10;

/// Reads and checks an application file; paths in it are relative to its folder, paths in `overrides` to the working
/// directory.
///
/// # Errors
/// Everything that is wrong with it.
pub fn load(path: &Path, overrides: &[Override], catalogue: &dyn Catalogue) -> Result<Application, Faults> {
    let bytes = read(path)?;
    match std::str::from_utf8(&bytes) {
        Ok(text) => parse(text, path, overrides, catalogue),
        Err(error) => {
            let good = error.valid_up_to();
            let text = std::str::from_utf8(&bytes[..good]).unwrap_or_default();
            let mut report = Report::new(path, text);
            report
                .fault(
                    &(good..good + 1),
                    "this byte is no UTF-8, and application files are",
                )
                .advise("save the file as UTF-8");
            Err(report.into_faults())
        }
    }
}

/// Checks the text of an application file; `path` is where it stands, or would.
///
/// # Errors
/// Everything that is wrong with it.
pub fn parse(
    text: &str,
    path: &Path,
    overrides: &[Override],
    catalogue: &dyn Catalogue,
) -> Result<Application, Faults> {
    let mut report = Report::new(path, text);
    let (document, errors) = DeTable::parse_recoverable(text);
    for error in errors.iter().take(MOST_SYNTAX) {
        let span = error.span().unwrap_or(0..0);
        report.fault(&span, format!("this is no TOML: {}", error.message()));
    }
    // What was recovered is not what was meant; faults found in it would lead astray.
    if !errors.is_empty() {
        return Err(report.into_faults());
    }
    let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut outline = Outline::read(&mut report, document.get_ref(), &file);
    let plugins = types::resolve(&mut report, &mut outline.drafts, catalogue, &outline.plugin_dirs);
    let checked = check(&mut report, outline, plugins, overrides, &file);
    report.finish()?;
    let application = checked.expect("an application without faults is complete");
    application.spec().validate().map_err(|errors| {
        let mut report = Report::new(path, text);
        for error in errors {
            report.whole(error.to_string());
        }
        report.into_faults()
    })?;
    Ok(application)
}

/// Everything after the types; none only if there are faults.
fn check(
    report: &mut Report,
    outline: Outline,
    plugins: Vec<Arc<Plugin>>,
    overrides: &[Override],
    file: &Path,
) -> Option<Application> {
    let drafts = &outline.drafts;
    modulations::refuse_strangers(report, drafts, overrides);
    let kin: Vec<Vec<Kin>> = (0..drafts.len())
        .map(|index| family::children(report, drafts, index))
        .collect();
    let roots: Vec<Edge> = family::roots(report, drafts, &outline.roots);
    let fathers = family::fathers(report, drafts, &kin, &roots);
    let mut groups = vec![groups::of_roots(report, drafts, outline.root.as_ref(), &roots)];
    for (father, kin) in kin.iter().enumerate() {
        groups.extend(groups::of_father(report, drafts, father, kin));
    }
    let mut instances: Vec<Option<Instance>> = (0..drafts.len())
        .map(|index| instance(report, &outline, overrides, file, index, &kin[index]))
        .collect();
    for (index, father) in fathers.iter().enumerate() {
        if let Some(instance) = &mut instances[index] {
            instance.father = *father;
            instance.group = groups.iter().position(|group| group.members.contains(&index));
        }
    }
    for instance in instances.iter_mut().flatten() {
        for role in instance.child_order.clone() {
            let child = instance.children[role];
            instance.child_groups[role] = groups
                .iter()
                .position(|group| child.is_some_and(|child| group.members.contains(&child)));
        }
    }
    needs::refuse_cycles(report, drafts, &instances);
    conflict::refuse(report, drafts, &instances, &groups);
    let mission = outline
        .mission
        .as_ref()
        .and_then(|written| wiring::mission(report, drafts, written));
    Some(Application {
        name: outline.name,
        doc: outline.doc,
        path: file.to_owned(),
        seed: outline.seed,
        executor: outline.executor,
        mission,
        plugins,
        instances: instances.into_iter().collect::<Option<_>>()?,
        groups,
    })
}

/// One instance, but for its place among the groups; none if its type is unknown, and then only what does not depend on
/// the type is checked.
fn instance(
    report: &mut Report,
    outline: &Outline,
    overrides: &[Override],
    file: &Path,
    index: usize,
    kin: &[Kin],
) -> Option<Instance> {
    let draft = outline.drafts.get(index);
    let (section, schema) = (&draft.section, outline.drafts.schema(index));
    let mut settings = Settings::read(report, section, schema.map(Arc::as_ref));
    let found = draft.found.clone()?;
    let schema = found.schema;
    let here = Here {
        drafts: &outline.drafts,
        index,
        schema: &schema,
    };
    let mut bindings = wiring::unbound(&schema);
    let folder = file.parent().unwrap_or(Path::new("/"));
    modulations::from_file(report, section, &schema, folder, &mut bindings);
    let working = std::env::current_dir().unwrap_or_default();
    for given in overrides.iter().filter(|given| given.schema == draft.name) {
        report.in_option(given.to_string(), |report| {
            modulations::from_option(report, given, &here, &working, &mut settings, &mut bindings);
        });
    }
    wiring::imports(report, &here, &mut bindings);
    wiring::triggers(report, &here, &mut bindings);
    wiring::actuators(report, &here, &mut bindings);
    family::modulate(report, &here, kin, &mut bindings);
    let mut children = vec![None; schema.children.len()];
    let mut child_order = Vec::with_capacity(kin.len());
    for kin in kin {
        if let Some(role) = kin.role {
            children[role] = Some(kin.child);
            child_order.push(role);
        }
    }
    Some(Instance {
        name: draft.name.to_owned(),
        doc: settings.doc,
        plugin: found.plugin,
        number: found.number,
        period_ns: settings.period_ns,
        budget_ns: settings.budget_ns,
        restart: settings.restart,
        father: None,
        group: None,
        child_groups: vec![None; children.len()],
        children,
        child_order,
        bindings,
        line: report.line(section.span.start),
        schema,
    })
}

fn read(path: &Path) -> Result<Vec<u8>, Faults> {
    let mut bytes = Vec::new();
    let reading = File::open(path).and_then(|file| file.take(MOST_BYTES + 1).read_to_end(&mut bytes));
    let mut report = Report::new(path, "");
    match reading {
        Ok(_) if bytes.len() as u64 <= MOST_BYTES => return Ok(bytes),
        Ok(_) => {
            let most = MOST_BYTES >> 20;
            report
                .whole(format!(
                    "the file has more than {most} MiB, and no application is that large"
                ))
                .advise("give the path of an application file");
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let fault = report.whole("there is no such file");
            if let Some(near) = neighbour(path) {
                fault.advise(format!("did you mean {}?", quote(&near.to_string_lossy())));
            }
        }
        Err(error) if error.kind() == ErrorKind::IsADirectory => {
            report
                .whole("this is a folder")
                .advise("give the path of an application file in it");
        }
        Err(error) => {
            report.whole(format!("the file cannot be read: {error}"));
        }
    }
    Err(report.into_faults())
}

/// The application file in the same folder whose name is nearest.
fn neighbour(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let names: Vec<String> = std::fs::read_dir(folder.unwrap_or(Path::new(".")))
        .ok()?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    let near = nearest(name, names.iter().map(String::as_str))?;
    Some(folder.map_or_else(|| PathBuf::from(near), |folder| folder.join(near)))
}

impl FromStr for Override {
    type Err = String;

    /// Reads `schema.variable=value`.
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once('=')
            .and_then(|(name, value)| Some((name.trim().split_once('.')?, value)));
        match parts {
            Some(((schema, variable), value)) if !schema.is_empty() && !variable.is_empty() => Ok(Self {
                schema: schema.to_owned(),
                variable: variable.to_owned(),
                value: value.trim().to_owned(),
            }),
            Some(_) | None => Err(format!(
                "{} sets nothing: write schema.variable=value, such as goon.speed=\"0.3 m/s\"",
                quote(text)
            )),
        }
    }
}

impl std::fmt::Display for Override {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "--set {}.{}={}", self.schema, self.variable, self.value)
    }
}
