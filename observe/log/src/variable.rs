//! The variables of a recording, as its channels describe them, and the topics that are none.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, LazyLock};

use jde_abi::describe::Type;
use jde_files::{Budget, LeftOut};
use jde_ros::{cdr, definition};
use jde_types::Value;

use crate::turns::TURNS_TOPIC;
use crate::{Channel, RecordedMessage, Recording, common, foreign, log_line, panel, record};

/// The largest value of a type whose capacities no recording states, bytes.
const MOST_BYTES: usize = 16 << 20;
/// What the description of a field takes, bytes.
const FIELD_BYTES: usize = 256;

/// A variable of a recording.
#[derive(Clone)]
pub struct RecordedVariable {
    /// Its topic: `/pioneer/laser`.
    pub topic: String,
    /// Its full name.
    pub name: String,
    /// `export`, `modulation` or `command`.
    pub access: String,
    /// Its type.
    pub value_type: Arc<Type>,
    /// What it means.
    pub doc: String,
    /// Unit of a plain number.
    pub unit: String,
    /// Whether another program has written it, which knows no capacities.
    is_foreign: bool,
}

/// Returns the topic of a variable, `owner.name`: `/owner/name`, a name of ROS 2.
#[must_use]
pub fn topic_name(variable: &str) -> String {
    format!("/{}", variable.replace('.', "/"))
}

/// The variables of a recording, and the report of what of it cannot be read.
pub struct RecordedVariables {
    list: Vec<RecordedVariable>,
    /// The variable of each channel. Several channels of one topic are one variable if they have the same type.
    of_channels: Vec<Option<usize>>,
    left_out: LeftOut,
}

impl RecordedVariable {
    /// Reads a channel's metadata. `value_type` is the type of its values.
    #[must_use]
    pub fn of(channel: &Channel, value_type: Type) -> Self {
        Self::new(channel, Arc::new(value_type), false)
    }

    fn new(channel: &Channel, value_type: Arc<Type>, is_foreign: bool) -> Self {
        let metadata = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
        let name = match metadata("variable") {
            // Recordings of other programs have topics instead of variables.
            name if name.is_empty() => channel.topic.trim_start_matches('/').replace('/', "."),
            name => name,
        };
        let access = match metadata("access") {
            access if access.is_empty() => "export".to_owned(),
            access => access,
        };
        Self {
            topic: channel.topic.clone(),
            name,
            access,
            value_type,
            doc: metadata("doc"),
            unit: metadata("unit"),
            is_foreign,
        }
    }

    /// Returns whether another program has written it, which knows no capacities.
    #[must_use]
    pub const fn is_foreign(&self) -> bool {
        self.is_foreign
    }

    /// Returns the variable with values of another type, which has the same fields and other capacities.
    #[must_use]
    pub fn with_type(&self, value_type: Type) -> Self {
        Self {
            value_type: Arc::new(value_type),
            ..self.clone()
        }
    }

    /// Returns the value of a message, as a value of a type with the same fields and perhaps other capacities.
    ///
    /// # Errors
    /// As for [`Self::decode_into`].
    pub fn decode_as<T: Value>(
        &self,
        message: &[u8],
        left_out: &mut LeftOut,
    ) -> Result<Option<T>, foreign::Error> {
        let bytes = self.with_type(T::describe()).decode(message, left_out)?;
        Ok(T::from_bytes(&bytes))
    }

    /// Replaces a value by that of a message. Messages of other programs may have more than there is room for: the beams of
    /// a scan are merged, texts are cut, and pictures become those that schemas read. What is cut is added to `left_out`.
    ///
    /// # Errors
    /// Why the message is no value. The contents of `value` are unspecified then.
    ///
    /// # Panics
    /// If there are not as many bytes as the type has.
    pub fn decode_into(
        &self,
        message: &[u8],
        value: &mut [u8],
        left_out: &mut LeftOut,
    ) -> Result<(), foreign::Error> {
        if !self.is_foreign {
            return Ok(cdr::decode_into(&self.value_type, message, value)?);
        }
        foreign::decode_into(&self.value_type, message, value, &mut |field, capacity| {
            left_out.add(
                format_args!("the end of `{field}` in {}", self.topic),
                None,
                format_args!("it has room for {capacity} bytes"),
            );
        })
    }

