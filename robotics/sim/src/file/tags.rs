//! The AprilTags of a world file.

use jde_tags::Family;

use super::fixtures::each;
use super::values::{self, between};
use crate::tag::Tag;
use jde_document::{FaultReport, Section, WrongValue};

const KEYS: [&str; 6] = ["name", "family", "id", "size", "place", "facing_deg"];
/// The default side of the black border, in metres: as large as fits on a sheet of A4 with the margin.
const SIZE: f64 = 0.16;

pub(crate) fn read(report: &mut FaultReport<'_>, root: &Section<'_>) -> Option<Vec<Tag>> {
    each(report, root, "tags", "tag", &KEYS, |report, table, _| {
        tag(report, table)
    })
}

fn tag(report: &mut FaultReport<'_>, table: &Section<'_>) -> Option<Tag> {
    let family = table.optional(report, "family", Family::Tag36h11, |node| {
        let text = values::text(node)?;
        let names = Family::ALL.iter().map(|family| family.name());
        Family::named(&text).ok_or_else(|| WrongValue::unknown(node, &text, "a family of tags", names))
    });
    let id = table.required(report, "id", |node| {
        let number = values::number(node)?;
        match number >= 0.0 && number.fract() == 0.0 {
            true => Ok(number as u32),
            false => Err(WrongValue::new(
                node,
                format!("is {number}: expected a whole number from 0"),
            )),
        }
    });
    let size = table.optional(report, "size", SIZE, between(0.001, 100.0, "m"));
    let place = table.required(report, "place", values::place);
    let facing = table.optional(report, "facing_deg", 0.0, values::number);
    let (family, id, size) = (family?, id?, size?);
    let tag = Tag::new((family, id), size, place?, facing?.to_radians());
    if tag.is_none() {
        let (name, last) = (family.name(), family.count() - 1);
        table.fault(
            report,
            &table.span,
            format!("is tag {id} of {name}, which has 0 to {last}"),
        );
    }
    tag
}
