//! Writes and reads the ROS 2 definition of a described type, in the form `ros2msg` of MCAP: the type's own
//! fields, then those of every type that it contains. Of services and actions it knows the parts, which are messages.

mod gather;
mod read;

pub use gather::{GatherError, gather, split};
pub use read::{ReadError, has_fields, read, read_interface};

use read::OF_ROS_1;
pub use read::scalar;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use jde_abi::describe::{Field, FieldKind, Form, Type};

/// The most elements or bytes of a field without a bound, unless something states another number.
pub const UNBOUNDED_CAPACITY: usize = 256;

/// The package of types whose names have none.
const PACKAGE: &str = "jde_msgs";
/// The line between two definitions.
const RULE: &str = "================================================================================";

/// Returns the name of a type's schema in the form of ROS 2: `package/msg/Type`, `package/srv/Type_Request` of the request
/// of a service, and `package/action/Type_Goal` of the goal of an action. Characters that a ROS name cannot have become `_`.
#[must_use]
pub fn name(value_type: &Type) -> String {
    let (package, name) = parts(&value_type.name);
    let stated = ["srv", "action"].into_iter().find(|folder| {
        let middle = value_type.name.split('/').nth(1);
        middle == Some(folder)
    });
    format!("{package}/{}/{name}", stated.unwrap_or("msg"))
}

/// Returns the full name of a type that definitions name `package/Type`. Names of messages have no `_` in ROS 2, and those
/// of parts of services and actions end with one and the part.
fn full(package: &str, name: &str) -> String {
    let is_action = |stem: &str| stem.ends_with("_SendGoal") || stem.ends_with("_GetResult");
    let folder = match name.rsplit_once('_') {
        Some((_, "Goal" | "Result" | "Feedback" | "FeedbackMessage")) => "action",
        Some((stem, "Request" | "Response" | "Event")) if is_action(stem) => "action",
        Some((_, "Request" | "Response" | "Event")) => "srv",
        _ => "msg",
    };
    format!("{package}/{folder}/{name}")
}

/// Returns the lines of a text, which end as on any system, without the byte order mark.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    text.lines().flat_map(|line| line.split('\r'))
}

/// Returns the definition of a type and of all types that it contains, with docs and units as comments.
///
/// Form: <https://mcap.dev/spec/registry#ros2msg>, and the interface definitions of ROS 2.
#[must_use]
pub fn definition(value_type: &Type) -> String {
    let mut text = String::new();
    let mut listed = BTreeSet::from([short(value_type)]);
    let mut pending = vec![value_type];
    while let Some(next) = pending.pop() {
        if !text.is_empty() {
            let _ = write!(text, "{RULE}\nMSG: {}\n", short(next));
        }
        write_fields(next, &mut text);
        let inner = next.fields.iter().filter_map(|field| match &field.kind {
            FieldKind::Struct(inner) if texts(field).is_none() => Some(&**inner),
            FieldKind::Struct(_) | FieldKind::Scalar(_) => None,
        });
        let new: Vec<_> = inner.filter(|inner| listed.insert(short(inner))).collect();
        pending.extend(new.into_iter().rev());
    }
    text
}

/// Returns the definition of the response that states how a goal has ended. `short` names the action as `package/NAME`.
#[must_use]
pub fn action_result(short: &str) -> String {
    format!(
        "# How it has ended: 4 succeeded, 5 canceled, 6 aborted, as in `action_msgs/msg/GoalStatus`.\nint8 status\n\
         # The result.\n{short}_Result result"
    )
}

/// Writes the type's own fields.
fn write_fields(value_type: &Type, text: &mut String) {
    if !value_type.doc.is_empty() {
        comment(&value_type.doc, "", text);
        text.push('\n');
    }
    for field in &value_type.fields {
        comment(&field.doc, &field.unit, text);
        let _ = writeln!(text, "{} {}", kind(field), field.name);
    }
}

fn kind(field: &Field) -> String {
    let element = match (&field.kind, texts(field)) {
        (FieldKind::Scalar(_), _) if field.notation.is_byte => "byte".to_owned(),
        (FieldKind::Scalar(scalar), _) => scalar.ros_name().to_owned(),
        (FieldKind::Struct(_), Some(capacity)) => format!("string<={capacity}"),
        (FieldKind::Struct(inner), None) => short(inner),
    };
    match field.form {
        Form::One => element,
        Form::Array(count) => format!("{element}[{count}]"),
        Form::Sequence { capacity, .. } => format!("{element}[<={capacity}]"),
        Form::Text { capacity, .. } => format!("string<={capacity}"),
    }
}

/// The structure whose lists are lists of texts in ROS 2. A message of one text is that text.
const TEXT: &str = "jde_msgs/msg/Name";

/// Returns the capacity of each text, if a field is a list of texts.
#[must_use]
pub fn texts(field: &Field) -> Option<usize> {
    match (&field.kind, field.form) {
        (FieldKind::Struct(inner), Form::Array(_) | Form::Sequence { .. }) if inner.name == TEXT => {
            inner.fields.first().map(|text| text.form.capacity())
        }
        _ => None,
    }
}

