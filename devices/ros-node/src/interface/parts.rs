//! Hashes of services and actions whose parts are values of described types.

use std::collections::BTreeMap;

use hiroz_schema::TypeDescription;
use jde_abi::describe::{FieldKind, Scalar};
use jde_ros::Type;
use jde_ros::definition::{self, action_result};

use super::{InterfaceError, Interfaces, RULE, standard};
use crate::hash::{describe_type, referenced};

/// What envelopes contain besides the parts.
const AROUND: [&str; 3] = [
    "builtin_interfaces/msg/Time",
    "service_msgs/msg/ServiceEventInfo",
    "unique_identifier_msgs/msg/UUID",
];

impl Interfaces {
    /// Returns the hash of a service whose request and response are values of these types, which are named
    /// `NAME_Request` and `NAME_Response`; `None` if they are not.
    #[must_use]
    pub fn service_hash(name: &str, request: &Type, response: &Type) -> Option<String> {
        Self::hash_around(&[request, response], name, |interfaces| interfaces.envelope(name))
    }

    /// Returns the hashes of an action's services for goals and results and of the messages of its feedback. The types are
    /// named `NAME_Goal`, `NAME_GetResult_Response` and `NAME_Feedback`; `None` if they are not, or if the second has other
    /// fields than `int8 status` and a `NAME_Result`.
    #[must_use]
    pub fn action_hashes(name: &str, goal: &Type, result: &Type, feedback: &Type) -> Option<[String; 3]> {
        let [status, inner] = result.fields.as_slice() else {
            return None;
        };
        let own = format!("{name}_Result");
        let is_own =
            |inner: &FieldKind| matches!(inner, FieldKind::Struct(inner) if definition::name(inner) == own);
        if status.name != "status" || status.kind != FieldKind::Scalar(Scalar::I8) || !is_own(&inner.kind) {
            return None;
        }
        let [send, get, message] =
            ["SendGoal", "GetResult", "FeedbackMessage"].map(|part| format!("{name}_{part}"));
        let short = name.replace("/action/", "/");
        Some([
            Self::hash_around(&[goal], &send, |interfaces| {
                interfaces.service(&send, &send_goal(&short))
            })?,
            Self::hash_around(&[result], &get, |interfaces| {
                interfaces.message(&format!("{get}_Request"), ID)?;
                interfaces.envelope(&get)
            })?,
            Self::hash_around(&[feedback], &message, |interfaces| {
                interfaces.message(&message, &feedback_message(&short))
            })?,
        ])
    }

    /// Returns the hash of an interface that `define` adds and that contains values of these types; `None` if it does not
    /// find them.
    fn hash_around(
        types: &[&Type],
        name: &str,
        define: impl FnOnce(&mut Self) -> Result<(), InterfaceError>,
    ) -> Option<String> {
        let around = standard()
            .0
            .iter()
            .filter(|(name, _)| AROUND.contains(&name.as_str()));
        let mut interfaces = Self(
            around
                .map(|(name, members)| (name.clone(), members.clone()))
                .collect(),
        );
        let mut parts: BTreeMap<String, TypeDescription> = BTreeMap::new();
        for value_type in types {
            referenced(value_type, &mut parts);
            let name = definition::name(value_type);
            // Its description is that of the type.
            interfaces.0.insert(name.clone(), Vec::new());
            parts.insert(name, describe_type(value_type));
        }
        define(&mut interfaces).ok()?;
        interfaces.hash_with(name, parts)
    }
}

/// The field that identifies a goal.
const ID: &str = "unique_identifier_msgs/UUID goal_id";

/// The definition of an action's service for goals. `short` names the action as `package/NAME`.
pub(super) fn send_goal(short: &str) -> String {
    format!("{ID}\n{short}_Goal goal\n{RULE}\nbool accepted\nbuiltin_interfaces/Time stamp")
}

/// The definition of an action's service for results.
pub(super) fn get_result(short: &str) -> String {
    format!("{ID}\n{RULE}\n{}", action_result(short))
}

/// The definition of a message of an action's feedback.
pub(super) fn feedback_message(short: &str) -> String {
    format!("{ID}\n{short}_Feedback feedback")
}
