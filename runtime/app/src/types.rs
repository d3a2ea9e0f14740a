//! Finds the type that each instance names, in the catalogue of plugins. Loads nothing itself.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use jde_abi::describe::Plugin;
use jde_nearest::nearest;
use jde_types::Value as _;

use super::drafts::{Drafts, ResolvedType};
use super::literal::parse_node;
use super::{Catalogue, Override, Unusable};
use jde_document::section::Text;
use jde_document::{FaultReport, quote, quote_all};

/// The key of a type, and its name in an option.
pub(super) const TYPE: &str = "type";

/// Gives every draft its type, that of an option instead of that of the file, and returns the plugins in use.
pub(super) fn resolve(
    report: &mut FaultReport,
    drafts: &mut Drafts,
    overrides: &[Override],
    catalogue: &dyn Catalogue,
    dirs: &[PathBuf],
) -> Vec<Arc<Plugin>> {
    let mut types = TypeResolver {
        catalogue,
        dirs,
        plugins: Vec::new(),
        plugin_indices: HashMap::new(),
        type_names: OnceCell::new(),
        resolved: HashMap::new(),
    };
    for draft in drafts.list.iter_mut() {
        let is_of = |given: &&Override| given.schema == draft.name && given.variable == TYPE;
        if let Some(given) = overrides.iter().rfind(is_of) {
            draft.resolved = report.in_option(given.to_string(), |report| {
                types.find_given(report, &draft.section.label, given)
            });
            continue;
        }
        if draft.section.get(TYPE).is_none() {
            let message = format!("{} has no `type`", draft.section.label);
            let fault = report.fault(&draft.section.span, message);
            let similar = types
                .type_names()
                .iter()
                .find(|known| known.rsplit('/').next() == Some(draft.name));
            fault.advise(match similar {
                Some(known) => format!("add type = \"{known}\""),
                None => {
                    "add type = \"PLUGIN/SCHEMA\", or only the plugin if it contains one schema".to_owned()
                }
            });
        }
        draft.resolved = draft
            .section
            .text(report, TYPE)
            .and_then(|written| types.find(report, &draft.section.label, &written));
    }
    types.plugins
}

struct TypeResolver<'c> {
    catalogue: &'c dyn Catalogue,
    dirs: &'c [PathBuf],
    plugins: Vec<Arc<Plugin>>,
    plugin_indices: HashMap<String, Result<usize, Unusable>>,
    type_names: OnceCell<Vec<String>>,
    /// Lets instances of one type share its description.
    resolved: HashMap<(usize, usize), ResolvedType>,
}

/// Splits a type into its plugin and its schema. A plugin of Python is a file, whose path may have folders.
fn split(text: &str) -> (&str, Option<&str>) {
    let last = if text.ends_with(".py") {
        None
    } else {
        text.rsplit_once('/')
    };
    last.map_or((text, None), |(plugin, schema)| (plugin, Some(schema)))
}

/// Returns a type whose file of Python, if it names one relative to a folder, is that of the folder.
fn in_folder(text: &str, folder: &Path) -> String {
    let (plugin, schema) = split(text);
    let file = folder.join(plugin);
    match (file.to_str(), schema) {
        (Some(file), _) if !plugin.ends_with(".py") || !Path::new(file).exists() => text.to_owned(),
        (Some(file), Some(schema)) => format!("{file}/{schema}"),
        (Some(file), None) => file.to_owned(),
        (None, _) => text.to_owned(),
    }
}

