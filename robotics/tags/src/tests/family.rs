//! The tables of codes.

use crate::Family;

#[test]
fn families_have_the_published_tags() {
    let first = |family: Family| family.codes().next().expect("it has a tag");
    assert_eq!(first(Family::Tag36h11), 0xd_5d62_8584);
    assert_eq!(first(Family::Tag25h9), 0x155_cbf1);
    assert_eq!(first(Family::Tag16h5), 0x231b);
    assert_eq!(Family::ALL.map(Family::count), [587, 35, 30]);
    for family in Family::ALL {
        assert_eq!(Family::named(family.name()), Some(family));
        assert_eq!(family.cells(family.count() as u32), None);
    }
}

#[test]
fn two_tags_differ_in_as_many_bits_as_the_name_states() {
    for (family, least) in Family::ALL.into_iter().zip([11, 9, 5]) {
        let codes: Vec<u64> = family.codes().collect();
        for (id, code) in codes.iter().enumerate() {
            let rest = &codes[id + 1..];
            let found = family.nearest(rest, *code, least - 1);
            assert_eq!(found, None, "{} {id}", family.name());
        }
    }
}

#[test]
fn a_reading_is_found_in_every_direction_and_with_wrong_bits() {
    let family = Family::Tag36h11;
    let codes: Vec<u64> = family.codes().collect();
    let mut reading = codes[321];
    for turns in [0, 3, 2, 1] {
        let found = family.nearest(&codes, reading ^ 0b101, 2).expect("it is near");
        assert_eq!((found.id, found.hamming, found.turns), (321, 2, turns));
        assert_eq!(family.nearest(&codes, reading ^ 0b111, 2), None);
        reading = family.turned(reading);
    }
    assert_eq!(reading, codes[321], "four quarters are a whole turn");
}

#[test]
fn cells_have_a_black_border_and_a_white_margin() {
    let cells = Family::Tag16h5.cells(0).expect("it exists");
    let text: Vec<String> = cells
        .chunks(8)
        .map(|row| row.iter().map(|white| if *white { '.' } else { '#' }).collect())
        .collect();
    // 0x231b is 0010 0011 0001 1011.
    let expected = [
        "........", ".######.", ".###.##.", ".###..#.", ".####.#.", ".#.#..#.", ".######.", "........",
    ];
    assert_eq!(text, expected);
}
