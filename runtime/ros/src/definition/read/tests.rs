//! Definitions of every standard type and of random types are read back. Other definitions are read as in ROS
//! 2, or refused.

use jde_types::{LaserScan, Value as _, standard};
use proptest::prelude::*;

use super::super::definition;
use super::*;
use crate::random::types;

fn assert_read_back(value_type: &Type) {
    let text = definition(value_type);
    let result = read(&value_type.name, &text).unwrap_or_else(|error| panic!("{error} in\n{text}"));
    assert_eq!(result.hash(), value_type.hash(), "{text}");
    assert_eq!(&result, value_type, "{text}");
}

#[test]
fn every_standard_type_is_read_back_with_docs_and_units() {
    for value_type in standard() {
        assert_read_back(&value_type);
    }
}

#[test]
fn a_definition_in_the_style_of_ros_is_read() {
    let text = "\
# A reading.
# Of something.

uint8 GOOD=1   # a constant
string NAME = \"a # b\"
# Belongs to the constant.
int32 X=-3

# Not near.

Inner inner
other_msgs/msg/Stamp at # when [ns]
float32[3] axes
char letter 7
# How far. [m]
# It is signed.
float64 far
# [m/s]
float64[<=2] fast 1.0 # nothing
================================================================================
MSG: my_msgs/Inner
byte small
================================================================================
MSG: other_msgs/Stamp
uint64 ns
";
    let read = read("my_msgs/msg/Reading", text).unwrap();
    assert_eq!(
        (read.name.as_str(), read.doc.as_str()),
        ("my_msgs/msg/Reading", "A reading.\nOf something.")
    );
    let fields: Vec<_> = read
        .fields
        .iter()
        .map(|field| {
            (
                field.name.as_str(),
                field.doc.as_str(),
                field.unit.as_str(),
                field.offset,
            )
        })
        .collect();
    assert_eq!(
        fields,
        [
            ("inner", "", "", 0),
            ("at", "when", "ns", 8),
            ("axes", "", "", 16),
            ("letter", "", "", 28),
            ("far", "How far. [m]\nIt is signed.", "", 32),
            ("fast", "", "m/s", 48),
        ]
    );
    assert_eq!((read.bytes, read.align), (64, 8));
    let FieldKind::Struct(inner) = &read.fields[0].kind else {
        panic!("{read:?}");
    };
    assert_eq!((inner.name.as_str(), inner.bytes), ("my_msgs/msg/Inner", 1));
}

#[test]
fn a_definition_without_bounds_has_the_fields_of_the_standard_type() {
    let scan = LaserScan::describe();
    let ros = "\
# Single scan
std_msgs/Header header
float32 angle_min
float32 angle_max
float32 angle_increment
float32 time_increment
float32 scan_time # seconds
float32 range_min
float32 range_max
float32[] ranges
float32[] intensities
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";
    assert!(has_fields(ros, &scan));
    assert!(has_fields(
        &ros.replace("float32[] ranges", "float32[<=9] ranges"),
        &scan
    ));
    for (from, to) in [
        ("float32[] ranges", "float64[] ranges"),
        ("float32[] ranges", "float32[9] ranges"),
        ("float32 scan_time # seconds\n", ""),
        ("string frame_id", "string frame"),
        ("std_msgs/Header header", "Header header"),
        ("MSG: builtin_interfaces/Time", "MSG: builtin_interfaces/Duration"),
    ] {
        assert!(!has_fields(&ros.replace(from, to), &scan), "{to}");
    }
    let constants = "byte GOOD=1\nchar x\n";
    let plain = read("a/msg/A", "uint8 x").unwrap();
    assert!(has_fields(constants, &plain));
}

#[test]
fn a_list_of_texts_is_one_of_ros() {
    let names = read("a/msg/A", "string<=6[<=3] names\nstring<=4[2] pair\n").unwrap();
    let texts: Vec<_> = names.fields.iter().map(super::super::texts).collect();
    assert_eq!(texts, [Some(6), Some(4)]);
    assert_eq!(names.bytes, 8 + 3 * 12 + 2 * 8);
    assert_read_back(&names);
    assert!(has_fields("string[] names\nstring[2] pair\n", &names));
    assert!(!has_fields("jde_msgs/Name[] names\nstring[2] pair\n", &names));
}