fn comment(doc: &str, unit: &str, text: &mut String) {
    let unit = match unit {
        "" => String::new(),
        unit => format!("[{unit}]"),
    };
    let last = doc.lines().count().saturating_sub(1);
    for (number, line) in doc.lines().enumerate() {
        let unit = if number == last { unit.as_str() } else { "" };
        let _ = writeln!(text, "{}", format!("# {line} {unit}").trim_end());
    }
    if doc.is_empty() && !unit.is_empty() {
        let _ = writeln!(text, "# {unit}");
    }
}

/// Returns the name of a type as in definitions: `package/Type`.
fn short(value_type: &Type) -> String {
    let (package, name) = parts(&value_type.name);
    format!("{package}/{name}")
}

fn parts(full: &str) -> (String, String) {
    let package = full.split_once('/').map_or(PACKAGE, |(package, _)| package);
    let name = full.rsplit_once('/').map_or(full, |(_, name)| name);
    (plain(package), plain(name))
}

fn plain(name: &str) -> String {
    let letter = |letter: char| {
        if letter.is_ascii_alphanumeric() {
            letter
        } else {
            '_'
        }
    };
    name.chars().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use jde_abi::describe::{RosNotation, Scalar};
    use jde_types::{Bumpers, Path, Twist, Value};

    use super::*;

    #[test]
    fn a_definition_has_the_type_and_then_each_contained_type_once() {
        let definition = definition(&Twist::describe());
        let mut parts = definition.split(RULE);
        let main = parts.next().unwrap();
        assert!(main.contains("\ngeometry_msgs/Vector3 linear\n"), "{main}");
        assert!(main.contains("\ngeometry_msgs/Vector3 angular\n"), "{main}");
        let vector = parts.next().unwrap();
        assert!(vector.starts_with("\nMSG: geometry_msgs/Vector3\n#"), "{vector}");
        assert!(vector.ends_with("float64 z\n"), "{vector}");
        assert_eq!(parts.next(), None);
    }

    #[test]
    fn capacities_are_bounds_and_padding_is_omitted() {
        let bumpers = definition(&Bumpers::describe());
        assert!(bumpers.contains("\nbool[<=8] front\n"), "{bumpers}");
        assert!(bumpers.contains("\nbool stalled\n"), "{bumpers}");
        assert!(!bumpers.contains("padding"), "{bumpers}");
        assert!(bumpers.contains("MSG: builtin_interfaces/Time\n"), "{bumpers}");
        assert!(bumpers.contains("\nstring<=52 frame_id\n"), "{bumpers}");
        assert!(definition(&<[f64; 3]>::describe()).contains("\nfloat64[3] data\n"));
    }

    #[test]
    fn every_nested_type_is_defined() {
        for value_type in jde_types::standard() {
            let text = definition(&value_type);
            let defined: BTreeSet<&str> = text
                .lines()
                .filter_map(|line| line.strip_prefix("MSG: "))
                .collect();
            for line in text.lines().filter(|line| !line.starts_with(['#', '=', 'M'])) {
                let kind = line.split(['[', ' ']).next().unwrap();
                assert!(!kind.contains('/') || defined.contains(kind), "{kind} in {text}");
            }
        }
        assert_eq!(name(&Path::describe()), "nav_msgs/msg/Path");
    }

    #[test]
    fn a_unit_follows_the_last_line_of_a_comment() {
        let field = |doc: &str, unit: &str| Field {
            name: "gap".to_owned(),
            doc: doc.to_owned(),
            unit: unit.to_owned(),
            kind: FieldKind::Scalar(Scalar::F32),
            form: Form::One,
            offset: 0,
            notation: RosNotation::default(),
        };
        let definition_of = |field: Field| {
            definition(&Type {
                name: "near by".to_owned(),
                doc: String::new(),
                bytes: 4,
                align: 4,
                fields: vec![field],
            })
        };
        assert_eq!(
            definition_of(field("How near.\nRoughly.", "m")),
            "# How near.\n# Roughly. [m]\nfloat32 gap\n"
        );
        assert_eq!(definition_of(field("", "m")), "# [m]\nfloat32 gap\n");
        assert_eq!(definition_of(field("", "")), "float32 gap\n");
    }

    #[test]
    fn a_name_without_a_package_gets_the_package_of_jde() {
        let mut value_type = Twist::describe();
        value_type.name = "near by".to_owned();
        assert_eq!(name(&value_type), "jde_msgs/msg/near_by");
        value_type.name = "my-plugin/Gap".to_owned();
        assert_eq!(name(&value_type), "my_plugin/msg/Gap");
    }

    #[test]
    fn parts_of_services_and_actions_have_a_folder_of_their_own() {
        for expected in [
            "a/msg/Goal",
            "a/srv/Go_Request",
            "a/srv/Go_Event",
            "a/action/Go_Goal",
            "a/action/Go_FeedbackMessage",
            "a/action/Go_GetResult_Response",
        ] {
            let own = expected.rsplit_once('/').unwrap().1;
            assert_eq!(full("a", own), expected);
            let value_type = Type {
                name: expected.to_owned(),
                ..Twist::describe()
            };
            assert_eq!(name(&value_type), expected);
        }
    }
}
