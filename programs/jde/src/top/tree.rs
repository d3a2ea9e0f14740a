//! The hierarchy as the rows of a list: fathers above their children, with their groups in between.
//!
//! Every schema is listed: those that no group and no father leads to follow at the end.

use jde_records::snapshot::Snapshot;

/// One row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// A group.
    Group {
        /// The lines of the tree before its name.
        branch: String,
        /// Its place.
        group: usize,
    },
    /// A schema.
    Schema {
        /// The lines of the tree before its name.
        branch: String,
        /// Its place.
        schema: usize,
    },
    /// A title above the schemas that do not compete.
    Heading(&'static str),
}

impl Row {
    /// Returns the schema of the row, if it shows one.
    pub(super) fn schema(&self) -> Option<usize> {
        match self {
            Self::Schema { schema, .. } => Some(*schema),
            Self::Group { .. } | Self::Heading(_) => None,
        }
    }
}

/// Returns the rows of a snapshot. Every schema appears once.
pub(crate) fn rows(snapshot: &Snapshot) -> Vec<Row> {
    let mut list = RowBuilder {
        snapshot,
        listed: vec![false; snapshot.schemas.len()],
        rows: Vec::new(),
    };
    list.push_children(None, "");
    let mut ungrouped: Vec<usize> = (0..list.listed.len())
        .filter(|&schema| !list.listed[schema])
        .collect();
    ungrouped.sort_by_key(|&schema| snapshot.schemas[schema].father.is_some());
    if !ungrouped.is_empty() {
        list.rows.push(Row::Heading("drivers and perception"));
    }
    for schema in ungrouped {
        list.push_schema(schema, "  ", "  ");
    }
    list.rows
}

struct RowBuilder<'a> {
    snapshot: &'a Snapshot,
    listed: Vec<bool>,
    rows: Vec<Row>,
}

impl RowBuilder<'_> {
    fn push_children(&mut self, father: Option<usize>, branch: &str) {
        let snapshot = self.snapshot;
        for (group, view) in snapshot
            .groups
            .iter()
            .enumerate()
            .filter(|(_, view)| view.father == father)
        {
            self.rows.push(Row::Group {
                branch: branch.to_owned(),
                group,
            });
            for (nth, &schema) in view.members.iter().enumerate() {
                let last = nth + 1 == view.members.len();
                let (own, under) = if last { ("└ ", "  ") } else { ("├ ", "│ ") };
                self.push_schema(schema, &format!("{branch}{own}"), &format!("{branch}{under}"));
            }
        }
        if let Some(father) = father {
            for (schema, view) in snapshot.schemas.iter().enumerate() {
                if view.father == Some(father) && view.group.is_none() {
                    self.push_schema(schema, &format!("{branch}· "), &format!("{branch}  "));
                }
            }
        }
    }

    fn push_schema(&mut self, schema: usize, own: &str, under: &str) {
        let Some(listed) = self.listed.get_mut(schema) else {
            return;
        };
        if !std::mem::replace(listed, true) {
            self.rows.push(Row::Schema {
                branch: own.to_owned(),
                schema,
            });
            self.push_children(Some(schema), under);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::tests::navigation;

    fn text(snapshot: &Snapshot) -> Vec<String> {
        let lines = rows(snapshot).into_iter().map(|row| match row {
            Row::Group { branch, group } => format!("{branch}[{}]", snapshot.groups[group].name),
            Row::Schema { branch, schema } => format!("{branch}{}", snapshot.schemas[schema].name),
            Row::Heading(title) => format!("# {title}"),
        });
        lines.collect()
    }

    #[test]
    fn children_are_listed_below_their_father_in_their_groups() {
        let expected = [
            "[roots]",
            "├ teleop",
            "└ example",
            "  [example/base]",
            "  ├ goon",
            "  ├ vff",
            "  └ stop",
            "  · map",
            "# drivers and perception",
            "  pioneer",
        ];
        assert_eq!(text(&navigation()), expected);
    }

    #[test]
    fn a_hierarchy_with_a_loop_of_fathers_ends() {
        let mut snapshot = navigation();
        snapshot.groups[0].father = Some(4);
        let listed = rows(&snapshot)
            .iter()
            .filter(|row| matches!(row, Row::Schema { .. }))
            .count();
        assert_eq!(listed, snapshot.schemas.len());
    }
}
