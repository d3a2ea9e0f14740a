//! Collects the definition of a message from files that define one message each, as ROS 2 installs them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::{OF_ROS_1, RULE, full, lines, parts, scalar};

/// Why a definition cannot be collected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GatherError {
    /// There is no definition of a message.
    #[error("`{0}` is not defined")]
    Missing(String),
    /// There is no definition of a message that another one contains.
    #[error("`{name}` is not defined, and `{user}` contains it")]
    Part {
        /// Its name.
        name: String,
        /// The name of the one that contains it.
        user: String,
    },
    /// The file of a message cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// It contains too many messages.
    #[error("it contains more than {MAX_MESSAGES} messages")]
    Large,
}

/// The most messages of a definition.
const MAX_MESSAGES: usize = 256;

/// Returns the definition of a message and of all that it contains, which [`read_interface`](super::read_interface()) takes.
/// `find` returns the text of a message's own file by its name, such as `std_msgs/msg/Header`, or why that cannot be read.
/// Definitions of messages that are `known` are left out.
///
/// # Errors
/// [`GatherError`].
pub fn gather(
    name: &str,
    mut find: impl FnMut(&str) -> Result<Option<String>, String>,
    known: impl Fn(&str) -> bool,
) -> Result<String, GatherError> {
    let mut text = String::new();
    let mut listed = BTreeSet::from([name.to_owned()]);
    let mut pending = vec![(name.to_owned(), None)];
    while let Some((next, user)) = pending.pop() {
        let own = find(&next).map_err(GatherError::Unreadable)?;
        let own = own.ok_or_else(|| match user {
            None => GatherError::Missing(next.clone()),
            Some(user) => GatherError::Part {
                name: next.clone(),
                user,
            },
        })?;
        if !text.is_empty() {
            let (package, own) = parts(&next);
            let _ = writeln!(text, "{RULE}\nMSG: {package}/{own}");
        }
        text.push_str(own.trim_start_matches('\u{feff}'));
        if !own.ends_with('\n') {
            text.push('\n');
        }
        let package = parts(&next).0;
        for element in lines(&own).filter_map(element) {
            // What is no type of ROS 2 has an error with its line when it is read.
            let is_plain = ["string", "wstring"].contains(&element) || OF_ROS_1.contains(&element);
            if is_plain || scalar(element).is_some() {
                continue;
            }
            let (stated, short) = element.rsplit_once('/').unwrap_or((&package, element));
            let inner = full(stated.trim_end_matches("/msg"), short);
            if !known(&inner) && listed.insert(inner.clone()) {
                pending.push((inner, Some(next.clone())));
            }
        }
        if listed.len() > MAX_MESSAGES {
            return Err(GatherError::Large);
        }
    }
    Ok(text)
}

/// Returns the messages of a definition, each by its name with its own text, as `find` of [`gather`] does.
#[must_use]
pub fn split(name: &str, text: &str) -> BTreeMap<String, String> {
    let mut messages = BTreeMap::new();
    let (mut name, mut own) = (name.to_owned(), String::new());
    let mut lines = lines(text);
    while let Some(line) = lines.next() {
        if line.len() < 3 || line.bytes().any(|byte| byte != b'=') {
            own.push_str(line);
            own.push('\n');
            continue;
        }
        let next = lines.next().unwrap_or_default();
        let (package, short) = parts(next.trim_start_matches("MSG:").trim());
        messages.insert(
            core::mem::replace(&mut name, full(&package, &short)),
            core::mem::take(&mut own),
        );
    }
    messages.insert(name, own);
    messages
}

/// Returns the type of a field's elements. `None` for a line without a field.
fn element(line: &str) -> Option<&str> {
    let code = line.split_once('#').map_or(line, |(code, _)| code);
    let mut words = code.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return None;
    }
    kind.split(['[', '<']).next()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use jde_types::Value as _;

    use super::super::{read_interface, texts};
    use super::*;

    #[expect(clippy::unnecessary_wraps, reason = "`gather` takes it")]
    fn find(name: &str) -> Result<Option<String>, String> {
        let text = match name {
            "my_msgs/msg/Cloud" => {
                "# Points.\nuint8 MOST=3\nstd_msgs/Header header\nPoint[] points\nstring name # who\nstring[] words\nstring<=8[] short\nfloat32[4] plane 0 0 0 1\n"
            }
            "my_msgs/msg/Point" => "float64 x\nfloat64 y\n",
            "std_msgs/msg/Header" => "builtin_interfaces/msg/Time stamp\nstring<=20 frame_id\n",
            "builtin_interfaces/msg/Time" => "int32 sec\nuint32 nanosec\n",
            "my_msgs/msg/Odd" => "my_msgs/Nothing what\n",
            _ => return Ok(None),
        };
        Ok(Some(text.to_owned()))
    }

    #[test]
    fn a_message_is_collected_with_what_it_contains_and_is_not_known() {
        let capacity = |field: &str| if field == "points" { 100 } else { 16 };
        let is_known = |name: &str| name == "std_msgs/msg/Header";
        let known = |name: &str| is_known(name).then(|| Arc::new(jde_types::Header::describe()));
        let text = gather("my_msgs/msg/Cloud", find, is_known).unwrap();
        let cloud = read_interface("my_msgs/msg/Cloud", &text, capacity, known).unwrap();
        let fields: Vec<_> = cloud
            .fields
            .iter()
            .map(|field| (&*field.name, field.form.capacity()))
            .collect();
        assert_eq!(
            fields,
            [
                ("header", 1),
                ("points", 100),
                ("name", 16),
                ("words", 16),
                ("short", 16),
                ("plane", 4)
            ]
        );
        assert_eq!([3, 4].map(|list| texts(&cloud.fields[list])), [Some(16), Some(8)]);
        assert_eq!(text.matches("MSG: ").count(), 1);
    }

    #[test]
    fn the_messages_of_a_definition_are_those_that_were_collected() {
        let text = gather("my_msgs/msg/Cloud", find, |_| false).unwrap();
        let messages = split("my_msgs/msg/Cloud", &text);
        assert_eq!(messages.len(), 4);
        let again = gather(
            "my_msgs/msg/Cloud",
            |name| Ok(messages.get(name).cloned()),
            |_| false,
        );
        assert_eq!(again, Ok(text));
    }

    #[test]
    fn a_message_that_is_not_defined_or_not_readable_is_named() {
        let error = |name: &str| gather(name, find, |_| false).unwrap_err().to_string();
        assert_eq!(error("my_msgs/msg/None"), "`my_msgs/msg/None` is not defined");
        assert_eq!(
            error("my_msgs/msg/Odd"),
            "`my_msgs/msg/Nothing` is not defined, and `my_msgs/msg/Odd` contains it"
        );
        let unreadable = gather(
            "a/msg/A",
            |_| Err("A.msg: it is not a regular file".to_owned()),
            |_| false,
        );
        assert_eq!(
            unreadable.unwrap_err().to_string(),
            "A.msg: it is not a regular file"
        );
    }
}