#[test]
fn a_comment_of_others_has_a_unit_only_if_jde_knows_it() {
    // Comments of PX4, of SBG and of others.
    let text = "\
float64 pressure # tyre [bar]
float32 temperature\t\t# [°C]
float32 quality # [-]
float32 share # [0-1]
float32 level 0.5 # after a default [%]
bool valid # as in [1] [m]
int32 choice # [@enum COLOR]
int32 reference # as in [1]
float32[3] rates # body rates [rad/s]
string name # [m]
Inner inner # [m]
# Above it.
float32 far # [m]
";
    let text = format!("{text}===\nMSG: a/Inner\nfloat32 x # [s]\n");
    let read = read_interface("a/msg/A", &text, |_| 8, |_| None).unwrap();
    let fields: Vec<_> = read
        .fields
        .iter()
        .map(|field| (&*field.doc, &*field.unit))
        .collect();
    assert_eq!(
        fields,
        [
            ("tyre [bar]", ""),
            ("[°C]", ""),
            ("[-]", ""),
            ("[0-1]", ""),
            ("after a default", "%"),
            ("as in [1] [m]", ""),
            ("[@enum COLOR]", ""),
            ("as in [1]", ""),
            ("body rates", "rad/s"),
            ("[m]", ""),
            ("[m]", ""),
            ("Above it.", ""),
        ]
    );
}

#[test]
fn a_structure_has_no_more_fields_than_a_plugin_takes() {
    let fields = |count: usize| -> String { (0..count).map(|number| format!("bool a{number}\n")).collect() };
    assert!(read("a/msg/A", &fields(2048)).is_ok());
    assert_refused(&fields(2049), "`a/A` has more than 2048 fields");
}

#[test]
fn all_that_ros_accepts_is_read() {
    let text = "\u{feff}# A file of Windows.\r\n\r\n\tuint8\tX=1\r\nstring<=10 s\t'a \\'b'\r\nwchar w\rint8 BIG = 0x7F # a\r\n\
                string<=5[<=2] list [\"a, b\", 'c']\nbyte[+04] bytes\nchar c 65\n\n\nunicode u # \u{e9}\u{1f916}\n\
                ===\nMSG: a/wchar\nint8 x\n===\nMSG: a/unicode\nint8 x\n";
    let read = read_interface("a/msg/A", text, |_| 9, |_| None).unwrap();
    let names: Vec<_> = read.fields.iter().map(|field| &*field.name).collect();
    assert_eq!(names, ["s", "w", "list", "bytes", "c", "u"]);
    assert_eq!(read.fields[5].doc, "\u{e9}\u{1f916}");
}

#[test]
fn a_fault_is_named_with_the_type_and_its_own_line() {
    let error = |text: &str| {
        let read = read_interface("a/msg/A", text, |_| 9, |_| None);
        read.unwrap_err().to_string()
    };
    let nested = "b/B b\n\n===\nMSG: b/B\nint8 x\n";
    assert_eq!(
        error(&format!("{nested}wstring name")),
        "`b/B`: line 2: a field of `wstring` cannot be shared; texts are UTF-8, as in `string<=64`"
    );
    assert_eq!(
        error(&format!("{nested}C c")),
        "`b/B`: line 2: `b/C` is not defined; expected it behind a line `MSG: b/C`"
    );
    assert_eq!(
        error(&format!("{nested}int8 x")),
        "`b/B`: line 2: there is a `x` already"
    );
    assert!(error(&format!("{nested}x")).starts_with("`b/B`: line 2: `x` is no field"));
    assert!(error("int8 x\ntime t").contains("line 2: a field of `time` cannot be shared; it is of ROS 1"));
    let long = format!("int8 {}", "x".repeat(65));
    assert!(error(&long).starts_with("line 1: the name of the field has 65 letters"));
    assert!(error(&"-".repeat(1000)).len() < 200);
}

#[track_caller]
fn assert_refused(text: &str, message: &str) {
    let error = read("a/msg/A", text).unwrap_err().to_string();
    assert!(error.contains(message), "{error}");
}

