//! The hierarchy as the rows of a list: fathers above their children, with the groups between them. Every schema has one
//! row: those that no group and no father leads to follow at the end.

use jde_records::snapshot::Snapshot;

use crate::hierarchy::Hierarchy;

/// A row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HierarchyRow {
    /// What it shows.
    pub item: Item,
    /// How far it is indented: a group and its members differ by one.
    pub depth: usize,
    /// Whether no row of the same depth follows below the same row.
    pub is_last: bool,
}

/// What a row shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A group, by its place.
    Group(usize),
    /// A schema, by its place, and whether rows are below it.
    Schema(usize, Children),
    /// The title above the schemas that do not compete.
    Others,
}

/// Whether a schema has rows below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Children {
    /// It has no children, or none is to be shown.
    Nothing,
    /// Its children follow.
    Shown,
    /// Its children are folded.
    Folded,
}

/// The title of [`Item::Others`].
pub const OTHERS: &str = "drivers and perception";

impl HierarchyRow {
    /// Returns the schema that it shows.
    #[must_use]
    pub fn schema(&self) -> Option<usize> {
        match self.item {
            Item::Schema(schema, _) => Some(schema),
            Item::Group(_) | Item::Others => None,
        }
    }

    /// Whether a snapshot has what it shows. Records may have named more than that.
    #[must_use]
    pub fn is_in(&self, snapshot: &Snapshot) -> bool {
        match self.item {
            Item::Group(group) => group < snapshot.groups.len(),
            Item::Schema(schema, _) => schema < snapshot.schemas.len(),
            Item::Others => true,
        }
    }

    /// Returns the group that it shows.
    #[must_use]
    pub fn group(&self) -> Option<usize> {
        match self.item {
            Item::Group(group) => Some(group),
            Item::Schema(..) | Item::Others => None,
        }
    }
}

impl Hierarchy {
    /// Returns all rows.
    #[must_use]
    pub fn rows(&self) -> Vec<HierarchyRow> {
        self.rows_of(|_| true, |_| false)
    }

    /// Returns the rows of the schemas that are to be shown, of their fathers, and of the groups between them. The children
    /// of a folded schema are left out.
    #[must_use]
    pub fn rows_of(
        &self,
        is_shown: impl Fn(usize) -> bool,
        is_folded: impl Fn(usize) -> bool,
    ) -> Vec<HierarchyRow> {
        let schemas = self.schemas();
        let mut shown = vec![false; schemas.len()];
        for place in (0..schemas.len()).filter(|place| is_shown(*place)) {
            for above in self.fathers(place) {
                if std::mem::replace(&mut shown[above], true) {
                    break;
                }
            }
        }
        // The children that do not compete.
        let mut others = vec![Vec::new(); schemas.len()];
        for (place, schema) in schemas
            .iter()
            .enumerate()
            .filter(|(_, schema)| schema.group.is_none())
        {
            if let Some(father) = schema.father.filter(|_| shown[place]) {
                others[father].push(place);
            }
        }
        let members = |group: usize| {
            let members = self.groups()[group].members.iter().copied();
            members.filter(|member| shown[*member]).collect::<Vec<_>>()
        };
        let has_rows =
            |group: &usize| self.groups()[*group].members.is_empty() || !members(*group).is_empty();
        let groups_of = |schema: usize| {
            let groups = schemas[schema].groups.iter().copied();
            groups.filter(has_rows).collect::<Vec<_>>()
        };
        let item = |schema: usize| {
            let below = match groups_of(schema).is_empty() && others[schema].is_empty() {
                true => Children::Nothing,
                false if is_folded(schema) => Children::Folded,
                false => Children::Shown,
            };
            Item::Schema(schema, below)
        };
        let mut rows = Vec::new();
        let mut pending = Vec::new();
        let roots = (0..self.groups().len()).filter(|group| self.groups()[*group].father.is_none());
        let roots = roots.filter(has_rows);
        push(&mut pending, 0, roots.map(Item::Group).collect());
        walk(&mut rows, &mut pending, &members, &groups_of, &others, item);
        let is_other =
            |place: &usize| shown[*place] && schemas[*place].father.or(schemas[*place].group).is_none();
        let last: Vec<_> = (0..schemas.len()).filter(is_other).map(item).collect();
        if !last.is_empty() {
            rows.push(HierarchyRow {
                item: Item::Others,
                depth: 0,
                is_last: true,
            });
        }
        push(&mut pending, 1, last);
        walk(&mut rows, &mut pending, &members, &groups_of, &others, item);
        rows
    }
}

/// Puts rows of one depth on the stack, so that the first is taken first.
fn push(pending: &mut Vec<HierarchyRow>, depth: usize, items: Vec<Item>) {
    let count = items.len();
    let rows = items.into_iter().enumerate().map(|(place, item)| HierarchyRow {
        item,
        depth,
        is_last: place + 1 == count,
    });
    pending.extend(rows.rev());
}

/// Takes the rows from the stack, each followed by those below it. Without recursion, since a file may nest schemas as deep
/// as it likes.
fn walk(
    rows: &mut Vec<HierarchyRow>,
    pending: &mut Vec<HierarchyRow>,
    members: &dyn Fn(usize) -> Vec<usize>,
    groups_of: &dyn Fn(usize) -> Vec<usize>,
    others: &[Vec<usize>],
    item: impl Fn(usize) -> Item,
) {
    while let Some(row) = pending.pop() {
        rows.push(row);
        let below = match row.item {
            Item::Group(group) => members(group).into_iter().map(&item).collect(),
            Item::Schema(schema, Children::Shown) => {
                let groups = groups_of(schema).into_iter().map(Item::Group);
                groups
                    .chain(others[schema].iter().map(|child| item(*child)))
                    .collect()
            }
            Item::Schema(_, Children::Nothing | Children::Folded) | Item::Others => Vec::new(),
        };
        push(pending, row.depth + 1, below);
    }
}
