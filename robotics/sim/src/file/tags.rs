//! The AprilTags of a world file.

use jde_tags::Family;

use super::document::{Document, Table};
use super::fixtures::each;
use super::values::{self, Read, between};
use crate::tag::Tag;

const KEYS: [&str; 6] = ["name", "family", "id", "size", "place", "facing_deg"];
/// The default side of the black border, in metres: as large as fits on a sheet of A4 with the margin.
const SIZE: f64 = 0.16;

pub(crate) fn read(document: &Document<'_>, root: &Table<'_>) -> Option<Vec<Tag>> {
    each(document, root, "tags", "tag", &KEYS, |table, _| tag(table))
}

fn tag(table: &Table<'_>) -> Option<Tag> {
    let family = table.optional("family", Family::Tag36h11, |item| {
        let text = values::text(item)?;
        Family::named(&text).ok_or_else(|| {
            let names = Family::ALL.map(Family::name).join("`, `");
            (item.span(), format!("is `{text}`: expected one of `{names}`"))
        })
    });
    let number = |item: &_| -> Read<u32> {
        let number = values::number(item)?;
        let is_whole = number >= 0.0 && number.fract() == 0.0;
        let whole = is_whole.then_some(number as u32);
        whole.ok_or_else(|| {
            (
                item.span(),
                format!("is {number}: expected a whole number from 0"),
            )
        })
    };
    let id = table.required("id", number);
    let size = table.optional("size", SIZE, between(0.001, 100.0, "m"));
    let place = table.required("place", values::place);
    let facing = table.optional("facing_deg", 0.0, values::number);
    let (family, id, size) = (family?, id?, size?);
    let tag = Tag::new((family, id), size, place?, facing?.to_radians());
    if tag.is_none() {
        let (name, last) = (family.name(), family.count() - 1);
        table.fault(
            table.span(),
            format!("{name} has no tag {id}: expected 0 to {last}"),
        );
    }
    tag
}