#[test]
fn types_that_cannot_be_shared_are_refused_with_the_line() {
    assert_refused("# doc\nfloat32[] ranges\n", "line 2: a field of `float32[]`");
    assert_refused(
        "string name",
        "line 1: a field of `string` cannot be shared; give it a bound",
    );
    assert_refused("wstring<=4 name", "UTF-8");
    assert_refused(
        "string[<=2] names",
        "give its texts a bound, as in `string<=64[<=8]`",
    );
    assert_refused("string<=4[] names", "give it a bound");
    assert_refused("string<=0[2] names", "1 to 4294967295");
    assert_refused("string<=400000000[2] names", "too large");
    assert_refused("float32[0] none", "1 to 4294967295");
    assert_refused("float32[<=99999999999] many", "1 to 4294967295");
    assert_refused("float32[3 axes", "`]`");
    assert_refused("\nfloat32\n", "line 2: `float32` is no field");
    assert_refused("float32 a.b", "is no field");
    assert_refused("float32 #comment", "is no field");
    assert_refused("float32 a\nint8 a", "line 2: there is a `a`");
    assert_refused("b/B b", "line 1: `b/B` is not defined");
    assert_refused("B b", "line 1: `a/B` is not defined");
    assert_refused("===\nfloat32 x", "line 2");
    assert_refused("===", "line 1");
    assert_refused("===\nMSG: a/A\nint8 x", "line 2: there is a `a/A`");
    assert_refused(
        "b/B b\n===\nMSG: b/B\nint8 x\n===\nMSG: b/B\nint8 y",
        "line 6: there is a `b/B`",
    );
}

#[test]
fn a_definition_may_be_listed_again() {
    let once = "b/B b\nb/B c\n===\nMSG: b/B\nint8 x\n";
    let again = format!("{once}===\nMSG: b/B\n# As above.\nint8 x\n");
    let read = |text: &str| read("a/A", text).expect("a definition");
    assert_eq!(read(&again), read(once));
}

#[test]
fn recursive_and_oversized_types_are_refused() {
    assert_refused("a/A again", "contains itself");
    assert_refused("b/B b\n===\nMSG: b/B\na/A[4] a", "contains itself");
    assert_refused(&"#".repeat(MAX_TEXT + 1), "at most");
    assert_refused("float64[4294967295] many", "too large");
    let chain = |links: usize, of: &str| -> String {
        let link = |n| {
            let fields = of.replace("NEXT", &format!("a/T{}", n + 1));
            format!("===\nMSG: a/T{n}\n{fields}\n")
        };
        let links: String = (0..links).map(link).collect();
        format!("a/T0 first\n{links}===\nMSG: a/T{}\nint8 x\n", links_of(&links))
    };
    assert!(read("a/msg/A", &chain(15, "NEXT next")).is_ok());
    assert_refused(&chain(16, "NEXT next"), "deeper");
    // Each level has twice the fields of the next.
    assert_refused(&chain(15, "NEXT x\nNEXT y\nNEXT z\n"), "too large");
}

fn links_of(text: &str) -> usize {
    text.matches("MSG:").count()
}

#[test]
fn a_deeply_nested_type_is_refused_in_any_order_of_use() {
    // The shallow use is first, so the type is finished when the deep use reaches it.
    let mut text = "a/T8 early\na/T0 first\n".to_owned();
    for n in 0..17 {
        text += &format!("===\nMSG: a/T{n}\na/T{} next\n", n + 1);
    }
    text += "===\nMSG: a/T17\nint8 x\n";
    assert_refused(&text, "deeper");
}

proptest! {
    #[test]
    fn random_types_are_read_back(value_type in types()) {
        assert_read_back(&value_type);
    }

    #[test]
    fn random_texts_do_not_panic(text in "([ -~]{0,12}\n?){0,40}") {
        let _ = read("a/msg/A", &text);
    }

    #[test]
    fn a_damaged_definition_does_not_panic(
        value_type in types(),
        at: prop::sample::Index,
        put in "[=#\\[\\]<a-c/ \n0-9]{0,6}",
    ) {
        let mut text = definition(&value_type);
        let at = at.index(text.len() + 1);
        text.replace_range(at..(at + 2).min(text.len()).max(at), &put);
        let _ = read(&value_type.name, &text);
    }
}
