//! Interfaces of ROS 2 as their definitions state them, with texts and sequences of any length: messages, services
//! and actions, their hashes (REP-2016), and their values in JSON. The values of schemas have a fixed size, and use
//! [`definition`](jde_ros::definition) and [`cdr`](jde_ros::cdr) instead.

mod parts;
mod standard;
mod values;

use std::collections::BTreeMap;

use hiroz_schema::{
    FieldDescription, FieldTypeDescription, TypeDescription, TypeDescriptionMsg, TypeId, calculate_hash,
};
use jde_abi::describe::Scalar;
use jde_ros::definition::scalar;
use serde_json::{Value, json};

use crate::hash::{number, placeholder};

pub use standard::{humble, standard};
pub use values::ValueError;

/// The line between the request and the response of a service.
const RULE: &str = "---";

/// Interfaces by their names, such as `std_srvs/srv/Trigger`.
#[derive(Clone, Debug, Default)]
pub struct Interfaces(BTreeMap<String, Vec<Member>>);

/// A field of a message.
#[derive(Clone, Debug)]
struct Member {
    name: String,
    kind: Kind,
    count: Count,
}

/// The type of a field's elements.
#[derive(Clone, Debug)]
enum Kind {
    /// The number, and the type's identifier in hashes, which distinguishes `byte` from `uint8`.
    Scalar(Scalar, u8),
    /// The greatest number of bytes, or 0 for any.
    Text(usize),
    Message(String),
}

/// The number of a field's elements.
#[derive(Clone, Copy, Debug)]
enum Count {
    One,
    Array(usize),
    /// The greatest number, or 0 for any.
    Sequence(usize),
}

/// A line that defines no field.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{interface}: `{line}`: {reason}")]
pub struct InterfaceError {
    /// The name of the interface.
    pub interface: String,
    /// The line.
    pub line: String,
    /// What is wrong.
    pub reason: &'static str,
}

impl Interfaces {
    /// Adds a message; the messages that it contains come before it. Constants and comments are skipped.
    ///
    /// # Errors
    /// [`InterfaceError`]. Wide texts are not supported.
    pub fn message(&mut self, name: &str, definition: &str) -> Result<(), InterfaceError> {
        let mut members = Vec::new();
        for line in definition.lines() {
            let error = |reason| InterfaceError {
                interface: name.to_owned(),
                line: line.to_owned(),
                reason,
            };
            let code = line.split_once('#').map_or(line, |(code, _)| code);
            let mut words = code.split_whitespace();
            let Some(kind) = words.next() else {
                continue;
            };
            let field = words.next().ok_or_else(|| error("expected a type and a name"))?;
            if field.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
                continue;
            }
            let (element, count) = split_kind(kind).map_err(error)?;
            let kind = self.kind(name, element).map_err(error)?;
            members.push(Member {
                name: field.to_owned(),
                kind,
                count,
            });
        }
        self.0.insert(name.to_owned(), members);
        Ok(())
    }

    /// Adds a service, and its messages `NAME_Request` and `NAME_Response`.
    ///
    /// # Errors
    /// [`InterfaceError`].
    pub fn service(&mut self, name: &str, definition: &str) -> Result<(), InterfaceError> {
        let mut lines = definition.lines();
        let request: Vec<_> = lines.by_ref().take_while(|line| line.trim() != RULE).collect();
        let response: Vec<_> = lines.collect();
        self.message(&format!("{name}_Request"), &request.join("\n"))?;
        self.message(&format!("{name}_Response"), &response.join("\n"))?;
        self.envelope(name)
    }

    /// Adds the messages of a service that contain its request and its response.
    fn envelope(&mut self, name: &str) -> Result<(), InterfaceError> {
        let short = name.replace("/srv/", "/").replace("/action/", "/");
        let event = format!(
            "service_msgs/ServiceEventInfo info\n{short}_Request[<=1] request\n{short}_Response[<=1] response"
        );
        self.message(&format!("{name}_Event"), &event)?;
        let whole = format!(
            "{short}_Request request_message\n{short}_Response response_message\n{short}_Event event_message"
        );
        self.message(name, &whole)
    }

    /// Adds an action: its messages `NAME_Goal`, `NAME_Result`, `NAME_Feedback` and `NAME_FeedbackMessage`, and its
    /// services `NAME_SendGoal` and `NAME_GetResult`.
    ///
    /// # Errors
    /// [`InterfaceError`].
    pub fn action(&mut self, name: &str, definition: &str) -> Result<(), InterfaceError> {
        let mut lines = definition.lines();
        for part in ["Goal", "Result", "Feedback"] {
            let own: Vec<_> = lines.by_ref().take_while(|line| line.trim() != RULE).collect();
            self.message(&format!("{name}_{part}"), &own.join("\n"))?;
        }
        let short = name.replace("/action/", "/");
        self.service(&format!("{name}_SendGoal"), &parts::send_goal(&short))?;
        self.service(&format!("{name}_GetResult"), &parts::get_result(&short))?;
        self.message(
            &format!("{name}_FeedbackMessage"),
            &parts::feedback_message(&short),
        )
    }

    /// Returns the hash of an interface, as in `RIHS01_eeff2cd6...`; `None` for one that was not added.
    #[must_use]
    pub fn hash(&self, name: &str) -> Option<String> {
        self.hash_with(name, BTreeMap::new())
    }

    /// Returns the description of an interface, a `type_description_interfaces/msg/TypeDescription`; `None` for one that
    /// was not added.
    #[must_use]
    pub fn description(&self, name: &str) -> Option<Value> {
        let whole = self.describe_with(name, BTreeMap::new())?;
        let others = whole.referenced_type_descriptions.iter();
        Some(json!({
            "type_description": description_of(&whole.type_description),
            "referenced_type_descriptions": others.map(description_of).collect::<Vec<_>>(),
        }))
    }

    /// Returns the hash of an interface that contains these parts.
    fn hash_with(&self, name: &str, parts: BTreeMap<String, TypeDescription>) -> Option<String> {
        let whole = self.describe_with(name, parts)?;
        Some(calculate_hash(&whole).to_rihs_string())
    }

    /// Returns the description of an interface that contains these parts.
    fn describe_with(
        &self,
        name: &str,
        mut parts: BTreeMap<String, TypeDescription>,
    ) -> Option<TypeDescriptionMsg> {
        self.describe(name, &mut parts);
        Some(TypeDescriptionMsg {
            type_description: parts.remove(name)?,
            referenced_type_descriptions: parts.into_values().collect(),
        })
    }

    /// Adds the descriptions of a message and of those that it contains, each once.
    fn describe(&self, name: &str, parts: &mut BTreeMap<String, TypeDescription>) {
        let Some(members) = self.0.get(name).filter(|_| !parts.contains_key(name)) else {
            return;
        };
        let mut fields: Vec<_> = members.iter().map(Member::describe).collect();
        if fields.is_empty() {
            fields.push(placeholder());
        }
        let type_name = name.to_owned();
        parts.insert(name.to_owned(), TypeDescription { type_name, fields });
        for member in members {
            if let Kind::Message(inner) = &member.kind {
                self.describe(inner, parts);
            }
        }
    }

    /// Finds the type of a field's elements. A message without a package is of that of the interface.
    fn kind(&self, interface: &str, element: &str) -> Result<Kind, &'static str> {
        if let Some(scalar) = scalar(element) {
            let id = if element == "byte" {
                TypeId::BYTE
            } else {
                number(scalar)
            };
            return Ok(Kind::Scalar(scalar, id));
        }
        if element == "string" {
            return Ok(Kind::Text(0));
        }
        if let Some(bound) = element.strip_prefix("string<=") {
            let bound = bound.parse().ok().filter(|bound| *bound > 0);
            return bound
                .map(Kind::Text)
                .ok_or("the bound of a text is a number from 1");
        }
        let package = interface.split('/').next().unwrap_or_default();
        let (package, name) = element.rsplit_once('/').unwrap_or((package, element));
        let package = package.trim_end_matches("/msg");
        ["msg", "srv", "action"]
            .iter()
            .map(|folder| format!("{package}/{folder}/{name}"))
            .find(|name| self.0.contains_key(name))
            .map(Kind::Message)
            .ok_or("this type is not defined before")
    }
}

