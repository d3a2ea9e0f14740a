//! The schemas that a file defines, before they are bound: by number and by name, with their types once these
//! are resolved. Binds nothing.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use jde_abi::describe::Schema;
use jde_abi::lists::ListedPort;
use jde_core::{Id, SchemaId, Table};
use toml::de::DeValue;

use super::InstancePort;
use jde_document::section::{Section, Text, report_wrong_shape};
use jde_document::{FaultReport, quote};

/// The longest name of a schema or a link, as for every name in a plugin.
pub(super) const MAX_NAME_LENGTH: usize = 64;

/// The schemas that a file defines, by number and by name.
#[derive(Default)]
pub(super) struct Drafts<'a> {
    pub(super) list: Table<SchemaId, Draft<'a>>,
    ids: HashMap<&'a str, SchemaId>,
}

/// A schema that a file defines.
pub(super) struct Draft<'a> {
    pub(super) name: &'a str,
    pub(super) section: Section<'a>,
    /// `None` if the type is missing or unknown, which has been reported.
    pub(super) resolved: Option<ResolvedType>,
}

/// The type of an instance.
#[derive(Clone)]
pub(super) struct ResolvedType {
    pub(super) plugin: usize,
    pub(super) number: usize,
    pub(super) schema: Arc<Schema>,
    /// The last of its ports: those of its lists.
    pub(super) listed: Vec<ListedPort>,
}

/// One instance, with access to the others.
pub(super) struct InstanceContext<'d, 'a> {
    pub(super) drafts: &'d Drafts<'a>,
    pub(super) id: SchemaId,
    pub(super) schema: &'d Schema,
}

impl<'d, 'a> InstanceContext<'d, 'a> {
    pub(super) fn section(&self) -> &'d Section<'a> {
        &self.drafts.list[self.id].section
    }

    /// Returns the ports of its lists.
    pub(super) fn listed(&self) -> &'d [ListedPort] {
        self.drafts.listed(self.id)
    }
}

impl<'a> Drafts<'a> {
    /// Returns the ports of an instance's lists.
    pub(super) fn listed(&self, id: SchemaId) -> &[ListedPort] {
        let resolved = self.list[id].resolved.as_ref();
        resolved.map_or(&[], |found| &found.listed)
    }

    pub(super) fn read(report: &mut FaultReport, top: &Section<'a>) -> Self {
        let mut drafts = Self::default();
        if top.get("schemas").is_none() {
            report
                .file_fault("there is no `schemas`, so the application has nothing to run")
                .advise("define each schema in its own table: [schemas.NAME] with type = \"PLUGIN/SCHEMA\"");
        }
        let Some(schemas) = top.section(report, "schemas", "`schemas`") else {
            return drafts;
        };
        for (name, node) in schemas.entries() {
            let what = format!("schema {}", quote(name.text));
            let DeValue::Table(entries) = node.get_ref() else {
                report_wrong_shape(report, &what, "a table", node);
                continue;
            };
            refuse_bad_name(report, &name, "a schema");
            drafts.ids.insert(name.text, SchemaId::new(drafts.list.len()));
            drafts.list.push(Draft {
                name: name.text,
                section: Section::new(what, name.span.clone(), entries),
                resolved: None,
            });
        }
        drafts
    }

    /// Returns the type of an instance; `None` if it is unknown.
    pub(super) fn schema(&self, id: SchemaId) -> Option<&Arc<Schema>> {
        self.list[id].resolved.as_ref().map(|found| &found.schema)
    }

    /// Returns the name of an instance, quoted.
    pub(super) fn quoted(&self, id: SchemaId) -> String {
        quote(self.list[id].name)
    }

    /// Returns the name of a port of an instance, quoted.
    pub(super) fn quoted_port(&self, InstancePort { instance, port }: InstancePort) -> String {
        let port = self
            .schema(instance)
            .map_or("", |schema| &schema.ports[port].name);
        quote(&format!("{}.{port}", self.list[instance].name))
    }

    pub(super) fn id_of(&self, name: &str) -> Option<SchemaId> {
        self.ids.get(name).copied()
    }

    /// Returns the instance of that name; reports it if there is none. `what` names the place in messages:
    /// "`roots` of the application".
    pub(super) fn find(
        &self,
        report: &mut FaultReport,
        what: &str,
        name: &str,
        span: &Range<usize>,
    ) -> Option<SchemaId> {
        let id = self.id_of(name);
        if id.is_none() {
            report
                .fault(
                    span,
                    format!("{what} names {}, and there is no such schema", quote(name)),
                )
                .suggest(name, "schemas", self.list.iter().map(|draft| draft.name));
        }
        id
    }
}

/// Whether the text can be the name of a schema or a variable.
pub(super) fn is_legal_name(name: &str) -> bool {
    (1..=MAX_NAME_LENGTH).contains(&name.len()) && name.chars().all(is_legal)
}

/// Whether a name may contain the character.
pub(super) fn is_legal(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '-'
}

/// Reports a name that `what`, such as "a schema", cannot have. Returns whether it was legal.
pub(super) fn refuse_bad_name(report: &mut FaultReport, name: &Text, what: &str) -> bool {
    let legal = is_legal_name(name.text);
    if !legal {
        let message = format!("{} cannot be the name of {what}", quote(name.text));
        report
            .fault(&name.span, message)
            .advise("use 1 to 64 letters, digits, `_` and `-`");
    }
    legal
}