    /// Returns the value of a message, as [`Self::decode_into`] does.
    ///
    /// # Errors
    /// As for that.
    pub fn decode(&self, message: &[u8], left_out: &mut LeftOut) -> Result<Vec<u8>, foreign::Error> {
        let mut value = vec![0; self.value_type.bytes];
        self.decode_into(message, &mut value, left_out)?;
        Ok(value)
    }
}

impl RecordedVariables {
    /// Finds the variables of a recording whose values can be decoded, in the order of their topics.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let mut types = Types::default();
        let mut left_out = recording.left_out().clone();
        let is_foreign = recording.metadata("jde").is_none();
        let mut by_topic: BTreeMap<&str, RecordedVariable> = BTreeMap::new();
        let mut topics = Vec::new();
        for channel in recording.channels() {
            let mut topic = None;
            if is_variable(channel) {
                match types.of(channel) {
                    Err(reason) => left_out.add(described(channel), None, reason),
                    Ok(value_type) => match by_topic.get(channel.topic.as_str()) {
                        Some(known) if !is_same(&known.value_type, &value_type) => left_out.add(
                            described(channel),
                            None,
                            format_args!(
                                "the topic also has messages of {}, which are read",
                                definition::name(&known.value_type)
                            ),
                        ),
                        Some(_) => topic = Some(channel.topic.as_str()),
                        None => {
                            by_topic.insert(
                                &channel.topic,
                                RecordedVariable::new(channel, value_type, is_foreign),
                            );
                            topic = Some(channel.topic.as_str());
                        }
                    },
                }
            }
            topics.push(topic);
        }
        // Topics that differ only in their slashes have one name, which is that of the first.
        let mut names = HashMap::new();
        by_topic.retain(
            |topic, variable| match names.insert(variable.name.clone(), *topic) {
                _ if variable.name.is_empty() => {
                    left_out.add("a topic without a name", None, "a variable has one");
                    false
                }
                None => true,
                Some(first) => {
                    left_out.add(
                        topic,
                        None,
                        format_args!("{first} is called `{}`, too", variable.name),
                    );
                    names.insert(variable.name.clone(), first);
                    false
                }
            },
        );
        let places: HashMap<&str, usize> = by_topic
            .keys()
            .enumerate()
            .map(|(place, topic)| (*topic, place))
            .collect();
        let of_channels = topics
            .into_iter()
            .map(|topic| places.get(topic?).copied())
            .collect();
        Self {
            of_channels,
            list: by_topic.into_values().collect(),
            left_out,
        }
    }

    /// Returns the variables, in the order of their topics.
    pub fn iter(&self) -> impl Iterator<Item = &RecordedVariable> + Clone {
        self.list.iter()
    }

    /// Returns whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Returns the variable of a channel of the recording. `None` if it is none, or cannot be read.
    #[must_use]
    pub fn get(&self, channel: &Channel) -> Option<&RecordedVariable> {
        let place = (*self.of_channels.get(channel.index)?)?;
        self.list.get(place)
    }

    /// Returns what of the recording cannot be read: files and topics.
    #[must_use]
    pub const fn left_out(&self) -> &LeftOut {
        &self.left_out
    }

    /// Adds to a report what of a message cannot be read. Own recordings have the values of their types.
    pub fn check(&self, message: &RecordedMessage, value: &mut Vec<u8>, left_out: &mut LeftOut) {
        let Some(variable) = self.get(&message.channel).filter(|variable| variable.is_foreign) else {
            return;
        };
        if value.len() < variable.value_type.bytes {
            // Zeros from the system take no memory until they are written.
            *value = vec![0; variable.value_type.bytes];
        }
        let value = &mut value[..variable.value_type.bytes];
        if let Err(reason) = variable.decode_into(&message.data, value, left_out) {
            left_out.add_again(format_args!("a message of {}", variable.topic), reason);
        }
    }
}

/// Whether values of two types have the same bytes.
fn is_same(one: &Arc<Type>, other: &Arc<Type>) -> bool {
    Arc::ptr_eq(one, other) || (one.name == other.name && one.difference(other).is_none())
}

fn described(channel: &Channel) -> String {
    match channel.type_name.as_str() {
        "" => channel.topic.clone(),
        name => format!("{} ({name})", channel.topic),
    }
}

/// The types of channels, each read once, within a budget.
#[derive(Default)]
struct Types<'a> {
    budget: Budget,
    known: HashMap<TypeKey<'a>, Result<Arc<Type>, String>>,
}

/// The name of a type, two encodings, and the object that is its definition.
type TypeKey<'a> = (&'a str, &'a str, &'a str, usize);