impl Member {
    fn describe(&self) -> FieldDescription {
        let (kind, nested_type_name) = match &self.kind {
            Kind::Scalar(_, id) => (*id, String::new()),
            Kind::Text(0) => (TypeId::STRING, String::new()),
            Kind::Text(_) => (TypeId::BOUNDED_STRING, String::new()),
            Kind::Message(name) => (TypeId::NESTED_TYPE, name.clone()),
        };
        let string_capacity = match self.kind {
            Kind::Text(bound) => bound as u64,
            Kind::Scalar(..) | Kind::Message(_) => 0,
        };
        let (offset, capacity) = match self.count {
            Count::One => (0, 0),
            Count::Array(count) => (TypeId::ARRAY_OFFSET, count),
            Count::Sequence(0) => (TypeId::UNBOUNDED_SEQUENCE_OFFSET, 0),
            Count::Sequence(bound) => (TypeId::BOUNDED_SEQUENCE_OFFSET, bound),
        };
        FieldDescription {
            name: self.name.clone(),
            field_type: FieldTypeDescription {
                type_id: kind + offset,
                capacity: capacity as u64,
                string_capacity,
                nested_type_name,
            },
            default_value: String::new(),
        }
    }
}

fn description_of(part: &TypeDescription) -> Value {
    let fields = part.fields.iter().map(|field| {
        let kind = &field.field_type;
        json!({
            "name": field.name,
            "type": {
                "type_id": kind.type_id,
                "capacity": kind.capacity,
                "string_capacity": kind.string_capacity,
                "nested_type_name": kind.nested_type_name,
            },
        })
    });
    json!({ "type_name": part.type_name, "fields": fields.collect::<Vec<_>>() })
}

/// Splits a type such as `float64[<=4]` into that of its elements, and their number.
fn split_kind(kind: &str) -> Result<(&str, Count), &'static str> {
    let Some((element, rest)) = kind.split_once('[') else {
        return Ok((kind, Count::One));
    };
    let count = rest.strip_suffix(']').ok_or("a `]` is missing")?;
    let (is_bound, digits) = count
        .strip_prefix("<=")
        .map_or((false, count), |bound| (true, bound));
    if digits.is_empty() && !is_bound {
        return Ok((element, Count::Sequence(0)));
    }
    match digits.parse() {
        Ok(number) if number > 0 && is_bound => Ok((element, Count::Sequence(number))),
        Ok(number) if number > 0 => Ok((element, Count::Array(number))),
        _ => Err("the number of elements is a number from 1"),
    }
}

#[cfg(test)]
mod tests;
