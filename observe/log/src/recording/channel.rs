//! The channels of a recording. Those of all its files that are the same are one, and share their definitions: a file of a few
//! bytes may name a definition many times.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

use jde_files::{Budget, Exceeded};

/// What a channel takes besides its texts, in bytes.
const CHANNEL_BYTES: usize = 512;
/// What a file takes for each of its channels, in bytes.
const ENTRY_BYTES: usize = 64;

/// The description of a topic's messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The name of the topic: `/pioneer/laser`.
    pub topic: String,
    /// The name of the type: `sensor_msgs/msg/LaserScan`.
    pub type_name: String,
    /// The encoding of the definition: `ros2msg`, `jsonschema`.
    pub definition_encoding: String,
    /// The definition.
    pub definition: Arc<[u8]>,
    /// The encoding of the messages: `cdr`, `json`.
    pub encoding: String,
    /// The channel's metadata: `variable`, `access`, `doc`, `unit`.
    pub metadata: BTreeMap<String, String>,
    /// Its position among the channels of the recording.
    pub(crate) index: usize,
}

/// What distinguishes channels. Equal definitions are one object.
type Key = (String, String, String, usize, String, BTreeMap<String, String>);

/// All channels, in the order in which they were found.
#[derive(Default)]
pub(super) struct Channels {
    list: Vec<Arc<Channel>>,
    by_content: HashMap<Key, usize>,
    definitions: HashSet<Arc<[u8]>>,
}

/// Adds the channels of a file, each of whose definitions is compared with others once.
pub(super) struct FileChannels<'a> {
    channels: &'a mut Channels,
    definitions: HashMap<u16, Arc<[u8]>>,
}

impl Channels {
    pub(super) fn iter(&self) -> impl Iterator<Item = &Channel> {
        self.list.iter().map(|channel| &**channel)
    }

    pub(super) fn definitions_of_file(&mut self) -> FileChannels<'_> {
        FileChannels {
            channels: self,
            definitions: HashMap::new(),
        }
    }

    /// Adds a channel, or returns an equal one that was added before.
    ///
    /// # Errors
    /// The channels need too much memory.
    pub(super) fn add(
        &mut self,
        mut channel: Channel,
        budget: &mut Budget,
    ) -> Result<Arc<Channel>, Exceeded> {
        channel.definition = self.definition(&channel.definition, budget)?;
        self.add_shared(channel, budget)
    }

    /// As [`Self::add`], for a channel whose definition comes from [`Self::definition`].
    fn add_shared(&mut self, mut channel: Channel, budget: &mut Budget) -> Result<Arc<Channel>, Exceeded> {
        budget.hold(ENTRY_BYTES)?;
        let key = (
            channel.topic.clone(),
            channel.type_name.clone(),
            channel.definition_encoding.clone(),
            channel.definition.as_ptr() as usize,
            channel.encoding.clone(),
            channel.metadata.clone(),
        );
        if let Some(index) = self.by_content.get(&key) {
            return Ok(Arc::clone(&self.list[*index]));
        }
        let texts = [
            &channel.topic,
            &channel.type_name,
            &channel.definition_encoding,
            &channel.encoding,
        ];
        let metadata = channel
            .metadata
            .iter()
            .map(|(key, value)| key.len() + value.len() + CHANNEL_BYTES);
        let bytes = texts.iter().map(|text| text.len()).chain(metadata).sum::<usize>();
        // The key has the texts again.
        budget.hold(2 * bytes + CHANNEL_BYTES)?;
        channel.index = self.list.len();
        self.by_content.insert(key, channel.index);
        self.list.push(Arc::new(channel));
        Ok(Arc::clone(&self.list[self.list.len() - 1]))
    }

    /// Returns the object that stands for all equal definitions.
    fn definition(&mut self, definition: &[u8], budget: &mut Budget) -> Result<Arc<[u8]>, Exceeded> {
        if let Some(known) = self.definitions.get(definition) {
            return Ok(Arc::clone(known));
        }
        budget.hold(definition.len() + ENTRY_BYTES)?;
        let definition: Arc<[u8]> = definition.into();
        self.definitions.insert(Arc::clone(&definition));
        Ok(definition)
    }
}

impl FileChannels<'_> {
    /// As [`Channels::add`].
    ///
    /// # Errors
    /// As for that.
    pub(super) fn add(
        &mut self,
        channel: &mcap::Channel<'_>,
        budget: &mut Budget,
    ) -> Result<Arc<Channel>, Exceeded> {
        let schema = channel.schema.as_deref();
        let definition = match schema {
            None => self.channels.definition(&[], budget)?,
            Some(schema) => match self.definitions.get(&schema.id) {
                Some(known) => Arc::clone(known),
                None => {
                    let definition = self.channels.definition(&schema.data, budget)?;
                    self.definitions.insert(schema.id, Arc::clone(&definition));
                    definition
                }
            },
        };
        let channel = Channel {
            topic: channel.topic.clone(),
            type_name: schema.map_or(String::new(), |schema| schema.name.clone()),
            definition_encoding: schema.map_or(String::new(), |schema| schema.encoding.clone()),
            definition,
            encoding: channel.message_encoding.clone(),
            metadata: channel.metadata.clone(),
            index: 0,
        };
        self.channels.add_shared(channel, budget)
    }
}