impl TypeResolver<'_> {
    /// Finds the type of an option.
    fn find_given(&mut self, report: &mut FaultReport, what: &str, given: &Override) -> Option<ResolvedType> {
        let node = parse_node(report, &given.value, &jde_types::Text::<1024>::describe())?;
        let key = format!("{} of {what}", quote(TYPE));
        let written = jde_document::section::text(report, &key, &node)?;
        let text = in_folder(written.text, &given.folder);
        self.find(
            report,
            what,
            &Text {
                text: &text,
                span: 0..0,
            },
        )
    }

    fn find(&mut self, report: &mut FaultReport, what: &str, written: &Text) -> Option<ResolvedType> {
        let (plugin, schema) = split(written.text);
        let index = match self.plugin(plugin) {
            Ok(index) => index,
            Err(Unusable { reason, is_missing }) => {
                let message = format!("{what}: plugin {} cannot be used: {reason}", quote(plugin));
                let fault = report.fault(&written.span, message);
                // Another one would be a wrong suggestion for a plugin that is there.
                if is_missing && let Some(near) = suggest_type(self.type_names(), written.text) {
                    fault.advise(format!("did you mean {}?", quote(&near)));
                }
                return None;
            }
        };
        let number = self.schema(report, index, schema, written)?;
        let plugins = &self.plugins;
        let found = self
            .resolved
            .entry((index, number))
            .or_insert_with(|| ResolvedType {
                plugin: index,
                number,
                schema: Arc::new(plugins[index].schemas[number].clone()),
                listed: Vec::new(),
            });
        Some(found.clone())
    }

    /// Returns the names for suggestions. Queries the catalogue only once.
    fn type_names(&self) -> &[String] {
        self.type_names.get_or_init(|| self.catalogue.type_names())
    }

    /// Returns the plugin's place. Queries the catalogue only once for each plugin.
    fn plugin(&mut self, name: &str) -> Result<usize, Unusable> {
        if let Some(known) = self.plugin_indices.get(name) {
            return known.clone();
        }
        let place = self.catalogue.plugin(name, self.dirs).map(|plugin| {
            self.plugins.push(plugin);
            self.plugins.len() - 1
        });
        self.plugin_indices.insert(name.to_owned(), place.clone());
        place
    }

    fn schema(
        &self,
        report: &mut FaultReport,
        plugin: usize,
        schema: Option<&str>,
        written: &Text,
    ) -> Option<usize> {
        let plugin = &self.plugins[plugin];
        let names = || plugin.schemas.iter().map(|schema| schema.name.as_str());
        let name = schema.unwrap_or(&plugin.name);
        if let Some(number) = names().position(|known| known == name) {
            return Some(number);
        }
        match schema {
            None if plugin.schemas.len() == 1 => return Some(0),
            None => {
                report
                    .fault(
                        &written.span,
                        format!(
                            "plugin {} contains {}; state which one",
                            quote(&plugin.name),
                            quote_all(names())
                        ),
                    )
                    .advise(format!(
                        "write type = \"{}/{}\"",
                        plugin.name, plugin.schemas[0].name
                    ));
            }
            Some(schema) => report
                .fault(
                    &written.span,
                    format!(
                        "plugin {} contains no schema {}",
                        quote(&plugin.name),
                        quote(schema)
                    ),
                )
                .suggest(schema, "its schemas", names()),
        }
        None
    }
}

/// Returns the known type that a name with a missing plugin probably means.
fn suggest_type(known: &[String], written: &str) -> Option<String> {
    let (plugin, schema) = split(written);
    let with_schema =
        |file: &str| schema.map_or_else(|| file.to_owned(), |schema| format!("{file}/{schema}"));
    let mut files = known
        .iter()
        .map(String::as_str)
        .filter(|name| name.ends_with(".py"));
    if plugin.ends_with(".py") {
        return nearest(plugin, files).map(with_schema);
    }
    // A file of Python without its end.
    if let Some(file) = files.find(|file| file.strip_suffix(".py") == Some(plugin)) {
        return Some(with_schema(file));
    }
    let halves = |known: &String| {
        let (plugin, schema) = known.split_once('/').unwrap_or((known, known));
        (plugin.to_owned(), schema.to_owned())
    };
    // The name of the schema alone, where a plugin is expected.
    if let Some(full) = known.iter().find(|known| halves(known).1 == written) {
        return Some(full.clone());
    }
    let plugins: Vec<_> = known.iter().map(|known| halves(known).0).collect();
    let all = known.iter().map(String::as_str);
    nearest(written, all.chain(plugins.iter().map(String::as_str))).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::{split, suggest_type};

    #[test]
    fn a_missing_file_of_python_is_probably_one_with_a_similar_name() {
        let known = ["hog.py", "shy.py", "vff", "vff/vff"].map(str::to_owned);
        let suggest = |written| suggest_type(&known, written);
        assert_eq!(suggest("hgo.py/Hog").as_deref(), Some("hog.py/Hog"));
        assert_eq!(suggest("hg.py").as_deref(), Some("hog.py"));
        assert_eq!(suggest("hog/Hog").as_deref(), Some("hog.py/Hog"));
        assert_eq!(suggest("quite_another.py"), None);
        assert_eq!(suggest("vf").as_deref(), Some("vff"));
    }

    #[test]
    fn a_file_of_python_may_be_in_a_folder() {
        for (text, plugin, schema) in [
            ("stop", "stop", None),
            ("sim/pioneer", "sim", Some("pioneer")),
            ("shy.py", "shy.py", None),
            ("shy.py/Shy", "shy.py", Some("Shy")),
            ("parts/shy.py", "parts/shy.py", None),
            ("/parts/shy.py/Shy", "/parts/shy.py", Some("Shy")),
        ] {
            assert_eq!(split(text), (plugin, schema), "{text}");
        }
    }
}
