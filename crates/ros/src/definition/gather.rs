//! Collects the definition of a message from files that define one message each, as ROS 2 installs them, and gives its
//! texts and sequences the bounds that a shared value needs.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::{RULE, parts, scalar};

/// Why a definition cannot be collected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GatherError {
    /// There is no definition of a message.
    #[error("`{0}` is not defined")]
    Missing(String),
    /// It contains too many messages.
    #[error("it contains more than {MOST} messages")]
    Large,
}

/// The most messages of a definition.
const MOST: usize = 256;

/// Returns the definition of a message and of all that it contains, which [`read`](super::read()) takes. `find` returns
/// the text of a message's own file by its name, such as `std_msgs/msg/Header`. `capacity` returns the most elements or
/// bytes of a field without a bound.
///
/// # Errors
/// [`GatherError`].
pub fn gather(
    name: &str,
    mut find: impl FnMut(&str) -> Option<String>,
    capacity: impl Fn(&str) -> usize,
) -> Result<String, GatherError> {
    let mut text = String::new();
    let mut listed = BTreeSet::from([name.to_owned()]);
    let mut pending = vec![name.to_owned()];
    while let Some(next) = pending.pop() {
        let own = find(&next).ok_or_else(|| GatherError::Missing(next.clone()))?;
        if !text.is_empty() {
            let _ = writeln!(text, "{RULE}\nMSG: {}", next.replace("/msg/", "/"));
        }
        let package = parts(&next).0;
        for line in own.lines() {
            let Some((element, bounded)) = field(line, &capacity) else {
                text.push_str(line);
                text.push('\n');
                continue;
            };
            text.push_str(&bounded);
            text.push('\n');
            if scalar(element).is_some() || ["string", "wstring"].contains(&element) {
                continue;
            }
            let (stated, short) = element.rsplit_once('/').unwrap_or((&package, element));
            let inner = format!("{}/msg/{short}", stated.trim_end_matches("/msg"));
            if listed.insert(inner.clone()) {
                pending.push(inner);
            }
        }
        if listed.len() > MOST {
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
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.len() < 3 || line.bytes().any(|byte| byte != b'=') {
            own.push_str(line);
            own.push('\n');
            continue;
        }
        let next = lines.next().unwrap_or_default();
        let (package, short) = parts(next.trim_start_matches("MSG:").trim());
        messages.insert(
            core::mem::replace(&mut name, format!("{package}/msg/{short}")),
            core::mem::take(&mut own),
        );
    }
    messages.insert(name, own);
    messages
}

/// Returns the type of a field's elements, and the field's line with a bound. `None` for a line without a field.
fn field<'l>(line: &'l str, capacity: &impl Fn(&str) -> usize) -> Option<(&'l str, String)> {
    let code = line.split_once('#').map_or(line, |(code, _)| code);
    let mut words = code.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return None;
    }
    let element = kind.split(['[', '<']).next()?;
    let list = kind.strip_prefix(element)?;
    let is_text = element == "string" && !list.starts_with("<=");
    if !is_text && !list.ends_with("[]") {
        return Some((element, line.to_owned()));
    }
    let bound = format!("<={}", capacity(name));
    let text = if is_text { bound.as_str() } else { "" };
    let list = list.replace("[]", &format!("[{bound}]"));
    Some((element, format!("{element}{text}{list} {name}")))
}

#[cfg(test)]
mod tests {
    use super::super::{read, texts};
    use super::*;

    fn find(name: &str) -> Option<String> {
        let text = match name {
            "my_msgs/msg/Cloud" => {
                "# Points.\nuint8 MOST=3\nstd_msgs/Header header\nPoint[] points\nstring name # who\nstring[] words\nstring<=8[] short\nfloat32[4] plane 0 0 0 1\n"
            }
            "my_msgs/msg/Point" => "float64 x\nfloat64 y\n",
            "std_msgs/msg/Header" => "builtin_interfaces/msg/Time stamp\nstring<=20 frame_id\n",
            "builtin_interfaces/msg/Time" => "int32 sec\nuint32 nanosec\n",
            "my_msgs/msg/Odd" => "my_msgs/Nothing what\n",
            _ => return None,
        };
        Some(text.to_owned())
    }

    #[test]
    fn a_message_is_collected_with_what_it_contains_and_bounds() {
        let capacity = |field: &str| if field == "points" { 100 } else { 16 };
        let text = gather("my_msgs/msg/Cloud", find, capacity).unwrap();
        let cloud = read("my_msgs/msg/Cloud", &text).unwrap();
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
        assert_eq!(text.matches("MSG: ").count(), 3);
    }

    #[test]
    fn the_messages_of_a_definition_are_those_that_were_collected() {
        let text = gather("my_msgs/msg/Cloud", find, |_| 16).unwrap();
        let messages = split("my_msgs/msg/Cloud", &text);
        assert_eq!(messages.len(), 4);
        let again = gather("my_msgs/msg/Cloud", |name| messages.get(name).cloned(), |_| 1);
        assert_eq!(again, Ok(text));
    }

    #[test]
    fn a_message_that_is_not_defined_is_named() {
        let error = gather("my_msgs/msg/Odd", find, |_| 1).unwrap_err();
        assert_eq!(error, GatherError::Missing("my_msgs/msg/Nothing".to_owned()));
    }
}