impl<'a> Types<'a> {
    fn of(&mut self, channel: &'a Channel) -> Result<Arc<Type>, String> {
        let key = (
            channel.type_name.as_str(),
            channel.definition_encoding.as_str(),
            channel.encoding.as_str(),
            channel.definition.as_ptr() as usize,
        );
        let budget = &mut self.budget;
        let read = || {
            let value_type = value_type(channel)?;
            let held = budget.hold(fields(&value_type) * FIELD_BYTES);
            held.map_err(|error| format!("with its type, {error}"))?;
            Ok(Arc::new(value_type))
        };
        self.known.entry(key).or_insert_with(read).clone()
    }
}

fn fields(value_type: &Type) -> usize {
    let fields = value_type.fields.iter().map(|field| match &field.kind {
        jde_abi::describe::FieldKind::Struct(inner) => 1 + fields(inner),
        jde_abi::describe::FieldKind::Scalar(_) => 1,
    });
    1 + fields.sum::<usize>()
}

/// Returns the type of the values of a channel: the one that its definition describes. If that has fields without a bound, as
/// in ROS 2, it is the standard type of the same name and fields, or one with the usual capacity of these fields. A type
/// without a definition is the standard or common one of its name.
///
/// # Errors
/// Why its values cannot be decoded.
pub fn value_type(channel: &Channel) -> Result<Type, String> {
    if channel.encoding != "cdr" {
        return Err(format!("its messages are in `{}`, not in CDR", channel.encoding));
    }
    let text = String::from_utf8_lossy(&channel.definition);
    let read = match channel.definition_encoding.as_str() {
        "ros2msg" => definition::read(&channel.type_name, &text).map_err(|error| error.to_string()),
        "" => Err("the recording contains no definition of it".to_owned()),
        other => Err(format!("its definition is in `{other}`, not in `ros2msg`")),
    };
    read.or_else(|reason| {
        let Some(standard) = standard(&channel.type_name) else {
            if channel.definition_encoding != "ros2msg" {
                let common = common::definition_of(&channel.type_name).ok_or(reason)?;
                return foreign_type(&channel.type_name, &common);
            }
            return foreign_type(&channel.type_name, &text);
        };
        if channel.definition_encoding == "ros2msg" && !definition::has_fields(&text, standard) {
            return Err("its fields are not those of the standard type of this name".to_owned());
        }
        Ok(standard.clone())
    })
}

/// Returns the standard type of a name as ROS 2 has it.
fn standard(name: &str) -> Option<&'static Type> {
    static STANDARD: LazyLock<HashMap<String, Type>> = LazyLock::new(|| {
        let types = jde_types::standard().into_iter();
        types
            .map(|standard| (definition::name(&standard), standard))
            .collect()
    });
    STANDARD.get(name)
}

/// Returns a type that is none of jde's, with the usual capacity of fields without a bound. What it contains is of the
/// standard type of the same name if that has the recorded fields.
fn foreign_type(name: &str, text: &str) -> Result<Type, String> {
    let recorded = definition::split(name, text);
    let read = |inner: &str| {
        let standard = standard(inner)?;
        let find = |name: &str| Ok(recorded.get(name).cloned());
        let own = definition::gather(inner, find, |_| false).ok()?;
        definition::has_fields(&own, standard).then(|| Arc::new(standard.clone()))
    };
    let seen = std::cell::RefCell::new(HashMap::new());
    let known = |inner: &str| {
        let found = seen.borrow().get(inner).cloned();
        found.unwrap_or_else(|| {
            let found: Option<Arc<Type>> = read(inner);
            seen.borrow_mut().insert(inner.to_owned(), found.clone());
            found
        })
    };
    let capacity = |_: &str| definition::UNBOUNDED_CAPACITY;
    let found = definition::read_interface(name, text, capacity, known).map_err(|error| error.to_string())?;
    match found.bytes <= MOST_BYTES {
        true => Ok(found),
        false => Err(format!(
            "with room for {} elements of each field without a bound it has {} MB, and at most {} MB are played",
            definition::UNBOUNDED_CAPACITY,
            found.bytes >> 20,
            MOST_BYTES >> 20
        )),
    }
}

/// Whether a channel contains values, instead of what a run reports of itself.
fn is_variable(channel: &Channel) -> bool {
    channel.topic != TURNS_TOPIC
        && record::kind(channel).is_none()
        && panel::schema(channel).is_none()
        && !log_line::is_log(channel)
}
