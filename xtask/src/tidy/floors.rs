//! The floors of the project, as their table in `docs/architecture.md` says: which floor may use which, the picture of the
//! table, and the page of each floor.

use std::collections::BTreeSet;

use super::layering::PAGE;
use super::tree::{Tree, Violation};
use crate::metadata::{Kind, Metadata};

/// The longest page of a floor, lines.
const MOST_LINES: usize = 14;

/// A row of the table.
struct Floor<'p> {
    name: &'p str,
    /// Names of floors; or `nothing`, `all but dev`, `all but programs`.
    uses: &'p str,
}

pub(super) fn check(tree: &Tree, metadata: &Metadata) -> Vec<Violation> {
    let page = tree.file(PAGE).map_or("", |file| file.text.as_str());
    let floors = floors(page);
    let mut found = arrows(tree, metadata, &floors);
    found.extend(picture(page, &floors));
    found.extend(floors.iter().filter_map(|floor| floor_page(tree, floor)));
    found
}

/// The floors, from the lowest.
fn floors(page: &str) -> Vec<Floor<'_>> {
    let rows = page.lines().skip_while(|line| *line != "## Floors").skip(1);
    let rows = rows.take_while(|line| !line.starts_with("## "));
    rows.filter_map(|line| {
        let (name, rest) = line.strip_prefix("| `")?.split_once("/` | ")?;
        let (_, uses) = rest.strip_suffix(" |")?.rsplit_once(" | ")?;
        Some(Floor { name, uses })
    })
    .collect()
}

impl Floor<'_> {
    fn allows(&self, floor: &str) -> bool {
        match self.uses.strip_prefix("all but ") {
            Some(refused) => floor != refused,
            None => floor == self.name || self.uses.split(", ").any(|used| used == floor),
        }
    }
}

fn arrows(tree: &Tree, metadata: &Metadata, floors: &[Floor<'_>]) -> Vec<Violation> {
    let mut found = Vec::new();
    for package in metadata.members() {
        let folder = package.folder(&tree.root);
        let floor = folder.split_once('/').map_or("", |(floor, _)| floor);
        let Some(floor) = floors.iter().find(|known| known.name == floor) else {
            continue;
        };
        let manifest = format!("{folder}/Cargo.toml");
        let dependencies = package.dependencies.iter();
        for dependency in dependencies.filter(|dependency| dependency.kind != Some(Kind::Dev)) {
            let used = dependency.folder(tree).unwrap_or_default();
            if let Some((used_floor, _)) = used.split_once('/').filter(|(used, _)| !floor.allows(used)) {
                found.push(Violation::new(
                    manifest.as_str(),
                    tree.line_of(&manifest, &dependency.name),
                    format!("{folder} uses {used}, and {} uses no {used_floor}", floor.name),
                    format!("{} may use {}, says {PAGE}", floor.name, floor.uses),
                ));
            }
        }
    }
    found
}

/// Compares the picture with the table.
fn picture(page: &str, floors: &[Floor<'_>]) -> Option<Violation> {
    let drawn: BTreeSet<_> = page
        .lines()
        .filter_map(|line| line.strip_prefix("    ")?.split_once(" --> "))
        .collect();
    let listed: BTreeSet<_> = floors
        .iter()
        .filter(|floor| floor.uses != "nothing" && !floor.uses.starts_with("all but "))
        .flat_map(|floor| floor.uses.split(", ").map(|used| (floor.name, used)))
        .collect();
    let (from, to) = drawn.symmetric_difference(&listed).next()?;
    Some(Violation::new(
        PAGE,
        1,
        format!("the picture of the floors and their table differ in {from} --> {to}"),
        "draw the arrows of the table",
    ))
}

/// Checks the page of a floor.
fn floor_page(tree: &Tree, floor: &Floor<'_>) -> Option<Violation> {
    let path = format!("{}/README.md", floor.name);
    let text = tree.file(&path).map_or("", |file| file.text.as_str());
    let uses = format!("**May use:** {}. ", floor.uses);
    let is_page =
        text.contains(&uses) && text.contains("**Refuses:** ") && text.lines().count() <= MOST_LINES;
    (!is_page).then(|| {
        Violation::new(
            path,
            1,
            "it does not say what the floor refuses and may use, in few lines",
            format!("at most {MOST_LINES} lines, with `**Refuses:** ..` and `{uses}`"),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "## Floors\n\n    plugin --> rules\n\n| `rules/` | what | nothing |\n| `plugin/` | what | rules |\n\
                         | `dev/` | what | all but plugin |\n\n## Next\n\n| `other/` | what | rules |\n";

    #[test]
    fn the_rows_of_the_section_are_the_floors() {
        let floors = floors(TABLE);
        let names: Vec<_> = floors.iter().map(|floor| floor.name).collect();
        assert_eq!(names, ["rules", "plugin", "dev"]);
        assert!(floors[1].allows("rules") && floors[1].allows("plugin") && !floors[1].allows("dev"));
        assert!(floors[2].allows("rules") && !floors[2].allows("plugin"));
        assert!(!floors[0].allows("plugin"));
    }

    #[test]
    fn a_picture_of_another_table_fails() {
        assert!(picture(TABLE, &floors(TABLE)).is_none());
        let more = TABLE.replace(
            "    plugin --> rules\n",
            "    plugin --> rules\n    rules --> plugin\n",
        );
        assert!(picture(&more, &floors(&more)).is_some());
        let fewer = TABLE.replace("    plugin --> rules\n", "");
        assert!(picture(&fewer, &floors(&fewer)).is_some());
    }

    #[test]
    fn a_floor_without_its_page_fails() {
        let floor = Floor {
            name: "rules",
            uses: "nothing",
        };
        let page = "# rules\n\n**Refuses:** x\n\n**May use:** nothing. \n";
        assert!(floor_page(&Tree::of(&[("rules/README.md", page)]), &floor).is_none());
        assert!(floor_page(&Tree::of(&[]), &floor).is_some());
        let other = page.replace("nothing", "all");
        assert!(floor_page(&Tree::of(&[("rules/README.md", &other)]), &floor).is_some());
    }
}
