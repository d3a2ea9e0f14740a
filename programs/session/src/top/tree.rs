//! The lines of a tree before the names of its rows.

use jde_timeline::{Hierarchy, HierarchyRow, Item};

/// Returns the rows of a hierarchy, each with the lines of the tree before its name.
#[must_use]
pub fn branches(hierarchy: &Hierarchy) -> Vec<(String, HierarchyRow)> {
    // What stands before the rows of each depth.
    let mut before = vec![String::new()];
    let branch = |row: HierarchyRow| {
        before.truncate(row.depth + 1);
        let above = before[row.depth].clone();
        let (own, below) = match row.item {
            Item::Group(_) | Item::Others => ("", ""),
            Item::Schema(schema, _) => {
                let schema = &hierarchy.schemas()[schema];
                match (schema.group, schema.father) {
                    (Some(_), _) if row.is_last => ("└ ", "  "),
                    (Some(_), _) => ("├ ", "│ "),
                    (None, Some(_)) => ("· ", "  "),
                    (None, None) => ("  ", "  "),
                }
            }
        };
        before.push(format!("{above}{below}"));
        (format!("{above}{own}"), row)
    };
    hierarchy.rows().into_iter().map(branch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::top::tests::snapshots::navigation;

    #[test]
    fn children_are_listed_below_their_father_in_their_groups() {
        let hierarchy = Hierarchy::of_snapshot(&navigation());
        let lines = branches(&hierarchy)
            .into_iter()
            .map(|(branch, row)| match row.item {
                Item::Group(group) => format!("{branch}[{}]", hierarchy.groups()[group].name),
                Item::Schema(schema, _) => format!("{branch}{}", hierarchy.schemas()[schema].name),
                Item::Others => format!("# {}", jde_timeline::OTHERS),
            });
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
        assert_eq!(lines.collect::<Vec<_>>(), expected);
    }
}
